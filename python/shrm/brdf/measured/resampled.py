"""Tables over half angles of BRDFs that take long to evaluate, and what they hold beyond their data.

A fit or an interpolation is evaluated once at the nodes of a table, whose look-up costs the same for all.
The nodes are even in the square root of theta_h, which gathers them about the mirror direction, and in
theta_d and phi_d [R98]. Directions farther from the normal than the data go are brought back to the last
that have some, at the same azimuth (`within`), or are black.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from shrm.arrays import BoolArray, FloatArray
from shrm.brdf.angle_table import AngleTable
from shrm.brdf.measured.measured import Extrapolate
from shrm.brdf.value import Value

SHAPE = (46, 91, 37)
"""Nodes in theta_h, theta_d and phi_d: 2 MB, exact to .2% where data is known to 1% (see `cornell`)."""

_BLOCK = 16384  # nodes evaluated at once: a fit's basis functions there take 7 MB, not 70

Function = Callable[[FloatArray, FloatArray], FloatArray]
"""Maps wi, wo, (n, 3) float64 unit vectors, to values (n, c) float64."""

Covers = Callable[[FloatArray, FloatArray], BoolArray]
"""Tells, (n,) bool, where there is data at wi, wo, (n, 3) float64 unit vectors."""


def resampled(brdf: Function, covers: Covers, extrapolate: Extrapolate) -> Function:
    """Put a BRDF into a table.

    Parameters
    ----------
    brdf : callable
        wi, wo, (n, 3) float64 unit vectors, to the BRDF without the cosine, (n, 3) float64. Asked for
        directions below the horizon too, at the nodes of cells that reach above it.
    covers : callable
        Where it has data.
    extrapolate : {"nearest", "zero"}
        What there is elsewhere: what the BRDF says, or nothing.

    Returns
    -------
    callable
        wi, wo, (n, 3) float64 above the horizon, to rho_hat (n, 3) float64, with the cosine in it.
    """
    wi, wo = half_angle_nodes(SHAPE)
    values = np.empty((len(wi), 3), np.float32)
    for start in range(0, len(wi), _BLOCK):
        block = slice(start, start + _BLOCK)
        values[block] = brdf(wi[block], wo[block])
    table = AngleTable(values.reshape(*SHAPE, 3), "half-angle", "ends", "square-root")
    return TableTimesCosine(table, covers if extrapolate == "zero" else None)


@dataclass(frozen=True, eq=False, repr=False)
class TableTimesCosine(Value):
    """A table of a BRDF times N.L.

    Attributes
    ----------
    table : AngleTable
        The BRDF without the cosine.
    covers : callable, optional
        Where there is data: it is black elsewhere. Everywhere, if not given.
    """

    table: AngleTable
    covers: Covers | None = None

    def __call__(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, (n, 3) float64, at unit vectors (n, 3) above the horizon."""
        values = self.table(wi, wo)
        values *= wi[:, 2:] if self.covers is None else (wi[:, 2] * self.covers(wi, wo))[:, None]
        return values


@dataclass(frozen=True, eq=False, repr=False)
class Cones(Value):
    """True where wi and wo lie within two cones about the normal.

    Smaller gaps between the geometries, such as goniometers have where the detector would shade the source,
    are interpolated across and count as covered.

    Attributes
    ----------
    theta_i, theta_o : float
        Angles from the normal, radians.
    """

    theta_i: float
    theta_o: float

    def __call__(self, wi: FloatArray, wo: FloatArray) -> BoolArray:
        """Tell, (n,) bool, for unit vectors (n, 3)."""
        # Cosines, with room for the rounding of a direction at the limit itself.
        least_i, least_o = np.cos(self.theta_i) - 1e-7, np.cos(self.theta_o) - 1e-7
        return np.asarray((wi[:, 2] >= least_i) & (wo[:, 2] >= least_o))


def within(w: FloatArray, theta: float) -> FloatArray:
    """Return unit vectors (n, 3) brought to at most an angle from the normal, at the same azimuth."""
    across = np.hypot(w[:, 0], w[:, 1])
    inside = w[:, 2] >= np.cos(theta)
    scale = np.where(inside, 1.0, np.sin(theta) / np.maximum(across, 1e-300))
    return np.stack([w[:, 0] * scale, w[:, 1] * scale, np.where(inside, w[:, 2], np.cos(theta))], axis=1)


def half_angle_nodes(shape: tuple[int, int, int]) -> tuple[FloatArray, FloatArray]:
    """Return wi and wo, (n, 3), at the nodes of a table in C order; some are below the horizon."""
    n_h, n_d, n_p = shape
    theta_h, theta_d, phi_d = np.meshgrid(
        np.linspace(0.0, 1.0, n_h) ** 2 * (np.pi / 2),
        np.linspace(0.0, np.pi / 2, n_d),
        np.linspace(0.0, np.pi, n_p),
        indexing="ij",
    )
    return from_half_angles(theta_h.ravel(), theta_d.ravel(), phi_d.ravel())


def from_half_angles(
    theta_h: FloatArray, theta_d: FloatArray, phi_d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return wi and wo, (n, 3), at half angles (n,) [R98]: H at azimuth 0, wi at (theta_d, phi_d) from it."""
    along, across = np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d)
    sin_h, cos_h, cos_d = np.sin(theta_h), np.cos(theta_h), np.cos(theta_d)
    wi = np.stack([along * cos_h + cos_d * sin_h, across, cos_d * cos_h - along * sin_h], axis=1)
    wo = np.stack([-along * cos_h + cos_d * sin_h, -across, cos_d * cos_h + along * sin_h], axis=1)
    return wi, wo
