"""A reflection map that follows its light: 1024 x 512 texels to a cube of global maps, and one view of it."""

from collections.abc import Callable
from itertools import cycle
from typing import Any

import counts
import numpy as np
import pytest
from inputs import TURN, FloatArray, latlong_directions
from maps import exact_rows, some_rows
from shrm import Environment, Prefilter, ReflectionMap, _core, brdf, sh
from shrm.frequency.analysis import analyse
from shrm.frequency.expansion import windowed
from shrm.frequency.orders import analysed
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]

H, F, P, SIZE = 512, 24, 3, 64
MAPS = (P + 1) ** 2
VIEW = np.array([0.48, 0.6, 0.64])
AFTER_LIGHT = [
    counts.map_coefficients(F, P),
    counts.cube_synthesis(SIZE, 3 * MAPS, F + P),
    counts.view(MAPS, SIZE, False),
]
AFTER_IMAGE = [counts.analysis(H, 2 * H, F), *AFTER_LIGHT]
TO = f"1024 x 512 to 6 x 64 x 64, F = {F}, P = {P}"


def _relit(center: Any, half: bool = False) -> Prefilter:
    env = Environment.daylight(size=H)
    return Prefilter(env, brdf.GGX(0.3), orders=(F, P), size=SIZE, layout="cube", center=center, half=half)


def _pictures() -> list[Any]:
    """Two lights, read-only: an Environment of each is made without a copy."""
    return [Environment.daylight(sun_azimuth=azimuth, size=H).pixels for azimuth in (50.0, 120.0)]


def _error(rm: ReflectionMap, light: FloatArray, material: brdf.BRDF) -> float:
    """Of the maps, against the series in float64 from light and material analysed anew."""
    rho = windowed(analysed(material, F, P)[0], F, P, None)
    b = _core.global_coefficients(light=light, rho=rho)
    rows, directions = some_rows("cube", SIZE)
    rings = rm.parts[0].rings
    return relative_rms(
        rings[rows].reshape(len(rows), -1, rings.shape[3]), exact_rows(b.reshape(len(b), -1), directions)
    )


@pytest.mark.benchmark(group="relighting")
@pytest.mark.parametrize("center", ["reflection", "lobe"])
@pytest.mark.parametrize("half", [False, True], ids=["float", "half"])
def bench_new_picture(measured: Measured, center: Any, half: bool) -> None:
    relit, pictures = _relit(center, half), cycle(_pictures())
    out = np.empty((6, SIZE, SIZE, 3), dtype=np.float32)
    last: list[Environment] = []

    def frame() -> ReflectionMap:
        last[:] = [Environment(next(pictures))]
        rm = relit.update(last[0])
        rm.at_view(VIEW, out=out)
        return rm

    measured(
        frame,
        lambda rm: _error(rm, Environment(last[0].pixels).coefficients(F), brdf.GGX(0.3).recentered(center)),
        f"new picture and view, about the {center}{', half maps' if half else ''}, {TO}",
        AFTER_IMAGE,
    )


@pytest.mark.benchmark(group="relighting")
def bench_rotation(measured: Measured) -> None:
    """The light's coefficients turned are those of its series sampled at R^T w."""
    relit = _relit("lobe")
    out = np.empty((6, SIZE, SIZE, 3), dtype=np.float32)

    def frame() -> ReflectionMap:
        rm = relit.update(rotation=TURN)
        rm.at_view(VIEW, out=out)
        return rm

    def error(rm: ReflectionMap) -> float:
        c = Environment.daylight(size=H).coefficients(F)
        sampled = sh.evaluate(c, (latlong_directions(64, 128) @ TURN).reshape(-1, 3))
        return _error(rm, sh.analysis(sampled.reshape(64, 128, 3), F), brdf.GGX(0.3))

    measured(frame, error, f"light turned, and view, about the lobe, {TO}", AFTER_LIGHT)


@pytest.mark.benchmark(group="relighting")
@pytest.mark.parametrize("known", [True, False], ids=["known", "new"])
def bench_material(measured: Measured, known: bool) -> None:
    relit, materials = _relit("lobe"), cycle([brdf.GGX(0.4), brdf.GGX(0.3)])
    out = np.empty((6, SIZE, SIZE, 3), dtype=np.float32)
    last: list[brdf.BRDF] = []

    def frame() -> ReflectionMap:
        if not known:
            analyse.cache_clear()
        last[:] = [next(materials)]
        rm = relit.update(brdf=last[0])
        rm.at_view(VIEW, out=out)
        return rm

    measured(
        frame,
        lambda rm: _error(rm, Environment.daylight(size=H).coefficients(F), last[0]),
        f"{'known' if known else 'new'} material and view, about the lobe, {TO}",
        AFTER_LIGHT if known else [],
    )
