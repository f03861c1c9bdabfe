"""Radiance known at the vertices of a mesh, in place of a material: what precomputed transfer gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.validation import require_instance, require_shape


@dataclass(frozen=True, eq=False)
class VertexRadiance:
    """Radiance towards the eye at each vertex of a mesh, interpolated linearly over its faces.

    It belongs to one eye and one light: for others another one is made. The array is neither copied nor
    watched; that it has changed is told by another `VertexRadiance` of it.

    Parameters
    ----------
    values : (V, 3) float32
        Linear. A row for each vertex of the mesh.

    Raises
    ------
    TypeError, ValueError
        If the array is not of this shape and type.
    """

    values: Float32Array

    def __post_init__(self) -> None:
        require_instance("values", self.values, np.ndarray, what="an array of float32")
        if self.values.dtype != np.float32:
            raise TypeError(f"values must be an array of float32, got {self.values.dtype}")
        require_shape("values", self.values, ("V", 3))

    def __repr__(self) -> str:
        """Say how many vertices there are."""
        return f"<VertexRadiance: {len(self.values)} vertices>"

    def require_vertices(self, count: int) -> None:
        """Check that there is a row for each vertex.

        Raises
        ------
        ValueError
            If there are more or fewer.
        """
        require_shape("values", self.values, (count, 3))

    def at(self, corners: IntArray, weights: FloatArray) -> Float32Array:
        """Return radiance (n, 3) at points of faces with corners (n, 3), by barycentric weights (n, 3)."""
        return np.asarray(np.einsum("nk,nkc->nc", weights, self.values[corners]), np.float32)
