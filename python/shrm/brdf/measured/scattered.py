"""Interpolation of values measured at scattered places, by thin-plate splines.

    s(x) = sum_k w_k |x - x_k|^2 log |x - x_k| + a + b.x,    sum_k w_k = 0,    sum_k w_k x_k = 0

takes the values at the places x_k; the kernel is conditionally positive definite of order 2 in every dimension,
so that one solution exists [D77], [W04 sec. 8.4].

References
----------
.. [D77] J. Duchon. Splines Minimizing Rotation-Invariant Semi-Norms in Sobolev Spaces. Constructive Theory of
   Functions of Several Variables, 1977.
.. [W04] H. Wendland. Scattered Data Approximation. Cambridge University Press, 2004.
"""

from __future__ import annotations

import numpy as np

from shrm.validation import FloatArray

MOST_PLACES = 4000
"""Of one spline: it solves a dense system of that many equations, 128 MB."""

_BLOCK = 128  # places evaluated at once, so that their distances to all x_k stay in the cache


class ThinPlateSpline:
    """The spline through values at scattered places.

    Parameters
    ----------
    places : (n, d) float64
        Where they were measured, in units that make the directions alike. At places nearer to each other than
        1e-6 of their extent the mean is taken; directions in which they do not spread are ignored.
    values : (n, c) float64
        What was measured.

    Raises
    ------
    ValueError
        If there are none, or more than `MOST_PLACES`.
    """

    def __init__(self, places: FloatArray, values: FloatArray) -> None:
        if not 0 < len(places) <= MOST_PLACES:
            raise ValueError(f"{len(places)} scattered places: 1 to {MOST_PLACES} can be interpolated")
        self._origin = places.mean(axis=0)
        offsets = places - self._origin
        extent = max(float(np.abs(offsets).max()), 1e-300)
        _, spread, axes = np.linalg.svd(offsets, full_matrices=False)
        self._axes = axes[spread > 1e-6 * extent * np.sqrt(len(places))].T
        self._nodes, values = _merged(offsets @ self._axes, values, 1e-6 * extent)
        tail = np.concatenate([np.ones((len(self._nodes), 1)), self._nodes], axis=1)
        n, m = tail.shape
        system = np.zeros((n + m, n + m))
        for start in range(0, n, _BLOCK):
            block = slice(start, min(start + _BLOCK, n))
            system[block, :n] = self._kernel(self._nodes[block])
        system[:n, n:], system[n:, :n] = tail, tail.T
        right = np.concatenate([values, np.zeros((m, values.shape[1]))])
        try:
            solution = np.linalg.solve(system, right)
        except np.linalg.LinAlgError:  # places in a line that is none to rounding
            solution = np.linalg.lstsq(system, right, rcond=None)[0]
        self._weights, self._constant, self._slope = solution[:n], solution[n], solution[n + 1 :]

    def __call__(self, places: FloatArray) -> FloatArray:
        """Return the spline at places (n, d), as (n, c) float64."""
        at = (places - self._origin) @ self._axes
        values = np.empty((len(at), self._weights.shape[1]))
        for start in range(0, len(at), _BLOCK):
            block = at[start : start + _BLOCK]
            kernel = self._kernel(block)
            values[start : start + _BLOCK] = kernel @ self._weights + block @ self._slope
        return np.asarray(values + self._constant)

    def _kernel(self, at: FloatArray) -> FloatArray:
        """r^2 log r^2 = 2 r^2 log r of the distances between (n, d) and the nodes."""
        squares = np.einsum("nd,nd->n", at, at)[:, None] + np.einsum("kd,kd->k", self._nodes, self._nodes)
        squares -= 2.0 * (at @ self._nodes.T)
        np.maximum(squares, 1e-30, out=squares)
        kernel = np.log(squares)
        kernel *= squares
        return np.asarray(kernel)


def _merged(places: FloatArray, values: FloatArray, near: float) -> tuple[FloatArray, FloatArray]:
    """Places that differ, to `near`, and the mean value at each."""
    if places.shape[1] == 0:
        return places[:1], values.mean(axis=0, keepdims=True)
    _, first, which = np.unique(np.round(places / near), axis=0, return_index=True, return_inverse=True)
    total = np.zeros((len(first), values.shape[1]))
    np.add.at(total, which.ravel(), values)
    return places[first], total / np.bincount(which.ravel())[:, None]
