"""Cabral's twelve maps: their weights, and what is exact about them."""

import numpy as np
import pytest
from shrm import brdf, prefilter
from shrm.integrate.angular import AngularReflection, integrate, prefilter_angular
from shrm.prefiltered import Cabral, Prefiltered
from shrm.prefiltered.icosahedron import faces, icosahedron, solid_angle, weights
from shrm_papers.comparison import Frames
from support import oracles
from support.directions import sphere
from support.light import band_limited_environment


def integrated(exact: AngularReflection) -> Cabral:
    return Cabral.fitted([exact.at_view(view) for view in icosahedron()])


def test_the_triangles_tile_the_sphere():
    a, b, c = icosahedron()[faces()].transpose(1, 0, 2)
    assert len(a) == 20
    np.testing.assert_allclose(solid_angle(a, b, c), 4 * np.pi / 20, rtol=1e-13)


def test_icosahedral_weights_are_barycentric():
    V = sphere(2000, seed=1)
    w = weights(V)
    assert w.min() >= 0
    np.testing.assert_allclose(w.sum(axis=1), 1, atol=1e-14)
    np.testing.assert_array_equal((w > 0).sum(axis=1), 3)  # almost surely inside a triangle
    # they belong to the triangle around the view: its three vertices are the nearest
    near = np.sort(np.argsort(-V @ icosahedron().T, axis=1)[:, :3], axis=1)
    np.testing.assert_array_equal(np.sort(np.argsort(-w, axis=1)[:, :3], axis=1), near)


def test_icosahedral_weights_are_exact_at_vertices_and_even_in_between():
    v = icosahedron()
    np.testing.assert_allclose(weights(v), np.eye(12), atol=1e-12)
    centers = v[faces()].sum(axis=1)
    w = weights(centers / np.linalg.norm(centers, axis=1, keepdims=True))
    np.testing.assert_allclose(np.take_along_axis(w, faces(), axis=1), 1 / 3, atol=1e-13)


def test_icosahedral_weights_are_continuous_over_edges():
    v = icosahedron()
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


@pytest.mark.slow
def test_twelve_maps_are_exact_for_their_own_views_and_for_radial_lobes():
    env = band_limited_environment(4, seed=3, H=16)
    glossy = brdf.GGX(0.5)
    # 3e-3: quadrature of texels of 11 degrees, and cubic look-ups between rows of 4 degrees
    maps = integrated(prefilter_angular(env, glossy, size=48, center="reflection"))
    assert maps.nbytes == 12 * 48 * 96 * 3 * 4
    V = icosahedron()[7]
    N = sphere(400, seed=4)
    N = N[N @ V > 0.3]
    views = np.broadcast_to(V, N.shape)
    expected = integrate(env, glossy, N, V, subsamples=2)
    np.testing.assert_allclose(
        maps.radiance(N.astype(np.float32), views.astype(np.float32)), expected, rtol=3e-3
    )
    phong = brdf.Phong(6)
    maps = integrated(prefilter_angular(env, phong, size=48))
    frames = Frames.drawn(300)
    expected = integrate(env, phong, frames.normals, frames.views, subsamples=2)
    np.testing.assert_allclose(frames.radiance(maps), expected, rtol=3e-3)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_of_a_shrm_they_are_its_maps_at_their_views(layout):
    """Borders included: every look-up is the SHRM's own, up to the rounding of sums of few float32 terms."""
    material = brdf.GGX(0.4) + 0.3 * brdf.Lambert(0.5)
    rm = prefilter(band_limited_environment(5, seed=7), material, orders=(5, 3), size=12, layout=layout)
    maps = Prefiltered.from_reflection_map(rm, material, technique="cabral")
    assert [len(one.layers) for one in maps.lobes] == [12, 1]
    for V in icosahedron():
        N = sphere(200, seed=8)
        N = N[N @ V > 0]  # beyond the horizon a SHRM is asked for another view
        expected = rm.radiance(N, V)
        np.testing.assert_allclose(maps.radiance(N, V), expected, atol=4e-6 * np.abs(expected).max())


def test_between_views_they_are_blended():
    rm = prefilter(band_limited_environment(5, seed=9), brdf.GGX(0.4), orders=(5, 3), size=12)
    maps = Prefiltered.from_reflection_map(rm, brdf.GGX(0.4), technique="cabral")
    N, V = oracles.random_views(100, seed=10)
    # Where each of the twelve views stands alone, at the same central directions.
    (cabral,) = maps.lobes
    C = cabral.central_directions(N, V, N)
    of_each = np.stack([layer.radiance(C) for layer in cabral.layers], axis=1)
    expected = np.einsum("nk,nkc->nc", weights(V), of_each)
    np.testing.assert_allclose(maps.radiance(N, V), expected, rtol=1e-5)
    assert np.abs(expected - rm.radiance(N, V)).max() > 0.01 * expected.max()  # which the SHRM is not


def test_twelve_pictures_are_asked_for():
    with pytest.raises(ValueError, match=r"shape \(12, H, 2 H, 3\), got \(3, 4, 8, 3\)"):
        Cabral.fitted(np.zeros((3, 4, 8, 3)))
