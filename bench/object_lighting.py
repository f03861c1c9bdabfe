"""Ways of lighting an object of 50,000 vertices: what each reads, takes and loses.

    OMP_NUM_THREADS=1 python bench/object_lighting.py FOLDER    # all of them, as JSON; half a minute and 2 GB

The object lies in the folder, where `write_object` put it, as the timing study of
beside_transfer_prototype.py reads it: random numbers, but for vertices and frames. Light and eye move, but
for what is made for one that does not. Times are medians of frames, of CPU time with one thread, of wall
time with more; errors are relative RMS against sums in float64, of halves with their rounding.
"""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import counts
import numpy as np
import numpy.typing as npt
from counts import Work
from shrm import sh
from shrm.threads import thread_count
from shrm.transfer.directional_basis import DirectionalBasis
from shrm.transfer.lighting import (
    Compressed,
    Convolution,
    Diffuse,
    FixedLight,
    FixedView,
    Lighting,
    Projection,
    Tents,
)
from shrm.transfer.tangent_frames import band_rotations
from shrm_papers.errors import relative_rms

V, n, SIDE, STORED = 50_000, 5, 64, 50
TERMS = n * n
BANDS = sum((2 * l + 1) ** 2 for l in range(n))
FEW = slice(0, V, 97)  # the vertices at which errors are measured
SECONDS = 0.25
LEAST_FRAMES = 10

KERNEL = np.linspace(1, 0.2, n)

Array = npt.NDArray[Any]


# ---- The object


def frames() -> npt.NDArray[np.float32]:
    """Vertices on a spiral over the unit sphere, as (V, 3, 3) frames; z is the vertex itself."""
    k = np.arange(V) + 0.5
    z, phi = 1 - 2 * k / V, np.pi * (1 + np.sqrt(5)) * k
    normal = np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], axis=1)
    tangent = np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=1)
    return np.stack([tangent, np.cross(normal, tangent), normal], axis=2).astype(np.float32)


def write_object(folder: Path) -> None:
    """Write the arrays, those too that only the study reads."""
    rng = np.random.default_rng(1)
    (folder / "meshes").mkdir()
    local = frames()
    np.ascontiguousarray(local[:, :, 2]).tofile(folder / "meshes" / "nef50.v")
    np.ascontiguousarray(np.swapaxes(local, 1, 2)).tofile(folder / "meshes" / "nef50.tbn")
    for name, values in {
        "Tt": V * TERMS**2,
        "RTt": V * TERMS**2,
        "Rb": V * BANDS,
        "pm": SIDE**2 * TERMS,
        "A7": V * 7**2 * TERMS,
        "A11": V * 11**2 * TERMS,
        "W50": V * STORED,
        "Ak50": STORED * 11**2 * TERMS,
    }.items():
        with (folder / f"bench_{name}.f32").open("wb") as file:
            for start in range(0, values, 1 << 22):
                (rng.random(min(values - start, 1 << 22), dtype=np.float32) - np.float32(0.5)).tofile(file)


class Stored:
    """The arrays of the folder."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.frames = folder, frames()
        self.vertices = np.ascontiguousarray(self.frames[:, :, 2])

    def read(self, name: str, *shape: int) -> npt.NDArray[np.float32]:
        return np.fromfile(self.folder / f"bench_{name}.f32", dtype=np.float32).reshape(shape)

    def map(self) -> Array:
        return self.read("pm", SIDE, SIDE, 1, TERMS)

    def transfer(self) -> Array:
        return self.read("Tt", V, TERMS, TERMS)

    def matrices(self, M: int) -> Array:
        return self.read(f"A{M}", V, M * M, 1, TERMS)

    def weights(self) -> Array:
        return self.read("W50", V, STORED)[:, :25]

    def components(self) -> Array:
        return self.read("Ak50", STORED, 121, 1, TERMS)[:25]


# ---- In float64, at a few vertices: radiance is a row times light


def _local_views(stored: Stored, eye: Array) -> Array:
    """Those below the horizon are brought to it."""
    towards = eye - stored.vertices[FEW].astype(np.float64)
    local = np.einsum("vij,vi->vj", stored.frames[FEW].astype(np.float64), towards)
    local[:, 2] = np.maximum(local[:, 2], 0)
    return np.asarray(local / np.linalg.norm(local, axis=1, keepdims=True))


def _tents(M: int, stored: Stored, eye: Array) -> Array:
    """All tents at the views: (v, M^2)."""
    return DirectionalBasis(M).evaluate(np.eye(M * M), _local_views(stored, eye))


def _tent_rows(M: int, stored: Stored, eye: Array) -> Array:
    matrices = stored.matrices(M)[FEW, :, 0].astype(np.float64)
    return np.asarray(np.einsum("vt,vtj->vj", _tents(M, stored, eye), matrices))


def _component_rows(K: int, stored: Stored, eye: Array) -> Array:
    weights, components = stored.weights()[FEW, :K], stored.components()[:K, :, 0].astype(np.float64)
    tents = _tents(11, stored, eye)
    return np.asarray(np.einsum("vt,vk,ktj->vj", tents, weights, components, optimize=True))


def _map_rows(stored: Stored, eye: Array) -> Array:
    """Between the samples of the parabolic map, rotated into global coordinates."""
    w = _local_views(stored, eye)
    at = (SIDE - 1) * (w[:, :2] / (1 + w[:, 2:]) + 1) / 2
    x, y = np.maximum(0, 1 - np.abs(at.T[:, :, None] - np.arange(SIDE)))
    local = np.einsum("vj,vi,jik->vk", y, x, stored.map()[:, :, 0].astype(np.float64), optimize=True)
    bands = band_rotations(stored.frames[FEW], n)
    parts = [np.einsum("vi,vij->vj", local[:, l * l : (l + 1) ** 2], bands[l]) for l in range(n)]
    return np.concatenate(parts, axis=1)


def _lobe_rows(stored: Stored, eye: Array) -> Array:
    axes = np.einsum("vij,vj->vi", stored.frames[FEW], _local_views(stored, eye) * [-1, -1, 1])
    degree = np.sqrt(np.arange(TERMS)).astype(int)
    Y = sh.evaluate(np.eye(TERMS), axes / np.linalg.norm(axes, axis=1, keepdims=True))
    return np.asarray(Y * KERNEL[degree])


def _shadowed(rows: Array, stored: Stored) -> Array:
    return np.asarray(np.einsum("vi,vij->vj", rows, stored.transfer()[FEW].astype(np.float64)))


# ---- The ways


@dataclass(frozen=True)
class Way:
    """One way of lighting: what is measured, what it must do at least, and its rows in float64.

    `moving` is what moves from frame to frame: "both", the "eye" or the "light".
    """

    make: Callable[[Stored], Lighting]
    work: Work
    rows: Callable[[Stored, Array], Array]
    moving: str = "both"


def _tents_way(M: int, kind: type) -> Way:
    return Way(
        lambda o: Tents(o.vertices, o.frames, o.matrices(M).astype(kind)),
        counts.lit_by_tents(V, M, TERMS, np.dtype(kind).itemsize),
        lambda o, eye: _tent_rows(M, o, eye),
    )


def _compressed_way(K: int, kind: type) -> Way:
    return Way(
        lambda o: Compressed(o.vertices, o.frames, o.weights().astype(kind), o.components(), K=K),
        counts.lit_by_components(V, K, 11, TERMS, np.dtype(kind).itemsize),
        lambda o, eye: _component_rows(K, o, eye),
    )


def _projection_way(kind: type, prerotated: bool) -> Way:
    return Way(
        lambda o: Projection(o.vertices, o.frames, o.map(), o.transfer().astype(kind), prerotated=prerotated),
        counts.lit_by_transfer(V, TERMS, np.dtype(kind).itemsize, 0 if prerotated else BANDS),
        lambda o, eye: _shadowed(_map_rows(o, eye), o),
    )


WAYS = {
    "a: projection, T and a stored rotation": _projection_way(np.float32, False),
    "a: projection, T rotated beforehand": _projection_way(np.float32, True),
    "the same, halves": _projection_way(np.float16, True),
    "b: 7 x 7 tents": _tents_way(7, np.float32),
    "7 x 7 tents, halves": _tents_way(7, np.float16),
    "c: 11 x 11 tents": _tents_way(11, np.float32),
    "11 x 11 tents, halves": _tents_way(11, np.float16),
    "d: PCA, K = 10": _compressed_way(10, np.float32),
    "K = 10, half weights": _compressed_way(10, np.float16),
    "e: PCA, K = 25": _compressed_way(25, np.float32),
    "K = 25, half weights": _compressed_way(25, np.float16),
    "fixed light, 11 x 11 tents": Way(
        lambda o: FixedLight(_tents_way(11, np.float32).make(o)),  # type: ignore[arg-type]
        counts.lit_by_fixed_tents(V),
        lambda o, eye: _tent_rows(11, o, eye),
        "eye",
    ),
    "fixed view": Way(
        lambda o: FixedView(_compressed_way(25, np.float32).make(o)),  # type: ignore[arg-type]
        counts.lit_by_rows(V, TERMS),
        lambda o, eye: _component_rows(25, o, eye),
        "light",
    ),
    "diffuse": Way(
        lambda o: Diffuse(np.ascontiguousarray(o.transfer()[:, :1])),
        counts.lit_by_rows(V, TERMS),
        lambda o, eye: o.transfer()[FEW, 0].astype(np.float64),
    ),
    "convolution, T": Way(
        lambda o: Convolution(o.vertices, o.frames, KERNEL, o.transfer()),
        counts.lit_by_transfer(V, TERMS, 4, 0),
        lambda o, eye: _shadowed(_lobe_rows(o, eye), o),
    ),
    "convolution, no shadows": Way(
        lambda o: Convolution(o.vertices, o.frames, KERNEL),
        counts.lit_without_shadows(V, TERMS, 0),
        _lobe_rows,
    ),
    "projection, no shadows": Way(
        lambda o: Projection(o.vertices, o.frames, o.map()),
        counts.lit_without_shadows(V, TERMS, BANDS),
        _map_rows,
    ),
}


def measured(way: Way, stored: Stored) -> dict[str, float]:
    """Return milliseconds a frame, the error, and the share of the machine's limit."""
    lighting, out = way.make(stored), np.empty((V, 3), dtype=np.float32)
    clock = time.thread_time if thread_count() == 1 else time.perf_counter
    taken: list[float] = []
    end = time.perf_counter() + SECONDS
    while len(taken) < LEAST_FRAMES or time.perf_counter() < end:
        light, eye = _frame(len(taken), way.moving)
        start = clock()
        lighting.radiance(light, eye=eye, out=out)
        taken.append(clock() - start)
    exact = way.rows(stored, eye) @ light
    return {"ms": 1e3 * median(taken[2:]), "error": relative_rms(out[FEW], exact)}


def _frame(k: int, moving: str) -> tuple[Array, Array]:
    """Light and eye of a frame, as the study moves them."""
    turned, lit = (0 if moving == "light" else k), (0 if moving == "eye" else k)
    light = 0.2 * np.sin(1.7 * np.arange(TERMS)[:, None] + 0.9 * np.arange(3) + 0.05 * lit)
    return light, np.array([3 * np.cos(0.13 * turned), 0.5, 3 * np.sin(0.13 * turned)])


if __name__ == "__main__":
    found = Stored(Path(sys.argv[1]))
    json.dump({name: measured(way, found) for name, way in WAYS.items()}, sys.stdout, indent=1)
    print()
