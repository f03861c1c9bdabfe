"""Materials of transfer: one for each vertex, blends, colors, and every kind of lobe."""

import numpy as np
import pytest
from shrm import brdf
from shrm.transfer.directional_basis import DirectionalBasis
from shrm.transfer.matrices.product import Route
from support import oracles
from support.directions import sphere
from support.precomputed import ALL, BUMPY, matrices, transferred
from support.transfer_meshes import ball, grid, together
from support.transfer_oracle import BruteForce, snr

ROUTES = [Route(), Route(4, m=6)]
GREY = (brdf.Lambert(0.5), brdf.GGX(0.4))
COLORED = brdf.GGX(0.5, f0=(1.0, 0.7, 0.3))
ROUNDING = 1e-5
"""Of sums of 128 float32 in another order, of the largest."""


def equal(actual: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(actual, expected, atol=ROUNDING * np.abs(expected).max(), rtol=0)


def shares(seed: int, count: int = 2) -> np.ndarray:
    s = np.random.default_rng(seed).uniform(size=(len(BUMPY[0]), count))
    return s / s.sum(axis=1, keepdims=True)


# ---- Shares. The bounces are those of one albedo: otherwise they are not linear in the shares.


@pytest.mark.parametrize("route", ROUTES, ids=str)
def test_one_material_for_each_vertex_is_that_materials(route):
    options = {"variants": ALL, "route": route, "albedo": 0.5}
    which = np.random.default_rng(1).integers(0, 2, len(BUMPY[0]))
    held = transferred(BUMPY, GREY, shares=np.eye(2)[which], **options)
    singles = [transferred(BUMPY, one, **options) for one in GREY]
    for name in ALL:
        expected = np.where(which[:, None, None, None] == 0, *(matrices(one, name) for one in singles))
        equal(matrices(held, name), expected)


def test_blends_are_blends_of_matrices():
    options = {"variants": ALL, "albedo": 0.5}
    s = shares(2)
    s[0] = 0, 0  # nothing
    s[1] = 2, 3  # brighter than either
    held = transferred(BUMPY, GREY, shares=s, **options)
    singles = [transferred(BUMPY, one, **options) for one in GREY]
    for name in ALL:
        expected = sum(s[:, k, None, None, None] * matrices(one, name) for k, one in enumerate(singles))
        equal(matrices(held, name), expected)
        assert not matrices(held, name)[0].any()


@pytest.mark.slow
def test_grey_and_colored_materials_blend():
    materials, s = (brdf.Lambert(0.5), COLORED), shares(3)
    held = transferred(BUMPY, materials, shares=s, variants=ALL, albedo=0.5)
    assert held.channels == 3
    for c, f0 in enumerate((1.0, 0.7, 0.3)):
        of_channel = (materials[0], brdf.GGX(0.5, f0=f0))
        one = transferred(BUMPY, of_channel, shares=s, variants=ALL, albedo=0.5)
        for name in ALL:
            equal(matrices(held, name)[:, :, c], matrices(one, name)[:, :, 0])


def test_shares_of_one_material_scale_it():
    s = shares(4, 3)[:, :1]
    held, one = (transferred(BUMPY, [brdf.GGX(0.4)], shares=x) for x in (s, np.ones_like(s)))
    equal(matrices(held), s[:, :, None, None] * matrices(one))
    equal(matrices(one), matrices(transferred(BUMPY, brdf.GGX(0.4))))


# ---- The albedo of bounces


def test_bounces_have_the_albedo_of_the_materials():
    """Of white light, over all views; and of a blend the blend of it."""
    pair, s = (brdf.Lambert(0.2), brdf.Lambert((0.9, 0.5, 0.1))), shares(5)
    by_default = transferred(BUMPY, pair, shares=s, variants=("interreflected",), bounces=3)
    albedo = s @ [[0.2] * 3, [0.9, 0.5, 0.1]]
    given = transferred(BUMPY, pair, shares=s, variants=("interreflected",), bounces=3, albedo=albedo)
    # The rows of materials are known to 1e-4
    expected = matrices(given, "interreflected")
    np.testing.assert_allclose(
        matrices(by_default, "interreflected"), expected, atol=2e-4 * np.abs(expected).max()
    )


def test_glossy_materials_have_an_albedo_too():
    alpha = 0.5
    x, w = np.polynomial.legendre.leggauss(16)
    cosines, weights = (1 + x) / 2, w / 2 * (1 + x)  # 1 / pi int cos d(view)
    views = [np.array([np.sqrt(1 - c * c), 0, c]) for c in cosines]
    albedo = weights @ [oracles.albedo(oracles.ggx(alpha), view, 200, 200) for view in views]
    assert 0.5 < albedo < 1
    by_default, given = (
        matrices(
            transferred(BUMPY, brdf.GGX(alpha), tents=9, variants=("interreflected",), **o), "interreflected"
        )
        for o in ({}, {"albedo": albedo})
    )
    # By the tents the albedo is an integral over them, right to a part of what they lose: 1e-3 of a tenth
    np.testing.assert_allclose(by_default, given, atol=1e-3 * np.abs(given).max())


@pytest.mark.slow
@pytest.mark.parametrize("route", ROUTES, ids=str)
@pytest.mark.parametrize("material", [brdf.GGX(0.4), COLORED], ids=["grey", "color"])
def test_colors_are_channels_by_themselves(route, material):
    albedo = (0.9, 0.5, 0.1)
    options = {"variants": ALL, "route": route, "bounces": 2}
    held = transferred(BUMPY, material, albedo=albedo, **options)
    assert held.channels == 3
    for c in range(3):
        of_channel = brdf.GGX(0.5, f0=(1.0, 0.7, 0.3)[c]) if material is COLORED else material
        one = transferred(BUMPY, of_channel, albedo=albedo[c], **options)
        assert one.channels == 1
        for name in ALL:
            equal(matrices(held, name)[:, :, c], matrices(one, name)[:, :, 0])


# ---- Lobes, against rays


def about_the_tangent(transfer: oracles.Transfer) -> oracles.Transfer:
    """Of a frame with z = normal, x = tangent, where its own has z = tangent; light above the horizon."""

    def turned(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        value = transfer(wi[:, [1, 2, 0]], np.broadcast_to(wo, wi.shape)[:, [1, 2, 0]])
        return np.where((wi[:, 2] > 0) & (wo[..., 2] > 0), value, 0.0)

    return turned


@pytest.mark.slow
@pytest.mark.parametrize("route", ROUTES, ids=str)
@pytest.mark.parametrize(
    ("material", "transfer"),
    [
        (brdf.Beckmann(0.4), oracles.beckmann(0.4)),
        (brdf.AnisotropicGGX(0.3, 0.6), oracles.anisotropic_ggx(0.3, 0.6)),
        (brdf.Banks(0.2), about_the_tangent(oracles.banks(0.2))),
    ],
    ids=["reflection", "anisotropic", "tangent"],
)
def test_every_kind_of_lobe_is_shadowed_as_by_rays(route, material, transfer):
    mesh = together(grid(6, [-2, -2, -1.1], [4, 0, 0], [0, 4, 0]), ball(1))
    tangent, views = np.array([1.0, 0.2, 0.3]), sphere(48, 6)
    tangents = np.tile(tangent, (len(mesh[0]), 1))
    held = transferred(mesh, material, tents=7, route=route, directions=1024, tangents=tangents)
    A, rays = matrices(held), BruteForce(*mesh, rays=8192)
    expected, found = [], []
    for p in range(0, len(mesh[0]), 8):
        up = views[views @ mesh[2][p] > 0]
        expected.append(rays.radiance(p, up, tangent, transfer, 3))
        found.append(DirectionalBasis(7).evaluate(A[p, :, 0], up @ held.frames[p].astype(np.float64)))
    reached = snr(np.concatenate(expected), np.concatenate(found))
    assert reached > 18  # a lobe in another frame has less than 10
    assert held.report["SNR of matrices"] == pytest.approx(reached, abs=3)
