"""The rings' Fourier sums as a folded matrix product, and as an FFT: one thread, CPU time.

    OMP_NUM_THREADS=1 python bench/rings.py 1024

Ours is what an analysis takes beyond that of a picture of the same rows but 16 columns, which has the same
Legendre sums: the deinterleaving of channels, the folding, the product and putting the modes in their
places. The FFT reads the picture as it is, or, for its best case, planar.
"""

import json
import sys
import time
from collections.abc import Callable, Mapping
from functools import partial
from statistics import median
from typing import Any

import numpy as np
import scipy.fft
from inputs import texels
from shrm import _core, sh
from shrm_papers.errors import relative_rms

DEGREES = (30, 100, 200, 300, 500, 1000)
NARROW = 16


def medians(rivals: Mapping[str, Callable[[], Any]], seconds: float, least: int = 5) -> dict[str, float]:
    """Return the median CPU time of each rival, seconds, taken in turns."""
    taken: dict[str, list[float]] = {name: [] for name in rivals}
    for call in rivals.values():
        call()
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or len(next(iter(taken.values()))) < least:
        for name, call in rivals.items():
            start = time.thread_time()
            call()
            taken[name].append(time.thread_time() - start)
    return {name: median(times) for name, times in taken.items()}


def compare(W: int) -> list[dict[str, Any]]:
    """Return a row for each degree, for a picture of W x W/2."""
    H = W // 2
    picture, narrow = texels((H, W, 3)), texels((H, NARROW, 3))
    planar = np.ascontiguousarray(picture.transpose(0, 2, 1))
    rows = []
    for F in DEGREES:
        wide, thin = sh.Plan((H, W), F), sh.Plan((H, NARROW), F)
        out = np.empty((sh.basis_size(F), 3))
        found = medians(
            {
                "whole": partial(wide.analysis, picture, out=out),
                "legendre": partial(thin.analysis, narrow, out=out),
                "fft": partial(scipy.fft.rfft, picture, axis=1),
                "fft_planar": partial(scipy.fft.rfft, planar, axis=2),
                "numpy_fft": partial(np.fft.rfft, picture, axis=1),
            },
            seconds=0.8,
        )
        found["product"] = found["whole"] - found["legendre"]
        found["with_fft"] = found["legendre"] + found["fft"]
        rows.append({"H": H, "W": W, "F": F, "error": _error(wide, picture), **found})
    return rows


def _error(plan: sh.Plan, picture: Any) -> float:
    """Of the analysis, against the same quadrature in float64, in a few orders m."""
    F, (H, W) = plan.F, plan.shape
    found, exact = [], []
    coefficients = plan.analysis(picture)
    theta = (np.arange(H) + 0.5) * np.pi / H
    phi = np.pi - 2 * np.pi * (np.arange(W) + 0.5) / W
    for m in sorted({0, 1, F // 2, F}):
        l = np.arange(m, F + 1)
        rows = _core.legendre(F=F, m=m, theta=theta)[m:] * _core.fejer_weights(H=H)
        modes = np.einsum("ijc,j->ic", picture, np.cos(m * phi) * 2 * np.pi / W)
        found.append(coefficients[l * (l + 1) + m])
        exact.append((np.sqrt(2) if m else 1) * rows @ modes)
    return relative_rms(np.concatenate(found), np.concatenate(exact))


if __name__ == "__main__":
    json.dump(compare(int(sys.argv[1])), sys.stdout)
