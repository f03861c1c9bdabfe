"""Fields of lines in the tangent planes of a mesh: directions whose sign means nothing.

In a plane with an orthonormal basis, the line at the angle phi from its first vector is the complex number
r exp(2 i phi): turned by pi it is the same, lines at right angles cancel, and r is its weight. The symmetric
tensor (a, b; b, c) is its mean (a + c) / 2 and the line (a - c) / 2 + i b. Such numbers can be averaged once
they are in one plane; the smallest rotation that takes normal to normal carries them from plane to plane
[KCPS13].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shrm.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from shrm.render.camera import Vector
from shrm.vectors import unit

VERTICAL: Vector = (0.0, 0.0, 1.0)


def tangents_around(axis: Vector, normals: FloatArray) -> FloatArray:
    """Return unit tangents that run around an axis: axis x N; where N is the axis itself, any tangent.

    Parameters
    ----------
    axis : 3 floats
    normals : (n, 3) float64

    Returns
    -------
    (n, 3) float64
    """
    tangents = np.cross(np.asarray(axis, np.float64), normals)
    lengths = np.linalg.norm(tangents, axis=1, keepdims=True)
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]  # the coordinate axis farthest from N
    spare = np.cross(least, normals)
    return unit(np.where(lengths > 1e-9, tangents, spare))


def orthogonalised(tangents: FloatArray, normals: FloatArray, axis: Vector = VERTICAL) -> FloatArray:
    """Return unit tangents orthogonal to normals: T - (T.N) N; where nothing is left of it, around an axis.

    Parameters
    ----------
    tangents : (n, 3) float64
        Of any length up to 1.
    normals : (n, 3) float64
        Unit vectors.
    axis : 3 floats

    Returns
    -------
    (n, 3) float64
    """
    across = tangents - np.einsum("nx,nx->n", tangents, normals)[:, None] * normals
    left = np.linalg.norm(across, axis=1, keepdims=True) > 1e-6
    return np.where(left, unit(across), tangents_around(axis, normals))


def aligned(tangents: FloatArray) -> FloatArray:
    """Return tangents (k, 3, 3) at the corners of faces with signs that agree, T.T' >= 0.

    Around a singular point of the field no signs make all three agree: there one pair does not.
    """
    a, b, c = (tangents[:, k] for k in range(3))
    b = np.where(np.einsum("nx,nx->n", a, b)[:, None] < 0.0, -b, b)
    c = np.where(np.einsum("nx,nx->n", a + b, c)[:, None] < 0.0, -c, c)
    return np.stack([a, b, c], axis=1)


@dataclass(frozen=True, eq=False)
class Planes:
    """The tangent planes of the points and faces of a mesh.

    The basis of a point is e1 around the vertical and e2 = N x e1; that of a face is u along an edge and
    v = F x u, with F its normal by the order of its corners.

    Attributes
    ----------
    faces : (k, 3) int64
    e1, e2 : (m, 3) float64
        Of the points. Where the normal is zero the plane is horizontal.
    u, v : (k, 3) float64
        Of the faces; zero for a degenerate one.
    edges : (k, 3, 3) float64
        The edge opposite to each corner.
    areas : (k, 3) float64
        The part of each face that belongs to each of its corners; zero for a degenerate one.
    turns : (k, 3) complex128
        exp(2 i alpha), alpha the angle from e1 to u, where u has been carried into the corner's plane.
    mirrored : (k, 3) bool
        Whether F is on the other side than the corner's N, so that angles run the other way.
    """

    faces: IntArray
    e1: FloatArray
    e2: FloatArray
    u: FloatArray
    v: FloatArray
    edges: FloatArray
    areas: FloatArray
    turns: ComplexArray
    mirrored: BoolArray

    @classmethod
    def of(cls, points: FloatArray, faces: IntArray, normals: FloatArray) -> Planes:
        """Return the tangent planes of points (m, 3) with unit or zero normals (m, 3)."""
        corners = points[faces]
        edges = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
        areas = _corner_areas(edges)
        proper = areas.any(axis=1, keepdims=True)
        F, u = proper * unit(np.cross(edges[:, 2], edges[:, 0])), proper * unit(edges[:, 2])
        normals = np.where(normals.any(axis=1, keepdims=True), normals, VERTICAL)
        e1 = tangents_around(VERTICAL, normals)
        e2 = np.cross(normals, e1)

        turns, mirrored = np.empty(faces.shape, np.complex128), np.empty(faces.shape, np.bool_)
        for k, corner in enumerate(faces.T):
            N = normals[corner]
            cosine = np.einsum("nx,nx->n", F, N)
            mirrored[:, k] = cosine < 0.0
            W = np.cross(np.where(mirrored[:, k, None], -F, F), N)
            cosine = np.abs(cosine)
            # The rotation that takes +-F to N takes u to cos u + W x u + (W.u) / (1 + cos) W.
            along = np.einsum("nx,nx->n", W, u) / (1.0 + cosine)
            carried = cosine[:, None] * u + np.cross(W, u) + along[:, None] * W
            turns[:, k] = components(carried, e1[corner], e2[corner]) ** 2
        return cls(faces, e1, e2, u, np.cross(F, u), edges, areas, turns, mirrored)

    @cached_property
    def point_areas(self) -> FloatArray:
        """The area that belongs to each point, (m,) float64."""
        return self._sums(self.areas)

    def at_points(self, values: FloatArray) -> FloatArray:
        """Average numbers (k,) of faces over those at each point, (m,), weighted by area; 0 without any."""
        return self._averages(values[:, None])

    def lines_at_points(self, lines: ComplexArray) -> ComplexArray:
        """Average lines (k,) of faces over those at each point, (m,), weighted by area; 0 without any."""
        carried = self.turns * np.where(self.mirrored, lines.conj()[:, None], lines[:, None])
        return self._averages(carried.real) + 1j * self._averages(carried.imag)

    def lines_on_faces(self, lines: ComplexArray) -> ComplexArray:
        """Average lines (m,) of points over the three of each face, (k,)."""
        carried = lines[self.faces] * self.turns.conj()
        return np.asarray(np.where(self.mirrored, carried.conj(), carried).mean(axis=1))

    def tangents(self, lines: ComplexArray) -> FloatArray:
        """Unit vectors (k, 3, 3) along lines (m,) of points at the corners of faces; e1 where a line is 0.

        Their signs agree within each face, so that they can be interpolated over it.
        """
        phi = 0.5 * np.angle(lines)[:, None]
        vectors = np.cos(phi) * self.e1 + np.sin(phi) * self.e2
        return aligned(vectors[self.faces])

    def _averages(self, values: FloatArray) -> FloatArray:
        """Average (k, 3) or (k, 1) over the corners at each point, (m,), weighted by area."""
        areas = self.point_areas
        return np.asarray(self._sums(values * self.areas) / np.where(areas > 0.0, areas, 1.0))

    def _sums(self, values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(self.faces.ravel(), values.ravel(), len(self.e1)), np.float64)


def components(vectors: FloatArray, x: FloatArray, y: FloatArray) -> ComplexArray:
    """Return vectors (..., 3) in planes with the bases x, y (..., 3), as complex numbers (...)."""
    return np.asarray((vectors * x).sum(axis=-1) + 1j * (vectors * y).sum(axis=-1))


def _corner_areas(edges: FloatArray) -> FloatArray:
    """Return the Voronoi areas (k, 3) of the corners of faces [MDSB02, 3.3].

    Obtuse faces give a half and two quarters.

    Parameters
    ----------
    edges : (k, 3, 3) float64
        The edge opposite to each corner.
    """
    squares = np.einsum("nkx,nkx->nk", edges, edges)
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    proper = area > 1e-12 * squares.max(axis=1)
    before, after = np.roll(squares, 1, axis=1), np.roll(squares, -1, axis=1)
    cotangents = (before + after - squares) / (4.0 * np.where(proper, area, 1.0))[:, None]
    voronoi = (before * np.roll(cotangents, 1, axis=1) + after * np.roll(cotangents, -1, axis=1)) / 8.0
    obtuse = cotangents < 0.0
    halves = np.where(obtuse, 0.5, 0.25) * area[:, None]
    return np.where(proper[:, None], np.where(obtuse.any(axis=1, keepdims=True), halves, voronoi), 0.0)
