"""The hottest kernels with one thread, each in its own process: OpenMP fixes its threads at the start."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest
from kernel import KERNELS
from limits import ROOT


@pytest.mark.benchmark(group="kernels")
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++, to measure the machine's limits")
def bench_kernels(noted: Callable[[Callable[[], list[dict[str, Any]]]], None]) -> None:
    def measure(name: str) -> dict[str, Any]:
        done = subprocess.run(
            [sys.executable, str(ROOT / "bench" / "kernel.py"), name],
            env={**os.environ, "OMP_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
            check=True,
        )
        found: dict[str, Any] = json.loads(done.stdout)
        return found

    noted(lambda: [measure(name) for name in KERNELS])
