"""Outgoing radiance of meshes by brute force, never importing shrm: rays in global directions, no expansion.

At a vertex with the normal N, towards a view v above it, for light that is the harmonic Y_j of order n,

    B_j = int_{N.d > 0} rho_hat(d, v) (V(d) Y_j(d) + (1 - V(d)) L_j(where the ray ends)) dd

with rho_hat of `oracles`, cosine included. The integral is a sum over a spiral around the world's z axis,
turned at random for each vertex; V is what `trimesh` finds of a ray from just above the vertex; and the light
of the object itself is diffuse,

    L_j = albedo / pi int cos V Y_j        with the normal interpolated where the ray ends,

by rays of its own from there. Nothing is interpolated between vertices but normals.
"""

from collections.abc import Callable

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation
from trimesh.ray import ray_pyembree

from support import oracles

Array = np.ndarray

_ABOVE = 1e-5
"""Height of the starts of rays above the surface, relative to the mesh's longest side."""


def spiral(count: int, turn: Array) -> Array:
    """Directions (count, 3) over the sphere, each standing for 4 pi / count."""
    k = np.arange(count) + 0.5
    z, phi = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    r = np.sqrt(1 - z**2)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1) @ turn.T


class BruteForce:
    """A mesh, as rays see it.

    Parameters
    ----------
    vertices, faces, normals : (V, 3), (T, 3), (V, 3)
        Normals of unit length.
    rays : int
        Over a sphere; half of them count.
    """

    def __init__(self, vertices: Array, faces: Array, normals: Array, rays: int = 16384) -> None:
        self.vertices, self.normals, self.rays = vertices, normals, rays
        self.faces = faces
        self.mesh = trimesh.Trimesh(vertices, faces, process=False)
        self.caster = ray_pyembree.RayMeshIntersector(self.mesh)
        self.above = _ABOVE * np.ptp(vertices[faces].reshape(-1, 3), axis=0).max()

    def radiance(
        self,
        p: int,
        views: Array,
        tangent: Array,
        transfer: Callable[[Array, Array], Array],
        n: int,
        albedo: float | None = None,
        seed: int = 0,
    ) -> Array:
        """B (views, n^2) at the vertex p towards views (views, 3) above it.

        Parameters
        ----------
        transfer : callable
            rho_hat(wi, wo), see `oracles`, with x along the tangent's part square to the normal.
        albedo : float, optional
            Of what the object's own light has been reflected by, once; without it there is none.
        """
        N = self.normals[p]
        d = spiral(self.rays, Rotation.random(rng=np.random.default_rng([seed, p])).as_matrix())
        d = d[d @ N > 0]
        origins = np.tile(self.vertices[p] + self.above * N, (len(d), 1))
        if albedo is None:
            blocked = self.caster.intersects_any(origins, d)
        else:
            blocked = self.caster.intersects_first(origins, d) >= 0
        light = oracles.real_harmonics(n - 1, d)
        light[blocked] = 0
        if albedo is not None and blocked.any():
            light[blocked] = albedo * self._received(origins[blocked], d[blocked], n, p)
        frame = oracles.frames(N[None], tangent[None])[0]
        local = d @ frame
        rho = np.stack([transfer(local, view[None]) for view in views @ frame])
        return 4 * np.pi / self.rays * rho @ light

    def _received(self, origins: Array, d: Array, n: int, seed: int, again: int = 48) -> Array:
        """1 / pi int cos V Y (rays, n^2) where rays end, by `again` rays each; 0 on the backs of faces."""
        face = self.caster.intersects_first(origins, d)
        corners = self.vertices[self.faces[face]]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        along = np.einsum("rc,rc->r", corners[:, 0] - origins, flat) / np.einsum("rc,rc->r", d, flat)
        place = origins + along[:, None] * d
        weights = trimesh.triangles.points_to_barycentric(corners, place)
        smooth = np.einsum("rk,rkc->rc", weights, self.normals[self.faces[face]])
        smooth /= np.linalg.norm(smooth, axis=1, keepdims=True)
        rng = np.random.default_rng([1, seed])
        w = rng.normal(size=(len(d), again, 3))
        w = w / np.linalg.norm(w, axis=2, keepdims=True) + smooth[:, None]  # by the cosine about the normal
        w = (w / np.linalg.norm(w, axis=2, keepdims=True)).reshape(-1, 3)
        starts = np.repeat(place + self.above * smooth, again, axis=0)
        seen = ~self.caster.intersects_any(starts, w)
        Y = (seen[:, None] * oracles.real_harmonics(n - 1, w)).reshape(len(d), again, -1).mean(axis=1)
        Y[np.einsum("rc,rc->r", d, flat) > 0] = 0
        return Y


def snr(expected: Array, found: Array) -> float:
    """10 log10 of energy over lost energy."""
    return float(10 * np.log10(np.sum(expected**2) / np.sum((expected - found) ** 2)))


def first_hits(origins: Array, towards: Array, mesh: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Distance and face of the first hit of every ray, inf and -1 without: Moeller and Trumbore."""
    a, b, c = (mesh[0][mesh[1][:, k]] for k in range(3))
    e1, e2 = b - a, c - a
    best, face = np.full(len(origins), np.inf), np.full(len(origins), -1)
    for k in range(len(a)):
        p = np.cross(towards, e2[k])
        det = p @ e1[k]
        s = origins - a[k]
        q = np.cross(s, e1[k])
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v, t = (x / det for x in ((s * p).sum(1), (q * towards).sum(1), q @ e2[k]))
        nearer = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < best)
        best[nearer], face[nearer] = t[nearer], k
    return best, face
