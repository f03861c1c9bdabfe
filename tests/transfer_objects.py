"""Small objects with transfer, unshadowed or with made-up shadows, and plain sums to judge how they are drawn.

Where `shrm.transfer` has no `RadianceTransfer`, a stand-in of the same interface takes its place.
"""

import json
import sys
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from shrm import brdf
from shrm.brdf_matrix import project_on_tents
from shrm.directional_basis import DirectionalBasis
from shrm.tangent_frames import band_rotations, vertex_frames

N, M = 4, 5
COMPONENTS = 12


@dataclass(frozen=True, eq=False)
class _Variant:
    weights: Any = None
    components: Any = None
    clusters: Any = None
    matrices: Any = None


@dataclass(frozen=True, eq=False)
class _Lighting:
    """Tents of A_p, evaluated as they are defined."""

    vertices: np.ndarray
    frames: np.ndarray
    matrices: np.ndarray
    M: int

    def radiance(self, light, *, eye=None, view=None, out=None):
        assert (eye is None) != (view is None)
        views = np.broadcast_to(view, self.vertices.shape) if eye is None else eye - self.vertices
        local = np.einsum("pxk,px->pk", self.frames, views / np.linalg.norm(views, axis=1, keepdims=True))
        local[:, 2] = np.maximum(local[:, 2], 0.0)  # views below the horizon are brought to it
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        index, weight = DirectionalBasis(self.M).tents(local)
        rows = np.einsum("pt,ptcj->pcj", weight, self.matrices[np.arange(len(index))[:, None], index])
        found = np.einsum("pcj,jc->pc", np.broadcast_to(rows, (len(rows), 3, rows.shape[2])), light)
        return np.ascontiguousarray(found, np.float32)


@dataclass(frozen=True, eq=False)
class _RadianceTransfer:
    vertices: np.ndarray
    faces: np.ndarray
    frames: np.ndarray
    variants: dict[str, _Variant]
    material: str
    uv: np.ndarray | None = None
    report: dict[str, Any] = field(default_factory=dict)

    @property
    def n(self):
        return round(np.sqrt(next(iter(self.variants.values())).components.shape[-1]))

    @property
    def M(self):  # noqa: N802 - as the paper has it
        return round(np.sqrt(next(iter(self.variants.values())).components.shape[-3]))

    @property
    def channels(self):
        return next(iter(self.variants.values())).components.shape[-2]

    def lighting(self, variant=None, *, K=None, M=None):
        held = self.variants[variant or list(self.variants)[-1]]
        matrices = np.einsum("pk,ktcj->ptcj", held.weights[:, :K], held.components[:K])
        coarse = M or self.M
        if coarse != self.M:
            basis, fine = DirectionalBasis(coarse), DirectionalBasis(self.M)
            at, weights = basis.quadrature(6)
            moved = basis.solve(basis.accumulate(weights[:, None] * fine.evaluate(np.eye(fine.size), at), at))
            matrices = np.einsum("st,ptcj->pscj", moved, matrices)
        return _Lighting(self.vertices, self.frames, matrices, coarse)

    def radiance(self, light, *, eye=None, view=None, variant=None, K=None, M=None):
        return self.lighting(variant, K=K, M=M).radiance(light, eye=eye, view=view)

    def save(self, path):
        arrays = {"vertices": self.vertices, "faces": self.faces, "frames": self.frames}
        if self.uv is not None:
            arrays["uv"] = self.uv
        for name, held in self.variants.items():
            arrays[f"{name} weights"], arrays[f"{name} components"] = held.weights, held.components
        with open(path, "wb") as file:
            np.savez(file, about=json.dumps([self.material, self.report, list(self.variants)]), **arrays)

    @classmethod
    def load(cls, path):
        try:
            with np.load(path) as file:
                material, report, names = json.loads(str(file["about"]))
                variants = {n: _Variant(file[f"{n} weights"], file[f"{n} components"]) for n in names}
                uv = file["uv"] if "uv" in file else None
                held = file["vertices"], file["faces"], file["frames"]
        except OSError:
            raise
        except Exception as fault:
            raise ValueError(f"{path}: no object with transfer ({fault})") from None
        return cls(*held, variants, material, uv, report)


try:
    from shrm.transfer.object import RadianceTransfer, Variant
except ImportError:
    RadianceTransfer, Variant = _RadianceTransfer, _Variant
    module: Any = ModuleType("shrm.transfer.object")
    module.RadianceTransfer, module.Variant = RadianceTransfer, Variant
    sys.modules["shrm.transfer.object"] = module


def globe(rings: int = 12, around: int = 24) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, faces and uv of an oblate spheroid, off the origin and of an odd size, with a seam."""
    v, u = np.meshgrid(np.arange(rings + 1) / rings, np.arange(around + 1) / around, indexing="ij")
    theta, phi = np.pi * v.ravel(), 2.0 * np.pi * u.ravel()
    unit = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(rings), np.arange(around), indexing="ij"))
    a, b = i * (around + 1) + j, (i + 1) * (around + 1) + j
    faces = np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])
    vertices = np.array([3.0, -2.0, 1.0]) + unit * np.array([0.7, 0.7, 0.5])
    return vertices.astype(np.float32), faces.astype(np.int32), np.stack([u, 1.0 - v], axis=2).reshape(-1, 2)


@cache
def transferred(
    rings: int = 12,
    around: int = 24,
    variants: tuple[str, ...] = ("unshadowed", "shadowed", "interreflected"),
):
    """A glossy globe: T is the identity, and the made-up shadow lies on its lower half."""
    vertices, faces, uv = globe(rings, around)
    normals = (vertices - vertices.mean(axis=0)) / np.array([0.7, 0.7, 0.5]) ** 2
    frames = vertex_frames(normals)
    material = brdf.GGX(0.5, f0=(1.0, 0.7, 0.3))
    Q = project_on_tents(material, DirectionalBasis(M), N)
    R = np.zeros((len(vertices), N * N, N * N))
    for l, band in enumerate(band_rotations(frames, N)):
        R[:, l * l : (l + 1) ** 2, l * l : (l + 1) ** 2] = band
    A = np.einsum("ctj,pjk->ptck", Q, R)
    shade = {"unshadowed": 1.0, "shadowed": np.where(normals[:, 2] < 0, 0.3, 1.0)}
    shade["interreflected"] = 0.8 * shade["shadowed"] + 0.2
    made = {}
    for name in variants:
        shaded = (A * np.reshape(shade[name], (-1, 1, 1, 1))).reshape(len(A), -1)
        left, s, right = np.linalg.svd(shaded, full_matrices=False)
        made[name] = Variant(
            weights=(left * s)[:, :COMPONENTS].astype(np.float32),
            components=right[:COMPONENTS].reshape(COMPONENTS, *A.shape[1:]).astype(np.float32),
        )
    return RadianceTransfer(
        vertices=vertices,
        faces=faces,
        frames=frames.astype(np.float32),
        variants=made,
        material=material.name,
        uv=uv.astype(np.float32),
        report={"rays": 0},
    )
