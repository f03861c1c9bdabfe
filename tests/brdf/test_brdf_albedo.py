"""Directional albedo: closed forms, independent rules, energy."""

import numpy as np
import pytest
from shrm import brdf
from support.directions import direction

# One lobe that is grey, and one of three channels whose exponents differ.
GREY_LOBE = brdf.Lafortune([-1.0], [-1.0], [0.9], [20.0])


VIEWS = np.array([1.0, 0.95, 0.7, 0.3, 0.1, 0.02, 0.0])


def test_albedo_of_lambert_is_its_albedo_for_every_view():
    np.testing.assert_allclose(brdf.directional_albedo(brdf.Lambert(0.7), VIEWS), 0.7, rtol=1e-13)
    rgb = np.array([0.1, 0.2, 0.3])
    np.testing.assert_allclose(
        brdf.directional_albedo(brdf.Lambert(rgb), VIEWS), np.tile(rgb, (len(VIEWS), 1)), rtol=1e-13
    )


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 7.0, 512.0, 1e6])
def test_integral_of_phong_over_the_sphere_is_1(exponent):
    np.testing.assert_allclose(brdf.directional_albedo(brdf.Phong(exponent), VIEWS), 1, rtol=1e-8)


def test_albedo_of_ggx_with_alpha_1_in_closed_form():
    # D = 1 / pi and G1(w) = 2 N.w / (1 + N.w): the integral is elementary.
    expected = 2 * (1 - np.log(2)) / (1 + VIEWS)
    np.testing.assert_allclose(brdf.directional_albedo(brdf.GGX(1.0), VIEWS)[:, 0], expected, rtol=1e-7)


def test_albedo_of_a_lafortune_lobe_in_closed_form():
    # rho_hat = (N.L)^2 N.V, then the exponent 1 about the normal: 2 pi / 3 N.V.
    lobe = brdf.Lafortune([0.0], [0.0], [1.0], [1.0])
    np.testing.assert_allclose(brdf.directional_albedo(lobe, VIEWS)[:, 0], 2 * np.pi / 3 * VIEWS, atol=1e-9)


def albedo_over_half_vectors(material, cos_v: float) -> float:
    """Integrate over H instead of L: dw_i = 4 (V.H) dw_h, tan(theta_h) graded from the narrowest lobe on."""
    x, w = np.polynomial.legendre.leggauss(24)
    edges = np.concatenate([[0.0], np.pi / 2 * 0.5 ** np.arange(14, -1, -1)])
    width = np.diff(edges)[:, None]
    theta = (edges[:-1, None] + width * (x + 1) / 2).ravel()
    weight = (width / 2 * w).ravel()
    phi = (np.arange(1000) + 0.5) * (np.pi / 1000)
    sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None]
    h = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine + 0 * phi], axis=-1).reshape(-1, 3)
    wo = np.broadcast_to(direction(cos_v, 0.0), h.shape)
    v_h = np.sum(wo * h, axis=1)
    wi = 2 * v_h[:, None] * h - wo
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    solid = (2 * np.pi / 1000 * weight * np.sin(theta))[:, None] + 0 * phi
    return float(np.sum(material.transfer(wi, wo) * np.where(v_h > 0, 4 * v_h, 0) * solid.ravel()))


@pytest.mark.slow
@pytest.mark.parametrize("cos_v", [1.0, 0.6, 0.15])
@pytest.mark.parametrize(
    "material",
    [brdf.GGX(0.02), brdf.GGX(0.4, 0.04), brdf.Beckmann(0.05), brdf.Beckmann(0.5)],
    ids=lambda m: m.name,
)
def test_albedo_agrees_with_an_integral_over_half_vectors(material, cos_v):
    # The other rule crosses the horizon, where rho_hat has a kink, on a grid of panels and of pi / 1000.
    other = albedo_over_half_vectors(material, cos_v)
    assert brdf.directional_albedo(material, [cos_v])[0, 0] == pytest.approx(other, abs=2e-5)


@pytest.mark.parametrize("cos_v", [0.9, 0.4, 0.1])
@pytest.mark.parametrize(
    "material",
    [brdf.Microfacet(0.2), brdf.GGX(0.4), brdf.Beckmann(0.3, (1.0, 0.5, 0.04)), GREY_LOBE],
    ids=lambda m: m.name,
)
def test_albedo_of_wide_lobes_agrees_with_a_product_rule_about_the_normal(material, cos_v):
    # Gauss in N.L, whose interval ends at the horizon, and the trapezoid rule in azimuth: both
    # converge geometrically for lobes as wide as these: half of the nodes already give 1e-4.
    x, w = np.polynomial.legendre.leggauss(300)
    phi = 2 * np.pi / 500 * np.arange(500)
    cosine = (x[:, None] + 1) / 2 + 0 * phi
    sine = np.sqrt(1 - cosine**2)
    wi = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1).reshape(-1, 3)
    weight = (w[:, None] / 2 * (2 * np.pi / 500) + 0 * phi).ravel()
    values = material.transfer(wi, np.broadcast_to(direction(cos_v, 0.3), wi.shape))
    np.testing.assert_allclose(brdf.directional_albedo(material, [cos_v])[0], weight @ values, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("model", [brdf.GGX, brdf.Beckmann])
@pytest.mark.parametrize("alpha", [1e-3, 0.03, 0.2, 0.6, 1.0])
def test_microfacets_do_not_reflect_more_than_they_receive(model, alpha):
    assert np.all(brdf.directional_albedo(model(alpha), VIEWS) <= 1 + 1e-7)


@pytest.mark.parametrize("model", [brdf.GGX, brdf.Beckmann])
def test_a_smooth_surface_reflects_fresnels_share(model):
    cosine = np.array([1.0, 0.8, 0.5])
    fresnel = 0.04 + 0.96 * (1 - cosine) ** 5
    albedo = brdf.directional_albedo(model(1e-3, 0.04), cosine)[:, 0]
    # The lobe spreads F over a width alpha: second order, alpha^2 log(1 / alpha) = 7e-6 here.
    np.testing.assert_allclose(albedo, fresnel, atol=2e-5)


def test_albedo_about_the_tangent_in_closed_form():
    assert brdf.directional_albedo(brdf.KajiyaKay(0.0), [0.0])[0, 0] == pytest.approx(4 * np.pi, rel=1e-12)
    for s in (0.0, 0.5, 0.99):  # along T: 2 pi times the integral of (u - s) / (1 - s)^2 from s to 1
        assert brdf.directional_albedo(brdf.Banks(s), [1.0])[0, 0] == pytest.approx(np.pi, rel=1e-6)


def test_albedo_of_a_sum_is_the_sum():
    a, b = brdf.Lambert((0.1, 0.2, 0.3)), brdf.GGX(0.3)
    total = brdf.directional_albedo(0.5 * a + 0.25 * b, VIEWS)
    parts = 0.5 * brdf.directional_albedo(a, VIEWS) + 0.25 * brdf.directional_albedo(b, VIEWS)
    assert total.shape == (len(VIEWS), 3)
    np.testing.assert_allclose(total, parts, rtol=1e-7)


@pytest.mark.parametrize("cosine", [[-0.1], [1.1], 0.5, [[0.5]], [np.nan]])
def test_albedo_refuses_cosines_out_of_range(cosine):
    with pytest.raises(ValueError, match="cos_theta_v must"):
        brdf.directional_albedo(brdf.GGX(0.3), cosine)
