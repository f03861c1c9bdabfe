"""What went wrong, as a person is told it."""

from __future__ import annotations


def one_line(fault: BaseException) -> str:
    """Say a fault in one line; one of the system names the file first."""
    if isinstance(fault, OSError) and fault.filename is not None and fault.strerror:
        return f"{fault.filename}: {fault.strerror}"
    if isinstance(fault, MemoryError):
        return "not enough memory"
    return " ".join(str(fault).split()) or type(fault).__name__
