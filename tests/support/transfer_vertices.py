"""Vertices to be lit, and what their lighting is by plain sums in float64."""

import numpy as np
import pytest
from shrm.transfer.lighting import Compressed, Tents

from support import oracles

V = 531  # two whole blocks, and vectors that are not full
EYE, VIEW = np.array([1.4, -0.7, 0.9]), np.array([0.48, -0.6, 0.64])
SEEN = pytest.mark.parametrize("seen", [{"eye": EYE}, {"view": VIEW}], ids=["near", "distant"])


# ---- Objects


def frames(count: int, seed: int) -> np.ndarray:
    return oracles.rotations(np.random.default_rng(seed).uniform(size=(count, 3))).astype(np.float32)


def vertices(count: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-0.5, 0.5, size=(count, 3)).astype(np.float32)


def random(shape: tuple[int, ...], seed: int, dtype: type = np.float32) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=shape).astype(dtype)


POINTS, FRAMES = vertices(V, 1), frames(V, 2)


def shadows(count: int, n: int, seed: int, dtype: type = np.float32) -> np.ndarray:
    return (np.eye(n * n) + 0.3 * random((count, n * n, n * n), seed)).astype(dtype)


def some_of(kind: str, channels: int) -> Tents | Compressed:
    if kind == "tents":
        return Tents(POINTS, FRAMES, random((V, 49, channels, 25), 31))
    if kind == "halves":
        return Tents(POINTS, FRAMES, random((V, 49, channels, 25), 32, np.float16))
    weights, components = random((V, 9), 33), random((3, 9, 49, channels, 25), 34)
    if kind == "compressed":
        return Compressed(POINTS, FRAMES, weights, components[0], K=6)
    return Compressed(POINTS, FRAMES, weights, components, np.arange(V) % 3, K=7)


# ---- Oracles


def local_views(seen: dict, points: np.ndarray = POINTS, axes: np.ndarray = FRAMES) -> np.ndarray:
    """In float64, brought to the horizon where below."""
    d = seen["eye"] - points.astype(np.float64) if "eye" in seen else np.tile(seen["view"], (len(points), 1))
    local = np.einsum("vij,vi->vj", axes.astype(np.float64), d)
    below = local[:, 2] < 0
    local[below, 2] = 0
    return local / np.linalg.norm(local, axis=1, keepdims=True)


def hats(M: int, w: np.ndarray) -> np.ndarray:
    """All tents (n, M^2) at directions above the horizon, the concentric map by its sectors of the disk."""
    r, phi = np.sqrt(np.maximum(1 - w[:, 2], 0)), np.arctan2(w[:, 1], w[:, 0])
    phi = np.where(phi < -np.pi / 4, phi + 2 * np.pi, phi)
    sector = np.clip(((phi + np.pi / 4) // (np.pi / 2)).astype(int), 0, 3)
    along = 4 / np.pi * (phi - sector * np.pi / 2) * r
    a = np.choose(sector, [r, -along, -r, along])
    b = np.choose(sector, [along, r, -along, -r])
    one = [np.maximum(0, 1 - np.abs((M - 1) * (x + 1)[:, None] / 2 - np.arange(M))) for x in (a, b)]
    return (one[1][:, :, None] * one[0][:, None, :]).reshape(len(w), M * M)


def tents_oracle(matrices: np.ndarray, light: np.ndarray, seen: dict) -> np.ndarray:
    """[LK03] eq. 9, every tent."""
    A, M = matrices.astype(np.float64), round(np.sqrt(matrices.shape[1]))
    rows = np.einsum("vt,vtcj->vcj", hats(M, local_views(seen)), A)
    return np.einsum("vcj,jc->vc", np.broadcast_to(rows, (V, 3, rows.shape[2])), light)


def tolerance(matrices: np.ndarray, light: np.ndarray, M: int) -> float:
    """What float32 may err, for random values of deviation 1 and light likewise.

    Positions on the square err by some 4e-7 of its side, M - 1 cells, of the difference of two tents' values,
    each of deviation |light|; sums of n^2 products by n^2 times 6e-8 of it. Three channels of V vertices
    reach four deviations.
    """
    spread = np.abs(matrices.astype(np.float64)).std() + np.abs(matrices.astype(np.float64)).mean()
    return 4 * spread * np.linalg.norm(light, axis=0).max() * (2 * 4e-7 * (M - 1) + 6e-8 * len(light) ** 0.5)


def assert_close(found: np.ndarray, expected: np.ndarray, atol: float) -> None:
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol)
