"""The half vector H = (L + V) / |L + V| and Schlick's Fresnel term, for the microfacet models.

Sources: [WMLT07].
"""

from typing import NamedTuple

import numpy as np

from shrm.arrays import BoolArray, FloatArray
from shrm.validation import RGB


class HalfVector(NamedTuple):
    """Angles of H, each (n,) float64.

    Attributes
    ----------
    sin2, cos2
        Squares of sine and cosine of theta_h, the angle between N and H.
    cos_d
        L.H = V.H.
    """

    sin2: FloatArray
    cos2: FloatArray
    cos_d: FloatArray


def half_vector(wi: FloatArray, wo: FloatArray) -> HalfVector:
    """Compute the angles of H from unit vectors (n, 3) in a frame with z = N.

    Sines come from the horizontal components, not from 1 - cos^2, which would lose half of the
    digits for narrow lobes. Opposite vectors have no half vector: theta_h is 0 for them.
    """
    h = wi + wo
    across2 = h[:, 0] ** 2 + h[:, 1] ** 2
    up2 = h[:, 2] ** 2
    length2 = across2 + up2
    exists = length2 > 1e-60
    sin2 = np.divide(across2, length2, out=np.zeros_like(length2), where=exists)
    cos2 = np.divide(up2, length2, out=np.ones_like(length2), where=exists)
    return HalfVector(sin2, cos2, np.minimum(0.5 * np.sqrt(length2), 1.0))  # |L + V| = 2 L.H


def tangential_squares(wi: FloatArray, wo: FloatArray, h: HalfVector) -> tuple[FloatArray, FloatArray]:
    """Return the squares (n,) of the components of H along the tangent and the bitangent."""
    length2 = np.maximum(4.0 * h.cos_d**2, 1e-60)
    return (wi[:, 0] + wo[:, 0]) ** 2 / length2, (wi[:, 1] + wo[:, 1]) ** 2 / length2


def schlick(f0: float | RGB, cos_d: FloatArray) -> FloatArray:
    """Return Schlick's Fresnel term f0 + (1 - f0) (1 - cos_d)^5, (n,) or (n, 3)."""
    grazing = (1.0 - cos_d) ** 5
    if isinstance(f0, tuple):
        normal = np.array(f0)
        return normal + (1.0 - normal) * grazing[:, None]
    return f0 + (1.0 - f0) * grazing


def above_horizon(wi: FloatArray, wo: FloatArray) -> BoolArray:
    """Tell, (n,) bool, where light reaches the eye from above the surface: N.L > 0 and N.V >= 0."""
    return (wi[:, 2] > 0.0) & (wo[:, 2] >= 0.0)
