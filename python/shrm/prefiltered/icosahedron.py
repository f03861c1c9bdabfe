"""The vertices of an icosahedron as views, and the weights of other views between them [CON99]."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray

VERTICES = 12


def icosahedron() -> FloatArray:
    """Return the twelve vertices of an icosahedron on the unit sphere, two of them at +z and -z; (12, 3)."""
    phi = np.pi / 5 * np.arange(10)
    z = np.where(np.arange(10) % 2 == 0, 1, -1) / np.sqrt(5)
    ring = np.stack([np.sqrt(0.8) * np.cos(phi), np.sqrt(0.8) * np.sin(phi), z], axis=1)
    return np.concatenate([[[0, 0, 1.0]], ring, [[0, 0, -1.0]]])


@cache
def faces() -> npt.NDArray[np.intp]:
    """Return the vertices of each triangle of `icosahedron`, (20, 3), counterclockwise from outside."""
    v = icosahedron()
    near = v @ v.T > 0.4  # neighbors are at 1 / sqrt(5), others at most at its negative
    triples = [t for t in combinations(range(VERTICES), 3) if all(near[a, b] for a, b in combinations(t, 2))]
    outward = [(a, b, c) if np.linalg.det(v[[a, b, c]]) > 0 else (a, c, b) for a, b, c in triples]
    return np.array(outward)


@cache
def coordinates() -> FloatArray:
    """Return the matrices m, (20, 3, 3), for which view @ m are coordinates along a triangle's corners."""
    return np.asarray(np.linalg.inv(icosahedron()[faces()]), np.float64)


def weights(views: FloatArray) -> FloatArray:
    """Return the weights of the twelve views for other views: spherical barycentric coordinates.

    In the triangle that holds a view, each vertex has the share of the solid angle opposite to it.

    Parameters
    ----------
    views : (n, 3) float64
        Unit vectors.

    Returns
    -------
    (n, 12) float64
        Each at least 0, their sum 1, at most three of them above 0.
    """
    v = icosahedron()
    # The triangle that holds a view is the one whose least coordinate is largest.
    inside = (views @ coordinates()).min(axis=2)  # (20, n)
    face = faces()[inside.argmax(axis=0)]
    a, b, c = v[face].transpose(1, 0, 2)
    shares = np.stack([solid_angle(views, b, c), solid_angle(a, views, c), solid_angle(a, b, views)], axis=1)
    shares = np.maximum(shares, 0)  # rounding on an edge makes them negative
    result = np.zeros((len(views), VERTICES))
    np.put_along_axis(result, face, shares / shares.sum(axis=1, keepdims=True), axis=1)
    return result


def solid_angle(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return the solid angles (n,) of triangles of unit vectors (n, 3), positive counterclockwise [OS83]."""
    volume = np.einsum("nk,nk->n", a, np.cross(b, c))
    dots = sum(np.einsum("nk,nk->n", *pair) for pair in ((a, b), (b, c), (c, a)))
    return np.asarray(2 * np.arctan2(volume, 1 + dots))
