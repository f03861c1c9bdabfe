"""Vectors in arrays."""

from __future__ import annotations

import numpy as np

from shrm.arrays import FloatArray


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., 3) of unit length; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, 1.0))
