"""Vectors of unit length."""

import numpy as np
from shrm.vectors import unit


def test_lengths_are_one_directions_stay_and_zero_stays_zero() -> None:
    vectors = np.random.default_rng(0).normal(size=(4, 5, 3))
    vectors[2, 3] = 0.0
    of_unit_length = unit(vectors)
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    expected = np.ones((4, 5))
    expected[2, 3] = 0.0
    np.testing.assert_allclose(np.linalg.norm(of_unit_length, axis=-1), expected, atol=1e-15)
    np.testing.assert_allclose(of_unit_length * lengths, vectors, atol=1e-14)
