"""What the benchmarks are fed with."""

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def coefficients(F: int, channels: int = 3, seed: int = 1) -> FloatArray:
    """A natural fall of the spectrum: energy 1 / l in degree l."""
    c = np.random.default_rng(seed).normal(size=((F + 1) ** 2, channels))
    l = np.sqrt(np.arange((F + 1) ** 2)).astype(int)
    return np.asarray(c / np.maximum(l, 1)[:, None])


def frames(n: int) -> tuple[FloatArray, FloatArray]:
    """Normals and views, cos^2(theta_v) uniform."""
    rng = np.random.default_rng(2)
    N, T = rng.normal(size=(2, n, 3))
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    T -= N * (N * T).sum(axis=1, keepdims=True)
    T /= np.linalg.norm(T, axis=1, keepdims=True)
    cosine = np.sqrt(rng.random(n))[:, None]
    return N, cosine * N + np.sqrt(1 - cosine**2) * T


def latlong_directions(H: int, W: int) -> FloatArray:
    """Texel centers (H, W, 3)."""
    theta = (np.arange(H)[:, None] + 0.5) * np.pi / H
    phi = np.pi - 2 * np.pi * (np.arange(W) + 0.5) / W
    z = np.broadcast_to(np.cos(theta), (H, W))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), z], axis=-1)


def texels(shape: tuple[int, ...], seed: int = 3) -> npt.NDArray[Any]:
    """Random float32 in [0, 1)."""
    return np.random.default_rng(seed).random(shape, dtype=np.float32)


# A rotation about no axis of the grid, with rational entries.
TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
