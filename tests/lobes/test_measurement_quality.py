"""What is said of measured materials: reciprocity, energy, coverage."""

from collections.abc import Callable

import numpy as np
import pytest
from shrm.brdf import GGX, Measured, directional_albedo
from shrm.lobes.measurement_quality import VIEWS, quality

Array = np.ndarray


def measured(
    f: Callable[[Array, Array], Array], covers: Callable[[Array, Array], Array] | None = None
) -> Measured:
    """A material of the BRDF f, without the cosine."""

    def function(wi: Array, wo: Array) -> Array:
        return np.repeat((f(wi, wo) * wi[:, 2])[:, None], 3, axis=1)

    def everywhere(wi: Array, wo: Array) -> Array:
        return np.ones(len(wi), dtype=bool)

    return Measured("made up", "test", function, covers or everywhere)


def test_a_reciprocal_material_has_no_error_and_its_albedo() -> None:
    found = quality(measured(lambda wi, wo: np.full(len(wi), 0.25 / np.pi)))
    assert found.reciprocity_error < 1e-12
    np.testing.assert_allclose(found.albedo, 0.25, rtol=1e-6)
    assert found.covered == 1.0
    assert found.covered_to == np.pi / 2


def test_the_error_of_reciprocity_is_the_integral_it_says() -> None:
    """F = 1 + (x - y) / 2 with x = N.L, y = N.V, uniform: int |x - y| x y over int x y is (1/15) / (1/4)."""
    found = quality(measured(lambda wi, wo: 1 + 0.5 * (wi[:, 2] - wo[:, 2])))
    assert found.reciprocity_error == pytest.approx(4 / 15, rel=2e-3)  # 65536 pairs of a sequence


def test_albedos_agree_with_another_quadrature() -> None:
    ggx = GGX(0.15)
    found = quality(measured(lambda wi, wo: ggx.transfer(wi, wo) / np.maximum(wi[:, 2], 1e-12)))
    seen = np.radians(88) > VIEWS
    expected = directional_albedo(ggx, np.cos(VIEWS[seen]))
    np.testing.assert_allclose(found.albedo[seen], np.repeat(expected, 3, axis=1), rtol=1e-3)


def test_a_material_that_reflects_too_much_is_said_to() -> None:
    found = quality(measured(lambda wi, wo: 1 / (np.pi * np.maximum(wo[:, 2], 0.1))))
    largest, view = found.largest_albedo
    assert largest == pytest.approx(10.0, rel=1e-6)
    assert np.cos(view) < 0.1
    assert found.albedo[0, 0] == pytest.approx(1.0, rel=1e-6)


def test_coverage_is_by_solid_angle_and_to_an_angle() -> None:
    edge = np.cos(np.radians(70.0))
    found = quality(
        measured(lambda wi, wo: np.ones(len(wi)), lambda wi, wo: (wi[:, 2] >= edge) & (wo[:, 2] >= edge))
    )
    assert found.covered == pytest.approx((1 - edge) ** 2, abs=1e-3)
    assert found.covered_to == pytest.approx(np.radians(70.0))


def test_the_same_is_said_again() -> None:
    first, second = (quality(measured(lambda wi, wo: wi[:, 2] + 2 * wo[:, 2])) for _ in range(2))
    assert first.reciprocity_error == second.reciprocity_error
    np.testing.assert_array_equal(first.albedo, second.albedo)


def test_black_is_no_fault() -> None:
    found = quality(measured(lambda wi, wo: np.zeros(len(wi))))
    assert found.reciprocity_error == 0
    assert not found.albedo.any()
