"""Checks at the door: what they return, and that each refusal reads NAME must be WHAT, got WHAT IT WAS."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from shrm import validation
from shrm.brdf import GGX, require_brdf
from shrm.environment import Environment, require_environment

HUGE = np.full((2, 3), 1e39)


@pytest.mark.parametrize(
    ("check", "error", "text"),
    [
        (lambda: validation.number("x", "1"), TypeError, "x must be a number, got '1'"),
        (lambda: validation.number("x", True), TypeError, "x must be a number, got True"),
        (lambda: validation.number("x", math.nan), ValueError, "x must be finite, got nan"),
        (lambda: validation.number("x", 2, 0, 1), ValueError, "x must be in [0, 1], got 2"),
        (lambda: validation.number("x", -1, 0), ValueError, "x must be at least 0, got -1"),
        (lambda: validation.positive("x", 0), ValueError, "x must be above 0, got 0"),
        (lambda: validation.positive("x", 1, 1), ValueError, "x must be above 0 and below 1, got 1"),
        (lambda: validation.positive("x", math.inf), ValueError, "x must be finite, got inf"),
        (lambda: validation.fraction("x", 1), ValueError, "x must be in [0, 1), got 1"),
        (lambda: validation.whole_number("n", 1.0, 0), TypeError, "n must be a whole number, got 1.0"),
        (lambda: validation.whole_number("n", 0, 1), ValueError, "n must be at least 1, got 0"),
        (lambda: validation.picture_shape("s", 4), TypeError, "s must be a pair (H, W), got 4"),
        (lambda: validation.picture_shape("s", "48"), TypeError, "s must be a pair (H, W), got '48'"),
        (
            lambda: validation.picture_shape("s", (4, 8, 3)),
            TypeError,
            "s must be a pair (H, W), got (4, 8, 3)",
        ),
        (lambda: validation.picture_shape("s", (0, 8)), ValueError, "s[0] must be in [1, 65536], got 0"),
        (
            lambda: validation.picture_shape("s", (1, 1e3)),
            TypeError,
            "s[1] must be a whole number, got 1000.0",
        ),
        (lambda: validation.number_or_rgb("c", -1, 0), ValueError, "c must be at least 0, got -1"),
        (
            lambda: validation.unit_vectors("n", [[1.0, 0]]),
            ValueError,
            "n must have the shape (n, 3), got (1, 2)",
        ),
        (
            lambda: validation.rotation("R", np.ones((3, 3))),
            ValueError,
            "R must be a rotation, orthogonal to 1e-6 with determinant 1, got one off by 3 with determinant"
            " 0",
        ),
        (
            lambda: validation.require_finite("a", np.array([np.nan])),
            ValueError,
            "a must be finite, got 1 values that are not, the first at (0,)",
        ),
        (lambda: validation.flag("f", 1), TypeError, "f must be True or False, got 1"),
        (lambda: validation.string("s", 1), TypeError, "s must be a string, got 1"),
        (lambda: validation.one_of("s", "c", "ab"), ValueError, "s must be one of a, b, got 'c'"),
        (lambda: validation.require_instance("s", 1, str), TypeError, "s must be a str, got int"),
        (
            lambda: validation.require_instance("s", 1, str, OSError),
            TypeError,
            "s must be a str or an OSError, got int",
        ),
        (
            lambda: validation.real_array("a", ["1"]),
            TypeError,
            "a must be an array of real numbers, got dtype <U1",
        ),
        (
            lambda: validation.real_array("a", [[1.0], [1.0, 2.0]]),  # type: ignore[list-item]
            TypeError,
            "a must be an array of real numbers, got rows of unequal length",
        ),
        (
            lambda: validation.real_array("a", [[1.0, math.inf]]),
            ValueError,
            "a must be finite, got 1 values that are not, the first at (0, 1)",
        ),
        (
            lambda: validation.real_array("a", [1.0], ("n", 3), (3,)),
            ValueError,
            "a must have the shape (n, 3) or (3,), got (1,)",
        ),
        (
            lambda: validation.real_array("a", np.zeros((0, 3)), ("n", 3), empty=False),
            ValueError,
            "a must have the shape (n, 3), not empty, got (0, 3)",
        ),
        (
            lambda: validation.float32_array("a", HUGE),
            ValueError,
            "a must be within the range of float32, got 1e+39",
        ),
        (
            lambda: validation.indices("i", [0.0], 3),
            TypeError,
            "i must be an array of whole numbers, got dtype float64",
        ),
        (
            lambda: validation.indices("i", [0, 3, -1], 3),
            ValueError,
            "i must be in [0, 3), got 2 that are not, from -1 to 3",
        ),
        (
            lambda: validation.indices("i", [0], 3, ("T", 3)),
            ValueError,
            "i must have the shape (T, 3), got (1,)",
        ),
        (
            lambda: validation.require_stored("a", np.zeros(2), (2,)),
            TypeError,
            "a must be an array of float32 or float16, got float64",
        ),
        (
            lambda: validation.require_stored("a", np.array([np.nan, 0], np.float16), (2,)),
            ValueError,
            "a must be finite, got 1 values that are not, the first at (0,)",
        ),
        (
            lambda: validation.stored_array("a", np.zeros((0, 3), np.float16), ("V", 3)),
            ValueError,
            "a must have the shape (V, 3), not empty, got (0, 3)",
        ),
        (
            lambda: validation.stored_array("a", [[1j]], ("V", "K")),
            TypeError,
            "a must be an array of real numbers, got dtype complex128",
        ),
        (
            lambda: validation.require_rotations("R", np.array([1, -1, 2.0])[:, None, None] * np.eye(3)),
            ValueError,
            "R must be rotations, orthogonal to 1e-06 with determinant 1, got 2 that are not, the first at 1",
        ),
        (
            lambda: validation.require_array("a", np.zeros(2), (2,), np.float32),
            TypeError,
            "a must be an array of float32, got float64",
        ),
        (lambda: require_environment(HUGE), TypeError, "env must be an Environment, got ndarray"),
        (lambda: require_brdf("ggx"), TypeError, "brdf must be a material of shrm.brdf, got str"),
    ],
)
def test_refusals_say_what_it_must_be_and_what_it_was(
    check: Callable[[], Any], error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=f"^{re.escape(text)}$"):
        check()


def test_zero_has_no_sign() -> None:
    """Values that are equal are written alike."""
    assert math.copysign(1, validation.number("x", -0.0)) == 1


def test_arrays_come_back_in_their_form() -> None:
    kept = np.ones((4, 3))
    assert validation.real_array("a", kept, ("n", 3)) is kept
    turned = validation.float32_array("a", np.asfortranarray(kept), ("n", 3))
    assert turned.dtype == np.float32
    assert turned.flags.c_contiguous
    faces = validation.indices("i", np.array([[2, 1, 0]], np.uint8), 3, ("T", 3), empty=False)
    assert faces.dtype == np.int32
    np.testing.assert_array_equal(faces, [[2, 1, 0]])
    for dtype, held_as in ((np.float16, np.float16), (np.float32, np.float32), (np.int8, np.float32)):
        stored = validation.stored_array("a", kept.astype(dtype), ("n", 3))
        assert stored.dtype == held_as
    mapped = np.ones((4, 3), np.float16)
    assert np.shares_memory(validation.stored_array("a", mapped, ("n", 3)), mapped)
    unchecked = np.full((2, 2), np.nan, np.float32)
    validation.require_stored("a", unchecked, (2, "K"), finite=False)
    assert validation.flag("f", np.True_) is True
    assert validation.positive("x", np.float32(0.5), 1) == 0.5


def test_one_value_of_a_large_array_is_found() -> None:
    """Larger than what is tested at once; in its last row."""
    large = np.zeros((3, 1 << 20), np.float32)
    validation.require_finite("a", large)
    large[2, 5] = np.nan
    with pytest.raises(ValueError, match=r"got 1 values that are not, the first at \(2, 5\)"):
        validation.require_finite("a", large)


def test_materials_and_environments_pass() -> None:
    require_brdf(GGX(0.1))
    require_environment(Environment(np.ones((2, 4, 3), np.float32)))
