"""Rotation in frequency space, and of the picture itself."""

from collections.abc import Callable
from typing import Any

import pytest
from inputs import TURN, coefficients
from shrm import Environment, sh
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]


@pytest.mark.benchmark(group="rotation")
@pytest.mark.parametrize("F", [30, 200])
def bench_coefficients(measured: Measured, F: int) -> None:
    c = coefficients(F)
    measured(lambda: sh.rotate(c, TURN), lambda found: relative_rms(sh.rotate(found, TURN.T), c), f"F = {F}")


@pytest.mark.benchmark(group="rotation")
def bench_picture(measured: Measured) -> None:
    env = Environment.daylight(size=64)
    turned = sh.rotate(env.coefficients(8), TURN)
    measured(
        lambda: env.rotated(TURN),
        lambda found: relative_rms(found.coefficients(8), turned),
        "128 x 64 texels, as areas; coefficients to l = 8",
    )
