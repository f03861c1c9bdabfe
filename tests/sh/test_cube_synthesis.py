"""Synthesis on cubes: the sums of the eight mirror classes against the series itself, texel by texel."""

import numpy as np
import pytest
from shrm import _core, sh

EPS32 = float(np.finfo(np.float32).eps)
CHANNELS = (1, 3, 5, 27, 48)  # the blocks of twelve, three and one, and what they leave


def series(c: np.ndarray, N: int) -> np.ndarray:
    """The values (rows, channels, columns) at all texels, borders included."""
    directions = _core.cube_directions(N=N)
    values = sh.evaluate(c, directions.reshape(-1, 3))
    return values.reshape(*directions.shape[:2], -1).transpose(0, 2, 1)


@pytest.mark.parametrize("N", [2, 6, 16, 34])
def test_cubes_hold_the_series_borders_included(N):
    for F in range(21):
        c = np.random.default_rng(F).normal(size=((F + 1) ** 2, max(CHANNELS)))
        expected = series(c, N)
        # sum_lm Y_lm^2 = (F+1)^2 / 4 pi: what rounding is relative to; a float32 sum of n terms errs as the
        # root of n, F + 1.
        largest = np.linalg.norm(c, axis=0).max() * (F + 1) / np.sqrt(4 * np.pi)
        for channels in CHANNELS:
            rings = _core.cube_synthesis(coefficients=np.ascontiguousarray(c[:, :channels]), N=N)
            assert rings.shape == (6 * (N + 4), channels, N + 4)
            np.testing.assert_allclose(
                rings, expected[:, :channels], rtol=0, atol=(4 + F + 1) * EPS32 * largest
            )


@pytest.mark.parametrize(
    ("l", "m"), [(0, 0), (1, -1), (1, 0), (1, 1), (5, -4), (6, -3), (6, 2), (7, 7), (8, 0)]
)
def test_each_function_lands_in_its_class(l, m):
    """One Y_lm alone: a wrong sign of a mirror image shows as an error as large as the function."""
    c = np.zeros((81, 1))
    c[l * (l + 1) + m] = 1
    rings = _core.cube_synthesis(coefficients=c, N=10)
    np.testing.assert_allclose(rings, series(c, 10), rtol=0, atol=4 * EPS32)


@pytest.mark.parametrize(("N", "channels", "F"), [(6, 12, 9), (16, 27, 4)])
def test_repeated_use_gives_the_same_bit_for_bit(N, channels, F):
    plan = _core.CubeSynthesis(N=N, channels=channels, F=F)
    rng = np.random.default_rng(1)
    c, other = rng.normal(size=(2, (F + 1) ** 2, channels))
    rings = np.empty((6 * (N + 4), channels, N + 4), dtype=np.float32)
    for coefficients in (c, other, c):
        plan.run(coefficients, rings)
    np.testing.assert_array_equal(rings, _core.cube_synthesis(coefficients=c, N=N))
