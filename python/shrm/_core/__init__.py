"""The C++ core, in the build for the best instruction set this processor has.

The environment variable SHRM_INSTRUCTION_SET chooses another: portable, x86-64-v3 (AVX2) or x86-64-v4
(AVX-512). One that this processor or build has not is an ImportError. Results agree to 1e-6.
"""

import os
from importlib import import_module

from shrm._core import processor

_SPINS = "20000"
"""Times that a waiting thread looks for more work before it sleeps: some 100 us, longer than kernels wait.
GNU's OpenMP would look for milliseconds, and so keep the processors from other programs and from the very
threads that it waits for."""

_requested = os.environ.get("SHRM_INSTRUCTION_SET")
if _requested is not None and _requested not in processor.instruction_sets():
    raise ImportError(
        f"SHRM_INSTRUCTION_SET is {_requested!r}, but this processor and build have "
        + ", ".join(processor.instruction_sets())
    )
INSTRUCTION_SET: str = _requested or processor.instruction_sets()[0]

# GNU's OpenMP reads its settings when it is loaded; the user's own go before.
_waits_as_set = not os.environ.keys().isdisjoint({"GOMP_SPINCOUNT", "OMP_WAIT_POLICY"})
if not _waits_as_set:
    os.environ["GOMP_SPINCOUNT"] = _SPINS
try:
    _build = import_module(f"shrm._core.{INSTRUCTION_SET.replace('-', '_')}")
finally:
    if not _waits_as_set:
        del os.environ["GOMP_SPINCOUNT"]
globals().update({name: value for name, value in vars(_build).items() if not name.startswith("_")})
