"""Meshes that are bent grids: the torus and sphere of [KVHS00] section 5.2, stand-ins for scanned objects."""

from __future__ import annotations

import numpy as np
from shrm.arrays import FloatArray, IntArray
from shrm.render import Mesh


def torus(tilt: float = 0.0, tube: float = 0.4, around: int = 96, rings: int = 48) -> Mesh:
    """Return a torus of radius 1 with smooth normals; its axis is turned from +z towards +x, in degrees."""
    a, b = _grid(around, rings)
    outward = np.stack([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)], axis=1)
    middle = np.stack([np.cos(a), np.sin(a), np.zeros_like(a)], axis=1)
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    R = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return Mesh((middle + tube * outward) @ R.T, _closed_faces(around, rings), outward @ R.T)


def knot(around: int = 512, rings: int = 84, tube: float = 0.3) -> Mesh:
    """Return a tube about a trefoil, wound about the vertical, with smooth normals: it shadows itself.

    Its 43008 vertices are about as many as [LK03]'s objects have.
    """
    a, b = (angle[:, None] for angle in _grid(around, rings))
    ring = np.concatenate([np.cos(2 * a), np.sin(2 * a), 0 * a], axis=1)
    beside = np.concatenate([-np.sin(2 * a), np.cos(2 * a), 0 * a], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    # Twice around a torus of radii 1 and .5 and thrice about its tube; `out` is the torus's normal
    out, along = np.cos(3 * a) * ring + np.sin(3 * a) * up, -np.sin(3 * a) * ring + np.cos(3 * a) * up
    tangent = 2 * (1 + 0.5 * np.cos(3 * a)) * beside + 1.5 * along
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    outward = np.cos(b) * out + np.sin(b) * np.cross(tangent, out)
    return Mesh(ring + 0.5 * out + tube * outward, _closed_faces(around, rings), outward)


def _grid(around: int, rings: int) -> tuple[FloatArray, FloatArray]:
    """Return both angles of every vertex, (around rings,)."""
    a, b = np.meshgrid(np.arange(around) / around, np.arange(rings) / rings, indexing="ij")
    return 2 * np.pi * a.ravel(), 2 * np.pi * b.ravel()


def _closed_faces(around: int, rings: int) -> IntArray:
    """Return two triangles for every cell of a grid that closes in both directions."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(around), np.arange(rings), indexing="ij"))
    corners = [(x % around) * rings + y % rings for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
    faces = [np.stack([corners[k] for k in triangle], axis=1) for triangle in ((0, 1, 2), (0, 2, 3))]
    return np.concatenate(faces)


def ball(around: int = 36, bands: int = 37) -> Mesh:
    """Return a unit sphere of 2 around (bands - 1) triangles, by default the paper's 2592."""
    theta, phi = np.pi * np.arange(bands + 1) / bands, 2 * np.pi * np.arange(around) / around
    t, p = (angle.ravel() for angle in np.meshgrid(theta, phi, indexing="ij"))
    outward = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(bands), np.arange(around), indexing="ij"))
    corners = [x * around + y % around for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
    # Of the two triangles beside a pole one is a line.
    lower = np.stack([corners[k] for k in (0, 1, 2)], axis=1)[i < bands - 1]
    upper = np.stack([corners[k] for k in (0, 2, 3)], axis=1)[i > 0]
    return Mesh(outward, np.concatenate([lower, upper]), outward)


POT = (
    *((0.0, 1.18), (0.16, 1.18), (0.2, 1.06), (0.08, 0.98), (0.3, 0.9), (0.72, 0.82)),
    *((0.78, 0.72), (1.05, 0.45), (1.2, 0.0), (1.05, -0.45), (0.7, -0.62), (0.0, -0.62)),
)
"""Corners (radius, height) of the pot's profile, from the knob down; the curve runs inside of them."""


def pot(around: int = 128) -> Mesh:
    """Return a bellied pot with a lid and a knob, turned about z, in place of a teapot."""
    profile = np.array(POT)
    # Corners are cut thrice by Chaikin's rule; both ends stay.
    for _ in range(3):
        low, high = profile[:-1], profile[1:]
        cut = np.stack([0.75 * low + 0.25 * high, 0.25 * low + 0.75 * high], axis=1).reshape(-1, 2)
        profile = np.concatenate([profile[:1], cut, profile[-1:]])
    # The profile is turned about z; triangles at the poles are lines where the radius is 0.
    radius, z = profile.T
    phi = 2 * np.pi * np.arange(around) / around
    rings = len(profile)
    vertices = np.stack(
        [np.outer(radius, np.cos(phi)), np.outer(radius, np.sin(phi)), np.repeat(z[:, None], around, axis=1)],
        axis=-1,
    ).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij"))
    a, b, c, d = (x * around + y % around for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    faces = np.concatenate([np.stack(corner, axis=1) for corner in ((a, b, c), (a, c, d))])
    return Mesh(vertices, faces)
