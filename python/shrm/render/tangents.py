"""Tangent fields of meshes, for the materials about the tangent: along u, or along the principal direction.

Both are fields of lines: T and -T are the same, as they are to Banks' and to Kajiya and Kay's model.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from shrm.arrays import ComplexArray, FloatArray, IntArray
from shrm.render.line_field import Planes, components

Tangents = Literal["axis", "uv", "principal"]

STEPS = 8
"""Averages over the faces around a point, of lines with their weights: they reach two or three edges far."""
UNIT_STEPS = 4
"""Further averages, of lines of equal weight."""
ANISOTROPY = 0.03
"""Least ||k1| - |k2|| as a fraction of the larger curvature; triangles of an icosphere have up to 0.02."""
TURNING = 1e-4
"""The same as an angle between normals an edge apart, radians: files round positions to six digits."""


def uv_tangents(vertices: FloatArray, faces: IntArray, normals: FloatArray, uv: FloatArray) -> FloatArray:
    """Tangents along dP/du, the lines of constant v.

    Lines, not vectors, are averaged over the faces at a vertex, weighted by area: a chart and its mirror
    image agree about them. Vertices of one place, normal and uv are one. Where the uv of all faces at
    a vertex are degenerate, tangents run around the vertical.

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (k, 3) int64
    normals : (n, 3) float64
        Unit vectors; zero where nothing defines one.
    uv : (n, 2) float64

    Returns
    -------
    (k, 3, 3) float64
        Unit vectors at the corners of faces, orthogonal to the normals, of one sign within each face.
    """
    _, planes = _joined(faces, vertices, normals, uv)
    along = _edges(uv[faces])
    (du, dv), (du2, dv2) = along[:, 2].T, along[:, 0].T
    # P_u du + P_v dv = dP along two edges gives P_u up to the determinant, whose sign means nothing.
    direction = dv2[:, None] * planes.edges[:, 2] - dv[:, None] * planes.edges[:, 0]
    tangent = components(direction, planes.u, planes.v)
    defined = np.abs(du * dv2 - du2 * dv) > 1e-9 * np.hypot(du, dv) * np.hypot(du2, dv2)
    return planes.tangents(planes.lines_at_points(_phase(tangent * defined) ** 2))


def principal_tangents(vertices: FloatArray, faces: IntArray, normals: FloatArray) -> FloatArray:
    """Tangents along the principal direction of the larger |curvature|: around a cylinder, not along it.

    The lines at the vertices, of weight ||k1| - |k2||, are averaged over neighbours in eight steps, which
    reaches two or three edges far: that takes out noise, and carries lines into flat regions beside
    them. Four more steps average them with equal weights: where the other curvature becomes the larger
    one, at k1 = -k2, lines turn within some edges instead of jumping.

    Where, after the eight steps, the weight is less than 3 % of the larger curvature, or so small that
    normals an edge apart turn by less than 1e-4, no direction is the principal one (spheres, planes,
    umbilics): there the lines turn, continuously as the weight goes to zero, to those around the vertical.

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (k, 3) int64
    normals : (n, 3) float64
        Unit vectors; zero where nothing defines one. Vertices of one place and normal are one.

    Returns
    -------
    (k, 3, 3) float64
        Unit vectors at the corners of faces, orthogonal to the normals, of one sign within each face.
    """
    rows, planes = _joined(faces, vertices, normals)
    mean, line = _curvature(planes, normals[rows])
    # k1, k2 = mean +- |line|: the first has the larger |k| if the mean is positive, else the second.
    larger = 2.0 * np.minimum(np.abs(mean), np.abs(line)) * np.sign(mean) * _phase(line)
    for _ in range(STEPS):
        larger = planes.lines_at_points(planes.lines_on_faces(larger))
    edge = np.sqrt(np.where(planes.point_areas > 0.0, planes.point_areas, 1.0))
    needed = ANISOTROPY * (np.abs(mean) + np.abs(line)) + TURNING / edge
    larger += np.maximum(needed - np.abs(larger), 0.0)
    for _ in range(UNIT_STEPS):
        larger = planes.lines_at_points(planes.lines_on_faces(_phase(larger)))
    return planes.tangents(larger)


def _curvature(planes: Planes, normals: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Curvature tensors at points: the mean (m,) and the line (m,) of each.

    That of a face is the one that fits best how normals (m, 3) differ along its edges; that of a point is
    the average over the faces at it, carried into its plane and weighted by area [R04, section 3].
    """
    dp, dn = (
        components(edges, planes.u[:, None], planes.v[:, None])
        for edges in (planes.edges, _edges(normals[planes.faces]))
    )
    # Least squares of (a, b; b, c) dp = dn, which has a diagonal matrix in the edges' own principal axes.
    turn = np.exp(-0.5j * np.angle((dp**2).sum(axis=1)))
    dp, dn = dp * turn[:, None], dn * turn[:, None]
    xx, yy = (dp.real**2).sum(axis=1), (dp.imag**2).sum(axis=1)
    extended = yy > 0.0  # the shorter axis; degenerate faces have no plane
    xx, yy = np.where(extended, xx, 1.0), np.where(extended, yy, 1.0)
    a = (dp.real * dn.real).sum(axis=1) / xx
    b = (dp.real * dn.imag + dp.imag * dn.real).sum(axis=1) / (xx + yy)
    c = (dp.imag * dn.imag).sum(axis=1) / yy
    line = (0.5 * (a - c) + 1j * b) / turn**2
    return planes.at_points(0.5 * (a + c)), planes.lines_at_points(line)


def _joined(faces: IntArray, *columns: FloatArray) -> tuple[IntArray, Planes]:
    """Join vertices that are the same in all columns, of which the first two are places and normals.

    Returns
    -------
    rows : (m,) int64
        A vertex of each point.
    planes : Planes
        Of the points.
    """
    _, rows, point = np.unique(
        np.concatenate(columns, axis=1), axis=0, return_index=True, return_inverse=True
    )
    return rows, Planes.of(columns[0][rows], point.reshape(-1)[faces], columns[1][rows])


def _edges(corners: FloatArray) -> FloatArray:
    """Return differences (k, 3, x) of values at corners along the edge opposite to each corner."""
    return np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)


def _phase(z: ComplexArray) -> ComplexArray:
    """Complex numbers of modulus 1; zero stays zero."""
    size = np.abs(z)
    return np.asarray(z / np.where(size > 0.0, size, 1.0))
