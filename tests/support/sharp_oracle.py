"""Reflected radiance of lobes far narrower than a texel, in float64; shares no code with shrm.

The lights within `NEAR` of the mirror direction are visited in rings about it that shrink towards it, the
picture constant over each texel; those beyond as in `oracles.reflected`, where such lobes are smooth.
"""

from collections.abc import Callable

import numpy as np

from support import oracles

Array = np.ndarray
Transfer = Callable[[Array, Array], Array]

NEAR = np.radians(12.0)
HALVINGS, NODES, AZIMUTHS = 11, 10, 96
"""The smallest ring is 12 / 2^11 degrees wide."""


def reflected(
    pixels: Array,
    transfer: Callable[[Array, Array], Array],
    normals: Array,
    views: Array,
    subsamples: int = 2,
) -> Array:
    """Radiance (n, 3) of a lobe about the normal, transfer(wi (m, 3), wo (m or 1, 3)) -> (m, 3)."""

    def far(wi: Array, wo: Array) -> Array:
        mirror = wo * [-1.0, -1.0, 1.0]
        beyond = wi @ mirror[0] < np.cos(NEAR)
        return transfer(wi, wo) * beyond[:, None]

    total = oracles.reflected(pixels, far, normals, views, subsamples=subsamples)
    frames = oracles.frames(normals, views)
    rings, weights = _rings()
    for k, frame in enumerate(frames):
        wo = views[k] @ frame
        mirror = wo * [-1.0, -1.0, 1.0]
        wi = rings @ oracles.frames(mirror[None], np.array([[0.0, 1.0, 0.0]]))[0].T
        above = wi[:, 2] > 0
        rho = transfer(wi[above], wo[None])
        total[k] += (weights[above, None] * rho * _texels(pixels, wi[above] @ frame.T)).sum(axis=0)
    return total


def _rings() -> tuple[Array, Array]:
    """Directions about z within NEAR, and their solid angles."""
    edges = NEAR * np.concatenate([[0.0], 0.5 ** np.arange(HALVINGS, -1, -1.0)])
    x, w = np.polynomial.legendre.leggauss(NODES)
    theta = (edges[:-1, None] + np.diff(edges)[:, None] * (x + 1) / 2).ravel()
    weight = (np.diff(edges)[:, None] * w / 2).ravel() * np.sin(theta) * 2 * np.pi / AZIMUTHS
    phi = 2 * np.pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    t, p = np.meshgrid(theta, phi, indexing="ij")
    directions = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)
    return directions.reshape(-1, 3), np.repeat(weight, AZIMUTHS)


def _texels(pixels: Array, w: Array) -> Array:
    """The texels that directions (n, 3) fall in."""
    H, W, _ = pixels.shape
    i = np.minimum((np.arccos(np.clip(w[:, 2], -1, 1)) * H / np.pi).astype(int), H - 1)
    j = ((np.pi - np.arctan2(w[:, 1], w[:, 0])) * W / (2 * np.pi)).astype(int) % W
    return pixels[i, j].astype(np.float64)
