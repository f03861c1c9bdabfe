"""How many threads this process is to use, on any system."""

from __future__ import annotations

import os


def thread_count() -> int:
    """Return how many threads to start: as many as OMP_NUM_THREADS says, else as there are processors to use.

    The core's OpenMP goes by the same. Processors are those that this process may use where the system knows
    (Linux), else all of the machine.
    """
    first_level = os.environ.get("OMP_NUM_THREADS", "").split(",")[0].strip()
    if first_level.isascii() and first_level.isdecimal() and int(first_level) > 0:
        return int(first_level)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
