"""Vectors of unit length."""

import numpy as np
import pytest
from shrm.vectors import golden_azimuths, golden_spiral, unit


def test_lengths_are_one_directions_stay_and_zero_stays_zero() -> None:
    vectors = np.random.default_rng(0).normal(size=(4, 5, 3))
    vectors[2, 3] = 0.0
    of_unit_length = unit(vectors)
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    expected = np.ones((4, 5))
    expected[2, 3] = 0.0
    np.testing.assert_allclose(np.linalg.norm(of_unit_length, axis=-1), expected, atol=1e-15)
    np.testing.assert_allclose(of_unit_length * lengths, vectors, atol=1e-14)


@pytest.mark.parametrize("count", [7, 64, 1000])
def test_azimuths_are_spread_evenly(count: int) -> None:
    """Multiples of the golden ratio leave gaps of three sizes at the most, the largest below 2 / count."""
    turns = np.sort(golden_azimuths(count) / (2 * np.pi) % 1)
    gaps = np.diff(np.append(turns, turns[0] + 1))
    assert gaps.max() < 2 / count
    assert len(np.unique(np.round(gaps, 9))) <= 3


@pytest.mark.parametrize("start", [0.0, 0.5])
def test_the_spiral_integrates_what_is_smooth(start: float) -> None:
    """Of directions at the middles of 1000 bands: 1, x, y, z and their products over the sphere."""
    count = 1000
    w = golden_spiral(1 - 2 * (np.arange(count) + 0.5) / count, start)
    np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(w.mean(axis=0), 0.0, atol=2e-3)
    np.testing.assert_allclose(w.T @ w / count, np.eye(3) / 3, atol=2e-3)
