"""Relative RMS errors, by which all results judge approximations."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from shrm.environment import layouts


def relative_rms(values: npt.ArrayLike, exact: npt.ArrayLike, weights: npt.ArrayLike = 1.0) -> float:
    """Return the relative root mean square difference of values from exact ones, colors pooled.

    Parameters
    ----------
    values, exact : array_like
        Arrays of one shape.
    weights : array_like
        Weights of the squares, of a shape that is broadcast to theirs.
    """
    reference, factors = np.asarray(exact, np.float64), np.asarray(weights, np.float64)
    difference = np.asarray(values, np.float64) - reference
    return float(np.sqrt(np.sum(factors * difference**2) / np.sum(factors * reference**2)))


def relative_rms_on_sphere(pixels: npt.ArrayLike, exact: npt.ArrayLike) -> float:
    """Return the relative RMS difference of two lat-long maps (H, W, 3), texels weighted by solid angle."""
    H, W = np.shape(exact)[:2]
    return relative_rms(pixels, exact, layouts.solid_angles("latlong", H, W)[..., None])
