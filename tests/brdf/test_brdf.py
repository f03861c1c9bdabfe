"""Materials: their values against formulas written here, and the properties they must have."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special
from shrm import brdf
from shrm.frequency import orders
from shrm.frequency.analysis import analyse
from support.directions import direction, hemisphere, sphere, turned

# One lobe that is grey, and one of three channels whose exponents differ.
GREY_LOBE = brdf.Lafortune([-1.0], [-1.0], [0.9], [20.0])
RGB_LOBES = brdf.Lafortune(
    x=[[-1.1, -1.0, -0.9], [-0.5, -0.6, -0.7]],
    y=[[-1.1, -1.0, -0.9], [-0.5, -0.6, -0.7]],
    z=[[0.8, 0.7, 0.6], [0.4, 0.4, -0.3]],
    exponent=[[30.0, 20.0, 10.0], [3.0, 0.0, 2.5]],
    diffuse=(0.3, 0.2, 0.1),
)
ABOUT_NORMAL = [
    brdf.Lambert(0.8),
    brdf.Lambert((0.8, 0.5, 0.1)),
    brdf.Phong(0.0),
    brdf.Phong(64.0),
    brdf.Microfacet(0.2),
    brdf.GGX(0.05),
    brdf.GGX(0.7, (1.0, 0.5, 0.04)),
    brdf.Beckmann(0.05),
    brdf.Beckmann(0.7, (1.0, 0.5, 0.04)),
    GREY_LOBE,
    RGB_LOBES,
    0.5 * brdf.Lambert(0.8) + (0.1, 0.2, 0.3) * brdf.GGX(0.2),
]
ABOUT_TANGENT = [
    brdf.KajiyaKay(32.0),
    brdf.KajiyaKay(0.0),
    brdf.KajiyaKay(5.0, "mirror"),
    brdf.Banks(0.0),
    brdf.Banks(0.9),
]


# Values -------------------------------------------------------------------------------------------


def ggx_by_angles(alpha: float, f0: float, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    tan2 = np.tan(np.arccos(h[:, 2])) ** 2
    D = alpha**2 / (np.pi * h[:, 2] ** 4 * (alpha**2 + tan2) ** 2)  # Walter et al. 2007, eq. 33
    g1 = [2 / (1 + np.sqrt(1 + alpha**2 * np.tan(np.arccos(w[:, 2])) ** 2)) for w in (wi, wo)]  # eq. 34
    F = f0 + (1 - f0) * (1 - np.einsum("nc,nc->n", wi, h)) ** 5
    return D * g1[0] * g1[1] * F / (4 * wi[:, 2] * wo[:, 2]) * wi[:, 2]


def beckmann_by_angles(alpha: float, f0: float, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    tan2 = np.tan(np.arccos(h[:, 2])) ** 2
    D = np.exp(-tan2 / alpha**2) / (np.pi * alpha**2 * h[:, 2] ** 4)  # Walter et al. 2007, eq. 25
    g1 = []
    for w in (wi, wo):  # 1 / (1 + Lambda), Lambda = exp(-a^2) / (2 a sqrt(pi)) - erfc(a) / 2
        a = 1 / (alpha * np.tan(np.arccos(w[:, 2])))
        g1.append(1 / (1 + np.exp(-(a**2)) / (2 * a * np.sqrt(np.pi)) - special.erfc(a) / 2))
    F = f0 + (1 - f0) * (1 - np.einsum("nc,nc->n", wi, h)) ** 5
    return D * g1[0] * g1[1] * F / (4 * wo[:, 2])


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
@pytest.mark.parametrize(
    ("model", "formula"), [(brdf.GGX, ggx_by_angles), (brdf.Beckmann, beckmann_by_angles)]
)
def test_microfacets_follow_the_formulas_in_angles(model, formula, alpha):
    wi, wo = hemisphere(4000, 1), hemisphere(4000, 2)
    wi[:2000] = wo[:2000] * [-1, -1, 1] + 0.1 * wi[:2000]  # most of the energy is here
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    # tan(acos(z)) loses digits near the normal: 1e-16 / theta^2, and alpha^2 divides it.
    np.testing.assert_allclose(
        model(alpha, 0.3).transfer(wi, wo), formula(alpha, 0.3, wi, wo), rtol=1e-8, atol=1e-12
    )


@pytest.mark.parametrize("model", [brdf.GGX, brdf.Beckmann])
def test_head_on_only_the_peak_of_d_remains(model):
    z = np.array([[0.0, 0.0, 1.0]])
    assert model(0.1, 0.5).transfer(z, z) == pytest.approx(0.5 / (4 * np.pi * 0.01), rel=1e-14)
    np.testing.assert_allclose(
        model(0.1, (0.1, 0.2, 0.3)).transfer(z, z),
        np.array([[0.1, 0.2, 0.3]]) / (4 * np.pi * 0.01),
        rtol=1e-14,
    )


def test_microfacet_is_equation_11():
    wi, wo = hemisphere(2000, 3), hemisphere(2000, 4)
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    expected = np.exp(-((np.arccos(h[:, 2]) / 0.2) ** 2)) / (4 * np.pi * 0.2**2)
    np.testing.assert_allclose(brdf.Microfacet(0.2).transfer(wi, wo), expected, rtol=1e-11)


def test_phong_is_a_power_of_the_cosine_to_the_reflection():
    wi, wo = sphere(2000, 5), sphere(2000, 6)
    r = 2 * wo[:, 2:] * [0, 0, 1] - wo
    expected = 21 / (2 * np.pi) * np.maximum(np.sum(r * wi, axis=1), 0) ** 20
    np.testing.assert_allclose(brdf.Phong(20).transfer(wi, wo), expected, rtol=1e-12, atol=1e-15)


def test_lambert_is_a_cosine():
    wi, wo = sphere(2000, 7), sphere(2000, 8)
    cosine = np.maximum(wi[:, 2:], 0)
    np.testing.assert_allclose(brdf.Lambert(0.5).transfer(wi, wo), 0.5 / np.pi * cosine[:, 0], rtol=1e-15)
    rgb = np.array([0.1, 0.2, 0.3])
    np.testing.assert_allclose(brdf.Lambert(rgb).transfer(wi, wo), cosine * rgb / np.pi, rtol=1e-14)


def test_lafortune_is_the_sum_of_its_lobes_and_its_diffuse_part():
    wi, wo = hemisphere(300, 9), hemisphere(300, 10)
    for n in range(300):
        for c in range(3):
            value = RGB_LOBES.diffuse[c] / np.pi
            for k in range(2):
                C = np.diag([RGB_LOBES.x[k][c], RGB_LOBES.y[k][c], RGB_LOBES.z[k][c]])
                dot = wi[n] @ C @ wo[n]
                value += dot ** RGB_LOBES.exponent[k][c] if dot > 0 else 0.0
            assert RGB_LOBES.transfer(wi[n : n + 1], wo[n : n + 1])[0, c] == pytest.approx(
                value * wi[n, 2], rel=1e-12
            )


def test_lafortune_with_unit_coefficients_is_phong_times_the_cosine():
    wi, wo = hemisphere(500, 11), hemisphere(500, 12)
    phong = brdf.Phong(20).transfer(wi, wo) * (2 * np.pi / 21)
    lobe = brdf.Lafortune([-1], [-1], [1], [20])
    np.testing.assert_allclose(lobe.transfer(wi, wo), phong * wi[:, 2], rtol=1e-11, atol=1e-15)


@pytest.mark.parametrize(("cone", "sign"), [("paper", 1), ("mirror", -1)])
def test_kajiya_kay_in_dot_products(cone, sign):
    wi, wo = sphere(2000, 13), sphere(2000, 14)
    sines = np.sqrt(1 - wi[:, 2] ** 2) * np.sqrt(1 - wo[:, 2] ** 2)
    expected = np.maximum(sines + sign * wi[:, 2] * wo[:, 2], 0) ** 8
    np.testing.assert_allclose(brdf.KajiyaKay(8, cone).transfer(wi, wo), expected, rtol=1e-9, atol=1e-14)


def test_kajiya_kay_mirror_cone_holds_the_mirror_direction():
    # Whatever the normal across the fibre, the mirror direction is on the cone theta_i = pi - theta_o.
    wo, normal = sphere(100, 15), sphere(100, 16)
    normal[:, 2] = 0
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    mirror = 2 * np.sum(wo * normal, axis=1, keepdims=True) * normal - wo
    np.testing.assert_allclose(brdf.KajiyaKay(64, "mirror").transfer(mirror, wo), 1, atol=1e-12)


def test_banks_is_the_printed_formula():
    wi, wo = sphere(2000, 17), sphere(2000, 18)
    lt, vt = wi[:, 2], wo[:, 2]
    printed = (np.sqrt(1 - lt**2) * np.sqrt(1 - vt**2) - lt * vt - 0.4) / (1 - 0.4) ** 2
    np.testing.assert_allclose(brdf.Banks(0.4).transfer(wi, wo), np.maximum(printed, 0), atol=1e-13)


# Symmetries and horizons --------------------------------------------------------------------------


@pytest.mark.parametrize("material", [*ABOUT_NORMAL, *ABOUT_TANGENT], ids=lambda m: m.name)
def test_turning_and_mirroring_both_directions_changes_nothing(material):
    wi, wo = sphere(1000, 19), sphere(1000, 20)
    value = material.transfer(wi, wo)
    np.testing.assert_allclose(
        material.transfer(turned(wi, 2.1), turned(wo, 2.1)), value, rtol=1e-9, atol=1e-13
    )
    mirror = [1, -1, 1]
    np.testing.assert_allclose(material.transfer(wi * mirror, wo * mirror), value, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    "material",
    [brdf.GGX(0.2, 0.3), brdf.Beckmann(0.2, (0.1, 0.2, 1.0)), RGB_LOBES, brdf.Lambert(0.4)],
    ids=lambda m: m.name,
)
def test_reciprocity(material):
    wi, wo = hemisphere(2000, 21), hemisphere(2000, 22)
    forward, backward = material.transfer(wi, wo), material.transfer(wo, wi)
    by_row = (slice(None),) + (None,) * (forward.ndim - 1)
    np.testing.assert_allclose(forward / wi[:, 2][by_row], backward / wo[:, 2][by_row], rtol=1e-9)


@pytest.mark.parametrize(
    "material", [brdf.Microfacet(0.3), brdf.GGX(0.3), brdf.Beckmann(0.3), GREY_LOBE], ids=lambda m: m.name
)
def test_nothing_comes_from_below_the_horizon_or_goes_there(material):
    wi, wo = sphere(4000, 23), sphere(4000, 24)
    above = (wi[:, 2] > 0) & (wo[:, 2] >= 0)
    value = material.transfer(wi, wo)
    assert np.all(value[~above] == 0)
    assert np.all(material.transfer(direction(0.0, 1.0), direction(0.5, 0.0)) == 0)  # N.L = 0


grazing = st.sampled_from([0.0, 1e-300, 1e-30, 1e-16, 1e-12, 1e-8, 1e-4, 0.1, 0.5, 1 - 1e-8, 1 - 1e-16, 1.0])
cosines = st.one_of(grazing, grazing.map(lambda c: -c), st.floats(-1.0, 1.0))
azimuths = st.one_of(st.sampled_from([0.0, np.pi, np.pi / 2, 1e-12]), st.floats(0.0, 2 * np.pi))
unit = st.floats(0.0, 1.0)
reflectance = st.one_of(unit, st.tuples(unit, unit, unit))
widths = st.one_of(st.sampled_from([1e-6, 1e-3, 1.0]), st.floats(1e-6, 1.0))
exponents = st.one_of(st.sampled_from([0.0, 1e-3, 1e6, 1e12]), st.floats(0.0, 1e4))
coefficients = st.floats(-1.5, 1.5)
materials = st.one_of(
    st.builds(brdf.Lambert, reflectance),
    st.builds(brdf.Phong, exponents),
    st.builds(brdf.Microfacet, st.one_of(widths, st.floats(1.0, 1e200))),
    st.builds(brdf.GGX, widths, reflectance),
    st.builds(brdf.Beckmann, widths, reflectance),
    st.builds(brdf.KajiyaKay, exponents, st.sampled_from(["paper", "mirror"])),
    st.builds(brdf.Banks, st.floats(0.0, 1 - 1e-6)),
    st.builds(
        lambda xy, z, e, d: brdf.Lafortune([xy], [xy], [z], [e], d),
        coefficients,
        coefficients,
        st.floats(0.0, 170.0),
        reflectance,
    ),
)


@pytest.mark.slow
@settings(max_examples=600)
@given(materials, cosines, azimuths, cosines, azimuths)
def test_values_are_finite_and_not_negative_everywhere(material, cos_i, phi_i, cos_o, phi_o):
    value = material.transfer(direction(cos_i, phi_i), direction(cos_o, phi_o))
    assert value.dtype == np.float64
    assert value.shape == ((1,) if material.channels == 1 else (1, 3))
    assert np.all(np.isfinite(value))
    assert np.all(value >= 0)


# Energy -------------------------------------------------------------------------------------------

VIEWS = np.array([1.0, 0.95, 0.7, 0.3, 0.1, 0.02, 0.0])


# Sums, products, centers --------------------------------------------------------------------------


def test_sums_and_products_are_those_of_their_values():
    a, b = brdf.GGX(0.3), RGB_LOBES
    wi, wo = hemisphere(100, 25), hemisphere(100, 26)
    va, vb = a.transfer(wi, wo), b.transfer(wi, wo)
    np.testing.assert_allclose((a + b).transfer(wi, wo), va[:, None] + vb, rtol=1e-13)
    np.testing.assert_allclose((2 * a).transfer(wi, wo), 2 * va, rtol=1e-14)
    rgb = np.array([0.5, 1.0, 2.0])
    for product in (rgb * a, a * rgb, (0.5, 1, 2) * a, a * [0.5, 1, 2]):
        np.testing.assert_allclose(product.transfer(wi, wo), va[:, None] * rgb, rtol=1e-14)
        assert product.channels == 3
    assert (np.float64(0.5) * a).name == "0.5*ggx(alpha=0.3)"
    assert ((1, 0.5, 0.2) * (a + brdf.Lambert(1))).name == (
        "1/0.5/0.2*ggx(alpha=0.3) + 1/0.5/0.2*lambert(albedo=1)"
    )
    assert [lobe.center for lobe in (a + b).lobes] == ["lobe", "lobe", "normal"]


@pytest.mark.parametrize(
    ("factor", "error"), [(-1, ValueError), (np.nan, ValueError), ((1, 2), TypeError), ("2", TypeError)]
)
def test_impossible_factors_are_refused(factor, error):
    with pytest.raises(error, match="factor must be"):
        brdf.GGX(0.3) * factor


def test_a_material_has_its_centers():
    def centers(material):
        return [(type(lobe).__name__, lobe.center) for lobe in material.lobes]

    assert centers(brdf.Lambert(1)) == [("RadialLobe", "normal")]
    assert centers(brdf.Phong(1)) == [("RadialLobe", "reflection")]
    for material in (brdf.Microfacet(0.1), brdf.GGX(0.1), brdf.Beckmann(0.1), GREY_LOBE):
        assert centers(material) == [("IsotropicLobe", "lobe")]
    assert centers(RGB_LOBES) == [("IsotropicLobe", "lobe"), ("RadialLobe", "normal")]
    for material in (brdf.KajiyaKay(1), brdf.Banks(0)):
        assert centers(material) == [("ZonalLobe", "tangent")]


def test_recentring_moves_isotropic_lobes_and_keeps_the_values():
    material = RGB_LOBES + brdf.Phong(5)
    wi, wo = hemisphere(100, 27), hemisphere(100, 28)
    for center in ("reflection", "normal", "lobe"):
        moved = material.recentered(center)
        assert [lobe.center for lobe in moved.lobes] == [center, "normal", "reflection"]
        assert moved.name == material.name
        np.testing.assert_array_equal(moved.transfer(wi, wo), material.transfer(wi, wo))


def test_merging_makes_one_lobe_of_all():
    wi, wo = sphere(500, 29), hemisphere(500, 30)
    merged = RGB_LOBES.recentered("reflection", merge=True)
    assert len(merged.lobes) == 1
    assert isinstance(merged.lobes[0], brdf.IsotropicLobe)
    assert merged.lobes[0].center == "reflection"
    np.testing.assert_allclose(merged.transfer(wi, wo), RGB_LOBES.transfer(wi, wo), rtol=1e-14)


@pytest.mark.parametrize(
    ("material", "center", "merge", "reason"),
    [
        (brdf.KajiyaKay(8), "reflection", False, "no normal"),
        (brdf.Banks(0.5), "lobe", False, "no normal"),
        (brdf.GGX(0.1), "tangent", False, "depends on it"),
        (brdf.GGX(0.1) + brdf.KajiyaKay(8), "normal", False, "no normal"),
        (brdf.KajiyaKay(8), "tangent", True, "no normal"),
        (brdf.Phong(8) + brdf.Lambert(1), "reflection", True, "no horizon"),
        (brdf.GGX(0.1), "half", False, "center must be one of"),
    ],
)
def test_impossible_centers_are_refused_with_the_reason(material, center, merge, reason):
    with pytest.raises(ValueError, match=reason):
        material.recentered(center, merge=merge)


def test_lobes_of_two_frames_cannot_be_evaluated_together():
    both = brdf.Lambert(0.5) + brdf.KajiyaKay(8)
    with pytest.raises(ValueError, match="share no frame"):
        both.transfer(hemisphere(2, 0), hemisphere(2, 1))


@pytest.mark.parametrize(
    ("wi", "error", "text"),
    [
        (np.zeros((4, 3)), ValueError, "wi must be unit vectors"),
        (np.full((4, 3), np.nan), ValueError, "wi must be finite"),
        (np.array([0.0, 0.0, 1.0]), ValueError, r"wi must have the shape \(n, 3\), got \(3,\)"),
        (hemisphere(5, 0), ValueError, "same shape"),
        (np.full((4, 3), "z"), TypeError, "wi must be an array of real numbers"),
        (hemisphere(4, 0) * 1j, TypeError, "wi must be an array of real numbers"),
    ],
)
def test_directions_that_are_none_are_refused(wi, error, text):
    with pytest.raises(error, match=text):
        brdf.GGX(0.1).transfer(wi, hemisphere(4, 0))


def test_float32_and_empty_directions_are_taken():
    wi = hemisphere(4, 0).astype(np.float32)
    assert brdf.GGX(0.1).transfer(wi, wi).dtype == np.float64
    assert brdf.GGX(0.1, (1, 1, 1)).transfer(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 3)


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: brdf.Lambert(1.5), ValueError, r"Lambert: albedo must be in \[0, 1\], got 1.5"),
        (lambda: brdf.Lambert((0.1, 0.2)), TypeError, "albedo must be a number or three"),
        (lambda: brdf.Lambert((0.1, 0.2, -0.1)), ValueError, "albedo"),
        (lambda: brdf.Lambert(None), TypeError, "albedo"),
        (lambda: brdf.Phong(-1), ValueError, r"Phong: exponent must be in \[0, 1e\+12\], got -1"),
        (lambda: brdf.Phong(np.inf), ValueError, "exponent"),
        (lambda: brdf.Microfacet(0), ValueError, "Microfacet: sigma must be at least 1e-06, got 0"),
        (lambda: brdf.Microfacet("rough"), TypeError, "sigma must be a number, got 'rough'"),
        (lambda: brdf.Microfacet(True), TypeError, "sigma"),
        (lambda: brdf.GGX(0), ValueError, r"GGX: alpha must be in \[1e-06, 1\], got 0"),
        (lambda: brdf.GGX(1.1), ValueError, "GGX: alpha"),
        (lambda: brdf.GGX(np.nan), ValueError, "GGX: alpha"),
        (lambda: brdf.GGX(0.1, 2), ValueError, "GGX: f0"),
        (lambda: brdf.Beckmann(0), ValueError, "Beckmann: alpha"),
        (lambda: brdf.Beckmann(0.5, (0, 0, 2)), ValueError, "Beckmann: f0"),
        (lambda: brdf.KajiyaKay(-1), ValueError, "KajiyaKay: exponent"),
        (lambda: brdf.KajiyaKay(1, "hair"), ValueError, "cone must be one of paper, mirror, got 'hair'"),
        (lambda: brdf.Banks(1), ValueError, "Banks: sharpness"),
        (lambda: brdf.Banks(-0.1), ValueError, "Banks: sharpness"),
        (lambda: brdf.Lafortune([-1], [-0.5], [1], [5]), ValueError, "absolute azimuth"),
        (
            lambda: brdf.Lafortune([-1], [-1], [1], [-5]),
            ValueError,
            r"must be in \[0, 1e\+12\], got -5",
        ),
        (lambda: brdf.Lafortune([-2], [-2], [1], [500]), ValueError, "exponent"),
        (lambda: brdf.Lafortune([-1], [-1], [1, 1], [5]), ValueError, "must share the shape"),
        (lambda: brdf.Lafortune([-1], [-1], [1], [5], 1.5), ValueError, "diffuse"),
        (lambda: brdf.Tabulated(np.ones((4, 4))), ValueError, "values must have the shape"),
        (lambda: brdf.Tabulated(np.ones((4, 1, 4))), ValueError, "values must have the shape"),
        (lambda: brdf.Tabulated(-np.ones((4, 4, 4))), ValueError, r"values must be in \[0, 1e\+30\], got -1"),
        (lambda: brdf.Tabulated(np.ones((4, 4, 4)), "polar"), ValueError, "axes must be"),
        (lambda: brdf.RadialLobe("tangent", np.abs), ValueError, "center must be one of"),
        (lambda: brdf.IsotropicLobe("tangent", np.add), ValueError, "center must be one of"),
        (lambda: brdf.Material((), "none"), TypeError, "lobes must be"),
    ],
)
def test_parameters_out_of_range_are_refused_by_name(make, error, text):
    with pytest.raises(error, match=text) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_equal_materials_about_another_center_are_one():
    analyse.cache_clear()
    for merge in (False, True):
        for _ in range(2):
            orders.analysed(brdf.GGX(0.3).recentered("reflection", merge=merge), 8, 2)
    assert analyse.cache_info()[:2] == (2, 2)  # hits, misses
    assert brdf.GGX(0.3).recentered("reflection") is brdf.GGX(0.3).recentered("reflection")
    assert brdf.GGX(0.3).recentered("reflection") is not brdf.GGX(0.3).recentered("lobe")
    assert brdf.GGX(0.3).recentered("reflection") is not brdf.GGX(0.4).recentered("reflection")


def test_materials_that_change_are_recentered_anew():
    class Changing(brdf.BRDF):
        alpha = 0.3
        name = "changing"

        @property
        def lobes(self):
            return brdf.GGX(self.alpha).lobes

    @dataclasses.dataclass
    class Unhashable(Changing):
        alpha: float = 0.3

    above = np.array([[0.0, 0.0, 1.0]])
    for material in (Changing(), Unhashable()):
        before = material.recentered("reflection").transfer(above, above)
        material.alpha = 0.6
        after = material.recentered("reflection").transfer(above, above)
        np.testing.assert_allclose(after, brdf.GGX(0.6).transfer(above, above))
        assert before > 2 * after
