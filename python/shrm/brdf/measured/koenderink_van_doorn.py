"""The basis of Koenderink and van Doorn for isotropic reciprocal BRDFs.

Zernike's polynomials on the disk, brought to the hemisphere by the map that keeps areas [KD98]:

    Theta_n^l(theta) = sqrt((n + 1) / (2 pi)) R_n^l(sqrt(2) sin(theta / 2)),    0 <= l <= n, n - l even

are, times 1 (l = 0), sqrt(2) cos(l phi) or sqrt(2) sin(l phi), orthonormal over the solid angle of the
hemisphere. What is the same for L and V exchanged, and depends on the azimuths by their difference alone
and evenly, is

    f(L, V) = sum_nml a_nml (Theta_n^l(theta_i) Theta_m^l(theta_v) + Theta_m^l(theta_i) Theta_n^l(theta_v))
              cos(l (phi_i - phi_v)),    0 <= l <= m <= n <= order,  n - l and m - l even

with 1, 5 and 55 coefficients for the orders 0, 2 and 8. The functions of different (n, m, l) are orthogonal
over both hemispheres; `norms` are their lengths.
"""

from __future__ import annotations

import math

import numpy as np

from shrm.arrays import FloatArray, IntArray


def indices(order: int) -> IntArray:
    """Return n, m, l of the coefficients of an order, (coefficients, 3): n slowest, l fastest."""
    return np.array(
        [
            (n, m, l)
            for n in range(order + 1)
            for m in range(n + 1)
            for l in range(m + 1)
            if (n - l) % 2 == 0 and (m - l) % 2 == 0
        ],
        dtype=np.int64,
    )


def norms(order: int) -> FloatArray:
    """Return the lengths of the basis functions, (coefficients,) float64.

    The square of one is its integral, squared, over the solid angles of L and V.
    """
    n, m, l = indices(order).T
    return np.asarray(np.sqrt(np.where(n == m, 4.0, 2.0) * np.where(l == 0, 1.0, 0.5)))


def evaluate(order: int, wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Evaluate the basis functions.

    Parameters
    ----------
    order : int
        The largest n.
    wi, wo : (k, 3) float64
        Unit vectors to the light and to the eye, above the horizon.

    Returns
    -------
    (k, coefficients) float64
        Per steradian; in the order of `indices`.
    """
    theta_i, theta_v = _thetas(order, wi[:, 2]), _thetas(order, wo[:, 2])
    # cos(l delta) by Chebyshev's recurrence, of the cosine of the difference of the azimuths
    across = np.hypot(wi[:, 0], wi[:, 1]) * np.hypot(wo[:, 0], wo[:, 1])
    along = wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1]
    cosine = np.clip(np.divide(along, across, out=np.ones_like(along), where=across > 0.0), -1.0, 1.0)
    multiples = [np.ones_like(cosine), cosine]
    for l in range(2, order + 1):
        multiples.append(2.0 * cosine * multiples[l - 1] - multiples[l - 2])
    columns = [
        (theta_i[n, l] * theta_v[m, l] + theta_i[m, l] * theta_v[n, l]) * multiples[l]
        for n, m, l in indices(order).tolist()
    ]
    return np.stack(columns, axis=1)


def fit(order: int, wi: FloatArray, wo: FloatArray, values: FloatArray) -> FloatArray:
    """Fit coefficients to measurements by least squares.

    Parameters
    ----------
    order : int
        The largest n.
    wi, wo : (k, 3) float64
        Unit vectors to the light and to the eye, above the horizon.
    values : (k, channels) float64
        The BRDF, without the cosine.

    Returns
    -------
    (coefficients, channels) float64
        a_nml; those of least length, in the orthonormal basis, where the measurements leave some open.
    """
    length = norms(order)
    solution, *_ = np.linalg.lstsq(evaluate(order, wi, wo) / length, values, rcond=1e-10)
    return np.asarray(solution / length[:, None])


def _thetas(order: int, cos_theta: FloatArray) -> dict[tuple[int, int], FloatArray]:
    """Return Theta_n^l at each colatitude, by (n, l)."""
    square = np.clip(1.0 - cos_theta, 0.0, 1.0)  # of the radius: 2 sin^2(theta / 2)
    radius = np.sqrt(square)
    thetas = {}
    for l in range(order + 1):
        for n in range(l, order + 1, 2):
            polynomial = np.polynomial.polynomial.polyval(square, _radial(n, l))
            thetas[n, l] = math.sqrt((n + 1) / (2.0 * math.pi)) * polynomial * radius**l
    return thetas


def _radial(n: int, l: int) -> FloatArray:
    """Return the coefficients of R_n^l(r) / r^l, Zernike's polynomial, in powers of r^2, the lowest first."""
    half_sum, half_difference = (n + l) // 2, (n - l) // 2
    highest_first = [
        (-1) ** s
        * math.factorial(n - s)
        // (math.factorial(s) * math.factorial(half_sum - s) * math.factorial(half_difference - s))
        for s in range(half_difference + 1)
    ]
    return np.array(highest_first[::-1], dtype=np.float64)
