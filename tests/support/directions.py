"""Seeded unit vectors for the tests."""

import numpy as np


def sphere(n: int, seed: int) -> np.ndarray:
    w = np.random.default_rng(seed).normal(size=(n, 3))
    return w / np.linalg.norm(w, axis=1, keepdims=True)


def hemisphere(n: int, seed: int) -> np.ndarray:
    w = sphere(n, seed)
    w[:, 2] = np.abs(w[:, 2])
    return w


def direction(cos_theta: float, phi: float) -> np.ndarray:
    s = np.sqrt((1.0 - cos_theta) * (1.0 + cos_theta))
    return np.array([[s * np.cos(phi), s * np.sin(phi), cos_theta]])


def turned(w: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return w @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
