"""Nodes over the light directions in the frame of a lobe's center, exact about the horizon.

In the frame of the central direction C (z axis), with N and V at azimuth 0,

    N = (sin gamma, 0, cos gamma)      V = (sin theta_o, 0, cos theta_o)
    L = (sin theta_i cos phi, sin theta_i sin phi, cos theta_i)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from shrm import _core
from shrm.arrays import FloatArray

Transfer = Callable[[FloatArray, FloatArray], FloatArray]
"""rho_hat(wi, wo), (n, 3) unit vectors in the frame of the normal to (n,) or (n, 3)."""

_BLOCK = 5400
"""Directions asked of a lobe at once: their vectors stay below 128 KiB, where malloc maps new pages."""


@dataclass(frozen=True)
class Quadrature:
    """Nodes over the light directions in the frame of C, one set per view.

    Attributes
    ----------
    theta_i, weight_theta : (views, I) float64
        Colatitudes, and weights that include sin(theta_i).
    arc : (views, I) float64
        The azimuths run over [0, arc], at most pi, and stand for both signs.
    share, weight_share : (K,) float64
        Nodes and weights on [0, 1]: phi_k = arc share_k, its weight 2 arc weight_share_k.
    """

    theta_i: FloatArray
    weight_theta: FloatArray
    arc: FloatArray
    share: FloatArray
    weight_share: FloatArray

    @property
    def shape(self) -> tuple[int, int, int]:
        """(views, K, I), the shape of a table over the nodes."""
        views, I = self.theta_i.shape
        return views, len(self.share), I


@lru_cache(maxsize=256)
def leggauss(n: int) -> tuple[FloatArray, FloatArray]:
    """Return Gauss-Legendre nodes and weights on [-1, 1], kept for the next call."""
    return np.polynomial.legendre.leggauss(n)


@lru_cache(maxsize=256)
def unit_gauss(n: int) -> tuple[FloatArray, FloatArray]:
    """Return Gauss-Legendre nodes and weights on [0, 1], kept for the next call."""
    x, w = leggauss(n)
    return (x + 1) / 2, w / 2


@lru_cache(maxsize=256)
def _root_gauss(n: int) -> tuple[FloatArray, FloatArray]:
    """Return Gauss nodes in t of sin^2(pi t / 2), on [0, 1]: square-root ends of functions become smooth."""
    t, w = unit_gauss(n)
    return np.sin(np.pi / 2 * t) ** 2, np.pi / 2 * np.sin(np.pi * t) * w


_SLENDER = 5e-3
"""Width below which azimuths lie in panels that shrink. Such lobes do not reach the horizon until views graze
it, and are then many times as long as wide; K Gauss nodes see wider ones to 3e-5."""
_SMALLEST_SHARE = 12
"""Halvings of those panels at most: the views of an analysis are a thousandth of a radian from the horizon or
more, and lobes 2^-10 as wide as long."""
_SLENDERNESS = 64.0
"""Length of a lobe by its width where views begin to weigh little: a hundredth of a radian from grazing."""
_AZIMUTH_WAVES = 24 * np.pi
"""Radians, for each unit of the share, of the largest azimuthal order that they resolve."""


@lru_cache(maxsize=64)
def _shrinking_gauss(halvings: int, least: int) -> tuple[FloatArray, FloatArray]:
    """Gauss nodes and weights on panels of [0, 1] that shrink by halves towards both ends."""
    half = 0.5 ** np.arange(halvings, 0.0, -1.0)
    edges = np.concatenate([[0.0], half, 1.0 - half[-2::-1], [1.0]])
    nodes, weights = panels(edges[None], _AZIMUTH_WAVES, least, roots=0)
    return nodes[0], weights[0]


def _azimuths(width: float, K: int) -> tuple[FloatArray, FloatArray]:
    """Shares of the arc and their weights, for a lobe of some width: K of them, or more if it is slender."""
    if width >= _SLENDER:
        return unit_gauss(K)
    return _shrinking_gauss(min(int(np.ceil(-np.log2(width))), _SMALLEST_SHARE), max(K // 6, 3))


def panels(edges: FloatArray, L: float, least: int, roots: int) -> tuple[FloatArray, FloatArray]:
    """Return composite Gauss nodes and weights on the panels between edges (views, n+1).

    The last `roots` panels are for functions with square-root ends.
    """
    lengths = np.diff(edges, axis=1)
    # f_lq turns by L radians per radian; Gauss needs pi nodes per wave, half a node per radian
    counts = least + np.ceil(0.5 * L * lengths.max(axis=0)).astype(int)
    smooth = len(counts) - roots
    rules = [unit_gauss(n) if i < smooth else _root_gauss(n) for i, n in enumerate(counts.tolist())]
    panel = np.repeat(np.arange(len(counts)), counts)
    length = np.take(lengths, panel, axis=1)
    nodes = np.take(edges, panel, axis=1) + length * np.concatenate([x for x, _ in rules])
    return nodes, length * np.concatenate([w for _, w in rules])


def horizon_quadrature(gamma: FloatArray, width: float, L: int, K: int, least: int = 10) -> Quadrature:
    """Return nodes for lobes that end at N.L = 0, exact about that edge.

    Parameters
    ----------
    gamma : (views,) float64
        Angles between C and N in [0, pi/2], radians.
    width : float
        Angle within which most of the lobe lies, radians: panels double in size from there.
    L : int
        Largest degree to be integrated.
    K : int
        Azimuths for each colatitude; lobes narrower than 5e-3 get more.
    least : int
        Colatitudes in each panel, before those that L needs.

    Returns
    -------
    Quadrature
    """
    # Panels in theta_i: up to `full` the whole circle is above the horizon, beyond it an arc. A slender lobe
    # begins to fall where it is narrowest.
    full = np.pi / 2 - gamma
    first = width if width >= _SLENDER else width / _SLENDERNESS
    rungs = first * 2.0 ** np.arange(max(np.ceil(np.log2(full.max() / first)), 0))
    inner = np.minimum(np.concatenate([[0.0], rungs, [np.pi]]), full[:, None])
    outer = full[:, None] + 2 * gamma[:, None] * np.array([0.25, 1.0])
    # The length of the arc has square roots at both ends of the outer panels.
    theta_i, weight = panels(np.concatenate([inner, outer], axis=1), L, least, roots=2)

    # The arc of phi where N.L > 0: cos(phi) > -cot(gamma) cot(theta_i)
    with np.errstate(divide="ignore"):
        limit = -1 / (np.tan(gamma[:, None]) * np.tan(theta_i))
    arc = np.where(theta_i <= full[:, None], np.pi, np.arccos(np.clip(limit, -1, 1)))
    # Gauss in azimuth even where the arc is a whole circle: it is dense where lobes are narrow, at phi = 0.
    return Quadrature(theta_i, weight * np.sin(theta_i), arc, *_azimuths(width, K))


def whole_quadrature(width: float, L: int) -> Quadrature:
    """Return nodes over the whole sphere, for radial lobes: one view and one azimuth."""
    rungs = width * 2.0 ** np.arange(np.ceil(np.log2(np.pi / 2 / width)))
    edges = np.concatenate([[0.0], rungs[rungs < np.pi / 2], [np.pi / 2, np.pi]])
    theta_i, weight = panels(edges[None], L, least=12, roots=len(edges) - 1)
    return _without_azimuth(theta_i, weight)


def ring_edges(rings: FloatArray, width: float) -> FloatArray:
    """Edges of panels from 0 to pi, (views, n), that double in size from `width` on, on both sides of rings.

    Rings are colatitudes (views, m), radians.
    """
    rungs = width * 2.0 ** np.arange(max(np.ceil(np.log2(np.pi / width)), 0))
    steps = np.concatenate([-rungs[::-1], [0.0], rungs])
    edges = (rings[..., None] + steps).reshape(len(rings), -1)
    ends = np.tile([0.0, np.pi], (len(rings), 1))
    return np.sort(np.clip(np.concatenate([ends, edges], axis=1), 0.0, np.pi), axis=1)


def panel_quadrature(edges: FloatArray, L: int) -> Quadrature:
    """Nodes over the whole sphere on panels of colatitude between edges (views, n): one azimuth."""
    theta_i, weight = panels(edges, L, least=12, roots=0)
    return _without_azimuth(theta_i, weight)


def uniform_quadrature(views: int, L: int, count: int = 8) -> Quadrature:
    """Return nodes over the sphere with no preferred colatitude, for lobes about the tangent: one azimuth."""
    edges = np.tile(np.linspace(0, np.pi, count + 1), (views, 1))
    theta_i, weight = panels(edges, L, least=24, roots=count)
    return _without_azimuth(theta_i, weight)


def _without_azimuth(theta_i: FloatArray, weight: FloatArray) -> Quadrature:
    """Return nodes in theta_i that stand for all azimuths."""
    arc = np.full_like(theta_i, np.pi)
    return Quadrature(theta_i, weight * np.sin(theta_i), arc, np.zeros(1), np.ones(1))


def tabulate(transfer: Transfer, theta_v: FloatArray, gamma: FloatArray, nodes: Quadrature) -> FloatArray:
    """Evaluate rho_hat at the nodes, (views, K, I, channels), L and V carried from C's frame to that of N."""
    views, K, I = nodes.shape
    step = max(_BLOCK // (K * I), 1)
    blocks = [slice(v, min(v + step, views)) for v in range(0, views, step)]
    parts = [columns(transfer(*light_and_view(theta_v, gamma, nodes, block))) for block in blocks]
    return np.concatenate(parts).reshape(views, K, I, -1)


def light_and_view(
    theta_v: FloatArray, gamma: FloatArray, nodes: Quadrature, block: slice
) -> tuple[FloatArray, FloatArray]:
    """Return wi and wo at the nodes of some views, with phi in [0, arc], V at azimuth 0 about N.

    (views K I, 3) each, their components contiguous.
    """
    wi, wo = _core.directions(
        theta_v=theta_v[block],
        gamma=gamma[block],
        theta_i=nodes.theta_i[block],
        arc=nodes.arc[block],
        share=nodes.share,
    )
    return wi.reshape(3, -1).T, wo.reshape(3, -1).T


def columns(values: FloatArray) -> FloatArray:
    """Return (n,) values as (n, 1), and (n, 3) as they are."""
    return values if values.ndim == 2 else values[:, None]
