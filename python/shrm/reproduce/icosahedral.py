"""Cabral's rendering from twelve reflection maps, for views at the vertices of an icosahedron [CON99].

A point looks up the maps of the three vertices around its view, all at its reflection R, and blends them with
the barycentric weights of the spherical triangle. [CON99] has maps over normals, which it warps along R to
the new view before it blends them; maps over R need no warp [RH02 section 3.1].

References
----------
[CON99] B. Cabral, M. Olano, P. Nemec. Reflection Space Image Based Rendering. SIGGRAPH 1999.
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
[OS83] A. van Oosterom, J. Strackee. The Solid Angle of a Plane Triangle. IEEE Transactions on Biomedical
    Engineering 30(2), 1983.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import numpy.typing as npt

from shrm.brdf.lobe import Center, FloatArray
from shrm.explicit import fit, icosahedron
from shrm.reference import AngularReflection

Float32Array = npt.NDArray[np.float32]


@cache
def faces() -> npt.NDArray[np.intp]:
    """Indices (20, 3) of the vertices of each triangle of `icosahedron`, counterclockwise from outside."""
    v = icosahedron()
    near = v @ v.T > 0.4  # neighbours are at 1 / sqrt(5), others at most at its negative
    triples = [t for t in combinations(range(len(v)), 3) if all(near[a, b] for a, b in combinations(t, 2))]
    outward = [(a, b, c) if np.linalg.det(v[[a, b, c]]) > 0 else (a, c, b) for a, b, c in triples]
    return np.array(outward)


def weights(views: FloatArray) -> FloatArray:
    """Return the weights of the twelve views for others: spherical barycentric coordinates.

    Of the triangle that holds a view, each vertex has the share of the solid angle that lies opposite to it.

    Parameters
    ----------
    views : (n, 3) float64
        Unit vectors.

    Returns
    -------
    (n, 12) float64
        At least 0, of sum 1, and not 0 for at most three.
    """
    v = icosahedron()
    inside = np.stack([views @ np.linalg.inv(v[face]) for face in faces()]).min(axis=2)  # (20, n)
    face = faces()[inside.argmax(axis=0)]
    a, b, c = v[face].transpose(1, 0, 2)
    shares = np.stack([solid_angle(views, b, c), solid_angle(a, views, c), solid_angle(a, b, views)], axis=1)
    shares = np.maximum(shares, 0)  # on an edge, rounding makes it negative
    result = np.zeros((len(views), len(v)))
    np.put_along_axis(result, face, shares / shares.sum(axis=1, keepdims=True), axis=1)
    return result


def solid_angle(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Solid angles (n,) of triangles of unit vectors (n, 3), positive where counterclockwise [OS83]."""
    volume = np.einsum("nk,nk->n", a, np.cross(b, c))
    dots = sum(np.einsum("nk,nk->n", *pair) for pair in ((a, b), (b, c), (c, a)))
    return np.asarray(2 * np.arctan2(volume, 1 + dots))


class IcosahedralMaps:
    """Twelve explicit reflection maps.

    Parameters
    ----------
    exact : AngularReflection
        What integrates the maps, lat-long, of lobes about one centre.
    center : {"reflection", "tangent"}
        The direction that they are looked up by, which is that of `exact`.
    """

    def __init__(self, exact: AngularReflection, center: Center):
        views = icosahedron()
        maps = np.stack([_only(exact.at_view(view)) for view in views])
        self.nbytes = maps.nbytes
        # a map for one view is a SHRM of P = 0
        self._maps = [fit(maps[k : k + 1], views[k : k + 1], P=0, center=center) for k in range(len(views))]

    def radiance(
        self, normals: Float32Array, views: Float32Array, tangents: Float32Array | None = None
    ) -> Float32Array:
        """Return the reflected radiance (n, 3) for unit vectors (n, 3), by cubic look-ups."""
        toward_eye = np.asarray(views, np.float64)
        shares = weights(toward_eye / np.linalg.norm(toward_eye, axis=1, keepdims=True))
        result = np.zeros(normals.shape, np.float32)
        for k, rm in enumerate(self._maps):
            near = np.flatnonzero(shares[:, k])
            if len(near):
                T = None if tangents is None else tangents[near]
                result[near] += shares[near, k, None] * rm.radiance(normals[near], views[near], T)
        return result


def _only(maps: Float32Array | dict[str, Float32Array]) -> Float32Array:
    if isinstance(maps, dict):
        raise ValueError(f"the lobes must have one centre, got {', '.join(maps)}")
    return maps
