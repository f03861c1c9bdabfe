"""Powers of cosines that keep their digits where they are narrow, and profiles that take the haversine too.

cos^s falls to half within 1.2 / sqrt(s) radians of its maximum, where the rounding of a cosine in float64,
1e-16, changes the power by s 1e-16 of itself. The haversine sin^2(theta / 2) has no such rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf.value import Method

SHARP = 1e4
"""Exponent from which on the haversine is used: below, the rounding of the cosine changes less than 1e-12."""


class SharpProfile(Method[FloatArray]):
    """A model's profile of the cosine and, after it, the haversine of the same angles."""

    takes_haversine: ClassVar[bool] = True


def profile_at(profile: Callable[..., FloatArray], cosine: FloatArray, haversine: FloatArray) -> FloatArray:
    """Evaluate a radial profile at angles whose cosines and haversines, both (n,), are given."""
    if getattr(profile, "takes_haversine", False):
        return profile(cosine, haversine)
    return profile(cosine)


def profile_at_angles(profile: Callable[..., FloatArray], theta: FloatArray) -> FloatArray:
    """Evaluate a radial profile at angles (n,) in radians."""
    return profile_at(profile, np.cos(theta), np.sin(0.5 * theta) ** 2)


def cosine_power(cosine: FloatArray, haversine: FloatArray, exponent: float) -> FloatArray:
    """Return max(cosine, 0)^exponent, 0 where the cosine is not positive, even for the exponent 0."""
    positive = cosine > 0.0
    if exponent < SHARP:
        return np.where(positive, np.maximum(cosine, 0.0) ** exponent, 0.0)
    # cos = 1 - 2 haversine, which is no more than 1/2 where the cosine is positive
    with np.errstate(divide="ignore"):
        return np.where(positive, np.exp(exponent * np.log1p(-2.0 * np.minimum(haversine, 0.5))), 0.0)
