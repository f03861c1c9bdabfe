"""Explicit sets of maps from reflection maps and back: [RH02] appendix C."""

from dataclasses import replace

import numpy as np
import pytest
from shrm import brdf, prefilter
from shrm.prefiltered import explicit
from shrm.prefiltered.explicit import (
    fit,
    icosahedral_maps,
    reflection_maps,
    three_dimensional_texture,
    without_azimuth,
)
from shrm.prefiltered.icosahedron import icosahedron
from shrm_papers.comparison import Frames
from shrm_papers.rh02.velvet import velvet
from support import oracles
from support.directions import sphere as directions
from support.light import band_limited_environment


def test_icosahedron_has_twelve_equal_corners():
    v = icosahedron()
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 1, atol=1e-15)
    np.testing.assert_allclose(v.sum(axis=0), 0, atol=1e-14)
    nearest = np.sort(v @ v.T, axis=1)[:, -6:-1]
    np.testing.assert_allclose(nearest, 1 / np.sqrt(5), atol=1e-14)


def test_explicit_sets_and_back():
    env = band_limited_environment(5, seed=23)
    rm = prefilter(env, brdf.GGX(0.4).recentered("reflection"), orders=(5, 2), size=16)
    twelve = icosahedral_maps(rm)
    assert twelve.shape == (12, 16, 32, 3)
    np.testing.assert_array_equal(twelve[0], rm.at_view([0, 0, 1.0]))
    many = reflection_maps(rm, 6)
    assert many.shape == (6, 6, 16, 32, 3)
    again = fit(many.reshape(36, 16, 32, 3), explicit.grid_views(6).reshape(-1, 3), P=2)
    scale = np.abs(rm.parts[0].maps).max()
    np.testing.assert_allclose(again.parts[0].maps, rm.parts[0].maps, atol=1e-5 * scale)
    assert again.error < 1e-5
    from_twelve = fit(twelve, icosahedron(), P=2)  # 12 views determine 9 coefficients
    np.testing.assert_allclose(from_twelve.parts[0].maps, rm.parts[0].maps, atol=1e-5 * scale)
    N, V = oracles.random_views(20, seed=24)
    np.testing.assert_allclose(again.radiance(N, V), rm.radiance(N, V), rtol=1e-4)
    with pytest.raises(ValueError, match="12 views do not determine the 16 coefficients of P = 3"):
        fit(twelve, icosahedron(), P=3)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_the_three_dimensional_texture_is_the_local_form_without_azimuth(layout):
    env = band_limited_environment(5, seed=25)
    rm = prefilter(env, brdf.GGX(0.4).recentered("reflection"), orders=(5, 3), size=16, layout=layout)
    texture = three_dimensional_texture(rm, 7)
    part = rm.parts[0]
    # B_p0 from eq. 14: d^l_m0 e^{i m beta} is Y_lm but for sqrt((2l+1) / 4 pi)
    l = np.sqrt(np.arange(len(part.light))).astype(int)
    b = part.light[:, None] * np.sqrt(4 * np.pi / (2 * l + 1))[:, None, None] * part.rho[l, :, 0]
    C = part.directions()
    local = np.einsum("nk,kpc->pnc", oracles.real_harmonics(5, C.reshape(-1, 3)), b)
    theta_o = (np.arange(7) + 0.5) * np.pi / 7
    Y = np.stack([oracles.special.sph_harm_y(p, 0, theta_o, 0).real for p in range(4)], axis=1)
    expected = np.einsum("tp,pnc->tnc", Y, local).reshape(7, *C.shape)
    np.testing.assert_allclose(texture, expected, atol=2e-5 * np.abs(expected).max())


@pytest.mark.parametrize(("layout", "size"), [("latlong", 18), ("cube", 10)])
def test_a_grid_of_views_is_every_view_on_its_own(layout, size):
    env = band_limited_environment(5, seed=26)
    rm = prefilter(
        env, brdf.GGX(0.4).recentered("reflection"), orders=(5, 4), size=size, layout=layout, clamp=True
    )
    single = np.stack([rm.at_view(view) for view in explicit.grid_views(3).reshape(-1, 3)])
    many = reflection_maps(rm, 3)
    np.testing.assert_allclose(many.reshape(single.shape), single, atol=1e-5 * single.max())


def test_a_lobe_without_azimuth_loses_nothing_without_it():
    env = band_limited_environment(6, seed=5)
    frames = Frames.drawn(200)
    rm = prefilter(env, brdf.GGX(0.4), orders=(6, 3), center="reflection", size=32)
    (part,) = rm.parts
    rho = part.rho.copy()
    rho[:, :, 1:] = 0  # a lobe that has no azimuth, through all (P+1)^2 maps of the global form
    full = replace(rm, parts=(replace(part, rho=rho).resized(32, "latlong"),))
    flat = without_azimuth(full)
    assert full.parts[0].maps.shape == (16, 32, 64, 3)
    assert flat.parts[0].maps.shape == (4, 32, 64, 3)
    np.testing.assert_allclose(frames.radiance(flat), frames.radiance(full), rtol=1e-3)
    phong = prefilter(env, brdf.Phong(8), orders=(6, 0), size=32)
    np.testing.assert_array_equal(frames.radiance(without_azimuth(phong)), frames.radiance(phong))


def test_without_azimuth_is_the_mean_over_the_azimuth_of_the_view():
    env = band_limited_environment(5, seed=6)
    rm = prefilter(
        env, velvet(0.4, (0.3, 0.1, 0.2), (0.1, 0.2, 0.3)), orders=(5, 3), center="reflection", size=48
    )
    flat = without_azimuth(rm)
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


def test_fitted_maps_have_no_azimuth_to_lose():
    fitted = fit(np.zeros((1, 4, 8, 3)), [[0, 0, 1.0]], P=0)
    with pytest.raises(ValueError, match="fitted to pictures"):
        without_azimuth(fitted)
