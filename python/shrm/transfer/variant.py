"""A variant of transfer: the matrices of all vertices, with or without shadows and bounces [LK03]."""

from __future__ import annotations

from dataclasses import dataclass

from shrm.arrays import Int32Array, RealArray
from shrm.transfer.described import Described

VARIANTS = ("unshadowed", "shadowed", "interreflected")
"""Names of the variants: nothing hides the light; the object does; its parts send each other light, too."""


@dataclass(frozen=True, eq=False, repr=False)
class Variant(Described):
    """Transfer matrices of all vertices: components and weights, or the matrices themselves, or both.

    Attributes
    ----------
    weights : (V, K) float32 or float16, or None
    components : (K, M^2, C, n^2) or, clustered, (Q, K, M^2, C, n^2) float32 or float16, or None
        Matrices are sum_k weights[p, k] components[k] [LK03 eq. 12].
    clusters : (V,) int32 or None
        Clusters of the vertices, in [0, Q).
    matrices : (V, M^2, C, n^2) float32 or float16, or None
        Uncompressed matrices; mapped from disk maybe.
    """

    weights: RealArray | None = None
    components: RealArray | None = None
    clusters: Int32Array | None = None
    matrices: RealArray | None = None

    @property
    def K(self) -> int:
        """Number of components of a vertex; 0 where there are the matrices alone."""
        return 0 if self.weights is None else int(self.weights.shape[1])
