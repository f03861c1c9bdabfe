"""Clustered principal components: vertices in clusters, each with components of its own [SHHS03].

Clusters are found among the coordinates of vertices in many global components: few numbers of the same
energy. What those components leave is not looked at again.
"""

from __future__ import annotations

import numpy as np

from shrm.arrays import Float32Array, FloatArray, Int32Array
from shrm.transfer.compression.components import PrincipalComponents
from shrm.validation import number, whole_number


def clustered(
    components: PrincipalComponents,
    clusters: int,
    K: int,
    *,
    seed: int = 0,
    tolerance: float = 1e-3,
    rounds: int = 100,
) -> PrincipalComponents:
    """Return clusters of K components each, by turns of assignment and local components [SHHS03].

    Parameters
    ----------
    components : PrincipalComponents
        Global ones, in float32, many more than K: what they leave is not looked at again.
    clusters : int
        Q, at most the number of vertices.
    K : int
        Components of a cluster, at most those given.
    seed : int
        Seed of the draw of vertices that clusters start from.
    tolerance : float
        It ends when a turn lowers the energy that is left by less than this part of it.
    rounds : int
        The most turns.

    Returns
    -------
    PrincipalComponents
        Components with `clusters`; all Q are used.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    if components.clusters is not None or components.weights.dtype != np.float32:
        raise ValueError("components must be global and in float32, before rounding")

    # Global weights are coordinates: components are orthonormal
    Y = components.weights
    Q, K = whole_number("clusters", clusters, 1, len(Y)), whole_number("K", K, 1, components.K)
    tolerance, rounds = number("tolerance", tolerance, 0), whole_number("rounds", rounds, 1)
    energies = np.einsum("pk,pk->p", Y, Y, dtype=np.float64)

    # Turns of assignment and local components, until they lower the energy by little
    index = _nearest(Y, _lines(Y, Q, np.random.default_rng(seed)), energies)[0]
    before = np.inf
    for _ in range(rounds):
        axes = _local_components(Y, index, Q, K)[0]
        index, left = _nearest(Y, axes, energies)
        if before - left.sum() <= tolerance * left.sum():
            break
        before = left.sum()

    # What the last clusters have
    axes, spectra = _local_components(Y, index, Q, K)
    weights = np.empty((len(Y), K), np.float32)
    for q in range(Q):
        weights[index == q] = Y[index == q] @ axes[q].T
    flat = components.components.reshape(components.K, -1)
    forms = (axes.reshape(Q * K, -1) @ flat).reshape(Q, K, *components.components.shape[1:])
    left = components.left[-1] + np.append(spectra, 0.0)[::-1].cumsum()[::-1][: K + 1]
    return PrincipalComponents(weights, forms, index, left, np.zeros(K + 1))


def _lines(Y: Float32Array, Q: int, rng: np.random.Generator) -> Float32Array:
    """Return unit vectors (Q, 1, s) along vertices, drawn by the energy that those before leave of them."""
    left = np.einsum("pk,pk->p", Y, Y, dtype=np.float64)
    lines = np.zeros((Q, 1, Y.shape[1]), np.float32)
    for q in range(Q):
        if left.sum() <= 0:
            break  # the rest stay empty, and are filled by the first turn
        y = Y[rng.choice(len(Y), p=left / left.sum())]
        lines[q, 0] = y / np.linalg.norm(y)
        along = (Y @ lines[q, 0]).astype(np.float64)
        left = np.minimum(left, np.maximum(np.einsum("pk,pk->p", Y, Y) - along**2, 0))
    return lines


def _nearest(Y: Float32Array, axes: Float32Array, energies: FloatArray) -> tuple[Int32Array, FloatArray]:
    """Return the cluster (V,) that leaves least of each vertex, and what it leaves (V,); none is empty.

    An empty cluster takes the vertex that is served worst, from one that keeps others.
    """
    Q, K, s = axes.shape
    along = Y @ axes.reshape(Q * K, s).T
    kept = np.einsum("pqk,pqk->pq", *2 * [along.reshape(len(Y), Q, K)])
    index = kept.argmax(axis=1).astype(np.int32)
    left = np.maximum(energies - np.take_along_axis(kept, index[:, None], axis=1)[:, 0], 0)
    counts = np.bincount(index, minlength=Q)
    worst = iter(np.argsort(-left, kind="stable"))
    for q in np.flatnonzero(counts == 0):
        p = next(p for p in worst if counts[index[p]] > 1)
        counts[index[p]] -= 1
        counts[q] += 1
        index[p], left[p] = q, 0.0
    return index, left


def _local_components(Y: Float32Array, index: Int32Array, Q: int, K: int) -> tuple[Float32Array, FloatArray]:
    """Return the K largest components (Q, K, s) of each cluster, and energies (s,) of first, second, ..."""
    s = Y.shape[1]
    axes, spectra = np.empty((Q, K, s), np.float32), np.zeros(s)
    for q in range(Q):
        y = Y[index == q].astype(np.float64)
        values, vectors = np.linalg.eigh(y.T @ y)
        v = vectors[:, ::-1][:, :K]
        largest = np.take_along_axis(v, np.abs(v).argmax(axis=0)[None], axis=0)
        axes[q] = (v * np.where(largest < 0, -1, 1)).T
        spectra += np.maximum(values[::-1], 0)
    return axes, spectra
