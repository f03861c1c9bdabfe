"""Tents over the hemisphere: the map, the tents, their Gram matrix, and the projection's known error."""

import numpy as np
import pytest
from shrm import _core
from shrm.transfer.directional_basis import DirectionalBasis, hemispherical_gram
from support import oracles
from support.directions import hemisphere, sphere

# Average PSNR in dB, from an independent computation of the same matrices: rows m = 2..8.
PSNR = {
    3: [22.3, 13.6, 9.0, 6.6, 5.4, 4.7, 4.3],
    5: [30.6, 23.1, 17.8, 13.6, 10.6, 8.5, 7.1],
    7: [36.0, 29.0, 23.9, 19.8, 16.5, 13.7, 11.4],
    9: [39.8, 33.4, 28.6, 24.6, 21.2, 18.3, 15.8],
    11: [42.8, 36.7, 32.1, 28.3, 25.1, 22.2, 19.6],
    13: [45.2, 39.4, 35.0, 31.4, 28.2, 25.4, 22.9],
    15: [47.2, 41.6, 37.4, 34.0, 30.9, 28.2, 25.7],
}


def from_square(uv: np.ndarray) -> np.ndarray:
    """Shirley and Chiu's map by its four triangles, then z = 1 - r^2."""
    a, b = 2 * uv[:, 0] - 1, 2 * uv[:, 1] - 1
    with np.errstate(divide="ignore", invalid="ignore"):
        triangles = [
            (a > -b) & (a > b),
            (a > -b) & (a <= b),
            (a <= -b) & (a < b),
            (a <= -b) & (a >= b) & (b != 0),
        ]
        r = np.select(triangles, [a, b, -a, -b], 0.0)
        phi = np.pi / 4 * np.select(triangles, [b / a, 2 - a / b, 4 + b / a, 6 - a / b], 0.0)
    radius = r * np.sqrt(2 - r * r)
    return np.stack([radius * np.cos(phi), radius * np.sin(phi), 1 - r * r], axis=1)


def hats(M: int, uv: np.ndarray) -> np.ndarray:
    """All tents at positions on the square, (n, M^2)."""
    one = [np.maximum(0, 1 - np.abs((M - 1) * uv[:, k, None] - np.arange(M))) for k in (0, 1)]
    return (one[1][:, :, None] * one[0][:, None, :]).reshape(len(uv), M * M)


def positions(n: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(size=(n, 2))


# The map


def test_the_map_is_shirley_and_chius():
    uv = positions(5000, 1)
    uv[:5] = [[0.5, 0.5], [0, 0], [1, 0.5], [0.25, 0.75], [1, 1]]
    np.testing.assert_allclose(_core.hemisphere_from_square(positions=uv), from_square(uv), atol=1e-15)


def test_the_map_keeps_areas():
    n = 400
    u = (np.arange(n) + 0.5) / n
    uv = np.stack(np.meshgrid(u, u), axis=-1).reshape(-1, 2)
    w = _core.hemisphere_from_square(positions=uv)
    # Means of z^k over the hemisphere are 1 / (k+1), those of x^2 and y^2 1/3; midpoints err by n^-2.
    for k in range(5):
        assert np.mean(w[:, 2] ** k) == pytest.approx(1 / (k + 1), abs=2e-5)
    np.testing.assert_allclose(w.T @ w / n**2, np.diag([1 / 3] * 3) + 0, atol=2e-5)


# Tents


@pytest.mark.parametrize("M", [2, 3, 8, 11])
def test_tents_are_products_of_hats(M):
    basis, uv = DirectionalBasis(M), positions(2000, 2)
    indices, weights = basis.tents(from_square(uv))
    values = np.zeros((len(uv), M * M))
    np.put_along_axis(values, indices, weights, axis=1)
    np.testing.assert_allclose(values, hats(M, uv), atol=1e-12)


@pytest.mark.parametrize("M", [2, 5, 16])
def test_tents_are_a_partition_of_unity_and_four_at_a_time(M):
    directions = np.concatenate([sphere(2000, 3), np.eye(3), -np.eye(3), [[0.6, 0, 0.8], [0, -0.8, 0.6]]])
    indices, weights = DirectionalBasis(M).tents(directions)
    assert indices.shape == weights.shape == (len(directions), 4)
    assert np.all((indices >= 0) & (indices < M * M))
    assert np.all(np.diff(indices) == [1, M - 1, 1])
    assert np.all(weights >= 0)
    np.testing.assert_allclose(weights.sum(axis=1), 1, rtol=1e-14)


def test_each_tent_is_1_at_its_own_node():
    M = 7
    uv = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, M)]), axis=-1).reshape(-1, 2)
    values = DirectionalBasis(M).evaluate(np.eye(M * M), from_square(uv))
    np.testing.assert_allclose(values, np.eye(M * M), atol=1e-12)


def test_directions_below_the_horizon_are_brought_to_it():
    basis, w = DirectionalBasis(9), sphere(500, 4)
    w = w[w[:, 2] < 0]
    level = w * [1, 1, 0]
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    for below, at in zip(basis.tents(w), basis.tents(level), strict=True):
        np.testing.assert_allclose(below, at, atol=1e-12)


def test_tents_are_continuous_across_cells_diagonals_and_the_pole():
    basis = DirectionalBasis(6)
    uv = np.concatenate([positions(300, 5), [[0.5, 0.5], [0.2, 0.2], [0.4, 0.6], [0.4, 0.31]]])
    coefficients = np.random.default_rng(6).normal(size=36)
    here = basis.evaluate(coefficients, from_square(uv))
    for step in ([1e-9, 0], [-1e-9, 0], [0, 1e-9], [0, -1e-9]):
        there = basis.evaluate(coefficients, from_square(np.clip(uv + step, 0, 1)))
        np.testing.assert_allclose(there, here, atol=1e-7)


@pytest.mark.parametrize("channels", [1, 3, 25])
def test_accumulating_is_the_adjoint_of_evaluating(channels):
    basis, rng = DirectionalBasis(8), np.random.default_rng(7)
    w, f = sphere(400, 8), rng.normal(size=(400, channels))
    coefficients = rng.normal(size=(64, channels))
    forward = np.sum(basis.evaluate(coefficients, w) * f)
    assert forward == pytest.approx(np.sum(coefficients * basis.accumulate(f, w)), rel=1e-12)


# Matrices


@pytest.mark.parametrize("M", [2, 3, 6, 11])
def test_the_gram_matrix_is_the_integral_of_products(M):
    # Two Gauss nodes a cell and dimension are exact for squares of hats.
    x = (np.arange(M - 1)[:, None] + 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)).ravel() / (M - 1)
    g = hats(M, np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2))
    expected = 2 * np.pi * g.T @ g / len(g)
    np.testing.assert_allclose(DirectionalBasis(M).gram(), expected, rtol=1e-12, atol=1e-16)


@pytest.mark.parametrize("M", [2, 3, 11, 40])
def test_solving_undoes_the_gram_matrix(M):
    basis = DirectionalBasis(M)
    x = np.random.default_rng(9).normal(size=(M * M, 4))
    np.testing.assert_allclose(basis.solve(basis.gram() @ x), x, atol=1e-13)
    np.testing.assert_allclose(basis.solve(basis.gram() @ x[:, 0])[:, 0], x[:, 0], atol=1e-13)


def test_the_quadrature_is_exact_for_polynomials():
    for M in (2, 5, 8):
        directions, weights = DirectionalBasis(M).quadrature(12)
        x, y, z = directions.T
        assert np.all(weights > 0)
        for values, exact in ((z, np.pi), (x**2, 2 * np.pi / 3), (x * x * y * y * z, np.pi / 24), (x, 0)):
            assert weights @ values == pytest.approx(exact, abs=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize(("M", "m"), [(2, 3), (5, 4), (8, 8), (11, 10)])
def test_the_change_of_basis_is_the_integral_of_tents_times_harmonics(M, m):
    C = DirectionalBasis(M).change_of_basis(m)
    # Midpoints of the square, cells cut in `fine` parts: second order, whatever the kinks
    fine = 240 // (M - 1)
    u = (np.arange((M - 1) * fine) + 0.5) / ((M - 1) * fine)
    uv = np.stack(np.meshgrid(u, u), axis=-1).reshape(-1, 2)
    Y = oracles.real_harmonics(m - 1, from_square(uv))
    expected = hats(M, uv).T @ Y * (2 * np.pi / len(uv))
    np.testing.assert_allclose(C, expected, atol=2 * (m / 240) ** 2 * np.abs(C).max())


@pytest.mark.slow
@pytest.mark.parametrize(("M", "m"), [(2, 10), (3, 8), (11, 6), (4, 16)])
def test_the_change_of_basis_does_not_depend_on_its_nodes(M, m):
    basis = DirectionalBasis(M)
    directions, weights = basis.quadrature(30)
    Y = oracles.real_harmonics(m - 1, directions)
    expected = basis.accumulate(Y * weights[:, None], directions)
    np.testing.assert_allclose(basis.change_of_basis(m), expected, atol=1e-12)


@pytest.mark.parametrize("m", [1, 4, 10])
def test_the_hemispherical_gram_matrix(m):
    x, w = np.polynomial.legendre.leggauss(2 * m + 4)
    phi = (np.arange(4 * m + 8) + 0.3) * 2 * np.pi / (4 * m + 8)
    z, weight = (1 + x) / 2, w / 2 * 2 * np.pi / len(phi)
    sine = np.sqrt(1 - z * z)[:, None]
    nodes = np.stack(np.broadcast_arrays(sine * np.cos(phi), sine * np.sin(phi), z[:, None]), axis=-1)
    Y = oracles.real_harmonics(m - 1, nodes.reshape(-1, 3))
    S = hemispherical_gram(m)
    np.testing.assert_allclose(S, Y.T @ (Y * np.repeat(weight, len(phi))[:, None]), atol=1e-13)
    # Functions of one parity are orthonormal, halved: l + l' even.
    degree = np.floor(np.sqrt(np.arange(m * m)))
    even = (degree[:, None] + degree) % 2 == 0
    np.testing.assert_allclose(S[even], 0.5 * np.eye(m * m)[even], atol=1e-14)


# The error of the projection


@pytest.mark.slow
@pytest.mark.parametrize("M", PSNR)
def test_the_average_psnr(M):
    basis = DirectionalBasis(M)
    actual = [basis.average_psnr(m) for m in range(2, 9)]
    np.testing.assert_allclose(actual, PSNR[M], atol=0.1)  # the table has one decimal


@pytest.mark.parametrize("M", [2, 3, 11])
def test_constants_are_projected_exactly(M):
    basis = DirectionalBasis(M)
    assert abs(basis.error_matrix(1)[0, 0]) < 1e-12
    assert basis.average_psnr(1) == np.inf
    constant = basis.project_coefficients([np.sqrt(4 * np.pi)])
    np.testing.assert_allclose(constant, 1, rtol=1e-12)


def test_the_average_is_that_of_random_expansions():
    basis, rng = DirectionalBasis(7), np.random.default_rng(10)
    l = rng.normal(size=(20000, 16))
    l /= np.linalg.norm(l, axis=1, keepdims=True)
    squared = np.einsum("ni,ij,nj->n", l, basis.error_matrix(4), l)
    error = np.std(squared) / np.sqrt(len(l)) / np.mean(squared)  # of the mean, relative
    assert -10 * np.log10(np.mean(squared)) == pytest.approx(basis.average_psnr(4), abs=5 * 4.35 * error)


@pytest.mark.slow
@pytest.mark.parametrize(("M", "m"), [(5, 3), (11, 8)])
def test_the_error_matrix_measures_what_projection_leaves(M, m):
    basis, rng = DirectionalBasis(M), np.random.default_rng(11)
    l = rng.normal(size=(m * m, 3))
    directions, weights = basis.quadrature(24)
    exact = oracles.real_harmonics(m - 1, directions) @ l
    projected = basis.project_coefficients(l)
    off = exact - basis.evaluate(projected, directions)
    np.testing.assert_allclose(
        weights @ off**2, np.einsum("ic,ij,jc->c", l, basis.error_matrix(m), l), rtol=1e-9
    )
    # [LK03] appendix A: what is left is orthogonal to every tent
    np.testing.assert_allclose(basis.accumulate(off * weights[:, None], directions), 0, atol=1e-11)
    # and less than what interpolation between the nodes leaves
    nodes = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, M)]), axis=-1).reshape(-1, 2)
    sampled = oracles.real_harmonics(m - 1, from_square(nodes)) @ l
    interpolated = exact - basis.evaluate(sampled, directions)
    assert np.all(weights @ off**2 < 10**-0.1 * (weights @ interpolated**2))


def test_functions_and_their_coefficients_are_projected_alike():
    basis, l = DirectionalBasis(9), np.random.default_rng(12).normal(size=(25, 3))
    by_values = basis.project(lambda w: oracles.real_harmonics(4, w) @ l, points=16)
    np.testing.assert_allclose(by_values, basis.project_coefficients(l), atol=1e-12)


def test_tents_are_projected_on_themselves():
    basis = DirectionalBasis(6)
    coefficients = np.random.default_rng(13).normal(size=(36, 2))
    again = basis.project(lambda w: basis.evaluate(coefficients, w), points=6)
    np.testing.assert_allclose(again, coefficients, atol=1e-12)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: DirectionalBasis(1), ValueError, "M must be in"),
        (lambda: DirectionalBasis(3.0), TypeError, "M must be a whole number"),
        (lambda: DirectionalBasis(3).tents([[0, 0, 2.0]]), ValueError, "directions must be unit"),
        (lambda: DirectionalBasis(3).evaluate(np.ones(8), [[0, 0, 1.0]]), ValueError, r"shape \(9,\)"),
        (lambda: DirectionalBasis(3).accumulate(np.ones(2), hemisphere(3, 1)), ValueError, r"shape \(3,\)"),
        (lambda: DirectionalBasis(3).solve(np.ones((9, 2, 2))), ValueError, "right must have"),
        (lambda: DirectionalBasis(3).change_of_basis(0), ValueError, "m must be in"),
        (lambda: DirectionalBasis(3).project_coefficients(np.ones(8)), ValueError, "rows"),
        (lambda: DirectionalBasis(3).project(lambda w: np.full(len(w), np.nan)), ValueError, "finite"),
        (lambda: hemispherical_gram(33), ValueError, "m must be in"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(call, error, text):
    with pytest.raises(error, match=text):
        call()
