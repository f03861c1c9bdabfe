"""Coefficients to maps: of the global form at once, in plans, and by the detour through the local form."""

from collections.abc import Callable
from typing import Any

import counts
import numpy as np
import pytest
from inputs import coefficients
from maps import exact_rows, product, some_rows
from shrm import _core, sh
from shrm.frequency.rings import BORDER
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]

ORDERS = [(12, 2), (24, 3), (30, 3), (30, 5)]


@pytest.mark.benchmark(group="synthesis")
@pytest.mark.parametrize(("H", "F"), [(128, 30), (512, 30), (512, 100)])
def bench_picture(measured: Measured, H: int, F: int) -> None:
    c = coefficients(F)
    plan, out = sh.Plan((H, 2 * H), F), np.empty((H, 3, 2 * H), dtype=np.float32)
    rows, directions = some_rows("latlong", H)
    measured(
        lambda: plan.synthesis(c, out=out),
        lambda rings: relative_rms(rings[rows], exact_rows(c, directions)),
        f"plan, {2 * H} x {H}, F = {F}",
        [counts.synthesis(H, 2 * H, 3, F)],
    )


@pytest.mark.benchmark(group="synthesis")
@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize(("F", "P"), ORDERS)
def bench_maps(measured: Measured, F: int, P: int, layout: str) -> None:
    known = product(F, P)
    columns = 3 * known.maps
    plan: Any
    if layout == "latlong":
        size, where = 128, "256 x 128"
        plan = _core.Synthesis(H=size, W=2 * size, channels=columns, F=known.degree)
        rings = np.empty((size, columns, 2 * size), dtype=np.float32)
        work = counts.synthesis(size, 2 * size, columns, known.degree)
    else:
        size, where = 64, "6 x 64 x 64"
        side = size + 2 * BORDER
        plan = _core.CubeSynthesis(N=size, channels=columns, F=known.degree)
        rings = np.empty((6 * side, columns, side), dtype=np.float32)
        work = counts.cube_synthesis(size, columns, known.degree)
    rows, directions = some_rows(layout, size)
    flat = known.flat
    measured(
        lambda: plan.run(flat, rings),
        lambda _: relative_rms(rings[rows], exact_rows(flat, directions)),
        f"{known.maps} maps of F = {F}, P = {P}, {where}",
        [work],
    )


@pytest.mark.benchmark(group="global")
@pytest.mark.parametrize(("F", "P"), ORDERS)
def bench_coefficients(measured: Measured, F: int, P: int) -> None:
    """The error is that of the maps they give, against the local form turned: the other way there."""
    known = product(F, P)
    plan = _core.MapCoefficients(F=F, P=P, channels=3, zonal=False)
    plan.set_material(known.rho)
    found = np.empty_like(known.coefficients)
    size = 32
    local = _core.local_reflection_map(light=known.light, rho=known.rho, H=size, W=2 * size)
    turned = _core.global_from_local(local=local)

    def error(_: None) -> float:
        flat = found.reshape(len(found), -1)
        return relative_rms(
            sh.synthesis(flat, (size, 2 * size)).transpose(0, 2, 1), turned.reshape(size, -1, 64)
        )

    measured(
        lambda: plan.run(known.light, found),
        error,
        f"coefficients, F = {F}, P = {P}",
        [counts.map_coefficients(F, P)],
    )


@pytest.mark.benchmark(group="global")
@pytest.mark.parametrize("way", ["at once", "by the local form"])
@pytest.mark.parametrize(("F", "P"), [(30, 3), (30, 5)])
def bench_whole(measured: Measured, F: int, P: int, way: str) -> None:
    known = product(F, P)
    size = 128
    columns = 3 * known.maps
    rows, directions = some_rows("latlong", size)
    exact = exact_rows(known.flat, directions)
    couple = _core.MapCoefficients(F=F, P=P, channels=3, zonal=False)
    couple.set_material(known.rho)
    synthesis = _core.Synthesis(H=size, W=2 * size, channels=columns, F=known.degree)
    found = np.empty_like(known.coefficients)
    rings = np.empty((size, columns, 2 * size), dtype=np.float32)

    def at_once() -> Any:
        couple.run(known.light, found)
        synthesis.run(found.reshape(len(found), -1), rings)
        return rings

    def by_the_local_form() -> Any:
        local = _core.local_reflection_map(light=known.light, rho=known.rho, H=size, W=2 * size)
        return _core.global_from_local(local=local)

    measured(
        at_once if way == "at once" else by_the_local_form,
        lambda maps: relative_rms(np.asarray(maps).reshape(size, columns, -1)[rows], exact),
        f"maps {way}, F = {F}, P = {P}, 256 x 128",
        [counts.map_coefficients(F, P), counts.synthesis(size, 2 * size, columns, known.degree)]
        if way == "at once"
        else [],
    )
