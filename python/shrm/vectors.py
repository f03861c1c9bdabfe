"""Unit vectors, and directions spread evenly by the golden ratio."""

from __future__ import annotations

import numpy as np

from shrm.arrays import FloatArray

GOLDEN_RATIO = (np.sqrt(5) - 1) / 2
"""The golden ratio, less than 1: its multiples, modulo 1, fill [0, 1) evenly however many there are."""


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., 3) of unit length; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))


def golden_azimuths(count: int, start: float = 0.0) -> FloatArray:
    """Return azimuths (count,) in radians, each turned on from the last by the golden ratio of a turn.

    `start` is the first of the numbers, one apart, that are multiplied by it.
    """
    return np.asarray(2 * np.pi * (np.arange(count) + start) * GOLDEN_RATIO)


def golden_spiral(z: FloatArray, start: float = 0.0) -> FloatArray:
    """Return unit vectors (n, 3) of heights z (n,) with `golden_azimuths`.

    Where heights are one step apart, they share the sphere between these heights evenly.
    """
    phi = golden_azimuths(len(z), start)
    sine = np.sqrt((1 - z) * (1 + z))
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
