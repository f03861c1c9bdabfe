"""Reflection maps in use: one dynamic map for each view, and radiance point by point."""

from collections.abc import Callable
from typing import Any

import counts
import numpy as np
import pytest
from inputs import frames
from shrm import Environment, brdf, prefilter, sh
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]


@pytest.mark.benchmark(group="per view")
@pytest.mark.parametrize("P", [3, 5])
@pytest.mark.parametrize("half", [False, True], ids=["float", "half"])
def bench_dynamic_map(measured: Measured, P: int, half: bool) -> None:
    """Half maps are judged by the float ones: their error is that of rounding the maps."""
    env, material = Environment.daylight(size=128), brdf.GGX(0.3).recentered("reflection")
    full = prefilter(env, material, orders=(20, P), size=64, layout="cube")
    rm = prefilter(env, material, orders=(20, P), size=64, layout="cube", half=half)
    view = np.array([0.48, 0.6, 0.64])
    Y = sh.evaluate(np.eye((P + 1) ** 2), view[None])[0]
    exact = np.tensordot(Y, full.parts[0].maps.astype(np.float64), axes=1)
    out = np.empty(exact.shape, dtype=np.float32)
    maps = (P + 1) ** 2
    measured(
        lambda: rm.at_view(view, out=out),
        lambda pixels: relative_rms(pixels, exact),
        f"{maps} {'half' if half else 'float'} maps, 6 x 64 x 64",
        [counts.view(maps, 64, half)],
    )


@pytest.mark.benchmark(group="radiance")
@pytest.mark.parametrize("interpolation", ["bilinear", "cubic"])
@pytest.mark.parametrize("layout", ["latlong", "cube"])
def bench_radiance(measured: Measured, layout: Any, interpolation: Any) -> None:
    env, material = Environment.daylight(size=128), brdf.GGX(0.3).recentered("reflection")
    size, texels = (128, 128 * 256) if layout == "latlong" else (64, 6 * 64 * 64)
    rm = prefilter(env, material, orders=(20, 3), size=size, layout=layout)
    N, V = frames(100_000)
    R = 2 * (N * V).sum(axis=1, keepdims=True) * N - V
    R /= np.linalg.norm(R, axis=1, keepdims=True)
    few = slice(0, 2000)
    exact = rm.parts[0].series(R[few], V[few])
    where = "256 x 128" if layout == "latlong" else "6 x 64 x 64"
    measured(
        lambda: rm.radiance(N, V, interpolation=interpolation),
        lambda found: relative_rms(found[few], exact),
        f"100,000 points, P = 3, {where}, {interpolation}",
        [counts.radiance(100_000, 16, 4 if interpolation == "bilinear" else 16, texels)],
    )
