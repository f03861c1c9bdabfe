"""Tables over half angles of BRDFs that take long to evaluate, and what they hold beyond their data.

A fit or an interpolation is evaluated once at the nodes of a table, whose look-up costs the same for all. The
nodes are even in the square root of theta_h, which gathers them about the mirror direction, and in theta_d and
phi_d. Directions farther from the normal than the data go are brought back to the last that have some, at
the same azimuth ("nearest"), or are black ("zero").
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shrm.brdf.angle_table import AngleTable
from shrm.brdf.lobe import FloatArray
from shrm.brdf.measured.material import BoolArray, Extrapolate

SHAPE = (46, 91, 37)
"""Nodes in theta_h, theta_d and phi_d."""

Function = Callable[[FloatArray, FloatArray], FloatArray]
Covers = Callable[[FloatArray, FloatArray], BoolArray]


def resampled(
    brdf: Function, theta_i: float, theta_o: float, extrapolate: Extrapolate
) -> tuple[Function, Covers]:
    """Put a BRDF into a table.

    Parameters
    ----------
    brdf : callable
        wi, wo, (n, 3) float64 unit vectors within the given angles of the normal, to the BRDF without the
        cosine, (n, 3) float64.
    theta_i, theta_o : float
        The largest angles of wi and wo from the normal at which it has data, in (0, pi/2).
    extrapolate : {"nearest", "zero"}
        What there is beyond.

    Returns
    -------
    function, covers : callable
        rho_hat with the cosine in it, and where it has data: as `Measured` takes them.
    """
    wi, wo = half_angle_nodes(SHAPE)
    values = brdf(within(wi, theta_i), within(wo, theta_o))
    table = AngleTable(
        np.ascontiguousarray(values.reshape(*SHAPE, 3), np.float32), "half-angle", "ends", "square-root"
    )
    # Cosines, with room for the rounding of a direction at the limit itself.
    least_i, least_o = np.cos(theta_i) - 1e-7, np.cos(theta_o) - 1e-7

    def covers(wi: FloatArray, wo: FloatArray) -> BoolArray:
        return (wi[:, 2] >= least_i) & (wo[:, 2] >= least_o)

    def function(wi: FloatArray, wo: FloatArray) -> FloatArray:
        result = table(wi, wo)
        result *= wi[:, 2:] if extrapolate == "nearest" else (wi[:, 2] * covers(wi, wo))[:, None]
        return result

    return function, covers


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
    """Return wi and wo, (n, 3), of half angles [R98] (n,): H at azimuth 0, wi at (theta_d, phi_d) about it."""
    along, across = np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d)
    sin_h, cos_h, cos_d = np.sin(theta_h), np.cos(theta_h), np.cos(theta_d)
    wi = np.stack([along * cos_h + cos_d * sin_h, across, cos_d * cos_h - along * sin_h], axis=1)
    wo = np.stack([-along * cos_h + cos_d * sin_h, -across, cos_d * cos_h + along * sin_h], axis=1)
    return wi, wo
