"""The rings' Fourier sums as a folded matrix product, and as an FFT: see rings.py."""

from collections.abc import Callable
from typing import Any

import pytest
from processes import found_by

pytest.importorskip("scipy.fft", reason="needs scipy, of the extra test")


@pytest.mark.benchmark(group="Fourier")
@pytest.mark.parametrize("W", [1024, 2048])
def bench_rings(noted: Callable[[Callable[[], list[dict[str, Any]]]], None], W: int) -> None:
    noted(lambda: found_by("rings.py", str(W), threads=1))
