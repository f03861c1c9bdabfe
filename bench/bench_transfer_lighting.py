"""All ways of lighting an object of 50,000 vertices, with one thread and two, beside the timing study."""

import shutil
from collections.abc import Callable
from typing import Any

import beside_transfer_prototype
import pytest
from shrm.threads import thread_count


@pytest.mark.benchmark(group="lighting")
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++, to measure the machine's limits")
@pytest.mark.skipif(thread_count() < 2, reason="compares one thread and two")
def bench_transfer_lighting(noted: Callable[[Callable[[], list[dict[str, Any]]]], None]) -> None:
    noted(beside_transfer_prototype.compare)
