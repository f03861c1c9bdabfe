"""The machine's limits, measured by machine.cpp, and what share of them a kernel reaches.

`python bench/limits.py` prints them for one thread and for all.
"""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from counts import Work
from shrm.threads import thread_count

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"


def compiled(source: Path, name: str, *options: str) -> Path:
    """Compile a program for this very processor into build/."""
    compiler = shutil.which("g++")
    if compiler is None:
        raise FileNotFoundError("g++ is not installed")
    BUILD.mkdir(exist_ok=True)
    program = BUILD / name
    command = [compiler, "-O3", "-march=native", "-std=c++20", "-fopenmp", *options, str(source), "-o"]
    command.append(str(program))
    subprocess.run(command, check=True)
    return program


@cache
def limits(count: int) -> dict[str, Any]:
    """Measure the limits with so many threads, GFLOP/s and GB/s.

    "float" and "double" are products with sums, each of two operations; "read" is by level of the memory,
    "size" what each level holds.
    """
    program = compiled(ROOT / "bench" / "machine.cpp", "machine")
    size = {"L1": count * _cache_size(1), "L2": count * _cache_size(2), "L3": _cache_size(3)}
    done = subprocess.run(
        [str(program), *map(str, size.values())],
        env={**os.environ, "OMP_NUM_THREADS": str(count)},
        capture_output=True,
        text=True,
        check=True,
    )
    return {**json.loads(done.stdout), "size": size}


def _cache_size(level: int) -> int:
    """Bytes that a data cache of the first processor holds, as Linux has it; guesses elsewhere."""
    for index in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        says = {name: (index / name).read_text().strip() for name in ("level", "type", "size")}
        if says["level"] == str(level) and says["type"] != "Instruction":
            return int(says["size"].removesuffix("K")) << 10
    return {1: 32 << 10, 2: 1 << 20, 3: 16 << 20}[level]


def least_seconds(work: Work, machine: dict[str, Any]) -> tuple[float, str]:
    """Return the least time that the machine could take, and what sets it: arithmetic, or a memory level.

    The level is the smallest that holds the arrays: kernels are measured again and again on the same
    arrays.
    """
    held = work.bytes if work.held is None else work.held
    level = next((name for name, size in machine["size"].items() if held <= size), "DRAM")
    kind = "double" if work.double else "float"
    arithmetic = 1e-9 * work.flops / machine[kind]
    reading = 1e-9 * work.bytes / machine["read"][level]
    return (arithmetic, "FMA") if arithmetic >= reading else (reading, level)


def share(works: Sequence[Work], seconds: float, machine: dict[str, Any]) -> tuple[float, str]:
    """Return the least time of kernels one after the other as a share of the time taken, and what sets it."""
    least = [least_seconds(work, machine) for work in works]
    return sum(time for time, _ in least) / seconds, max(least)[1]


if __name__ == "__main__":
    json.dump([limits(count) for count in sorted({1, thread_count()})], sys.stdout, indent=1)
    print()
