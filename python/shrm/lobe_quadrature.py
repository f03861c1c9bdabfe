"""Nodes over the light directions in the frame of a lobe's centre, exact about the horizon.

In the frame of the central direction C (z axis), with N and V at azimuth 0,

    N = (sin gamma, 0, cos gamma)      V = (sin theta_o, 0, cos theta_o)
    L = (sin theta_i cos phi, sin theta_i sin phi, cos theta_i)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Transfer = Callable[[FloatArray, FloatArray], FloatArray]
"""rho_hat(wi, wo), (n, 3) unit vectors in the frame of the normal to (n,) or (n, 3)."""


@dataclass(frozen=True)
class Quadrature:
    """Nodes over the light directions in the frame of C, one set per view.

    Attributes
    ----------
    theta_i, weight_theta : (views, I) float64
        Colatitudes, and weights that include sin(theta_i).
    phi, weight_phi : (views, I, K) float64
        Azimuths in [0, pi], and weights that count both signs.
    """

    theta_i: FloatArray
    weight_theta: FloatArray
    phi: FloatArray
    weight_phi: FloatArray


def gauss(a: FloatArray, b: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on [a, b], along a new last axis."""
    x, w = leggauss(n)
    half = (b - a)[..., None] / 2
    return a[..., None] + half * (x + 1), half * w


@lru_cache(maxsize=256)
def leggauss(n: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on [-1, 1], kept."""
    return np.polynomial.legendre.leggauss(n)


def panels(edges: FloatArray, L: int, least: int) -> tuple[FloatArray, FloatArray]:
    """Composite Gauss nodes on the panels between edges (views, n+1); enough for degree L on each."""
    nodes, weights = [], []
    for a, b in zip(edges[:, :-1].T, edges[:, 1:].T, strict=True):
        # f_lq turns by L radians per radian; Gauss needs pi nodes per wave, half a node per radian
        n = least + int(np.ceil(0.5 * L * float(np.max(b - a))))
        # theta = a + (b - a) sin^2: square-root ends, where the horizon enters, become smooth
        t, w = gauss(np.zeros_like(a), np.full_like(a, np.pi / 2), n)
        nodes.append(a[:, None] + (b - a)[:, None] * np.sin(t) ** 2)
        weights.append((b - a)[:, None] * np.sin(2 * t) * w)
    return np.concatenate(nodes, axis=1), np.concatenate(weights, axis=1)


def horizon_quadrature(gamma: FloatArray, width: float, L: int, K: int, least: int = 10) -> Quadrature:
    """Nodes for lobes that end at N.L = 0, exact about that edge.

    Parameters
    ----------
    gamma : (views,) float64
        Angles between C and N in [0, pi/2], radians.
    width : float
        Angle within which most of the lobe lies, radians: panels double in size from there.
    L : int
        Largest degree to be integrated.
    K : int
        Azimuths for each colatitude.
    least : int
        Colatitudes in each panel, before those that L needs.

    Returns
    -------
    Quadrature
    """
    full = np.pi / 2 - gamma  # below, the whole circle is above the horizon; above, an arc of it
    rungs = width * 2.0 ** np.arange(np.ceil(np.log2(np.pi / width)))
    inner = np.minimum(np.concatenate([[0.0], rungs])[None, :], full[:, None])
    outer = full[:, None] + 2 * gamma[:, None] * np.array([0.0, 0.25, 1.0])
    edges = np.concatenate([inner, outer], axis=1)
    theta_i, weight = panels(edges, L, least)
    # N.L > 0: cos(phi) > -cot(gamma) cot(theta_i)
    with np.errstate(divide="ignore"):
        limit = -1 / (np.tan(gamma[:, None]) * np.tan(theta_i))
    end = np.where(theta_i <= full[:, None], np.pi, np.arccos(np.clip(limit, -1, 1)))
    phi, weight_phi = gauss(np.zeros_like(end), end, K)
    return Quadrature(theta_i, weight * np.sin(theta_i), phi, 2 * weight_phi)


def whole_quadrature(views: int, width: float, L: int, K: int) -> Quadrature:
    """Nodes over the whole sphere, for lobes without a horizon."""
    rungs = width * 2.0 ** np.arange(np.ceil(np.log2(np.pi / 2 / width)))
    edges = np.concatenate([[0.0], rungs[rungs < np.pi / 2], [np.pi / 2, np.pi]])
    theta_i, weight = panels(np.tile(edges, (views, 1)), L, least=12)
    if K == 1:
        phi, weight_phi = np.zeros((*theta_i.shape, 1)), np.full((*theta_i.shape, 1), 2 * np.pi)
    else:
        phi, weight_phi = gauss(np.zeros_like(theta_i), np.full_like(theta_i, np.pi), K)
        weight_phi = 2 * weight_phi
    return Quadrature(theta_i, weight * np.sin(theta_i), phi, weight_phi)


def uniform_quadrature(views: int, L: int, K: int, count: int = 8) -> Quadrature:
    """Nodes over the whole sphere with no preferred colatitude, for lobes about the tangent."""
    edges = np.tile(np.linspace(0, np.pi, count + 1), (views, 1))
    theta_i, weight = panels(edges, L, least=24)
    phi, weight_phi = gauss(np.zeros_like(theta_i), np.full_like(theta_i, np.pi), K)
    return Quadrature(theta_i, weight * np.sin(theta_i), phi, 2 * weight_phi)


def tabulate(transfer: Transfer, theta_v: FloatArray, gamma: FloatArray, nodes: Quadrature) -> FloatArray:
    """rho_hat at the nodes, (views, I, K, channels): L and V carried from the frame of C to that of N."""
    sin_i, cos_i = np.sin(nodes.theta_i)[..., None], np.cos(nodes.theta_i)[..., None]
    x, y = sin_i * np.cos(nodes.phi), sin_i * np.sin(nodes.phi)
    c, s = np.cos(gamma)[:, None, None], np.sin(gamma)[:, None, None]
    wi = np.stack([x * c - cos_i * s, y, x * s + cos_i * c], axis=-1)
    wo = np.stack([np.sin(theta_v), np.zeros_like(theta_v), np.cos(theta_v)], axis=-1)
    wo = np.broadcast_to(wo[:, None, None, :], wi.shape)
    values = transfer(wi.reshape(-1, 3), np.ascontiguousarray(wo.reshape(-1, 3)))
    return columns(values).reshape(*nodes.phi.shape, -1)


def columns(values: FloatArray) -> FloatArray:
    """Return (n,) values as (n, 1), and (n, 3) as they are."""
    return values if values.ndim == 2 else values[:, None]
