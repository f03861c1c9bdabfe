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

from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.brdf.lobe import Center
from shrm.explicit import fit, icosahedron
from shrm.reflection_map import FloatArray, Interpolation, Part, ReflectionMap, zonal_harmonics
from shrm.validation import one_of, real_array, unit_vectors

Float32Array = npt.NDArray[np.float32]


@cache
def faces() -> npt.NDArray[np.intp]:
    """Indices (20, 3) of the vertices of each triangle of `icosahedron`, counterclockwise from outside."""
    v = icosahedron()
    near = v @ v.T > 0.4  # neighbours are at 1 / sqrt(5), others at most at its negative
    triples = [t for t in combinations(range(len(v)), 3) if all(near[a, b] for a, b in combinations(t, 2))]
    outward = [(a, b, c) if np.linalg.det(v[[a, b, c]]) > 0 else (a, c, b) for a, b, c in triples]
    return np.array(outward)


@cache
def coordinates() -> FloatArray:
    """Return the matrices m, (20, 3, 3), for which view @ m are coordinates along a triangle's corners."""
    return np.asarray(np.linalg.inv(icosahedron()[faces()]), np.float64)


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
    inside = (views @ coordinates()).min(axis=2)  # (20, n)
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


@dataclass(frozen=True, eq=False)
class IcosahedralMaps:
    """Twelve reflection maps of a material, blended for the views between them.

    Attributes
    ----------
    maps : tuple of 12 ReflectionMap
        One for each vertex of `shrm.explicit.icosahedron`: a map that is the same for all views, P = 0.
    """

    maps: tuple[ReflectionMap, ...]

    def __post_init__(self) -> None:
        if len(self.maps) != len(icosahedron()):
            raise ValueError(f"maps must be {len(icosahedron())}, got {len(self.maps)}")

    @classmethod
    def of(cls, rm: ReflectionMap) -> IcosahedralMaps:
        """Return the maps that a SHRM has for the twelve views: between them it is not asked.

        Parameters
        ----------
        rm : ReflectionMap
            Of any material; each of its lobes gets twelve maps of its own, about its centre and on its grid,
            which is a cube for maps that the GPU is to draw.

        Raises
        ------
        TypeError
            If it is no reflection map.
        """
        if not isinstance(rm, ReflectionMap):
            raise TypeError(f"rm must be a ReflectionMap, got {type(rm).__name__}")
        lobes = [_at_vertices(part) for part in rm.parts]
        return cls(tuple(replace(rm, parts=parts) for parts in zip(*lobes, strict=True)))

    @classmethod
    def fitted(cls, maps: npt.ArrayLike, center: Center = "reflection") -> IcosahedralMaps:
        """Return them from pictures.

        Parameters
        ----------
        maps : (12, H, 2 H, 3) array_like
            Lat-long maps over the central direction, H even, in the order of `shrm.explicit.icosahedron`.
        center : {"reflection", "normal", "tangent"}
            The central direction by which they are looked up.

        Raises
        ------
        TypeError, ValueError
            If the maps have another shape.
        """
        pixels, views = real_array("maps", maps), icosahedron()
        if pixels.ndim != 4 or len(pixels) != len(views):
            raise ValueError(f"maps must have the shape (12, H, 2 H, 3), got {pixels.shape}")
        one = [slice(k, k + 1) for k in range(len(views))]
        return cls(tuple(fit(pixels[k], views[k], P=0, center=center) for k in one))

    @property
    def clamp(self) -> bool:
        """Whether negative radiance is set to zero when read."""
        return self.maps[0].clamp

    @property
    def nbytes(self) -> int:
        """Bytes of the maps."""
        return sum(part.rings.nbytes for rm in self.maps for part in rm.parts)

    def radiance(
        self,
        normals: npt.ArrayLike,
        views: npt.ArrayLike,
        tangents: npt.ArrayLike | None = None,
        *,
        interpolation: Interpolation = "cubic",
    ) -> Float32Array:
        """Return the radiance reflected towards the eye, (n, 3); all as `ReflectionMap.radiance` has it."""
        one_of("interpolation", interpolation, ("cubic", "bilinear"))
        N = unit_vectors("normals", normals)
        V = unit_vectors("views", views, 1 if np.ndim(views) == 1 else len(N))
        T = None if tangents is None else unit_vectors("tangents", tangents, len(N))
        shares = np.broadcast_to(weights(V), (len(N), len(self.maps)))
        V = np.broadcast_to(V, N.shape)
        result = np.zeros(N.shape, np.float32)
        for k, rm in enumerate(self.maps):
            near = np.flatnonzero(shares[:, k])
            if len(near):
                found = rm.radiance(
                    N[near], V[near], None if T is None else T[near], interpolation=interpolation
                )
                result[near] += shares[near, k, None] * found
        return result


def _at_vertices(part: Part) -> list[Part]:
    """The maps of one lobe for each vertex, borders included [RH02 eq. 12]."""
    views = icosahedron()
    rings = np.asarray(part.rings, np.float32)
    if part.zonal:  # the angle between C and V is another one at every texel
        C = part.ring_directions()
        of_views = [
            np.einsum("hwp,hpcw->hcw", zonal_harmonics(part.P, C @ view), rings, optimize=True)
            for view in views
        ]
    else:
        Y = sh.evaluate(np.eye((part.P + 1) ** 2), views)
        of_views = list(np.tensordot(Y.astype(np.float32), rings, axes=(1, 1)))
    constant = np.sqrt(4.0 * np.pi)  # Y_00 times it is 1
    return [
        replace(
            part,
            zonal=False,
            light=np.zeros((0, 3)),
            rho=np.zeros((0, 1, 1, 3)),
            rings=np.ascontiguousarray(constant * of_view[:, None], np.float32),
        )
        for of_view in of_views
    ]
