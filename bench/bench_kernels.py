"""The hottest kernels, with one thread: see kernel.py."""

import shutil
from collections.abc import Callable
from typing import Any

import pytest
from kernel import KERNELS
from processes import found_by


@pytest.mark.benchmark(group="kernels")
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++, to measure the machine's limits")
def bench_kernels(noted: Callable[[Callable[[], list[dict[str, Any]]]], None]) -> None:
    noted(lambda: [found_by("kernel.py", name, threads=1) for name in KERNELS])
