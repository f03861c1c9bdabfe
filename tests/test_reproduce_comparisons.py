"""What figures 9 and 10 of [RH02] compare SHRMs with: twelve maps, and lobes without azimuth."""

from dataclasses import replace

import numpy as np
import pytest
from data import require
from light import band_limited_environment
from shrm import Environment, brdf, explicit, prefilter
from shrm.reference import integrate, prefilter_angular
from shrm.reproduce import figure_9, figure_10
from shrm.reproduce.comparison import Frames
from shrm.reproduce.icosahedral import IcosahedralMaps, faces, solid_angle, weights
from shrm.reproduce.result import Settings
from shrm.reproduce.velvet import velvet


def directions(n: int, seed: int) -> np.ndarray:
    x = np.random.default_rng(seed).normal(size=(n, 3))
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def test_the_triangles_tile_the_sphere():
    a, b, c = explicit.icosahedron()[faces()].transpose(1, 0, 2)
    assert len(a) == 20
    np.testing.assert_allclose(solid_angle(a, b, c), 4 * np.pi / 20, rtol=1e-13)


def test_icosahedral_weights_are_barycentric():
    V = directions(2000, seed=1)
    w = weights(V)
    assert w.min() >= 0
    np.testing.assert_allclose(w.sum(axis=1), 1, atol=1e-14)
    np.testing.assert_array_equal((w > 0).sum(axis=1), 3)  # almost surely inside a triangle
    # they belong to the triangle around the view: its three vertices are the nearest
    near = np.sort(np.argsort(-V @ explicit.icosahedron().T, axis=1)[:, :3], axis=1)
    np.testing.assert_array_equal(np.sort(np.argsort(-w, axis=1)[:, :3], axis=1), near)


def test_icosahedral_weights_are_exact_at_vertices_and_even_in_between():
    v = explicit.icosahedron()
    np.testing.assert_allclose(weights(v), np.eye(12), atol=1e-12)
    centers = v[faces()].sum(axis=1)
    w = weights(centers / np.linalg.norm(centers, axis=1, keepdims=True))
    np.testing.assert_allclose(np.take_along_axis(w, faces(), axis=1), 1 / 3, atol=1e-13)


def test_icosahedral_weights_are_continuous_over_edges():
    v = explicit.icosahedron()
    i, j = np.nonzero(np.triu(v @ v.T > 0.4, k=1))
    assert len(i) == 30
    t = np.random.default_rng(2).uniform(size=(30, 1))
    on_edge = t * v[i] + (1 - t) * v[j]
    on_edge /= np.linalg.norm(on_edge, axis=1, keepdims=True)
    across = np.cross(v[i], v[j])
    step = 1e-9
    sides = [on_edge + sign * step * across for sign in (-1, 1)]
    left, right = (weights(s / np.linalg.norm(s, axis=1, keepdims=True)) for s in sides)
    # the gradient of a weight is of the order of 1 over the height of a triangle, 0.9
    np.testing.assert_allclose(left, right, atol=20 * step)
    rows = np.arange(30)
    np.testing.assert_allclose(left[rows, i] + left[rows, j], 1, atol=20 * step)


def test_twelve_maps_are_exact_for_their_own_views_and_for_radial_lobes():
    env = band_limited_environment(4, seed=3, H=16)
    glossy = brdf.GGX(0.5)
    # 3e-3: quadrature of texels of 11 degrees, and cubic look-ups between rows of 4 degrees
    maps = IcosahedralMaps(prefilter_angular(env, glossy, size=48, center="reflection"), "reflection")
    assert maps.nbytes == 12 * 48 * 96 * 3 * 4
    V = explicit.icosahedron()[7]
    N = directions(400, seed=4)
    N = N[N @ V > 0.3]
    views = np.broadcast_to(V, N.shape)
    expected = integrate(env, glossy, N, V, subsamples=2)
    np.testing.assert_allclose(
        maps.radiance(N.astype(np.float32), views.astype(np.float32)), expected, rtol=3e-3
    )
    phong = brdf.Phong(6)
    maps = IcosahedralMaps(prefilter_angular(env, phong, size=48), "reflection")
    frames = Frames.drawn(300)
    expected = integrate(env, phong, frames.normals, frames.views, subsamples=2)
    np.testing.assert_allclose(frames.radiance(maps), expected, rtol=3e-3)


def test_random_frames_are_what_they_say():
    frames = Frames.drawn(4000)
    cosine = np.einsum("nk,nk->n", frames.normals, frames.views)
    assert cosine.min() >= 0
    np.testing.assert_allclose(np.mean(cosine**2), 1 / 2, atol=4 * np.sqrt(1 / 12 / 4000))
    np.testing.assert_allclose(np.einsum("nk,nk->n", frames.normals, frames.tangents), 0, atol=1e-14)
    for x in (frames.normals, frames.views):  # of variance 1/3 each
        np.testing.assert_allclose(x.mean(axis=0), 0, atol=4 * np.sqrt(1 / 3 / 4000))


def test_a_lobe_without_azimuth_loses_nothing_without_it():
    env = band_limited_environment(6, seed=5)
    frames = Frames.drawn(200)
    rm = prefilter(env, brdf.GGX(0.4), orders=(6, 3), center="reflection", size=32)
    (part,) = rm.parts
    rho = part.rho.copy()
    rho[:, :, 1:] = 0  # a lobe that has no azimuth, through all (P+1)^2 maps of the global form
    full = replace(rm, parts=(replace(part, rho=rho).resized(32, "latlong"),))
    flat = figure_9.without_azimuth(full)
    assert full.parts[0].maps.shape == (16, 32, 64, 3)
    assert flat.parts[0].maps.shape == (4, 32, 64, 3)
    np.testing.assert_allclose(frames.radiance(flat), frames.radiance(full), rtol=1e-3)
    phong = prefilter(env, brdf.Phong(8), orders=(6, 0), size=32)
    np.testing.assert_array_equal(frames.radiance(figure_9.without_azimuth(phong)), frames.radiance(phong))


def test_without_azimuth_is_the_mean_over_the_azimuth_of_the_view():
    env = band_limited_environment(5, seed=6)
    rm = prefilter(
        env, velvet(0.4, (0.3, 0.1, 0.2), (0.1, 0.2, 0.3)), orders=(5, 3), center="reflection", size=48
    )
    flat = figure_9.without_azimuth(rm)
    C = directions(1, seed=7)[0]
    x = np.cross(C, [0, 0, 1.0])
    x /= np.linalg.norm(x)
    spin = 2 * np.pi * np.arange(8) / 8  # more than 2 P: the mean of degree 3 is exact
    around = np.cos(spin)[:, None] * x + np.sin(spin)[:, None] * np.cross(C, x)
    for theta_o in (0.4, 1.5, 2.6):
        V = np.cos(theta_o) * C + np.sin(theta_o) * around
        N = (V + C) / np.linalg.norm(V + C, axis=1, keepdims=True)
        full, without = rm.radiance(N, V), flat.radiance(N, V)
        np.testing.assert_allclose(without, np.broadcast_to(full.mean(axis=0), without.shape), rtol=1e-3)
        assert np.ptp(full, axis=0).max() > 0.01 * full.max()  # there is azimuth to lose


def test_the_velvet_s_distribution_is_normalised_and_its_light_comes_from_the_rim():
    white = velvet(0.5, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    # D at theta_h from L = V: f = D / (4 (2 c - c^2)), rho_hat = f c
    x, w = np.polynomial.legendre.leggauss(200)
    c, w = (1 + x) / 2, w / 2
    along = np.stack([np.sqrt(1 - c**2), 0 * c, c], axis=1)
    D = white.transfer(along, along)[:, 0] * 4 * (2 - c)
    np.testing.assert_allclose(2 * np.pi * np.sum(w * c * D), 1, rtol=1e-6)
    assert D[0] > 2 * D[-1]


@pytest.mark.parametrize("figure", [figure_9, figure_10], ids=["figure-9", "figure-10"])
def test_quick_figures(figure):
    settings = Settings(band_limited_environment(6, seed=8, H=32), "a test", quick=True)
    result = figure.make(settings)
    assert result.name == figure.NAME
    assert result.figure is not None
    assert all(len(row) == len(result.columns) for row in result.rows)
    errors = np.array([row[-2:] for row in result.rows], dtype=float)
    assert np.all((errors > 0) & (errors < 1))
    assert f"| {result.columns[0]} |" in result.markdown()


def test_the_fabric_is_the_fit_where_there_is_one():
    folder = require("brdf/merl_sgd_bagher2012.json").parent
    env = Environment.daylight(size=16)
    assert figure_9.fabric(Settings(env, "daylight", folder)).name == figure_9.FIT[1]
    assert figure_9.fabric(Settings(env, "daylight")).name != figure_9.FIT[1]
