"""A picture and a material to a reflection map, in one call. The error is the one that is predicted."""

from collections.abc import Callable
from typing import Any

import pytest
from shrm import Environment, brdf, prefilter
from shrm.frequency.analysis import analyse

Measured = Callable[..., Any]


@pytest.mark.benchmark(group="end to end")
@pytest.mark.parametrize("known", [True, False], ids=["known", "new"])
def bench_prefilter(measured: Measured, known: bool) -> None:
    pixels = Environment.daylight(size=512).pixels
    material = brdf.Microfacet(0.2)

    def run() -> Any:
        if not known:
            analyse.cache_clear()
        return prefilter(Environment(pixels), material, orders=(12, 2), size=128)

    which = "known material" if known else "new material"
    measured(run, lambda rm: rm.error, f"1024 x 512 to 256 x 128, F = 12, P = 2, {which}")


@pytest.mark.benchmark(group="end to end")
def bench_tolerance(measured: Measured) -> None:
    """Orders and size are chosen for the light, the error predicted; the material is known."""
    pixels = Environment.daylight(size=512).pixels
    material = brdf.GGX(0.5)

    def run() -> Any:
        rm = prefilter(Environment(pixels), material, tolerance=0.05)
        return rm, rm.error

    measured(run, lambda found: found[1], "1024 x 512, GGX .5, orders and size for 5%, known material")
