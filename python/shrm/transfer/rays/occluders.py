"""Rays from the vertices of a mesh against its own faces, by Embree.

Embree computes in float32, so the mesh is moved and scaled to reach from -1 to 1 along its longest side. Rays
start beside their vertex, by two steps:

- `_ABOVE` along the frame's normal, so that a ray does not meet the faces that it starts from. Positions are
  rounded to 2^-25: on planes and spheres from 2^-22 on no ray meets its own faces, and up to 2^-16 hardly any
  contact is lost (of a mesh whose edges are .013 long, 2e-4 of all rays change there, and 1.5e-2 at 2^-10).
- `_INWARD`, a quarter of that, towards the middle of the vertex's own faces, which is nowhere if they lie all
  around it. Where meshes are split along an edge, as at the corners of a room or at the foot of a box, a
  vertex of one side lies exactly in the other, and rounding would decide whether its rays see through.

A ray that meets a face from behind is blocked, and carries no light. Its start is inside the object, as at
the tip of a pit whose normal looks through its own faces, or the object is open and shows a side that is not
shaded: nothing is known about the light there. Rays into the front of the vertex's own faces, as those near
the horizon in a hollow, are blocked as well and carry the light of that face, which is what the smooth
surface's own neighbourhood would send: without it every hollow would lose energy.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from shrm.arrays import BoolArray, Float32Array, FloatArray, Int32Array, RealArray
from shrm.threads import thread_count
from shrm.transfer.described import Described

_ABOVE = 2.0**-18
"""Step along the normal from a vertex to the start of its rays, in halves of the mesh's longest side."""

_INWARD = 2.0**-20
"""Step towards the middle of the vertex's own faces, in the same unit."""

_RAYS = 1 << 17
"""Rays that one thread traces at a time: what they take, some 10 MB, stays in the caches."""


@dataclass(frozen=True, eq=False, repr=False)
class Hits(Described):
    """Ends of blocked rays, in the order of the False in `visible`, row by row.

    Attributes
    ----------
    face : (H,) int32
        The first face that is met; -1 if it is met from behind.
    u, v : (H,) float32
        The place (1 - u - v) P0 + u P1 + v P2 on the face with the corners P0, P1, P2; each in [0, 1].
    """

    face: Int32Array
    u: Float32Array
    v: Float32Array

    def __len__(self) -> int:
        return len(self.face)


class Occluders(Described):
    """Faces of a mesh, as what blocks the rays of its vertices.

    Faces without area block nothing. Vertices may coincide, or belong to no face: those are points that only
    look. Edges may have any number of faces.

    Arrays are taken as they are: `shrm.transfer.precompute` checks them.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (T, 3) int32
        Indices of vertices, in [0, V); at least one face.
    normals : (V, 3) float64, optional
        Normals at the vertices, of any length. The front of a face is where those of its corners look, on the
        whole; without normals it is where its corners run counter-clockwise.
    """

    shown = ("vertices", "faces")

    def __init__(self, vertices: FloatArray, faces: Int32Array, normals: FloatArray | None = None) -> None:
        self.vertices, self.normals = vertices, normals
        self.faces = np.ascontiguousarray(faces, np.int32)
        place = _placed(vertices, self.faces)
        corners = place[self.faces]

        # Vectors to the front of each face, of any length
        front = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        if normals is not None:
            front *= np.where(np.einsum("tc,tkc->t", front, normals[self.faces]) < 0, -1.0, 1.0)[:, None]
        self._front = front.astype(np.float32)

        self._beside = place + _INWARD * _inward(place, self.faces, corners)
        self._scene = _scene(place.astype(np.float32), self.faces)

    def __reduce__(self) -> tuple[type[Occluders], tuple[object, ...]]:
        """Return how a pickle makes it again: with another of Embree's scenes."""
        return type(self), (self.vertices, self.faces, self.normals)

    def cast(
        self,
        vertices: slice,
        frames: RealArray,
        directions: RealArray,
        *,
        hits: bool = True,
    ) -> tuple[BoolArray, Hits | None]:
        """Cast rays from some vertices, each in the same local directions.

        Arguments are taken as they are. The rays are dealt out to as many threads as there are processors, or
        as the environment variable OMP_NUM_THREADS says.

        Parameters
        ----------
        vertices : slice
            Which of them; B.
        frames : (B, 3, 3)
            Their rotations global_from_local, see `shrm.transfer.tangent_frames.vertex_frames`.
        directions : (D, 3)
            Unit vectors in local coordinates, z >= 0.
        hits : bool
            Whether to find where blocked rays end: without it rays are 1.2 times as fast.

        Returns
        -------
        visible : (B, D) bool
            Where the rays meet nothing.
        hits : Hits or None
        """
        R, d = np.asarray(frames, np.float32), np.asarray(directions, np.float32)

        # Parts for the threads
        starts = (self._beside[vertices] + _ABOVE * frames[:, :, 2]).astype(np.float32)
        step = max(1, _RAYS // len(d))
        parts = [slice(k, k + step) for k in range(0, len(starts), step)]
        with ThreadPoolExecutor(thread_count()) as pool:
            traced = list(pool.map(lambda part: self._trace(starts[part], R[part], d, hits), parts))
        visible = np.concatenate([part[0] for part in traced]) if traced else np.empty((0, len(d)), np.bool_)
        ends = [part[1] for part in traced if part[1] is not None]
        if not hits:
            return visible, None
        none = (np.empty(0, np.int32), np.empty(0, np.float32), np.empty(0, np.float32))
        face, u, v = (np.concatenate(column) for column in zip(none, *ends, strict=True))
        return visible, Hits(face, u, v)

    def _trace(
        self, starts: Float32Array, R: Float32Array, d: Float32Array, hits: bool
    ) -> tuple[BoolArray, tuple[Int32Array, Float32Array, Float32Array] | None]:
        """Return visibility (b, D), and face, u, v of the blocked rays; Embree lets other threads run."""
        # R d of all pairs as products of matrices with contiguous rows: the rays' time is Embree's.
        towards = np.matmul(d, np.ascontiguousarray(R.transpose(0, 2, 1))).reshape(-1, 3)
        origins = np.repeat(starts, len(d), axis=0)
        if not hits:
            visible = self._scene.run(origins, towards, query="OCCLUDED") == -1
            return visible.reshape(len(R), len(d)), None

        # Embree's number of the face, -1 for none; faces that are met from behind have none either
        ends = self._scene.run(origins, towards, output=True)
        visible = ends["primID"] == -1
        blocked = np.flatnonzero(~visible)
        face = ends["primID"][blocked]
        behind = np.einsum("hc,hc->h", self._front[face], towards[blocked]) > 0
        face[behind] = -1
        u, v = (np.clip(ends[name][blocked], 0.0, 1.0) for name in ("u", "v"))
        return visible.reshape(len(R), len(d)), (face, u, v)


def _placed(P: FloatArray, faces: Int32Array) -> FloatArray:
    """Return vertices (V, 3) moved and scaled so that faces reach from -1 to 1 along the longest side."""
    low, high = P[faces].min(axis=(0, 1)), P[faces].max(axis=(0, 1))
    reach = float((high / 2 - low / 2).max())  # halves: the whole may overflow
    with np.errstate(over="ignore"):  # a vertex of no face may be too far away for a number
        place = (P - (low / 2 + high / 2)) / (reach if reach > 0 else 1.0)
    return np.asarray(np.clip(place, -1e18, 1e18))  # squares in float32 are finite


def _inward(place: FloatArray, faces: Int32Array, corners: FloatArray) -> FloatArray:
    """Return at each vertex the mean (V, 3) of unit vectors to its faces' centroids; zero without faces."""
    sums, count = np.zeros((3, len(place))), np.bincount(faces.ravel(), minlength=len(place))
    centroids = corners.mean(axis=1)
    for k in range(3):
        step = centroids - corners[:, k]
        length = np.linalg.norm(step, axis=1, keepdims=True)
        step /= np.where(length > 0, length, 1.0)
        for c in range(3):
            sums[c] += np.bincount(faces[:, k], step[:, c], len(place))
    return (sums / np.maximum(count, 1)).T


def _scene(place: Float32Array, faces: Int32Array) -> Any:
    """Return Embree's scene of the faces, ready to be asked by several threads."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    # Robust: no ray slips through between two faces that share an edge.
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, np.ascontiguousarray(place), faces)
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))  # the first call builds the tree
    return scene
