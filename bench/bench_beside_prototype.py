"""Our kernels beside those of a hand-written timing study, in turns, with one thread and with two."""

import shutil
from collections.abc import Callable
from typing import Any

import beside_prototype
import pytest
from shrm.threads import thread_count


@pytest.mark.benchmark(group="beside the prototype")
@pytest.mark.skipif(not beside_prototype.SOURCE.exists(), reason="needs ../shared/prototypes")
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
@pytest.mark.skipif(thread_count() < 2, reason="compares one thread and two")
def bench_beside_prototype(noted: Callable[[Callable[[], list[dict[str, Any]]]], None]) -> None:
    noted(beside_prototype.compare)
