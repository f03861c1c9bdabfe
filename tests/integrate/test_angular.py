"""Direct integration in C++ against the oracle's sum, which shares no code with it.

Both take the same nodes, so what remains is the interpolation in the lobe's table, whose error the result
states, and single precision: 5e-6 of the root mean square for sums of some thousand positive terms in float32
with an angle of float32 behind each.
"""

import os
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose
from shrm.brdf.lobe import RadialLobe
from shrm.integrate.angular import integrate, prefilter_angular
from shrm.integrate.angular_lobes import IsotropicIntegral
from support import oracles
from support.integrands import environment, isotropic, lambert, material, noise, phong, radial, zonal

SINGLE = 5e-6


SKIN = oracles.lafortune([[-1.05] * 3, [-0.7] * 3], [[0.9] * 3, [0.6] * 3], [[18, 20, 30], [4, 5, 6]])


@pytest.mark.parametrize(
    "lobe",
    [phong(1), phong(8), phong(512), lambert(), lambert([0.2, 0.5, 0.9])],
    ids=["phong-1", "phong-8", "phong-512", "lambert", "lambert-rgb"],
)
@pytest.mark.parametrize(("H", "W", "k"), [(32, 64, 1), (32, 64, 3), (9, 25, 2)])
def test_radial_lobes_equal_the_oracle(lobe, H, W, k):
    pixels = noise(H, W)
    normals, views = oracles.random_views(32, seed=1)
    result = prefilter_angular(environment(pixels), material(lobe), subsamples=k)
    expected = oracles.reflected(pixels, lobe.transfer, normals, views, hemisphere=False, subsamples=k)
    assert oracles.relative_rms(result.radiance(normals, views), expected) < 2 * result.table_error + SINGLE


@pytest.mark.slow
@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize(
    "transfer",
    [
        oracles.microfacet(0.1),
        oracles.microfacet(0.5),
        oracles.ggx(0.05),
        oracles.ggx(0.1, [0.04, 0.5, 1.0]),
        oracles.ggx(0.5),
        oracles.beckmann(0.1),
        SKIN,
    ],
    ids=["facets-.1", "facets-.5", "ggx-.05", "ggx-rgb", "ggx-.5", "beckmann-.1", "lafortune"],
)
def test_isotropic_lobes_equal_the_oracle(transfer, k):
    pixels = noise(32, 64)
    normals, views = oracles.random_views(128, seed=2)
    result = prefilter_angular(environment(pixels), material(isotropic(transfer)), subsamples=k)
    expected = oracles.reflected(pixels, transfer, normals, views, subsamples=k)
    # A table's error is largest towards the grazing view, which 128 views meet now more, now less.
    assert result.table_error < 2e-3
    assert oracles.relative_rms(result.radiance(normals, views), expected) < 2 * result.table_error + SINGLE


@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize(
    "transfer",
    [oracles.kajiya_kay(8), oracles.kajiya_kay(64, "mirror"), oracles.banks(0.0), oracles.banks(0.8)],
    ids=["kajiya-kay-8", "kajiya-kay-mirror-64", "banks-0", "banks-.8"],
)
def test_zonal_lobes_equal_the_oracle(transfer, k):
    pixels = noise(32, 64)
    tangents, normals, views = oracles.random_hairs(64, seed=3)
    result = prefilter_angular(environment(pixels), material(zonal(transfer)), subsamples=k)
    expected = oracles.reflected(
        pixels, transfer, normals, views, tangents, frame="tangent", hemisphere=False, subsamples=k
    )
    assert result.table_error < 1e-3
    assert (
        oracles.relative_rms(result.radiance(normals, views, tangents), expected)
        < 2 * result.table_error + SINGLE
    )


@pytest.mark.slow
@pytest.mark.parametrize("row", [0, 13, 31])
def test_a_sun_two_texels_wide(row):
    pixels = np.zeros((64, 128, 3))
    pixels[row : row + 2, 127], pixels[row : row + 2, 0] = [1e5, 9e4, 7e4], [1e5, 9e4, 7e4]
    sun = 2 * oracles.solid_angles(64, 128)[row : row + 2, 0].sum() * np.array([1e5, 9e4, 7e4])
    # Queries that see it: normals near the sun and views near them.
    rng = np.random.default_rng(4)
    at = oracles.directions(64, 128)[row, 0]
    normals = at + 0.2 * rng.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    views = normals + 0.2 * rng.normal(size=(50, 3))
    views /= np.linalg.norm(views, axis=1, keepdims=True)
    for lobe, hemisphere in [
        (phong(64), False),
        (phong(4096), False),
        (isotropic(oracles.ggx(0.05)), True),
        (isotropic(oracles.microfacet(0.2)), True),
    ]:
        result = prefilter_angular(environment(pixels), material(lobe))
        expected = oracles.reflected(
            pixels, lobe.transfer, normals, views, hemisphere=hemisphere, subsamples=16
        )
        # The default number of nodes is exact to 1e-3 for lobes narrower than a texel.
        assert oracles.relative_rms(result.radiance(normals, views), expected) < 1e-3 + 2 * result.table_error
    # A Phong lobe only spreads light: its map holds the sun's energy. Texels of the map are 1/10 of the lobe.
    area = oracles.solid_angles(256, 512)[:, :, None]
    whole = prefilter_angular(environment(pixels), material(phong(64)), size=256).at_view([0, 0, 1])
    assert_allclose(np.sum(whole * area, axis=(0, 1)), sun, rtol=1e-3)


@pytest.mark.slow
def test_white_furnace():
    env = environment(np.ones((32, 64, 3)))
    normals, views = oracles.random_views(16, seed=5)
    for lobe in (lambert(), phong(8), phong(64)):
        B = prefilter_angular(env, material(lobe), subsamples=4).radiance(normals, views)
        # Four Gauss nodes to a texel of 0.1 rad; Lambert's kink at the horizon is integrated as O(h^2/16).
        assert_allclose(B, 1, rtol=2e-4 if lobe.center == "normal" else 2e-6)
    for transfer in (oracles.ggx(0.3), oracles.beckmann(0.5), oracles.microfacet(0.3)):
        result = prefilter_angular(env, material(isotropic(transfer)), subsamples=8)
        for n, v in zip(normals[:6], views[:6], strict=True):
            wo = (oracles.frames(n[None], v[None])[0]).T @ v
            # A jump at the horizon inside texels of 0.1 rad with 8 nodes each way.
            assert_allclose(result.radiance(n[None], v)[0], oracles.albedo(transfer, wo), rtol=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("cutoff", [0.01, 0.05, 0.3])
def test_truncation_leaves_out_what_it_may(cutoff):
    # Under constant light the loss is the part of the lobe's integral that was left out: at most the
    # cutoff, and not much less where texels (with their nodes) are small against the cap.
    env = environment(np.ones((64, 128, 3)))
    normals, views = oracles.random_views(16, seed=6)
    tangents, _, hair_views = oracles.random_hairs(16, seed=6)
    cases = [
        (phong(8), (normals, views), 0.0),
        (phong(128), (normals, views), 0.0),
        (lambert(), (normals, views), 0.0),
        (zonal(oracles.kajiya_kay(16)), (normals, hair_views, tangents), 0.0),
        # Caps of neighboring views are interpolated: an extra thousandth.
        (isotropic(oracles.ggx(0.2)), (normals, views), 1e-3),
        (isotropic(oracles.microfacet(0.3)), (normals, views), 1e-3),
    ]
    for lobe, query, slack in cases:
        whole = prefilter_angular(env, material(lobe), subsamples=2).radiance(*query)
        part = prefilter_angular(env, material(lobe), subsamples=2, cutoff=cutoff).radiance(*query)
        loss = 1 - part / whole
        assert loss.min() > -1e-5
        assert loss.max() < cutoff + slack + 1e-5
        assert loss.max() > 0.5 * cutoff


def test_truncation_follows_appendix_d():
    # Half a sky dark, half bright: the cutoff bounds the error by the light left out over all the light.
    pixels = np.zeros((64, 128, 3))
    pixels[:, 64:] = 1
    normals, views = oracles.random_views(32, seed=7)
    whole, part = (
        prefilter_angular(environment(pixels), material(phong(32)), cutoff=t).radiance(normals, views)
        for t in (0.0, 0.05)
    )
    # Texels of 0.05 rad are in or out as their centers are: part of a ring about a cap of 0.43 rad.
    assert np.max(whole - part) < 0.05 * 1.3
    assert np.min(whole - part) > -1e-5


@pytest.mark.parametrize(
    ("lobe", "map_size"), [(phong(8), 16), (phong(200), 20), (lambert([0.1, 0.5, 1]), 9), (phong(8), 64)]
)
@pytest.mark.parametrize("cutoff", [0.0, 0.02])
def test_a_map_is_the_integral_at_its_texels(lobe, map_size, cutoff):
    pixels = noise(24, 48)
    result = prefilter_angular(environment(pixels), material(lobe), size=map_size, cutoff=cutoff)
    C = oracles.directions(map_size, 2 * map_size).reshape(-1, 3)
    # With V = N = C every center is C.
    direct = result.radiance(C, C)
    assert oracles.relative_rms(result.at_view([0, 0, 1]).reshape(-1, 3), direct) < 1e-6


@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize("cutoff", [0.0, 0.05])
@pytest.mark.parametrize(
    ("lobe", "size"), [(phong(8), 24), (phong(512), 48), (lambert([0.1, 0.5, 1]), 12), (phong(60), 36)]
)
def test_symmetry_only_saves_work(lobe, size, cutoff, k):
    # Columns of the map and of the picture 48 wide: as many, twice, half and 3/2 as many.
    env, options = environment(noise(24, 48)), {"size": size, "cutoff": cutoff, "subsamples": k}
    by_symmetry, every_pair = (
        prefilter_angular(env, material(lobe), symmetry=s, **options).at_view([0, 0, 1])
        for s in (True, False)
    )
    assert_allclose(by_symmetry, every_pair, rtol=0, atol=2e-6 * every_pair.max())


@pytest.mark.parametrize("k", [1, 2])
@pytest.mark.parametrize("cutoff", [0.0, 0.05])
@pytest.mark.parametrize("sigma", [0.1, 0.5])
@pytest.mark.parametrize(("H", "W"), [(24, 48), (9, 25)])
def test_sharing_half_vectors_only_saves_work(sigma, cutoff, k, H, W):
    env, view = environment(noise(H, W)), np.array([0.6, 0, 0.8])
    lobe = material(isotropic(oracles.microfacet(sigma)))
    shared, every_pair = (
        prefilter_angular(env, lobe, size=16, cutoff=cutoff, subsamples=k, symmetry=s).at_view(view)
        for s in (True, False)
    )
    # Half vectors are the same to rounding; z = 1 + g^2 |H - N|^2 magnifies it for sharp lobes.
    assert_allclose(shared, every_pair, rtol=0, atol=1e-5 * every_pair.max())


@pytest.mark.slow
@pytest.mark.parametrize("sigma", [0.1, 0.5])
def test_the_sum_visits_its_caps(sigma):
    # Light outside of a query's cap leaves it black, light within is all there is, to a texel of .025 rad.
    facets, (H, W), texel = oracles.microfacet(sigma), (128, 256), np.pi / 128
    caps = IsotropicIntegral.of("lobe", facets, 0.05, share=True).caps

    def seen(n, v, *pictures):
        """Three at a time, as R, G and B."""
        lobe, lit = material(isotropic(facets)), environment(np.stack(pictures, axis=2))
        return prefilter_angular(lit, lobe, cutoff=0.05, subsamples=1).radiance(n[None], v)[0]

    normals, views = oracles.random_views(8, seed=9)
    axes, outer = caps(normals, views)
    directions = oracles.directions(H, W)
    for n, v, axis, angle in zip(normals, views, axes, outer, strict=True):
        distance = np.arccos(np.clip(directions @ axis, -1, 1))
        cap, rim = distance < angle + 1e-3, (distance > angle - 2 * texel) & (distance < angle)
        outside, inside, at_the_rim = seen(n, v, ~cap, cap, rim)
        (whole, *_) = seen(n, v, *3 * [np.ones((H, W))])
        assert outside <= 1e-6 * whole
        assert_allclose(inside, whole, rtol=1e-5)
        assert at_the_rim > 0 or angle >= np.pi / 2  # at the horizon there may be nothing


def test_a_map_of_every_pair_is_the_sum():
    env = environment(noise(24, 48))
    C = oracles.directions(8, 16).reshape(-1, 3)
    lobe = phong(40)
    for symmetry in (True, False):
        result = prefilter_angular(env, material(lobe), size=8, subsamples=1, symmetry=symmetry)
        found = result.at_view([0, 0, 1]).reshape(-1, 3)
        expected = integrate(env, material(lobe), C, C)
        assert oracles.relative_rms(found, expected) < 2 * result.table_error + SINGLE


def test_a_lobe_that_is_everywhere_sees_everything():
    # Equal weights: the mean of the picture, the texel opposite to the center included.
    pixels = noise(16, 32)
    lobe = RadialLobe("normal", lambda c: np.full_like(c, 1 / (4 * np.pi)))
    C = np.concatenate([oracles.directions(16, 32).reshape(-1, 3), -oracles.directions(16, 32)[3]])
    mean = (oracles.solid_angles(16, 32)[..., None] * pixels).sum(axis=(0, 1)) / (4 * np.pi)
    for k in (1, 2):
        result = prefilter_angular(environment(pixels), material(lobe), subsamples=k)
        assert_allclose(result.radiance(C, C), np.broadcast_to(mean, C.shape), rtol=3e-6)


@pytest.mark.parametrize("k", [1, 2])
def test_profiles_of_many_scales_are_as_exact(k):
    # A needle in a wide lobe has more segments than registers hold.
    def profile(c):
        return np.maximum(c, 0) ** 2 + 300 * np.maximum(c, 0) ** 3e5

    def transfer(wi, wo):
        return profile(wi @ np.array([0.0, 0.0, 1.0]))

    pixels = noise(32, 64)
    normals, views = oracles.random_views(32, seed=1)
    lobe = radial(transfer, profile, "normal")
    result = prefilter_angular(environment(pixels), material(lobe), subsamples=k)
    assert result._parts[0].table.values.shape[-1] > 32
    expected = oracles.reflected(pixels, transfer, normals, views, hemisphere=False, subsamples=k)
    assert oracles.relative_rms(result.radiance(normals, views), expected) < 2 * result.table_error + SINGLE


@pytest.mark.parametrize("k", [1, 2, 3])
@pytest.mark.parametrize("sigma", [0.05, 0.3, 1.0])
def test_lobes_of_the_half_angle_alone(sigma, k):
    # One view for all, shared half vectors: down to the horizon, and some of the normals turned away.
    env, transfer = environment(noise(24, 48)), oracles.microfacet(sigma)
    m = material(isotropic(transfer, "reflection"))
    normals, _ = oracles.random_views(60, seed=11)
    view = np.array([0.48, 0.6, 0.64])
    result = prefilter_angular(env, m, subsamples=k)
    expected = integrate(env, m, normals, view, subsamples=k)
    assert oracles.relative_rms(result.radiance(normals, view), expected) < 2 * result.table_error + SINGLE
    one = np.concatenate([result.radiance(n[None], view) for n in normals[:5]])
    assert_allclose(one, result.radiance(normals, view)[:5], rtol=1e-5)


@pytest.mark.slow
def test_turning_everything_about_the_axis_changes_nothing():
    pixels = noise(16, 32)
    normals, views = oracles.random_views(20, seed=8)
    columns = 5
    angle = columns * 2 * np.pi / 32  # to the left: towards +phi
    R = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    turned = np.roll(pixels, -columns, axis=1)
    for lobe in (phong(32), isotropic(oracles.ggx(0.2))):
        a = prefilter_angular(environment(pixels), material(lobe)).radiance(normals, views)
        b = prefilter_angular(environment(turned), material(lobe)).radiance(normals @ R.T, views @ R.T)
        assert oracles.relative_rms(b, a) < 1e-5


@pytest.mark.slow
def test_reflection_is_linear_and_black_stays_black():
    a, b = noise(16, 32, 1), noise(16, 32, 2)
    normals, views = oracles.random_views(20, seed=9)
    lobes = material(phong(16), lambert(0.5), isotropic(oracles.beckmann(0.3)))
    one, two, sum_ = (
        prefilter_angular(environment(p), lobes).radiance(normals, views) for p in (a, b, 2 * a - b)
    )
    assert_allclose(sum_, 2 * one - two, atol=1e-5 * np.abs(one).max())
    black = prefilter_angular(environment(np.zeros((16, 32, 3))), lobes)
    assert np.array_equal(black.radiance(normals, views), np.zeros((20, 3)))


def test_views_at_the_ends_of_the_table():
    pixels = noise(32, 64)
    normals = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.6, 0.0, 0.8], [0.0, 1.0, 0.0]])
    views = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.8, 0.0, -0.6], [1.0, 0.0, 0.0]])
    transfer = oracles.microfacet(0.3)
    result = prefilter_angular(environment(pixels), material(isotropic(transfer)), subsamples=1)
    assert_allclose(
        result.radiance(normals, views), oracles.reflected(pixels, transfer, normals, views), rtol=1e-4
    )


SCRIPT = """
import numpy as np
from shrm.brdf.lobe import RadialLobe
from shrm.integrate.angular import (prefilter_angular)
from support import integrands as t, oracles
env = t.environment(t.noise(32, 64))
n, v = oracles.random_views(100, seed=10)
tangents, _, w = oracles.random_hairs(100, seed=10)
B = [prefilter_angular(env, t.material(l), size=16) for l in (t.phong(32), t.isotropic(oracles.ggx(0.2)))]
C = prefilter_angular(env, t.material(t.zonal(oracles.kajiya_kay(8))))
np.save({out!r}, np.concatenate([B[0].radiance(n, v), B[1].radiance(n, v), C.radiance(n, w, tangents),
                                 B[0].at_view(v[0]).reshape(-1, 3)]))
"""


@pytest.mark.slow
def test_threads_do_not_matter(tmp_path):
    results = []
    for threads in (1, 3):
        out = str(tmp_path / f"{threads}.npy")
        code = SCRIPT.format(out=out)
        env = os.environ | {"OMP_NUM_THREADS": str(threads)}
        subprocess.run([sys.executable, "-c", code], env=env, check=True)
        results.append(np.load(out))
    assert np.array_equal(*results)
