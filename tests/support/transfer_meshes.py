"""Meshes for the tests of matrix radiance transfer: vertices, faces and the vertices' normals."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

Mesh = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass
class Surface:
    """A mesh as `precompute` takes it."""

    vertices: np.ndarray
    faces: np.ndarray
    vertex_normals: np.ndarray
    uv: np.ndarray | None = None


def random_rotation(seed: int) -> np.ndarray:
    return Rotation.random(rng=np.random.default_rng(seed)).as_matrix()


def moved(mesh: Mesh, R: np.ndarray, offset: np.ndarray | float = 0.0, scale: float = 1.0) -> Mesh:
    vertices, faces, normals = mesh
    return vertices @ R.T * scale + offset, faces, normals @ R.T


def grid(k: int, corner: list[float], along: list[float], across: list[float]) -> Mesh:
    """A rectangle of k x k cells of two triangles, seen from the side of along x across."""
    s = np.linspace(0, 1, k + 1)
    j, i = np.meshgrid(s, s, indexing="ij")
    vertices = (
        np.asarray(corner) + i.reshape(-1, 1) * np.asarray(along) + j.reshape(-1, 1) * np.asarray(across)
    )
    a = (np.arange(k)[:, None] * (k + 1) + np.arange(k)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + k + 2], 1), np.stack([a, a + k + 2, a + k + 1], 1)])
    normal = np.cross(along, across) / np.linalg.norm(np.cross(along, across))
    return vertices, faces, np.tile(normal, (len(vertices), 1))


def together(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh[0]) for mesh in meshes)])
    faces = [mesh[1] + start for mesh, start in zip(meshes, starts, strict=False)]
    return (
        np.concatenate([m[0] for m in meshes]),
        np.concatenate(faces),
        np.concatenate([m[2] for m in meshes]),
    )


def room(k: int) -> Mesh:
    """The unit cube from inside; each side has its own vertices along the edges."""
    x, y, z = [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]
    low = [grid(k, [0, 0, 0], *axes) for axes in ((x, y), (y, z), (z, x))]
    high = [grid(k, at, *axes) for at, axes in ((z, (y, x)), (x, (z, y)), (y, (x, z)))]
    return together(*low, *high)


def ball(subdivisions: int) -> Mesh:
    sphere = trimesh.creation.icosphere(subdivisions)
    return np.array(sphere.vertices), np.array(sphere.faces), np.array(sphere.vertices)


def bowl(k: int) -> Mesh:
    """The half z < 0 of the unit sphere from inside: a square carried there by the concentric map."""
    vertices, faces, _ = grid(2 * k, [-1, -1, 0], [2, 0, 0], [0, 2, 0])
    x, y = vertices[:, 0], vertices[:, 1]
    # Cells are cut along the diagonal that points at the middle: the other makes corners of rim alone
    first, second = faces[: 4 * k * k], faces[4 * k * k :]
    (a, b, c), d = first.T.copy(), second[:, 2].copy()
    other = (x[a] + x[c]) * (y[a] + y[c]) < 0
    first[other] = np.stack([a, b, d], axis=1)[other]
    second[other] = np.stack([b, c, d], axis=1)[other]
    r = np.maximum(abs(x), abs(y))
    angle = np.pi / 4 * np.where(abs(x) >= abs(y), y, x) / np.where(r > 0, r, 1)
    wide, narrow = np.cos(angle), np.sin(angle)
    s = r * np.sqrt(2 - r**2)
    place = np.stack(
        [
            s * np.where(abs(x) >= abs(y), wide * np.sign(x), narrow),
            s * np.where(abs(x) >= abs(y), narrow, wide * np.sign(y)),
            r**2 - 1,
        ],
        axis=1,
    )
    return place, faces, -place


def with_points(mesh: Mesh, points: np.ndarray, normals: np.ndarray) -> tuple[Mesh, slice]:
    """The mesh with vertices of no face that only look, and where they are."""
    vertices, faces, n = mesh
    return (np.r_[vertices, points], faces, np.r_[n, normals]), slice(
        len(vertices), len(vertices) + len(points)
    )


def bumpy(seed: int, subdivisions: int = 2) -> Mesh:
    """A closed mesh with hollows: a sphere of random radii."""
    mesh = trimesh.creation.icosphere(subdivisions)
    vertices = mesh.vertices * np.random.default_rng(seed).uniform(0.6, 1.4, (len(mesh.vertices), 1))
    mesh = trimesh.Trimesh(vertices, mesh.faces, process=False)
    return np.array(vertices), np.array(mesh.faces), np.array(mesh.vertex_normals)


def simplified(path: Path, cells: int) -> Mesh:
    """A mesh file whose vertices are drawn together in cubes, `cells` along the longest side."""
    mesh = trimesh.load(path, process=False)
    vertices = np.asarray(mesh.vertices, np.float64)
    step = np.ptp(vertices, axis=0).max() / cells
    cube = np.floor((vertices - vertices.min(axis=0)) / step).astype(int)
    place = np.unique(cube, axis=0, return_inverse=True)[1].reshape(-1)
    together = np.stack([np.bincount(place, vertices[:, c]) for c in range(3)], axis=1)
    together /= np.bincount(place)[:, None]
    faces = place[mesh.faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    faces = faces[np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]]
    used, numbers = np.unique(faces, return_inverse=True)
    vertices, faces = together[used], numbers.reshape(-1, 3)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    across, sums = np.cross(b - a, c - a), np.zeros_like(vertices)
    for k in range(3):
        np.add.at(sums, faces[:, k], across)
    return vertices, faces, sums / np.linalg.norm(sums, axis=1, keepdims=True)
