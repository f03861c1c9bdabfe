"""Small objects with transfer, unshadowed or with made-up shadows.

Where `shrm.transfer` has no `RadianceTransfer`, a stand-in of the same interface takes its place.
"""

import json
import sys
from dataclasses import dataclass, field
from functools import cache
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from shrm import brdf
from shrm.brdf_matrix import project_on_tents
from shrm.directional_basis import DirectionalBasis
from shrm.tangent_frames import band_rotations, vertex_frames

N, M = 4, 5
COMPONENTS = 60


MAGIC = b"stand-in"


@dataclass(frozen=True, eq=False)
class _Variant:
    weights: Any = None
    components: Any = None
    clusters: Any = None
    matrices: Any = None

    @property
    def K(self):
        return 0 if self.weights is None else self.weights.shape[1]


@dataclass(eq=False)
class _Lighting:
    """Tents of A_p, evaluated as they are defined."""

    vertices: np.ndarray
    frames: np.ndarray
    weights: np.ndarray
    components: np.ndarray
    K: int

    def radiance(self, light, *, eye=None, view=None, out=None):
        assert (eye is None) != (view is None)
        views = np.broadcast_to(view, self.vertices.shape) if eye is None else eye - self.vertices
        local = np.einsum("pxk,px->pk", self.frames, views / np.linalg.norm(views, axis=1, keepdims=True))
        local[:, 2] = np.maximum(local[:, 2], 0.0)  # views below the horizon are brought to it
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        index, weight = DirectionalBasis(round(np.sqrt(self.components.shape[1]))).tents(local)
        matrices = np.einsum("pk,ktcj->ptcj", self.weights[:, : self.K], self.components[: self.K])
        rows = np.einsum("pt,ptcj->pcj", weight, matrices[np.arange(len(index))[:, None], index])
        found = np.einsum("pcj,jc->pc", np.broadcast_to(rows, (len(rows), 3, rows.shape[2])), light)
        return np.ascontiguousarray(found, np.float32)


@dataclass(frozen=True, eq=False)
class _RadianceTransfer:
    vertices: np.ndarray
    faces: np.ndarray
    frames: np.ndarray
    n: int
    M: int
    channels: int
    variants: dict[str, _Variant]
    uv: np.ndarray | None = None
    material: str = ""
    report: dict[str, Any] = field(default_factory=dict)

    def lighting(self, variant=None, *, K=None, M=None):
        held = self.variants[variant or list(self.variants)[-1]]
        components = held.components
        if (K or 1) > held.K or (M or 2) > self.M:
            raise ValueError(f"K must be at most {held.K} and M at most {self.M}, got {K} and {M}")
        if M is not None and M != self.M:
            components = np.einsum("st,ktcj->kscj", coarser(self.M, M), components)
        return _Lighting(self.vertices, self.frames, held.weights, components, K or held.K)

    def radiance(self, light, *, eye=None, view=None, variant=None, K=None, M=None):
        return self.lighting(variant, K=K, M=M).radiance(light, eye=eye, view=view)

    def save(self, path):
        arrays = {"vertices": self.vertices, "faces": self.faces, "frames": self.frames}
        if self.uv is not None:
            arrays["uv"] = self.uv
        for name, held in self.variants.items():
            arrays[f"{name} weights"], arrays[f"{name} components"] = held.weights, held.components
        about = [self.n, self.M, self.channels, self.material, self.report, list(self.variants)]
        with open(path, "wb") as file:
            file.write(MAGIC)
            np.savez(file, about=json.dumps(about), **arrays)

    @classmethod
    def load(cls, path):
        content = Path(path).read_bytes()
        try:
            with np.load(BytesIO(content.removeprefix(MAGIC))) as file:
                n, m, channels, material, report, names = json.loads(str(file["about"]))
                variants = {x: _Variant(file[f"{x} weights"], file[f"{x} components"]) for x in names}
                held = file["vertices"], file["faces"], file["frames"], n, m, channels, variants
                return cls(*held, file.get("uv"), material, report)
        except Exception as fault:
            raise ValueError(f"{path}: is not a transfer file ({fault})") from None


try:
    from shrm.transfer.lighting import Compressed  # noqa: F401 - with all of it, the real ones
    from shrm.transfer.object import RadianceTransfer, Variant
except ImportError:
    RadianceTransfer, Variant = _RadianceTransfer, _Variant
    for name, held in {
        "object": {"RadianceTransfer": RadianceTransfer, "Variant": Variant},
        "file": {"MAGIC": MAGIC},
    }.items():
        module: Any = ModuleType(f"shrm.transfer.{name}")
        vars(module).update(held)
        sys.modules[module.__name__] = module


def coarser(fine: int, coarse: int) -> np.ndarray:
    """The projection of fine^2 tents on coarse^2, (coarse^2, fine^2)."""
    few, many = DirectionalBasis(coarse), DirectionalBasis(fine)
    at, weights = few.quadrature(12)
    return few.solve(few.accumulate(weights[:, None] * many.evaluate(np.eye(many.size), at), at))


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
    frames = vertex_frames(normals, np.cross([0.0, 0.0, 1.0], normals))
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
        n=N,
        M=M,
        channels=3,
        variants=made,
        uv=uv.astype(np.float32),
        material=material.name,
        report={
            "SNR of matrices": 21.5,
            "compression": {variants[-1]: {"SNR of 1 to K": [*range(COMPONENTS)]}},
        },
    )
