"""Frequency against angle: [RH02] table 4, and the integrator on an isotropic material."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from inputs import frames, relative_rms
from shrm import Environment, brdf, prefilter
from shrm.reference import integrate, prefilter_angular

Measured = Callable[..., Any]


@pytest.mark.benchmark(group="angular")
@pytest.mark.parametrize("s", [8, 32, 128, 512])
@pytest.mark.parametrize("method", ["frequency", "angle"])
def bench_phong(measured: Measured, s: int, method: str) -> None:
    """[RH02] table 4, with its tolerances: .01 of the BRDF's energy in frequency, .05 in angle.

    Eq. 9 has the time in frequency grow as sqrt(s), eq. 10 the time in angle fall as 1 / s.
    """
    env = Environment(Environment.daylight(size=128).pixels)
    material = brdf.Phong(s)
    view = [0.0, 0.0, 1.0]
    F = int(np.ceil(np.sqrt(-s * np.log(0.01))))  # [RH02] appendix D
    exact = prefilter(env, material, orders=(max(4 * F, 60), 0), size=128).at_view(view)

    def frequency() -> Any:
        return prefilter(Environment(env.pixels), material, orders=(F, 0), size=128).at_view(view)

    def angle() -> Any:
        return prefilter_angular(env, material, tolerance=0.05, size=128, subsamples=1).at_view(view)

    measured(
        frequency if method == "frequency" else angle,
        lambda pixels: relative_rms(pixels, exact),
        f"Phong s = {s}, 256 x 128 to the same, in {method}, "
        + (f"F = {F}" if method == "frequency" else "eps = .05"),
    )


@pytest.mark.benchmark(group="angular")
def bench_queries(measured: Measured) -> None:
    env, material = Environment.daylight(size=64), brdf.GGX(0.3)
    angular = prefilter_angular(env, material, subsamples=2)
    N, V = frames(400)
    few = slice(0, 20)
    exact = integrate(env, material, N[few], V[few], subsamples=4)
    measured(
        lambda: angular.radiance(N, V),
        lambda found: relative_rms(found[few], exact),
        "GGX .3, 400 points, each integrated over 128 x 64 texels",
    )
