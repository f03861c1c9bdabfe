"""Which builds of the core this processor can run."""

def instruction_sets() -> list[str]: ...  # best first
