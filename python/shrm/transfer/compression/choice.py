"""How the matrices of a mesh are compressed: exactly or at random, all together or in clusters."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from shrm.arrays import Float32Array
from shrm.transfer.compression.clusters import clustered
from shrm.transfer.compression.components import PrincipalComponents
from shrm.transfer.compression.pca import factored, streamed
from shrm.transfer.matrices.vertex_matrices import Factors
from shrm.transfer.rays.stored import read

GLOBAL_COMPONENTS = 256
"""Global components whose coordinates clusters are found among: their energy is all but that of the rest."""

CLUSTER_COMPONENTS = 3
"""Components of a cluster where their number is not given."""

FACTORED_COLUMNS = 2048
"""Columns, r n^2, up to which exact components are found as fast as random ones."""

_BLOCK = 1024
"""Vertices whose matrices are read at once."""


def principal_components(
    factors: Factors, n: int, accuracy: float, K: int | None, clusters: int | None
) -> PrincipalComponents:
    """Return components of matrices, as many as the accuracy takes or as are asked for.

    Parameters
    ----------
    factors : Factors
    n : int
        Order of the light.
    accuracy : float
        SNR in dB that decides where neither K nor clusters are given.
    K : int, optional
        Number of components; fewer where fewer are exact.
    clusters : int, optional
        Clusters of vertices with K components each, `CLUSTER_COMPONENTS` unless given.
    """
    # Exact ones where one material makes all matrices from few rows
    outer = factors.outer
    small = outer is not None and outer.shape[1] * n * n <= FACTORED_COLUMNS
    height = factors.tents * factors.channels
    columns = (min(height, factors.rows.shape[1]) if small else height) * n * n

    # How many: clusters are found among more than they have
    size: dict[str, Any] = {"accuracy": accuracy} if K is None else {"K": min(K, columns)}
    if clusters is not None:
        size = {"K": min(max(GLOBAL_COMPONENTS, K or 0), columns)}

    if outer is not None and small:
        P = outer.reshape(factors.tents, factors.channels, -1)
        components = factored(P, factors.rows, **size)
    else:
        components = streamed(_blocks(factors), **size)
    if clusters is None:
        return components
    return clustered(components, clusters, min(K or CLUSTER_COMPONENTS, components.K))


def _blocks(factors: Factors) -> Callable[[], Iterator[Float32Array]]:
    """Return what gives the matrices anew, in blocks of vertices."""

    def blocks() -> Iterator[Float32Array]:
        for start in range(0, len(factors.rows), _BLOCK):
            rows = read(factors.rows, slice(start, start + _BLOCK))
            matrices = rows if factors.outer is None else np.matmul(factors.outer, rows)
            yield matrices.reshape(len(rows), factors.tents, factors.channels, -1)

    return blocks
