"""Anisotropic materials: their formulas, symmetries and limits, and who takes them and who refuses."""

import numpy as np
import pytest
import shrm
from hypothesis import given, settings
from hypothesis import strategies as st
from shrm import brdf, prefiltered
from shrm.frequency import orders
from shrm.integrate import angular as reference
from support import oracles
from support.directions import direction, hemisphere, sphere, turned
from support.light import band_limited_environment

MODELS = [
    brdf.AshikhminShirley(40, 10),
    brdf.AshikhminShirley(5, 200, 0.3, (0.1, 0.5, 0.9)),
    brdf.AnisotropicGGX(0.3, 0.1),
    brdf.AnisotropicGGX(0.1, 0.6, (1.0, 0.5, 0.04)),
]
named = pytest.mark.parametrize("material", MODELS, ids=lambda m: m.name)


def near_mirror(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    wi, wo = hemisphere(n, seed), hemisphere(n, seed + 1)
    wi[: n // 2] = wo[: n // 2] * [-1, -1, 1] + 0.2 * wi[: n // 2]  # most of the energy is here
    return wi / np.linalg.norm(wi, axis=1, keepdims=True), wo


# Values


@pytest.mark.parametrize(("nu", "nv"), [(40, 40), (40, 10), (0, 7), (3000, 2)])
def test_ashikhmin_and_shirley_are_the_printed_equations(nu, nv):
    wi, wo = near_mirror(4000, 1)
    expected = oracles.ashikhmin_shirley(nu, nv, 0.3, 0.6)(wi, wo)
    # (N.H)^e by its cosine, not its sine, is off by e times 1e-16.
    np.testing.assert_allclose(
        brdf.AshikhminShirley(nu, nv, 0.3, 0.6).transfer(wi, wo), expected, rtol=1e-11, atol=1e-14
    )


@pytest.mark.parametrize(("alpha_x", "alpha_y"), [(0.3, 0.3), (0.05, 0.4), (1.0, 0.2)])
def test_anisotropic_ggx_follows_the_formulas_in_angles(alpha_x, alpha_y):
    wi, wo = near_mirror(4000, 3)
    expected = oracles.anisotropic_ggx(alpha_x, alpha_y)(wi, wo)
    np.testing.assert_allclose(
        brdf.AnisotropicGGX(alpha_x, alpha_y).transfer(wi, wo), expected, rtol=1e-9, atol=1e-12
    )


def test_with_two_equal_widths_it_is_ggx():
    wi, wo = sphere(4000, 5), sphere(4000, 6)
    one, two = brdf.GGX(0.2, (0.9, 0.5, 0.1)), brdf.AnisotropicGGX(0.2, 0.2, (0.9, 0.5, 0.1))
    np.testing.assert_allclose(two.transfer(wi, wo), one.transfer(wi, wo), rtol=1e-12, atol=1e-15)


# Symmetries and horizons


@named
def test_a_quarter_turn_exchanges_the_two_directions(material):
    if isinstance(material, brdf.AshikhminShirley):
        exchanged = brdf.AshikhminShirley(material.nv, material.nu, material.Rs, material.Rd)
    else:
        exchanged = brdf.AnisotropicGGX(material.alpha_y, material.alpha_x, material.f0)
    wi, wo = sphere(1000, 7), sphere(1000, 8)
    np.testing.assert_allclose(
        exchanged.transfer(turned(wi, np.pi / 2), turned(wo, np.pi / 2)),
        material.transfer(wi, wo),
        rtol=1e-9,
        atol=1e-13,
    )


@named
@pytest.mark.parametrize("mirror", [[-1, 1, 1], [1, -1, 1]])
def test_mirrored_in_either_direction_nothing_changes(material, mirror):
    wi, wo = sphere(1000, 9), sphere(1000, 10)
    np.testing.assert_allclose(
        material.transfer(wi * mirror, wo * mirror), material.transfer(wi, wo), rtol=1e-12, atol=1e-15
    )


@named
def test_reciprocity(material):
    wi, wo = hemisphere(2000, 11), hemisphere(2000, 12)
    forward, backward = material.transfer(wi, wo), material.transfer(wo, wi)
    by_row = (slice(None),) + (None,) * (forward.ndim - 1)
    np.testing.assert_allclose(forward / wi[:, 2][by_row], backward / wo[:, 2][by_row], rtol=1e-9)


@named
def test_nothing_comes_from_below_the_horizon_or_goes_there(material):
    wi, wo = sphere(4000, 13), sphere(4000, 14)
    above = (wi[:, 2] > 0) & (wo[:, 2] >= 0)
    assert np.all(material.transfer(wi, wo)[~above] == 0)


grazing = st.sampled_from([0.0, 1e-300, 1e-30, 1e-16, 1e-8, 1e-4, 0.5, 1 - 1e-8, 1 - 1e-16, 1.0])
cosines = st.one_of(grazing, grazing.map(lambda c: -c), st.floats(-1.0, 1.0))
azimuths = st.one_of(st.sampled_from([0.0, np.pi, np.pi / 2, 1e-12]), st.floats(0.0, 2 * np.pi))
unit = st.floats(0.0, 1.0)
reflectance = st.one_of(unit, st.tuples(unit, unit, unit))
widths = st.one_of(st.sampled_from([1e-6, 1e-3, 1.0]), st.floats(1e-6, 1.0))
exponents = st.one_of(st.sampled_from([0.0, 1e-3, 1e6, 1e12]), st.floats(0.0, 1e4))
materials = st.one_of(
    st.builds(brdf.AshikhminShirley, exponents, exponents, reflectance, reflectance),
    st.builds(brdf.AnisotropicGGX, widths, widths, reflectance),
)


@pytest.mark.slow
@settings(max_examples=300)
@given(materials, cosines, azimuths, cosines, azimuths)
def test_values_are_finite_and_not_negative_everywhere(material, cos_i, phi_i, cos_o, phi_o):
    value = material.transfer(direction(cos_i, phi_i), direction(cos_o, phi_o))
    assert value.shape == ((1,) if material.channels == 1 else (1, 3))
    assert np.all(np.isfinite(value))
    assert np.all(value >= 0)


# Energy


@pytest.mark.parametrize("phi", [0.0, 0.7, np.pi / 2])
@pytest.mark.parametrize("cosine", [1.0, 0.6, 0.2])
@pytest.mark.parametrize(
    ("material", "transfer"),
    [
        (brdf.AshikhminShirley(40, 10, 0.3, 0.6), oracles.ashikhmin_shirley(40, 10, 0.3, 0.6)),
        (brdf.AnisotropicGGX(0.3, 0.15), oracles.anisotropic_ggx(0.3, 0.15)),
    ],
    ids=lambda m: getattr(m, "name", ""),
)
def test_albedo_agrees_with_a_product_rule_about_the_normal(material, transfer, cosine, phi):
    expected = oracles.albedo(transfer, direction(cosine, phi)[0], 1200, 400)
    # The rule's even nodes meet the kink of max(N.L, N.V) anywhere: second order in pi / 1200.
    assert brdf.directional_albedo(material, [cosine], phi)[0, 0] == pytest.approx(expected, abs=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize("alphas", [(0.1, 0.3), (0.5, 0.1), (1.0, 1.0)])
def test_microfacets_do_not_reflect_more_than_they_receive(alphas):
    for phi in (0.0, 1.0, np.pi / 2):
        albedo = brdf.directional_albedo(brdf.AnisotropicGGX(*alphas), [1.0, 0.7, 0.1], phi)
        assert np.all(albedo <= 1 + 1e-5)


def test_ashikhmin_and_shirley_conserve_energy():
    for phi in (0.0, 1.0, np.pi / 2):
        material = brdf.AshikhminShirley(100, 10, 0.4, 1.0)
        assert np.all(brdf.directional_albedo(material, [1.0, 0.7, 0.1], phi) <= 1 + 1e-5)


# Who takes them


def test_the_integrator_turns_the_frame_to_the_tangent():
    env = band_limited_environment(4, seed=15, H=32)
    rng = np.random.default_rng(16)
    normals, views = sphere(6, 17), sphere(6, 18)
    views[np.einsum("nc,nc->n", normals, views) < 0] *= -1
    tangents = np.cross(normals, sphere(6, 19))
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    slanted = tangents + rng.uniform(-1, 1, (6, 1)) * normals
    slanted /= np.linalg.norm(slanted, axis=1, keepdims=True)
    expected = oracles.reflected(
        env.pixels, oracles.ashikhmin_shirley(40, 10), normals, views, tangents, subsamples=2
    )
    material = brdf.AshikhminShirley(40, 10)
    for t in (tangents, slanted):
        actual = reference.integrate(env, material, normals, views, t, subsamples=2)
        np.testing.assert_allclose(actual, expected, rtol=1e-8)
    with pytest.raises(ValueError, match=r"tangents must have the shape .* got None"):
        reference.integrate(env, material, normals, views)


@pytest.mark.parametrize(
    "make_map",
    [
        lambda env, m: shrm.prefilter(env, m),
        lambda env, m: shrm.prefilter(env, m, orders=(8, 2)),
        lambda env, m: shrm.cheapest(env, m),
        lambda env, m: shrm.prefilter_angular(env, m),
        lambda env, m: shrm.prefilter_hierarchical(env, m),
        lambda env, m: prefiltered.prefilter(env, m),
        lambda env, m: prefiltered.KautzMcCool2D.prefilter(env, m),
        lambda env, m: prefiltered.Cabral.prefilter(env, m),
        lambda env, m: orders.choose(env, m),
        lambda env, m: m.recentered("reflection", merge=True),
    ],
)
@pytest.mark.parametrize("material", [MODELS[0], MODELS[3]], ids=lambda m: m.name)
def test_reflection_maps_refuse_them_in_one_line_that_says_why(make_map, material):
    env = band_limited_environment(2, seed=20, H=8)
    with pytest.raises(ValueError, match="cannot hold that: use matrix radiance transfer") as caught:
        make_map(env, material)
    assert "\n" not in str(caught.value)


def test_scaled_and_recentered_lobes_keep_their_kind():
    material = (0.5, 1.0, 2.0) * MODELS[0] + brdf.GGX(0.3)
    assert [lobe.kind for lobe in material.lobes] == ["anisotropic", "isotropic"]
    assert [lobe.kind for lobe in material.recentered("reflection").lobes] == ["anisotropic", "isotropic"]
    wi, wo = hemisphere(50, 21), hemisphere(50, 22)
    np.testing.assert_allclose(
        ((0.5, 1.0, 2.0) * MODELS[0]).transfer(wi, wo),
        MODELS[0].transfer(wi, wo)[:, None] * [0.5, 1.0, 2.0],
        rtol=1e-14,
    )


@pytest.mark.parametrize(
    ("text", "material"),
    [
        ("ashikhmin-shirley:40,10", brdf.AshikhminShirley(40, 10)),
        (
            "ashikhmin-shirley:40,10,Rs=0.5/0.4/0.3,Rd=0.1",
            brdf.AshikhminShirley(40, 10, (0.5, 0.4, 0.3), 0.1),
        ),
        ("anisotropic-ggx:0.3,0.1", brdf.AnisotropicGGX(0.3, 0.1)),
        *((m.name, m) for m in MODELS),
    ],
)
def test_a_text_names_them(text, material):
    assert brdf.parse(text) == material


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: brdf.AshikhminShirley(-1, 10), "AshikhminShirley: nu must be"),
        (lambda: brdf.AshikhminShirley(10, 1e13), "AshikhminShirley: nv must be"),
        (lambda: brdf.AshikhminShirley(10, 10, 1.5), "AshikhminShirley: Rs must be"),
        (lambda: brdf.AshikhminShirley(10, 10, 0.5, (0, 0, -1)), "AshikhminShirley: Rd must be"),
        (lambda: brdf.AnisotropicGGX(0.0, 0.1), "AnisotropicGGX: alpha_x must be"),
        (lambda: brdf.AnisotropicGGX(0.1, 2.0), "AnisotropicGGX: alpha_y must be"),
        (lambda: brdf.AnisotropicGGX(0.1, 0.1, 2.0), "AnisotropicGGX: f0 must be"),
    ],
)
def test_parameters_out_of_range_are_refused_by_name(make, text):
    with pytest.raises(ValueError, match=text):
        make()
