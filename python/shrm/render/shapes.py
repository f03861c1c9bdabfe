"""What the renderer asks of a shape, and the exact sphere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from shrm.arrays import FloatArray, IntArray
from shrm.render.camera import Vector
from shrm.validation import positive, real_array


@dataclass(frozen=True, eq=False)
class Hits:
    """Where n rays first meet a shape.

    Attributes
    ----------
    distances : (n,) float64
        Along the ray; infinite where it misses, and there the other arrays mean nothing.
    normals : (n, 3) float64
        Unit shading normals, on the side that the ray comes from.
    uv : (n, 2) float64
        Texture coordinates, v upwards.
    tangents : (n, 3) float64, optional
        Unit tangents orthogonal to the normals, of any sign; without them they run around the object's axis.
    corners : (n, 3) int64, optional
        Vertices of the face that is hit, of shapes that have faces.
    weights : (n, 3) float64, optional
        Barycentric coordinates in that face.
    """

    distances: FloatArray
    normals: FloatArray
    uv: FloatArray
    tangents: FloatArray | None = None
    corners: IntArray | None = None
    weights: FloatArray | None = None

    def __repr__(self) -> str:
        """Say how many rays there are, and how many hit."""
        return f"<Hits: {len(self.distances)} rays, {np.isfinite(self.distances).sum()} hit>"


class Shape(Protocol):
    """What the renderer needs of a shape."""

    def intersect(self, origins: FloatArray, directions: FloatArray) -> Hits:
        """Return the first hits of rays with (n, 3) origins and unit directions."""
        ...


@dataclass(frozen=True)
class Sphere:
    """An exact sphere. Texture: the usual map of a globe, u = 1/2 on its +x meridian, east is +u.

    Parameters
    ----------
    center : 3 floats
    radius : float
        Above 0.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    center: Vector = (0.0, 0.0, 0.0)
    radius: float = 1.0

    def __post_init__(self) -> None:
        real_array("center", self.center, (3,))
        positive("radius", self.radius)

    def intersect(self, origins: FloatArray, directions: FloatArray) -> Hits:
        """Return the first hits of rays with (n, 3) origins and unit directions."""
        offsets = origins - np.asarray(self.center)
        nearest = -np.einsum("nk,nk->n", offsets, directions)  # to the point nearest the center
        distances = np.full(len(directions), np.inf)
        normals, uv = np.zeros((len(directions), 3)), np.zeros((len(directions), 2))

        # Only rays whose line comes near enough go on; the exact test, of vectors, is below.
        squared = np.einsum("nk,nk->n", offsets, offsets)
        hit = np.flatnonzero(squared - nearest**2 < self.radius**2 + 1e-9 * squared)
        offsets, directions, nearest = offsets[hit], directions[hit], nearest[hit]
        across = offsets + nearest[:, None] * directions
        half_chord = np.sqrt(np.maximum(self.radius**2 - np.einsum("nk,nk->n", across, across), 0.0))
        inside = squared[hit] < self.radius**2
        reached = np.where(inside, nearest + half_chord, nearest - half_chord)
        outward = (offsets + reached[:, None] * directions) / self.radius

        distances[hit] = np.where((half_chord > 0.0) & (reached > 0.0), reached, np.inf)
        normals[hit] = np.where(inside[:, None], -outward, outward)
        uv[hit, 0] = 0.5 + np.arctan2(outward[:, 1], outward[:, 0]) / (2.0 * np.pi)
        uv[hit, 1] = 1.0 - np.arccos(np.clip(outward[:, 2], -1.0, 1.0)) / np.pi
        return Hits(distances, normals, uv)
