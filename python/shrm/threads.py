"""The number of threads that this process is to use, on any system."""

from __future__ import annotations

import os


def thread_count() -> int:
    """Return the number of threads to start: OMP_NUM_THREADS if it is set, else the number of processors.

    OpenMP in the core follows the same rule. Processors are those that this process may use where the system
    tells (Linux), else all of the machine.
    """
    first_level = os.environ.get("OMP_NUM_THREADS", "").split(",")[0].strip()
    if first_level.isascii() and first_level.isdecimal() and int(first_level) > 0:
        return int(first_level)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
