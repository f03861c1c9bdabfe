"""What every row of the benchmarks says beside its time: the error, the machine, the threads, the commit."""

import os
import platform
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


def _machine() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines() if os.path.exists("/proc/cpuinfo") else []:
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def _commit() -> str:
    root = Path(__file__).resolve().parents[1]
    done = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=root, capture_output=True, text=True, check=False
    )
    return done.stdout.strip() or "unknown"


@pytest.fixture
def measured(benchmark: Any) -> Callable[..., Any]:
    """Time a call and note its error: `measured(call, error=lambda result: ..., work="...")`."""

    def run(call: Callable[[], Any], error: Callable[[Any], float], work: str) -> Any:
        result = benchmark(call)
        benchmark.extra_info.update(
            work=work,
            error=float(error(result)),
            machine=_machine(),
            threads=int(os.environ.get("OMP_NUM_THREADS", os.cpu_count() or 1)),
            commit=_commit(),
        )
        return result

    return run
