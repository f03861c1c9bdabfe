"""Interpolation of values measured at scattered places, by thin-plate splines.

    s(x) = sum_k w_k |x - x_k|^2 log |x - x_k| + a + b.x,    sum_k w_k = 0,    sum_k w_k x_k = 0

takes the values at the places x_k; the kernel is conditionally positive definite of order 2 in every
dimension, so that one solution exists [D77], [W04 sec. 8.4].

A BRDF is interpolated by the spline of

    log(f N.L N.V + softening)   over

    (0.4 asinh(5 x), 2.25 (1 - cos theta_d), 0.35 (N.V - N.L)),    x = sqrt(theta_h^2 + 0.04^2) - 0.04

with half angles [R98]. The first coordinate is even in theta_h about the mirror direction, for a round
peak, then theta_h, and its logarithm far away, as lobes fall; the second is even in theta_d, so that the
values go on smoothly to retro-reflection; the third is 0.7 sin(theta_h) sin(theta_d) cos(phi_d), smooth
where phi_d is undefined. An exchange of L and V changes its sign: reciprocity is not assumed. The softening
is a tenth of the median.

How near that comes was found by leaving out of Cornell's krylon_blue and garnet_red (`cornell`) each
geometry, each interior plane of incidence (20 to 70 degrees), and all that are nearest to retro-reflection,
where the instrument stands in its own light; error of X, Y, Z, the median of the relative one and the root
mean square of the logarithm's:

                                      geometry                   plane                    retro
    these coordinates                 .0064 .121, .0131 .114    .013 .053, .021 .072    .020 .040, .029 .098
    theta_h, 1.5 theta_d, N.V - N.L   .0062 .136, .0140 .133    .013 .066, .022 .089    .014 .035, .020 .087
    sin sin, delta phi, cos cos,      .0079 .190, .0170 .184    .027 .141, .032 .146    .025 .089, .038 .108
      N.V - N.L [PH10]
"""

from __future__ import annotations

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf.measured.resampled import Function

MOST_PLACES = 4000
"""Most places of one spline: it solves a dense system of as many equations, 128 MB."""

GRAZING = np.radians(89.5)
"""Largest angle from the normal whose cosine values are divided by, radians; larger ones are taken for it."""

_PRODUCT = 200_000
"""Multiplications of one matrix product, below OpenBLAS's threshold for threads: in many small products
several threads wait for one another, ten times as long where other programs run."""


def interpolated(wi: FloatArray, wo: FloatArray, values: FloatArray) -> Function:
    """Return a BRDF through values at scattered geometries, as described above.

    Parameters
    ----------
    wi, wo : (n, 3) float64
        Unit vectors to the light and to the eye.
    values : (n, c) float64
        The BRDF there, without the cosine, at least 0.

    Returns
    -------
    callable
        wi, wo, (m, 3) float64, to (m, c) float64, at least 0.

    Raises
    ------
    ValueError
        If there are too many geometries for a spline.
    """
    weighted = values * _cosines(wi, wo)
    softening = np.median(weighted, axis=0) / 10.0
    softening = np.where(softening > 0.0, softening, np.maximum(weighted.mean(axis=0) / 10.0, 1e-12))
    logarithm = np.log(weighted + softening)
    spline = ThinPlateSpline(coordinates(wi, wo), logarithm)
    largest = logarithm.max(axis=0) + np.log(2.0)  # no peak between geometries is believed beyond that

    def brdf(wi: FloatArray, wo: FloatArray) -> FloatArray:
        value = np.exp(np.minimum(spline(coordinates(wi, wo)), largest)) - softening
        return np.asarray(np.maximum(value, 0.0) / _cosines(wi, wo))

    return brdf


def coordinates(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return the three coordinates, (n, 3), in which the logarithm of a BRDF is smooth."""
    h = wi + wo
    theta_h = np.arctan2(np.hypot(h[:, 0], h[:, 1]), h[:, 2])
    rounded = np.hypot(theta_h, 0.04) - 0.04
    cos_d = 0.5 * np.linalg.norm(h, axis=1)
    return np.stack(
        [0.4 * np.arcsinh(5.0 * rounded), 2.25 * (1.0 - cos_d), 0.35 * (wo[:, 2] - wi[:, 2])], axis=1
    )


def _cosines(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return N.L N.V, (n, 1), of angles up to `GRAZING`."""
    least = np.cos(GRAZING)
    cosines: FloatArray = np.maximum(wi[:, 2:], least) * np.maximum(wo[:, 2:], least)
    return cosines


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

        # The places in the axes along which they spread, each once
        self._origin = places.mean(axis=0)
        offsets = places - self._origin
        extent = max(float(np.abs(offsets).max()), 1e-300)
        _, spread, axes = np.linalg.svd(offsets, full_matrices=False)
        self._axes = axes[spread > 1e-6 * extent * np.sqrt(len(places))].T
        self._nodes, values = _merged(offsets @ self._axes, values, 1e-6 * extent)

        # The system of equations: kernel and linear part, [W04 sec. 8.4]
        tail = np.concatenate([np.ones((len(self._nodes), 1)), self._nodes], axis=1)
        n, m = tail.shape
        system = np.zeros((n + m, n + m))
        self._block = max(1, _PRODUCT // (n * max(self._nodes.shape[1], values.shape[1])))
        for start in range(0, n, self._block):
            block = slice(start, min(start + self._block, n))
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
        points = (places - self._origin) @ self._axes
        values = np.empty((len(points), self._weights.shape[1]))
        for start in range(0, len(points), self._block):
            block = points[start : start + self._block]
            values[start : start + self._block] = self._kernel(block) @ self._weights + block @ self._slope
        return np.asarray(values + self._constant)

    def _kernel(self, points: FloatArray) -> FloatArray:
        """Return r^2 log r^2 = 2 r^2 log r, (n, nodes), of the distances of points (n, d) from the nodes."""
        squares = np.einsum("nd,nd->n", points, points)[:, None] + np.einsum(
            "kd,kd->k", self._nodes, self._nodes
        )
        squares -= 2.0 * (points @ self._nodes.T)
        np.maximum(squares, 1e-30, out=squares)
        kernel = np.log(squares)
        kernel *= squares
        return np.asarray(kernel)


def _merged(places: FloatArray, values: FloatArray, near: float) -> tuple[FloatArray, FloatArray]:
    """Return the places that differ by more than `near`, and the mean value at each."""
    if places.shape[1] == 0:
        return places[:1], values.mean(axis=0, keepdims=True)
    _, first, which = np.unique(np.round(places / near), axis=0, return_index=True, return_inverse=True)
    total = np.zeros((len(first), values.shape[1]))
    np.add.at(total, which.ravel(), values)
    return places[first], total / np.bincount(which.ravel())[:, None]
