"""Compression of transfer matrices: principal components of outgoing radiance [LK03 section 6].

The matrices A_p of all vertices are approximated by weighted sums of K, without taking off a mean:

    A_p ~ sum_k w_pk A_k                                                        [LK03 eq. 12]

[LK03 section 6] takes the components of the coefficients themselves. Here what is kept is best in outgoing
radiance: with G the Gram matrix of the tents and light whose coefficients are random, independent and of
variance 1, the expected squared error of radiance over the hemisphere, summed over channels, is
|L^T (A_p - A~_p)|^2, where G = L L^T. Rows are therefore multiplied by L^T ("whitened") before anything is
decomposed; components are orthonormal in G, and the energy left by K of them is the sum of the eigenvalues
beyond. SNRs are relative to uncompressed radiance, in dB.

`factored`  exact, for A_p = P X_p with one P for all vertices, as one material gives; never forms A
`streamed`  randomised, by subspace iteration [HMT11 algorithm 4.4], for matrices on disk, read in blocks
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property

import numpy as np

from shrm.arrays import Float32Array, FloatArray, RealArray
from shrm.transfer.compression.components import PrincipalComponents, components_for
from shrm.transfer.directional_basis import MOST_TENTS, gram_of_one_dimension
from shrm.validation import number, require_finite, require_shape, whole_number

Blocks = RealArray | Callable[[], Iterable[RealArray]]
"""Matrices (V, M^2, C, n^2), mapped from disk maybe; or what gives them anew, in order, in blocks."""

Read = Callable[[], Iterator[Float32Array]]
"""What gives the matrices anew, in blocks of float32."""

MOST = 512
"""The largest K of `streamed`, unless it is told another."""

PASSES = 3
"""Passes of `streamed` over the matrices. With the extra columns these lose less than .1 dB against the exact
components where singular values fall as slowly as those of shadowed matrices do."""

GRAM_COLUMNS = 4096
"""Numbers of a matrix up to which `streamed` keeps the Gram matrix of all vertices, at most 128 MB."""

_FIRST = 96
"""The K that is tried first where an accuracy decides; and then four times as many."""

_MORE = 8
"""Components beyond those that the iteration thinks are enough, which the last pass then decides."""

_BLOCK_BYTES = 1 << 25
"""Bytes of matrices that are multiplied at once: little beside the matrices of products."""


def factored(
    P: RealArray,
    X: RealArray,
    *,
    K: int | None = None,
    accuracy: float | None = None,
) -> PrincipalComponents:
    """Return the exact principal components of A_p = P X_p.

    With L^T P = Q U, Q orthonormal, components of U X_p in the plain metric are all that is needed. It takes
    (r n^2)^2 numbers of memory: for r n^2 of a few thousand.

    Parameters
    ----------
    P : (M^2, C, r) floating
        Coefficients in tents of what X_p becomes.
    X : (V, r, n^2) floating
        Rows X_p of each vertex, over light; mapped from disk maybe.
    K : int, optional
        How many components, 1 to min(M^2 C, r) n^2; by default all of them.
    accuracy : float, optional
        Instead: as many as reach this SNR, in dB.

    Returns
    -------
    PrincipalComponents

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    require_shape("P", P, ("M^2", "C", "r"), empty=False)
    require_shape("X", X, ("V", P.shape[2], "n^2"), empty=False)
    require_finite("P", P)

    # With L^T P = Q U those of U X_p
    sides, (V, r, n2) = _Sides(P.shape[0]), X.shape
    whitened = sides.times(sides.L.T, np.asarray(P, np.float64)[None]).reshape(-1, r)
    Q, U = np.linalg.qr(whitened)
    size = len(U) * n2
    step = max(1, _BLOCK_BYTES // (8 * size))
    most = _asked(K, accuracy, size)

    def rows() -> Iterator[FloatArray]:
        for start in range(0, V, step):
            yield (U @ np.asarray(X[start : start + step], np.float64)).reshape(-1, size)

    # Their Gram matrix over the vertices, and its eigenvectors
    S = np.zeros((size, size))
    for block in rows():
        S += block.T @ block
    if not np.isfinite(S).all():
        raise ValueError("X must be finite")
    values, vectors = _descending(S)
    left = np.append(np.cumsum(values[::-1])[::-1], 0.0)
    count = components_for(accuracy, left, most)

    # Coordinates of the vertices, and components back in tents
    kept = vectors[:, :count]
    weights = np.concatenate([np.asarray(block @ kept, np.float32) for block in rows()])
    whitened = Q @ kept.T.reshape(count, len(U), n2)  # (K, M^2 C, n^2)
    components = sides.times(sides.inverse.T, whitened.reshape(count, *P.shape[:2], n2))
    return PrincipalComponents.of(weights, components, left[: count + 1])


def streamed(
    matrices: Blocks,
    *,
    K: int | None = None,
    accuracy: float | None = None,
    most: int = MOST,
    passes: int = PASSES,
    seed: int = 0,
) -> PrincipalComponents:
    """Return principal components of matrices that are read in blocks.

    The space of the largest components is found by iteration from a random one [HMT11 algorithm 4.4]. Up to
    `GRAM_COLUMNS` numbers of a vertex it iterates on the Gram matrix of all vertices, for which the blocks
    are read once; beyond on the blocks, read for each pass and once more. The energy that is left outside is
    summed in a last pass, so that the SNR of every K is that of these components, whatever iteration missed.

    Parameters
    ----------
    matrices : (V, M^2, C, n^2) floating or callable
        Mapped from disk maybe; or what returns an iterable of blocks (b, M^2, C, n^2), in the order of
        vertices, each time it is called.
    K : int, optional
        How many components, up to M^2 C n^2; by default `most`.
    accuracy : float, optional
        Instead: as many as reach this SNR, in dB. Warns where `most` of them do not.
    most : int
        The largest K where it is not given.
    passes : int
        Passes of the iteration over the matrices, at least 1.
    seed : int
        Seed of the random space at the start.

    Returns
    -------
    PrincipalComponents

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    passes = whole_number("passes", passes, 1)
    read = _blocks(matrices)
    _, tents, C, n2 = shape = _matrices_shape(next(iter(read()), np.zeros((0, 0))))
    sides, size = _Sides(tents), tents * C * n2
    most = _asked(K, accuracy, size, min(whole_number("most", most, 1), size))
    gram = (_Gram if size <= GRAM_COLUMNS else _BlocksGram)(read, sides, shape[1:])

    # The space of the largest components, with more of them until they reach the accuracy
    rng, X = np.random.default_rng(seed), np.empty((size, 0))
    count = most if accuracy is None else min(_FIRST, most)
    while True:
        columns = min(size, count + max(16, count // 2))
        X = np.concatenate([X, rng.standard_normal((size, columns - X.shape[1]))], axis=1)
        for _ in range(passes - 1):
            X = _conditioned(gram.times(X))
        X = np.linalg.qr(gram.times(X))[0]
        values, vectors = _descending(X.T @ gram.times(X))
        if accuracy is None or count == most:
            break
        enough = np.cumsum(values[:count]) >= gram.energy * (1 - 10 ** (-accuracy / 10))
        if enough.any():
            count = min(int(enough.argmax()) + 1 + _MORE, most)
            break
        count = min(4 * count, most)

    # Coordinates of the vertices in it, and what is left outside
    X = X @ vectors[:, :count]
    Y, outside = _projected(read, X, sides, shape[1:])
    # Components are orthonormal: each keeps the energy of its own coordinates
    kept = np.einsum("pk,pk->k", Y, Y, dtype=np.float64)
    left = outside + np.append(np.cumsum(kept[::-1])[::-1], 0.0)
    count = components_for(accuracy, left, count)
    components = sides.times(sides.inverse.T, X[:, :count].T.reshape(count, *shape[1:]))
    return PrincipalComponents.of(Y[:, :count], components, left[: count + 1])


class _Sides:
    """L, where L (x) L is the Cholesky factor of the tents' Gram matrix [LK03 eq. 7], and its products."""

    def __init__(self, tents: int) -> None:
        self.M = round(np.sqrt(tents))
        if tents != self.M**2 or not 2 <= self.M <= MOST_TENTS:
            raise ValueError(f"matrices must have M^2 tents, M from 2 to {MOST_TENTS}, got {tents}")
        self.L = np.linalg.cholesky(np.sqrt(2 * np.pi) * gram_of_one_dimension(self.M))
        self.inverse = np.linalg.inv(self.L)

    def times(self, side: FloatArray, rows: RealArray) -> RealArray:
        """Return (side (x) side) times each of rows (k, M^2, C, n^2)."""
        M, factor = self.M, side.astype(rows.dtype)
        along_v = factor @ rows.reshape(len(rows), M, -1)
        along_u = factor @ along_v.reshape(len(rows) * M, M, -1)
        return np.asarray(along_u.reshape(rows.shape))


def _conditioned(X: FloatArray) -> FloatArray:
    """Return columns that span the same and are far from dependent, at the cost of a product."""
    S = X.T @ X
    shift = 1e-12 * np.trace(S)
    if shift == 0:
        return X
    L = np.linalg.cholesky(S + shift * np.eye(len(S)))
    return np.asarray(X @ np.linalg.inv(L).T)


class _Gram:
    """A^T A of whitened A (V, M^2 C n^2)."""

    def __init__(self, read: Read, sides: _Sides, shape: tuple[int, ...]) -> None:
        size = int(np.prod(shape))
        self.matrix = np.zeros((size, size))
        for block in read():
            whitened = sides.times(sides.L.T, block).reshape(len(block), size)
            self.matrix += whitened.T @ whitened
        self.energy = float(np.trace(self.matrix))
        if not np.isfinite(self.energy):
            raise ValueError("matrices must be finite")

    def times(self, X: FloatArray) -> FloatArray:
        """Return A^T A X."""
        return self.matrix @ X


class _BlocksGram:
    """A^T A that is never formed: columns take the factors, not A, and every product reads the blocks."""

    def __init__(self, read: Read, sides: _Sides, shape: tuple[int, ...]) -> None:
        self.read, self.sides, self.shape = read, sides, shape

    @cached_property
    def energy(self) -> float:
        """The trace of A^T A."""
        whitened = (self.sides.times(self.sides.L.T, block) for block in self.read())
        return sum(float(np.vdot(rows, rows)) for rows in whitened)

    def times(self, X: FloatArray) -> FloatArray:
        """Return A^T A X."""
        sides = self.sides
        inward = sides.times(sides.L, X.T.reshape(-1, *self.shape)).reshape(X.shape[::-1])
        inward = inward.T.astype(np.float32)
        total = np.zeros(X.shape)
        for block in self.read():
            rows = block.reshape(len(block), -1)
            total += rows.T @ (rows @ inward)
        if not np.isfinite(total).all():
            raise ValueError("matrices must be finite")
        outward = sides.times(sides.L.T, total.T.reshape(-1, *self.shape))
        return np.ascontiguousarray(outward.reshape(X.shape[::-1]).T)


def _projected(
    read: Read, X: FloatArray, sides: _Sides, shape: tuple[int, ...]
) -> tuple[Float32Array, float]:
    """Return coordinates (V, columns) in the orthonormal X, and the energy outside its span.

    That energy is summed over what is left, not taken as a difference, which loses its digits.
    """
    forms = X.T.reshape(-1, *shape)
    inward = sides.times(sides.L, forms).reshape(X.shape[::-1]).T.astype(np.float32)
    spanned = sides.times(sides.inverse.T, forms).reshape(X.shape[::-1]).astype(np.float32)
    coordinates, outside = [], 0.0
    for block in read():
        rows = block.reshape(len(block), -1)
        coordinates.append(np.asarray(rows @ inward, np.float32))
        rest = sides.times(sides.L.T, (rows - coordinates[-1] @ spanned).reshape(-1, *shape))
        outside += float(np.einsum("pi,pi->p", *2 * [rest.reshape(len(block), -1)]).sum(dtype=np.float64))
    return np.concatenate(coordinates), outside


def _blocks(matrices: Blocks) -> Read:
    """Return what gives the blocks, in float32, each checked against the first."""
    if not callable(matrices):
        _matrices_shape(matrices)
    rows = 1 if callable(matrices) else max(1, _BLOCK_BYTES // (4 * matrices[:1].size))

    def read() -> Iterator[Float32Array]:
        first = None
        parts = (
            matrices()
            if callable(matrices)
            else (matrices[start : start + rows] for start in range(0, len(matrices), rows))
        )
        for block in parts:
            first = first or _matrices_shape(block)[1:]
            if block.shape[1:] != first:
                raise ValueError(f"blocks of matrices must be alike, got {block.shape[1:]} after {first}")
            yield np.asarray(block, np.float32)

    return read


def _matrices_shape(matrices: RealArray) -> tuple[int, int, int, int]:
    """Return V, M^2, C and n^2; refuse what are no matrices."""
    shape = np.shape(matrices)
    if len(shape) != 4 or 0 in shape or np.asarray(matrices[:0]).dtype.kind != "f":
        raise ValueError(f"matrices must be floats of the shape (V, M^2, C, n^2), got the shape {shape}")
    return shape[0], shape[1], shape[2], shape[3]


def _asked(K: int | None, accuracy: float | None, size: int, otherwise: int | None = None) -> int:
    """Return the largest K that may be found."""
    if K is not None and accuracy is not None:
        raise ValueError(f"K must be None where accuracy is given, got {K!r}")
    if accuracy is not None:
        number("accuracy", accuracy)
    return whole_number("K", K, 1, size) if K is not None else otherwise or size


def _descending(S: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return eigenvalues, none below zero, and eigenvectors of a Gram matrix, the largest first."""
    values, vectors = np.linalg.eigh(S)
    return np.maximum(values[::-1], 0), vectors[:, ::-1]
