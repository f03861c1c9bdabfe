"""The oracles against facts that can be written down."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support import oracles


@pytest.mark.parametrize(("H", "W", "k"), [(4, 8, 1), (5, 7, 3), (16, 32, 2)])
def test_texels_cover_the_sphere(H, W, k):
    nodes, weights = oracles.texel_nodes(H, W, k)
    assert_allclose(weights.sum(), 4 * np.pi, rtol=1e-14)
    assert_allclose(weights.sum(axis=2), oracles.solid_angles(H, W), rtol=1e-13)
    assert_allclose(np.linalg.norm(nodes, axis=-1), 1, rtol=1e-14)


def test_axes_of_the_picture():
    # Between the two middle columns is +x, the top row is near +z, a quarter to the left is +y.
    d = oracles.directions(64, 128)
    assert_allclose(d[31:33, 63:65].mean(axis=(0, 1)), [1, 0, 0], atol=1e-3)
    assert_allclose(d[31:33, 31:33].mean(axis=(0, 1)), [0, 1, 0], atol=1e-3)
    assert d[0, :, 2].min() > 0.999


def test_harmonics_are_orthonormal():
    # Gauss-Legendre in z and uniform in phi integrate products of degree 2 F exactly.
    F = 9
    z, w = np.polynomial.legendre.leggauss(F + 1)
    phi = np.arange(2 * F + 1) * 2 * np.pi / (2 * F + 1)
    r = np.sqrt(1 - z * z)
    d = np.stack(np.broadcast_arrays(r[:, None] * np.cos(phi), r[:, None] * np.sin(phi), z[:, None]), axis=-1)
    Y = oracles.real_harmonics(F, d.reshape(-1, 3))
    weight = np.repeat(w * 2 * np.pi / (2 * F + 1), 2 * F + 1)
    assert_allclose(Y.T @ (weight[:, None] * Y), np.eye((F + 1) ** 2), atol=1e-13)


def test_harmonics_of_degree_one_have_the_phase():
    d = np.array([[0.6, 0.48, 0.64]])
    c = np.sqrt(3 / (4 * np.pi))
    assert_allclose(oracles.real_harmonics(1, d)[0, 1:], [-c * 0.48, c * 0.64, -c * 0.6], rtol=1e-14)


def test_coefficients_of_a_single_texel_approach_the_harmonics():
    pixels = np.zeros((64, 128, 1))
    pixels[20, 90] = 1
    area = oracles.solid_angles(64, 128)[20, 90]
    expected = oracles.real_harmonics(3, oracles.directions(64, 128)[20, 90][None])[0] * area
    assert_allclose(oracles.coefficients(pixels, 3)[:, 0], expected, atol=2e-3 * area)


def test_small_d_convention_and_degree_one():
    a = np.linspace(0, np.pi, 7)
    assert_allclose(oracles.small_d(1, 1, 0, a), -np.sin(a) / np.sqrt(2), atol=1e-15)
    assert_allclose(oracles.small_d(1, 1, 1, a), (1 + np.cos(a)) / 2, atol=1e-15)
    assert_allclose(oracles.small_d(1, 1, -1, a), (1 - np.cos(a)) / 2, atol=1e-15)


@pytest.mark.parametrize("l", [1, 2, 5, 20])
def test_small_d_is_a_group_and_gives_the_harmonics(l):
    m = range(-l, l + 1)

    def matrix(alpha):
        return np.array([[oracles.small_d(l, r, c, alpha) for c in m] for r in m])

    assert_allclose(matrix(0.3) @ matrix(1.1), matrix(1.4), atol=1e-12)
    assert_allclose(matrix(0.7) @ matrix(0.7).T, np.eye(2 * l + 1), atol=1e-12)
    theta = 0.8
    d = np.array([[np.sin(theta), 0.0, np.cos(theta)]])  # phi = 0: Y_lm = f_lm
    f = np.array([oracles.small_d(l, k, 0, theta) for k in range(l + 1)]) * np.sqrt((2 * l + 1) / (4 * np.pi))
    f[1:] *= np.sqrt(2)
    assert_allclose(oracles.real_harmonics(l, d)[0, l * (l + 1) :], f, atol=1e-12)


def test_rotated_coefficients_are_those_of_the_rotated_function():
    rng = np.random.default_rng(1)
    F = 4
    c = rng.normal(size=((F + 1) ** 2, 2))
    d = rng.normal(size=(30, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    for R in [*oracles.rotations(rng.random((3, 3))), np.eye(3), np.diag([-1.0, 1.0, -1.0])]:
        rotated = oracles.real_harmonics(F, d) @ oracles.rotated_coefficients(c, R)
        assert_allclose(rotated, oracles.real_harmonics(F, d @ R) @ c, atol=1e-12)


def test_frames_are_uniform_and_cosines_are_as_said():
    normals, views = oracles.random_views(4096, seed=2)
    cosine = np.sum(normals * views, axis=1)
    assert_allclose(np.linalg.norm(views, axis=1), 1, rtol=1e-12)
    # Halton points: discrepancy about log(n)^4 / n; means of smooth functions are far better than 1/64.
    assert_allclose(np.mean(cosine**2), 1 / 2, atol=5e-3)
    assert_allclose(np.mean(cosine**4), 1 / 3, atol=5e-3)
    for d in (normals, views):
        assert_allclose(d.T @ d / len(d), np.eye(3) / 3, atol=1e-2)
    tangents, square, hair_views = oracles.random_hairs(4096, seed=2)
    along = np.sum(tangents * hair_views, axis=1)
    assert_allclose([along.mean(), np.mean(along**2)], [0, 1 / 3], atol=5e-3)
    assert_allclose(np.sum(tangents * square, axis=1), 0, atol=1e-12)


ABOVE = np.array([[0, 0, 1.0], [0.6, 0, 0.8], [0.96, 0, 0.28]])


def test_albedo_of_lambert_and_of_phong_is_one():
    for wo in ABOVE:
        assert_allclose(oracles.albedo(oracles.lambert(0.7), wo), 0.7, rtol=1e-10)
    # A cosine lobe is cut at 90 degrees from its axis, where it vanishes to order s.
    for wo in ABOVE:
        assert_allclose(oracles.albedo(oracles.phong(20), wo), 1, rtol=1e-8)


@pytest.mark.slow
def test_facet_models_conserve_energy_and_are_reciprocal():
    rng = np.random.default_rng(3)
    d = np.abs(rng.normal(size=(2, 50, 3)))
    wi, wo = d / np.linalg.norm(d, axis=2, keepdims=True)
    for model in (oracles.ggx, oracles.beckmann):
        for alpha in (0.1, 0.5):
            f = model(alpha, 0.3)
            assert_allclose(f(wi, wo) * wo[:, 2], f(wo, wi) * wi[:, 2], rtol=1e-10)
            # Single scattering loses light between facets but never gains.
            for v in ABOVE:
                assert oracles.albedo(model(alpha), v) <= 1 + 1e-6
        # Smooth facets seen from above lose next to nothing: half angles beyond 45 degrees reflect down.
        assert_allclose(oracles.albedo(model(0.1), ABOVE[0], 1600), 1, atol=0.015)


def test_masking_is_the_shadowed_projected_area():
    # The defining property of Smith's G1 [WMLT07 eq. 12 to 14]: int D(h) G1(v) max(h.v, 0) dh = cos(v).
    # Through rho_hat: with F = 1 and G1(L) taken out, int rho_hat / G1(L) dL is
    # G1(V) int D (v.h) / (N.V) dh = 1, over all L, those below the horizon included; from above with small
    # alpha those are negligible.
    v = np.array([[0.6, 0, 0.8]])
    for alpha in (0.1, 0.3):
        x, w = np.polynomial.legendre.leggauss(400)
        theta = (1 + x) * np.pi / 4
        phi = (np.arange(400) + 0.5) * np.pi / 200
        t, p = np.meshgrid(theta, phi, indexing="ij")
        h = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
        weight = np.repeat(w * np.pi / 4 * np.sin(theta), 400) * np.pi / 200
        tan2 = (h[:, 0] ** 2 + h[:, 1] ** 2) / h[:, 2] ** 2
        ggx_D = alpha**2 / (np.pi * (alpha**2 + tan2) ** 2) / h[:, 2] ** 4
        beckmann_D = np.exp(-tan2 / alpha**2) / (np.pi * alpha**2) / h[:, 2] ** 4
        # G1(V) read back from the models at L = the mirror direction of V, where D and both G1 are known.
        mirror = np.array([[-0.6, 0, 0.8]])
        for model, D in ((oracles.ggx, ggx_D), (oracles.beckmann, beckmann_D)):
            peak = 1 / (np.pi * alpha**2)
            G1 = np.sqrt(model(alpha)(mirror, v)[0] * 4 * 0.8 / peak)
            assert_allclose(G1 * np.sum(weight * D * np.maximum(h @ v[0], 0)), 0.8, rtol=1e-5)


def test_hair_models_at_known_angles():
    def at(t):
        return np.array([[np.sin(t), 0.0, np.cos(t)]])

    assert_allclose(oracles.kajiya_kay(8)(at(0.7), at(0.7)), 1)
    assert_allclose(oracles.kajiya_kay(8, "mirror")(at(0.7), at(np.pi - 0.7)), 1)
    assert_allclose(oracles.banks(0.5)(at(0.7), at(np.pi - 0.7)), 0.5 / 0.25)  # cos(0) - s


def test_reflected_of_a_constant_environment_is_the_albedo():
    pixels = np.full((32, 64, 3), [1.0, 2.0, 3.0])
    normals, views = oracles.random_views(8, seed=4)
    B = oracles.reflected(pixels, oracles.lambert(0.5), normals, views, subsamples=4)
    # The kink at the horizon: texels of 0.1 rad with 4 nodes each way.
    assert_allclose(B, np.full((8, 1), 0.5) * [1, 2, 3], rtol=1e-3)
    # Two Gauss nodes to a texel of h = 0.1: an error of the order of (h/2)^4 s^2 / 135 for s = 16.
    B = oracles.reflected(pixels, oracles.phong(16), normals, views, subsamples=2, hemisphere=False)
    assert_allclose(B, np.ones((8, 1)) * [1, 2, 3], rtol=1.2e-5)


def test_reflected_carries_color_and_a_tangent_frame():
    pixels = np.zeros((16, 32, 3))
    pixels[3, 5] = [1, 1, 2]
    L, area = oracles.directions(16, 32)[3, 5], oracles.solid_angles(16, 32)[3, 5]
    tangents, normals, views = oracles.random_hairs(5, seed=5)
    B = oracles.reflected(
        pixels, oracles.kajiya_kay(4), normals, views, tangents, frame="tangent", hemisphere=False
    )
    theta_i, theta_o = np.arccos(tangents @ L), np.arccos(np.sum(tangents * views, axis=1))
    expected = np.maximum(0, np.cos(theta_i - theta_o)) ** 4 * area
    assert_allclose(B, expected[:, None] * [1, 1, 2], atol=1e-14)
    color = oracles.reflected(pixels, oracles.lambert([0.2, 0.4, 0.8]), normals, views)
    cosine = np.maximum(0, normals @ L)
    assert_allclose(color, cosine[:, None] / np.pi * area * [0.2, 0.4, 1.6], atol=1e-14)
