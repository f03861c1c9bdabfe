"""The rings' Fourier sums as a folded matrix product, and as an FFT.

Ours is what an analysis takes beyond that of a picture of the same rows but 16 columns, which has the same
Legendre sums: the deinterleaving of channels, the folding and the product. The FFT reads the picture as it
is, or, for its best case, planar.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
from inputs import relative_rms, texels
from limits import threads
from shrm import _core, sh
from turns import medians

scipy_fft = pytest.importorskip("scipy.fft", reason="needs scipy, of the extra test")

DEGREES = (30, 100, 300, 500, 1000)
NARROW = 16


@pytest.mark.benchmark(group="Fourier")
@pytest.mark.parametrize("W", [1024, 2048])
def bench_rings(noted: Callable[[Callable[[], list[dict[str, Any]]]], None], W: int) -> None:
    H = W // 2
    picture, narrow = texels((H, W, 3)), texels((H, NARROW, 3))
    planar = np.ascontiguousarray(picture.transpose(0, 2, 1))
    rfft = partial(scipy_fft.rfft, workers=threads())

    def compare() -> list[dict[str, Any]]:
        rows = []
        for F in DEGREES:
            wide, thin = sh.Plan(H, W, F), sh.Plan(H, NARROW, F)
            out = np.empty((sh.basis_size(F), 3))
            found = medians(
                {
                    "whole": partial(wide.analysis, picture, out=out),
                    "legendre": partial(thin.analysis, narrow, out=out),
                    "fft": partial(rfft, picture, axis=1),
                    "fft_planar": partial(rfft, planar, axis=2),
                    "numpy_fft": partial(np.fft.rfft, picture, axis=1),
                },
                seconds=0.8,
            )
            found["product"] = found["whole"] - found["legendre"]
            found["with_fft"] = found["legendre"] + found["fft"]
            rows.append({"H": H, "W": W, "F": F, "error": _error(wide, picture), **found})
        return rows

    noted(compare)


def _error(plan: sh.Plan, picture: Any) -> float:
    """Of the analysis, against the same quadrature in float64, in a few orders m."""
    F, H, W = plan.F, plan.H, plan.W
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
