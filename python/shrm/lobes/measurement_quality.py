"""The quality of measurements, to be known before they are trusted: reciprocity, energy, coverage.

Nothing is mended, here or by the readers: a material that reflects more than it receives does so in pictures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shrm.arrays import BoolArray, FloatArray
from shrm.brdf import Measured
from shrm.lobes.center import lobe_center
from shrm.lobes.quadrature import horizon_quadrature, tabulate

VIEWS = np.radians([0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85, 89])
"""Angles between N and V at which albedos are taken, radians."""

_DEGREES, _AZIMUTHS = 60, 48
"""Largest degree that the quadrature of albedos is exact for, and its azimuths: with more, albedos of real
files change by less than 1e-3."""


@dataclass(frozen=True)
class Quality:
    """The quality of a measured material.

    Attributes
    ----------
    reciprocity_error : float
        Mean of |f(L, V) - f(V, L)| over that of f, both weighted by (N.L)(N.V), over pairs with data both
        ways; 0 if f is reciprocal.
    albedo : (views, 3) float64
        Directional albedo at the angles `VIEWS`: the share of light from everywhere that is reflected.
    covered : float
        Share of all pairs of directions for which there is data, by solid angle.
    covered_to : float
        Angle from the normal, radians, to which (almost) every pair has data: nine tenths in each band of
        5 degrees.
    """

    reciprocity_error: float
    albedo: FloatArray
    covered: float
    covered_to: float

    @property
    def largest_albedo(self) -> tuple[float, float]:
        """The largest albedo of all channels, and the angle of its view, radians."""
        row = int(np.argmax(self.albedo.max(axis=1)))
        return float(self.albedo[row].max()), float(VIEWS[row])


def quality(material: Measured, pairs: int = 1 << 16) -> Quality:
    """Assess a measured material.

    Parameters
    ----------
    material : Measured
        An isotropic material, as all that are read are.
    pairs : int
        Pairs of directions of a fixed sequence; errors of means fall with its root, or faster.

    Returns
    -------
    Quality
    """
    L, V = _pairs(pairs)
    data = material.covers(L, V)
    both_ways = (data & material.covers(V, L))[:, None]
    forth = both_ways * material.function(L, V) * V[:, 2:]  # f (N.L)(N.V)
    back = both_ways * material.function(V, L) * L[:, 2:]
    mean = 0.5 * float((forth + back).sum())
    return Quality(
        reciprocity_error=float(np.abs(forth - back).sum()) / mean if mean > 0 else 0.0,
        albedo=_albedo(material),
        covered=float(data.mean()),
        covered_to=_covered_to(L, V, data),
    )


def _albedo(material: Measured) -> FloatArray:
    """Integrate the directional albedo at the angles `VIEWS`, (views, 3)."""
    transfer = material.lobes[0].function
    nodes = horizon_quadrature(VIEWS, lobe_center(transfer)[1], _DEGREES, _AZIMUTHS)
    values = tabulate(transfer, VIEWS, VIEWS, nodes)
    over_azimuth = 2 * np.einsum("k,vkic->vic", nodes.weight_share, values) * nodes.arc[..., None]
    return np.asarray(np.einsum("vi,vic->vc", nodes.weight_theta, over_azimuth))


def _covered_to(L: FloatArray, V: FloatArray, data: BoolArray) -> float:
    """Return the angle from the normal, radians, up to which nine tenths of each 5 degrees have data."""
    step = np.radians(5)
    farther = np.arccos(np.minimum(L[:, 2], V[:, 2]))
    band = np.minimum((farther / step).astype(int), 17)
    shares = [data[band == k].mean() if np.any(band == k) else 1.0 for k in range(18)]
    short = [k for k, share in enumerate(shares) if share < 0.9]
    return float(step * (short[0] if short else 18))


def _pairs(count: int) -> tuple[FloatArray, FloatArray]:
    """Return pairs of directions above the horizon, uniform by solid angle, from the roots of primes."""
    i = np.arange(1, count + 1)[:, None]
    a, b, c = (i * np.sqrt([2.0, 3.0, 5.0]) % 1).T
    directions = []
    for z, phi in ((a, 2 * np.pi * c), (b, np.zeros(count))):
        s = np.sqrt(1 - z * z)
        directions.append(np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1))
    return directions[0], directions[1]
