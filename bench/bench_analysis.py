"""Light to coefficients: one call, and a plan that is kept."""

from collections.abc import Callable
from typing import Any

import counts
import numpy as np
import numpy.typing as npt
import pytest
from inputs import FloatArray, coefficients, texels
from shrm import _core, sh
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]


@pytest.mark.benchmark(group="analysis")
@pytest.mark.parametrize(("H", "F"), [(128, 30), (512, 12), (512, 30), (512, 100)])
def bench_analysis(measured: Measured, H: int, F: int) -> None:
    pixels, known = _band_limited(H, F)
    measured(
        lambda: sh.analysis(pixels, F),
        lambda found: relative_rms(found, known),
        f"{2 * H} x {H}, F = {F}",
        [counts.analysis(H, 2 * H, F)],
    )


@pytest.mark.benchmark(group="analysis")
@pytest.mark.parametrize(("H", "F"), [(128, 30), (512, 12), (512, 30), (512, 100), (2048, 30)])
def bench_planned(measured: Measured, H: int, F: int) -> None:
    pixels, known = _band_limited(H, F)
    plan, out = sh.Plan((H, 2 * H), F), np.empty(known.shape)
    measured(
        lambda: plan.analysis(pixels, out=out),
        lambda found: relative_rms(found, known),
        f"plan, {2 * H} x {H}, F = {F}",
        [counts.analysis(H, 2 * H, F)],
    )


@pytest.mark.benchmark(group="analysis")
@pytest.mark.parametrize("H", [128, 512])
def bench_areas(measured: Measured, H: int) -> None:
    F = 30
    pixels = texels((H, 2 * H, 3))
    plan, out = sh.Plan((H, 2 * H), F, areas=True), np.empty(((F + 1) ** 2, 3))
    measured(
        lambda: plan.analysis(pixels, out=out),
        lambda found: relative_rms(found, exact_areas(pixels, F)),
        f"plan, {2 * H} x {H} areas, F = {F}",
        [counts.analysis(H, 2 * H, F)],
    )


def _band_limited(H: int, F: int) -> tuple[npt.NDArray[np.float32], FloatArray]:
    """A picture of known coefficients; above degree H/2 - 1, where aliases begin, they are zero."""
    c = coefficients(min(F, H // 2 - 1))
    known = np.zeros(((F + 1) ** 2, 3))
    known[: len(c)] = c
    return sh.synthesis(c, (H, 2 * H)), known


def exact_areas(pixels: npt.NDArray[np.float32], F: int) -> FloatArray:
    """Integrate Y_lm over every texel in float64: Gauss nodes in theta, the integral itself in phi."""
    H, W, channels = pixels.shape
    edges = np.pi - 2 * np.pi * np.arange(W + 1) / W
    x, w = np.polynomial.legendre.leggauss(16)
    theta = ((np.arange(H)[:, None] + (1 + x) / 2) * np.pi / H).ravel()
    weight = np.tile(w, H) * np.pi / H / 2 * np.sin(theta)
    rings = pixels.astype(np.float64).transpose(0, 2, 1).reshape(-1, W)
    result = np.zeros(((F + 1) ** 2, channels))
    for m in range(F + 1):
        rows = (_core.legendre(F=F, m=m, theta=theta) * weight).reshape(-1, H, len(x)).sum(axis=2)
        l = np.arange(m, F + 1)
        cosine = -np.diff(edges) if m == 0 else -np.diff(np.sin(m * edges)) / m
        norm = 1.0 if m == 0 else np.sqrt(2)
        result[l * (l + 1) + m] = norm * rows[-len(l) :] @ (rings @ cosine).reshape(H, channels)
        if m > 0:
            sine = np.diff(np.cos(m * edges)) / m
            result[l * (l + 1) - m] = norm * rows[-len(l) :] @ (rings @ sine).reshape(H, channels)
    return result
