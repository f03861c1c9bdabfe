"""Timing in turns: rivals one after the other, again and again, so that both see the same machine."""

import time
from collections.abc import Callable, Mapping
from statistics import median
from typing import Any


def medians(rivals: Mapping[str, Callable[[], Any]], seconds: float, least: int = 5) -> dict[str, float]:
    """Return the median wall time of each rival, seconds, from turns that take so long in all."""
    for call in rivals.values():
        call()
    taken: dict[str, list[float]] = {name: [] for name in rivals}
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or len(next(iter(taken.values()))) < least:
        for name, call in rivals.items():
            start = time.perf_counter()
            call()
            taken[name].append(time.perf_counter() - start)
    return {name: median(times) for name, times in taken.items()}
