"""The central direction C of a lobe: the angle gamma between C and the normal, for every view.

gamma = theta_v makes C the reflection R of the paper, gamma = 0 the normal. The *lobe center* takes gamma so
that C is the mean direction of rho_hat^2. Renderers look gamma(theta_v) up in a short table, as the analysis
and the integrators do.

Sources: [RH02].
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf.lobe import Center
from shrm.brdf.peaks import NARROW, narrower, peak_about_reflection
from shrm.lobes.quadrature import Transfer, horizon_quadrature, tabulate

GAMMA_SIZE = 257
"""Entries of a table of gamma, uniform in theta_v over [0, pi/2], linear in between."""

_GRAZING = np.radians(89.5)  # the last view at which gamma is measured; models may vanish at 90 degrees


def gamma_table(center: Center, transfer: Transfer | None = None) -> FloatArray:
    """Return gamma over theta_v in [0, pi/2], (257,) float64 radians; empty about the tangent.

    `transfer` is needed for the lobe center only.
    """
    theta_v = np.linspace(0, np.pi / 2, GAMMA_SIZE)
    if center == "reflection":
        return theta_v
    if center == "normal":
        return np.zeros(GAMMA_SIZE)
    if center == "tangent":
        return np.zeros(0)
    assert transfer is not None
    return lobe_center(transfer)[0]


def gamma_at(gamma: FloatArray, theta_v: FloatArray) -> FloatArray:
    """Look gamma(theta_v) up in its table, linearly, as renderers do."""
    return np.interp(theta_v, np.linspace(0, np.pi / 2, len(gamma)), gamma)


@lru_cache(maxsize=64)
def lobe_center(transfer: Transfer) -> tuple[FloatArray, float]:
    """Return gamma (257,) of the mean direction of rho_hat^2, and the angle that holds half, radians."""
    # rho_hat^2 about R, with panels that double from a hundredth of a radian, or from part of a peak's width
    theta_v = np.linspace(0, _GRAZING, 25)
    peak = peak_about_reflection(transfer)
    start = 0.25 * peak if peak < NARROW else 0.01
    nodes = horizon_quadrature(theta_v, start, L=0, K=16, least=6)
    values = tabulate(transfer, theta_v, theta_v, nodes)
    energy = np.einsum("vkic,vkic->vki", values, values)

    # Its integrals over phi, and those of its part towards x
    ring = 2 * nodes.weight_theta * nodes.arc * (nodes.weight_share @ energy)
    energy *= np.cos(nodes.arc[:, None] * nodes.share[:, None])
    towards_x = 2 * nodes.weight_theta * nodes.arc * (nodes.weight_share @ energy)

    # gamma from the mean direction
    along_x = (towards_x * np.sin(nodes.theta_i)).sum(axis=1)
    along_z = (ring * np.cos(nodes.theta_i)).sum(axis=1)
    gamma = np.clip(theta_v - np.arctan2(along_x, along_z), 0, np.pi / 2)
    gamma[0] = 0  # by symmetry

    # theta_o = theta_v + gamma must not fall, nor C leave the quadrant between N and the horizon.
    fine = np.linspace(0, np.pi / 2, GAMMA_SIZE)
    measured = _hermite(theta_v, gamma, np.minimum(fine, _GRAZING))
    if peak < NARROW:
        measured += np.maximum(fine - _GRAZING, 0)  # a narrow lobe stays with R
    theta_o = np.maximum.accumulate(fine + measured)
    table = np.clip(theta_o - fine, 0, np.pi / 2)

    # The angle that holds half, at the narrowest view
    inside = np.cumsum(ring, axis=1)
    total = inside[:, -1]
    half = [t[np.searchsorted(e, e[-1] / 2)] for t, e in zip(nodes.theta_i, inside, strict=True) if e[-1] > 0]
    if not np.any(total > 0):
        return np.linspace(0, np.pi / 2, GAMMA_SIZE), 0.5
    return table, narrower(float(np.min(half)), peak)


def _hermite(x: FloatArray, y: FloatArray, points: FloatArray) -> FloatArray:
    """Interpolate y(x) at points by cubic Hermite polynomials with central differences as slopes."""
    slope = np.gradient(y, x)
    i = np.clip(np.searchsorted(x, points, side="right") - 1, 0, len(x) - 2)
    h = x[i + 1] - x[i]
    t = (points - x[i]) / h
    return np.asarray(
        (1 + 2 * t) * (1 - t) ** 2 * y[i]
        + t * (1 - t) ** 2 * h * slope[i]
        + t**2 * (3 - 2 * t) * y[i + 1]
        + t**2 * (t - 1) * h * slope[i + 1]
    )
