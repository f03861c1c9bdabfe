"""Descent in a pyramid: the sum over all texels in the end, and the error that is asked for before."""

import os
import subprocess
import sys
from functools import cache

import numpy as np
import pytest
from shrm import Environment, brdf, prefilter_angular, prefilter_hierarchical
from shrm._core import processor
from shrm.integrate.angular import integrate
from shrm.integrate.hierarchical import HierarchicalReflection
from support import oracles
from support.data import environment
from support.directions import sphere

EXPONENTS = (10, 50, 100, 250, 500)
LIGHTS = ("sun.hdr", "quarry_01_1k.hdr", "venice_sunset_1k.hdr", "debevec_grace_cross.hdr")
VIEWS = ((0.6, 0.0, -0.8), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.6, 0.0, -0.8))


def picture(H: int, seed: int) -> Environment:
    """Bright and dark texels side by side, some black."""
    rng = np.random.default_rng(seed)
    pixels = rng.random((H, 2 * H, 3)) ** 8
    pixels[rng.random((H, 2 * H)) < 0.3] = 0.0
    return Environment(pixels.astype(np.float32))


def plain_sum(env: Environment, profile, centers: np.ndarray) -> np.ndarray:
    """Over all texels as points, in float64; shares no code with what is tested."""
    H, W, _ = env.pixels.shape
    theta = np.pi * (np.arange(H) + 0.5) / H
    power = env.pixels * texel_areas(H)
    phi = np.pi - 2 * np.pi * (np.arange(W) + 0.5) / W
    sine = np.sin(theta)[:, None]
    L = np.stack(
        [sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(np.cos(theta)[:, None], (H, W))], axis=-1
    )
    return profile(centers @ L.reshape(-1, 3).T) @ power.reshape(-1, 3).astype(np.float64)


def texel_areas(H: int) -> np.ndarray:
    edges = np.cos(np.pi * np.arange(H + 1) / H)
    return ((edges[:-1] - edges[1:]) * np.pi / H)[:, None, None]


@pytest.mark.parametrize("H", [5, 16, 33])
@pytest.mark.parametrize("s", EXPONENTS)
def test_without_a_threshold_every_texel_is_summed(s, H):
    env, lobe = picture(H, seed=1), brdf.Phong(s)
    N = sphere(41, seed=2)  # no whole number of blocks
    V = np.broadcast_to([0.0, 0.0, 1.0], N.shape)
    R = 2 * (N @ V[0])[:, None] * N - V
    found = prefilter_hierarchical(env, lobe, threshold=0.0).radiance(N, V)
    expected = plain_sum(env, lambda c: (s + 1) / (2 * np.pi) * np.maximum(c, 0) ** s, R)
    # The table's cubics err by 1e-5 of the lobe's root mean square.
    np.testing.assert_allclose(found, expected, atol=3e-5 * expected.max())


def test_diffuse_light_of_three_colors_and_a_sum_of_lobes():
    env = picture(24, seed=3)
    N = sphere(30, seed=4)
    albedo = np.array([0.8, 0.5, 0.2])
    diffuse = plain_sum(env, lambda c: np.maximum(c, 0) / np.pi, N) * albedo
    found = prefilter_hierarchical(env, brdf.Lambert(tuple(albedo)), threshold=0.0)
    np.testing.assert_allclose(found.radiance(N, N), diffuse, atol=3e-5 * diffuse.max())
    both = prefilter_hierarchical(env, brdf.Lambert(tuple(albedo)) + 0.5 * brdf.Phong(20), threshold=0.0)
    glossy = prefilter_hierarchical(env, brdf.Phong(20), threshold=0.0)
    np.testing.assert_allclose(
        both.radiance(N, N), found.radiance(N, N) + 0.5 * glossy.radiance(N, N), rtol=1e-5
    )
    assert set(both.maps_at_view([0, 0, 1.0])) == {"normal", "reflection"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "s"),
    [(name, s) for k, name in enumerate(LIGHTS) for j, s in enumerate(EXPONENTS) if (k + j) % 2 == 0],
)
def test_the_error_that_is_asked_for_is_had(name, s):
    env = environment(name)
    lobe = brdf.Phong(s)
    exact = prefilter_hierarchical(env, lobe, threshold=0.0, size=64)
    expected = exact.at_view([0, 0, 1.0])
    area = texel_areas(64)
    for error in (0.03, 0.01, 0.001):
        descent = prefilter_hierarchical(env, lobe, tolerance=error, size=64)
        found = descent.at_view([0, 0, 1.0])
        off = np.sqrt((area * (found - expected) ** 2).sum() / (area * expected**2).sum())
        assert off < 1.25 * error  # found from a part of the map


@pytest.mark.parametrize("s", [10, 250])
def test_a_lower_threshold_errs_no_more(s):
    env, lobe = picture(64, seed=5), brdf.Phong(s)
    expected = prefilter_hierarchical(env, lobe, threshold=0.0, size=32).at_view([0, 0, 1.0])
    last, evaluations = np.inf, 0.0
    for threshold in 10.0 ** np.arange(1, -6, -0.5):
        descent = prefilter_hierarchical(env, lobe, threshold=threshold, size=32)
        off = oracles.relative_rms(descent.at_view([0, 0, 1.0]), expected)
        assert off < 1.1 * last + 1e-6  # rounding
        assert descent.evaluations >= evaluations
        last, evaluations = off, descent.evaluations
    assert last < 1e-6


@pytest.mark.parametrize("s", EXPONENTS)
@pytest.mark.parametrize(
    "place",
    [(0, 0), *(pytest.param(place, marks=pytest.mark.slow) for place in [(20, 37), (63, 100), (127, 3)])],
)
def test_a_sun_keeps_its_energy(s, place):
    pixels = np.full((128, 256, 3), 1e-3, np.float32)
    i, j = place
    pixels[i, j : j + 2] = 1e4
    # Rows of .7 degrees, so that their sum is the integral over lobes of 4 degrees at the poles too.
    found = prefilter_hierarchical(Environment(pixels), brdf.Phong(s), size=256).at_view([0, 0, 1.0])
    incoming, reflected = ((x * texel_areas(len(x))).sum((0, 1)) for x in (pixels, found))
    np.testing.assert_allclose(reflected, incoming, rtol=0.01)
    assert found.min() > 0
    rows = found.max(axis=(1, 2))  # the lobe itself, no speck apart from it
    assert np.all(np.diff(np.sign(np.diff(rows[rows > 0.01 * rows.max()]))) <= 0)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_a_constant_light_stays_constant(layout):
    env = Environment(np.ones((128, 256, 3), np.float32))
    found = prefilter_hierarchical(env, brdf.Phong(100), tolerance=0.01, size=32, layout=layout).at_view(
        [0, 0, 1]
    )
    assert found.shape == ((32, 64, 3) if layout == "latlong" else (6, 32, 32, 3))
    np.testing.assert_allclose(found, 1, rtol=0.05)  # 1% is the root mean square
    assert oracles.relative_rms(found, np.ones_like(found)) < 0.0125


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize("lobe", [brdf.Lambert(0.5), brdf.Phong(30)], ids=lambda lobe: lobe.name)
def test_maps_are_those_of_integration(lobe, layout):
    """Texel by texel: blocks go back to their places, the last one too where it is not full."""
    env = picture(32, seed=6)
    found = prefilter_hierarchical(env, lobe, threshold=0.0, size=9, layout=layout).at_view([0, 0, 1.0])
    assert found[..., 0].size % 16 != 0
    expected = prefilter_angular(env, lobe, size=9, layout=layout, subsamples=1).at_view([0, 0, 1.0])
    np.testing.assert_allclose(found, expected, atol=3e-5 * expected.max())


def test_black_light_reflects_nothing():
    env = Environment(np.zeros((8, 16, 3), np.float32))
    assert not prefilter_hierarchical(env, brdf.Phong(10), size=8).at_view([0, 0, 1.0]).any()


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"threshold": -1.0}, "threshold"),
        ({"threshold": np.nan}, "threshold"),
        ({"threshold": "low"}, "threshold"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"tolerance": 2.0}, "tolerance"),
        ({"tolerance": 0.1, "threshold": 0.1}, "one of them"),
        ({"size": 0}, "size"),
        ({"layout": "disc"}, "layout"),
    ],
)
def test_bad_input_is_named(given, text):
    with pytest.raises((TypeError, ValueError), match=text):
        prefilter_hierarchical(picture(4, seed=7), brdf.Phong(10), **given)


def test_what_is_no_environment_or_view_is_refused():
    with pytest.raises(TypeError, match="env must be an Environment"):
        prefilter_hierarchical(np.ones((4, 8, 3)), brdf.Phong(10))
    descent = prefilter_hierarchical(picture(4, seed=8), brdf.Phong(10), size=4)
    with pytest.raises(ValueError, match="views"):
        descent.radiance([[0, 0, 1.0]], [[0, 0, 2.0]])
    hair = prefilter_hierarchical(picture(4, seed=8), brdf.Banks(0.5), size=4)
    with pytest.raises(ValueError, match="tangents"):
        hair.radiance([[0, 0, 1.0]], [[0, 0, 1.0]])


@cache
def every_texel(material: brdf.BRDF, size: int) -> HierarchicalReflection:
    """A descent that goes to every texel: its tables are made once for all lights."""
    return prefilter_hierarchical(picture(4, seed=17), material, threshold=0.0, size=size)


def exact_map(env: Environment, material: brdf.BRDF, view: tuple[float, ...], size: int) -> np.ndarray:
    everything = every_texel(material, size)
    everything.update(env)
    return everything.at_view(view)


# Lobes of other kinds -----------------------------------------------------------------------------

KINDS = [
    brdf.Banks(0.5),
    brdf.Banks(0.95),
    brdf.KajiyaKay(32),
    brdf.MillerHeidrich((0.5, 0.3, 0.1), 40, f0=0.1),
    brdf.GGX(0.1),
    brdf.GGX(0.4, (1.0, 0.7, 0.3)),
    brdf.Microfacet(0.2),
    brdf.Beckmann(0.3).recentered("reflection"),
    0.3 * brdf.Lambert(0.8) + brdf.GGX(0.2),
]


@pytest.mark.slow
@pytest.mark.parametrize("material", KINDS, ids=lambda material: material.name)
def test_all_kinds_are_summed_over_every_texel_without_a_threshold(material):
    env = picture(24, seed=9)
    N, V = oracles.random_views(43, seed=10)  # no whole number of blocks
    T = oracles.random_hairs(43, seed=11)[0]
    found = prefilter_hierarchical(env, material, threshold=0.0).radiance(N, V, T)
    by_table = prefilter_angular(env, material, subsamples=1).radiance(N, V, T)
    np.testing.assert_allclose(found, by_table, atol=1e-4 * by_table.max())
    # The table itself is another's to judge; here that it is the right one.
    plain = integrate(env, material, N, V, T)
    assert oracles.relative_rms(found, plain) < 5e-3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "view"), list(zip(LIGHTS, VIEWS, strict=True)))
@pytest.mark.parametrize("material", [KINDS[1], KINDS[4], KINDS[6]], ids=lambda material: material.name)
def test_the_error_that_is_asked_for_is_had_by_all_kinds(name, material, view):
    env = environment(name)
    expected = exact_map(env, material, view, 32)
    area = texel_areas(32)
    for error in (0.03, 0.01):
        found = prefilter_hierarchical(env, material, tolerance=error, size=32).at_view(view)
        off = np.sqrt((area * (found - expected) ** 2).sum() / (area * expected**2).sum())
        assert off < 1.25 * error  # found from other views, and a part of the map


@pytest.mark.slow
@pytest.mark.parametrize("material", [KINDS[1], KINDS[4]], ids=lambda material: material.name)
def test_a_lower_threshold_errs_no_more_for_any_kind(material):
    env = picture(32, seed=12)
    expected = prefilter_hierarchical(env, material, threshold=0.0, size=16).at_view([0, 0, 1.0])
    last = np.inf
    for threshold in 10.0 ** np.arange(1, -6, -1.0):
        found = prefilter_hierarchical(env, material, threshold=threshold, size=16).at_view([0, 0, 1.0])
        off = oracles.relative_rms(found, expected)
        assert off < 1.1 * last + 1e-6
        last = off
    assert last < 1e-4


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize("material", [KINDS[0], KINDS[4]], ids=lambda material: material.name)
def test_maps_of_a_view_are_those_of_integration(material, layout):
    env, view = picture(16, seed=13), [0.48, -0.6, 0.64]
    found = prefilter_hierarchical(env, material, threshold=0.0, size=9, layout=layout).at_view(view)
    expected = prefilter_angular(env, material, size=9, layout=layout, subsamples=1).at_view(view)
    np.testing.assert_allclose(found, expected, atol=1e-4 * expected.max())


@pytest.mark.slow
@pytest.mark.parametrize("place", [(3, 10), (31, 40), (60, 127)])
def test_a_sun_of_two_texels_is_not_overlooked(place):
    """By lobes narrower than the nodes above it, where samples alone would show nothing."""
    pixels = np.full((64, 128, 3), 1e-4, np.float32)
    pixels[place[0], [place[1], (place[1] + 1) % 128]] = 1e4
    env = Environment(pixels)
    for material in (brdf.GGX(0.05), brdf.Banks(0.98), brdf.Microfacet(0.05)):
        expected = exact_map(env, material, (0, 0.6, 0.8), 48)
        found = prefilter_hierarchical(env, material, tolerance=0.02, size=48).at_view([0, 0.6, 0.8])
        total, should = ((x * texel_areas(48)).sum() for x in (found, expected))
        assert total == pytest.approx(should, rel=0.01)


def test_lobes_narrower_than_their_tables_are_said_and_end():
    env = picture(64, seed=14)
    with pytest.warns(UserWarning, match="narrower than what its table resolves"):
        thin = prefilter_hierarchical(env, brdf.Banks(1 - 1e-6), tolerance=0.02, size=64)
    thin.at_view([0, 0, 1.0])
    assert (
        thin.evaluations < 0.3 * 64 * 128
    )  # of the light's texels: rows that are nothing do not widen the ring


@pytest.mark.slow
@pytest.mark.parametrize("size", [2, 9])
def test_small_maps_do_not_make_small_samples(size):
    """The threshold is found from as many texels, whatever the map is."""
    env, lobe = picture(24, seed=15), brdf.GGX(0.2)
    N, V = oracles.random_views(300, seed=16)
    expected = prefilter_hierarchical(env, lobe, threshold=0.0).radiance(N, V)
    found = prefilter_hierarchical(env, lobe, tolerance=0.01, size=size).radiance(N, V)
    assert oracles.relative_rms(found, expected) < 0.015


ALONG_THE_NORMAL = """
import numpy as np
from shrm import _core

H, W = 32, 64
pixels = np.ones((H, W, 3), np.float32)
theta = np.pi / H * (np.arange(H)[:, None] + 0.5)
phi = np.pi - 2 * np.pi / W * (np.arange(W) + 0.5)
across = np.sin(theta)
towards = np.stack([across * np.cos(phi), across * np.sin(phi), np.cos(theta) + 0 * phi], axis=-1)
towards = towards.reshape(-1, 3)
normals = np.concatenate([towards, towards.astype(np.float32), np.nextafter(towards, 0)]).astype(float)
radiance, _ = _core.hierarchical_isotropic(
    pyramid=_core.Pyramid(pixels),
    envelope=np.ones((1, 9), np.float32),
    ratio=np.ones((3, 1, 7, 7), np.float32),
    caps=np.array([[0.0, 1.6]] * 3),
    threshold=0.0,
    integral=1.0,
    finest=0.1,
    normals=normals,
    views=normals,
)
np.testing.assert_allclose(radiance, 2 * np.pi, rtol=0.06)  # a hemisphere, to half a row about its rim
"""


@pytest.mark.parametrize("name", processor.instruction_sets())
def test_light_along_the_normal_is_looked_up_inside_the_table(name: str) -> None:
    """Where products and sums are fused, 1 - sqrt(N.L) of N.L near 1 may be below 0."""
    environment = {**os.environ, "SHRM_INSTRUCTION_SET": name}
    subprocess.run([sys.executable, "-c", ALONG_THE_NORMAL], env=environment, check=True, timeout=120)


@pytest.mark.parametrize("material", [brdf.GGX(1e-5), brdf.Phong(1e10)], ids=["ggx", "phong"])
def test_lobes_that_fall_between_the_texels_are_warned_of(material):
    """With a tolerance: what meets it is the sum over texels, which is not what such a lobe reflects."""
    env = Environment(np.ones((16, 32, 3), np.float32))
    with pytest.warns(UserWarning, match="falls between the texels"):
        prefilter_hierarchical(env, material, tolerance=0.1)
    prefilter_hierarchical(env, material, threshold=0.1)
