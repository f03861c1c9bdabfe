"""From radiance to code values: the curve, the exposure, the coverage."""

import numpy as np
import pytest
from shrm.render import automatic_exposure, display, srgb


def test_the_srgb_curve_at_known_points() -> None:
    """IEC 61966-2-1: linear 0.21404 is code value 0.5; the two pieces meet at 0.0031308."""
    np.testing.assert_allclose(
        srgb(np.float32([-1.0, 0.0, 0.2140411, 1.0, 9.0])), [0, 0, 0.5, 1, 1], atol=1e-6
    )
    low, high = srgb(np.float32([0.0031307, 0.0031309]))
    assert high - low < 1e-5


def test_automatic_exposure_looks_at_the_objects() -> None:
    radiance, coverage = np.full((4, 4, 3), 8.0, np.float32), np.zeros((4, 4), np.float32)
    radiance[:2], coverage[:2] = 0.35, 1.0
    assert automatic_exposure(radiance, coverage) == pytest.approx(1.0, abs=1e-6)
    assert automatic_exposure(radiance) == pytest.approx(np.log2(0.7 / 8.0), abs=1e-6)
    assert automatic_exposure(0.0 * radiance) == 0.0


def test_display_doubles_per_stop_and_divides_by_coverage() -> None:
    radiance, coverage = np.full((1, 1, 3), 0.1070206, np.float32), np.full((1, 1), 0.5, np.float32)
    np.testing.assert_array_equal(display(radiance, 1.0), [[[128] * 3]])  # 0.5 of 255, rounded to even
    np.testing.assert_array_equal(display(radiance, 0.0, coverage), [[[128, 128, 128, 128]]])
