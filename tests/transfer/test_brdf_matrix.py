"""BRDF matrices: rows against plain quadrature, the double projection and its extensions, tents."""

from functools import cache

import numpy as np
import pytest
from shrm import brdf
from shrm.transfer import brdf_matrix
from shrm.transfer.directional_basis import DirectionalBasis
from support import oracles
from support.directions import direction, hemisphere, turned

AS = brdf.AshikhminShirley(40, 10, 0.5)


def vectors(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    t, p = theta[:, None], phi[None, :]
    nodes = np.stack(np.broadcast_arrays(np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)), axis=-1)
    return nodes.reshape(-1, 3)


def product_rule(rings: int, azimuths: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss in theta above the horizon, midpoints in phi: directions and steradians."""
    x, w = np.polynomial.legendre.leggauss(rings)
    theta, phi = np.pi / 4 * (1 + x), (np.arange(azimuths) + 0.5) * 2 * np.pi / azimuths
    return vectors(theta, phi), np.repeat(np.pi / 4 * w * np.sin(theta) * 2 * np.pi / azimuths, azimuths)


def lights_of(view: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss in the cube root of theta - theta_v and of the azimuth from the mirror direction.

    So nodes are dense about the mirror direction, and cut at theta_v, where max(N.L, N.V) has a kink.
    """
    x, w = np.polynomial.legendre.leggauss(count)
    t, w = ((1 + x) / 2) ** 3, 3 * ((1 + x) / 2) ** 2 * w / 2
    theta_v = np.arctan2(np.hypot(view[0], view[1]), view[2])
    theta = np.concatenate([theta_v * (1 - t), theta_v + (np.pi / 2 - theta_v) * t])
    phi = np.arctan2(view[1], view[0]) + np.pi + np.pi * np.concatenate([-t, t])
    w_theta = np.concatenate([theta_v * w, (np.pi / 2 - theta_v) * w]) * np.sin(theta)
    return vectors(theta, phi), np.outer(w_theta, np.pi * np.concatenate([w, w])).ravel()


def plain_rows(transfer, views: np.ndarray, n: int, count: int) -> np.ndarray:
    rows = []
    for view in views:
        nodes, weights = lights_of(view, count)
        rows.append(oracles.real_harmonics(n - 1, nodes).T @ (weights * transfer(nodes, view[None])))
    return np.array(rows)


def kajiya_kay_about_x(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Its frame has z = T."""
    return oracles.kajiya_kay(16.0)(wi[:, [1, 2, 0]], wo[:, [1, 2, 0]])


VIEWS = np.concatenate(
    [direction(c, phi) for c, phi in ((1, 0), (0.95, 0.3), (0.7, 2.0), (0.5, -1.0), (0.3, np.pi), (0.1, 4.0))]
)

# The rows


@pytest.mark.parametrize(
    ("material", "transfer"),
    [
        (brdf.Lambert(0.7), oracles.lambert(0.7)),
        (brdf.Phong(20), oracles.phong(20)),  # cut at the horizon
        (brdf.Microfacet(0.3), oracles.microfacet(0.3)),
        (brdf.GGX(0.3, 0.2), oracles.ggx(0.3, 0.2)),
        (brdf.GGX(0.3, 0.2).recentered("normal"), oracles.ggx(0.3, 0.2)),
        (AS, oracles.ashikhmin_shirley(40, 10, 0.5)),
        (brdf.AshikhminShirley(30, 90, 0.3, 0.6), oracles.ashikhmin_shirley(30, 90, 0.3, 0.6)),
        (brdf.AnisotropicGGX(0.5, 0.2), oracles.anisotropic_ggx(0.5, 0.2)),
        (brdf.KajiyaKay(16.0), kajiya_kay_about_x),
    ],
    ids=lambda m: getattr(m, "name", ""),
)
def test_rows_are_integrals_over_the_lights_above_the_horizon(material, transfer):
    expected = plain_rows(transfer, VIEWS, 5, 64)
    actual = brdf_matrix.rows(material, VIEWS, 5)
    # Accepted of the rows' quadrature is 1e-4; the plain one is better but for cones.
    np.testing.assert_allclose(actual, expected, atol=2e-4 * np.abs(expected).max())


def test_lamberts_rows_in_closed_form():
    row = np.zeros(9)
    row[[0, 2, 6]] = [np.sqrt(1 / (4 * np.pi)), np.sqrt(1 / (3 * np.pi)), np.sqrt(5 / np.pi) / 8]
    actual = brdf_matrix.rows(brdf.Lambert((0.2, 0.5, 1.0)), VIEWS, 3)
    expected = np.array([0.2, 0.5, 1.0])[:, None, None] * np.tile(row, (len(VIEWS), 1))
    np.testing.assert_allclose(actual, expected, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "material",
    [brdf.GGX(0.02), brdf.GGX(0.3, (0.04, 0.5, 1.0)), brdf.Beckmann(0.1), AS, brdf.AnisotropicGGX(0.1, 0.4)],
    ids=lambda m: m.name,
)
def test_under_a_constant_light_they_are_the_directional_albedo(material):
    cosines = np.array([1.0, 0.8, 0.4, 0.05])
    views = np.concatenate([direction(c, 0.9) for c in cosines])
    rows = np.atleast_3d(brdf_matrix.rows(material, views, 1).T).T
    albedo = brdf.directional_albedo(material, cosines, 0.9)
    np.testing.assert_allclose(np.sqrt(4 * np.pi) * rows[:, :, 0].T, albedo, atol=2e-4)


@pytest.mark.parametrize("material", [brdf.GGX(0.2), brdf.Lambert(0.5) + brdf.Phong(8)], ids=lambda m: m.name)
def test_rows_of_isotropic_materials_turn_with_the_view(material):
    angle = 1.1
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    expected = oracles.rotated_coefficients(brdf_matrix.rows(material, VIEWS, 6).T, R).T
    np.testing.assert_allclose(
        brdf_matrix.rows(material, turned(VIEWS, angle), 6), expected, atol=1e-10 * np.abs(expected).max()
    )


def test_rows_are_linear_in_the_material():
    a, b = brdf.Lambert((0.2, 0.4, 0.6)), AS
    both = brdf_matrix.rows(a + (1.0, 0.5, 0.0) * b, VIEWS, 4)
    weights = np.array([1.0, 0.5, 0.0])[:, None, None]
    expected = brdf_matrix.rows(a, VIEWS, 4) + weights * brdf_matrix.rows(b, VIEWS, 4)
    np.testing.assert_allclose(both, expected, atol=1e-12)


def test_a_black_material_has_black_rows():
    found = brdf_matrix.project(brdf.Lambert(0.0), 4, 3)
    assert not found.coefficients.any()
    assert found.snr == np.inf


# The double projection

GLOSSY = {
    (40, 40): {"least-squares": 33.0, "even": 28.0, "zero": 15.3},
    (40, 10): {"least-squares": 33.0, "even": 26.1, "zero": 14.2},
}


@pytest.fixture(scope="module")
def matrices() -> dict:
    return {
        (exponents, extension): brdf_matrix.project(
            brdf.AshikhminShirley(*exponents, 0.5), 8, 5, extension=extension
        )
        for exponents in GLOSSY
        for extension in GLOSSY[exponents]
    }


@pytest.mark.slow
@pytest.mark.parametrize("exponents", GLOSSY)
def test_what_the_extensions_keep_of_glossy_materials(matrices, exponents):
    snr = {extension: matrices[exponents, extension].snr for extension in GLOSSY[exponents]}
    assert snr["least-squares"] > GLOSSY[exponents]["least-squares"]
    for extension in ("even", "zero"):  # closed forms but for quadrature
        assert snr[extension] == pytest.approx(GLOSSY[exponents][extension], abs=0.1)


def test_the_even_mirror_holds_lambert():
    assert brdf_matrix.project(brdf.Lambert(0.5), 8, 5, extension="even").snr > 200
    assert brdf_matrix.project(brdf.Lambert(0.5), 8, 5).snr > 40


@cache
def glossy_rows() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Views in one quarter of the hemisphere, whose mirror images are the rest, and their rows."""
    views, weights = product_rule(20, 24)
    quarter = (views[:, 0] > 0) & (views[:, 1] > 0)
    views = views[quarter]
    return views, weights[quarter], plain_rows(oracles.ashikhmin_shirley(40, 10, 0.5), views, 5, 32)


@pytest.mark.slow
@pytest.mark.parametrize("extension", ["least-squares", "even", "zero"])
def test_the_snr_is_that_of_reflected_radiance(matrices, extension):
    made = matrices[(40, 10), extension]
    views, weights, rows = glossy_rows()
    off = rows - oracles.real_harmonics(7, views) @ made.coefficients
    # Lights l ~ N(0, I): the mean of (b.l)^2 is |b|^2.
    snr = 10 * np.log10((weights @ rows**2).sum() / (weights @ off**2).sum())
    assert made.snr == pytest.approx(snr, abs=0.1)
    assert made.quadrature_error <= brdf_matrix.QUADRATURE_ERROR


def test_least_squares_leaves_least():
    material, m, n = brdf.GGX(0.4), 6, 4
    B = brdf_matrix.project(material, m, n).coefficients
    views, weights = product_rule(60, 4 * m)
    rows, Y = brdf_matrix.rows(material, views, n), oracles.real_harmonics(m - 1, views)

    def objective(B: np.ndarray) -> float:
        return float((weights @ (rows - Y @ B) ** 2).sum() + brdf_matrix.RIDGE * (B**2).sum())

    # At a minimum all directions lead up by as much as their opposites.
    rng, least = np.random.default_rng(1), objective(B)
    for _ in range(10):
        step = 1e-2 * rng.normal(size=B.shape)
        up, down = objective(B + step) - least, objective(B - step) - least
        assert min(up, down) > 0
        assert up == pytest.approx(down, rel=1e-3)


def test_zero_and_even_extensions_differ_by_parity():
    zero = brdf_matrix.project(brdf.GGX(0.3), 6, 4, extension="zero").coefficients
    even = brdf_matrix.project(brdf.GGX(0.3), 6, 4, extension="even").coefficients
    mirrored = oracles.real_harmonics(5, hemisphere(1, 2) * [1, 1, -1]) / oracles.real_harmonics(
        5, hemisphere(1, 2)
    )
    np.testing.assert_allclose(even, (1 + mirrored.T) * zero, atol=1e-12)


def test_a_window_damps_the_degrees_above():
    degree = np.floor(np.sqrt(np.arange(64)))
    whole = brdf_matrix.project(brdf.GGX(0.3), 8, 4)
    windowed = brdf_matrix.project(brdf.GGX(0.3), 8, 4, window_above=5)
    weights = np.select([degree <= 5, degree == 6, degree == 7], [1, 0.75, 0.25])
    np.testing.assert_allclose(windowed.coefficients, weights[:, None] * whole.coefficients, atol=1e-15)
    assert windowed.snr < whole.snr
    assert windowed.window_above == 5


def test_the_nodes_of_the_view_suffice(monkeypatch):
    coarse = brdf_matrix.project(AS, 4, 3)
    quadrature = brdf_matrix.hemisphere_quadrature
    monkeypatch.setattr(
        brdf_matrix, "hemisphere_quadrature", lambda rings, azimuths: quadrature(2 * rings, 2 * azimuths)
    )
    brdf_matrix._over_hemisphere.cache_clear()
    fine = brdf_matrix.project(AS, 4, 3)
    brdf_matrix._over_hemisphere.cache_clear()
    difference = np.linalg.norm(fine.coefficients - coarse.coefficients) / np.linalg.norm(fine.coefficients)
    assert difference < 2 * brdf_matrix.QUADRATURE_ERROR  # the rows of both err by it
    assert fine.snr == pytest.approx(coarse.snr, abs=0.05)


def test_channels_come_first():
    made = brdf_matrix.project(brdf.GGX(0.3, (1.0, 0.5, 0.04)), 5, 3)
    assert made.coefficients.shape == (3, 25, 9)
    red = brdf_matrix.project(brdf.GGX(0.3), 5, 3)
    np.testing.assert_allclose(made.coefficients[0], red.coefficients, atol=brdf_matrix.QUADRATURE_ERROR)


# Tents


def test_lambert_on_tents_is_constant():
    basis = DirectionalBasis(5)
    on_tents = brdf_matrix.project_on_tents(brdf.Lambert(0.5), basis, 4)
    np.testing.assert_allclose(
        on_tents, np.tile(brdf_matrix.rows(brdf.Lambert(0.5), VIEWS[:1], 4), (25, 1)), atol=1e-12
    )


def test_straight_on_tents_keeps_more_than_by_way_of_harmonics():
    basis, material, n = DirectionalBasis(9), brdf.GGX(0.3), 4
    views, weights = product_rule(60, 61)
    rows = brdf_matrix.rows(material, views, n)

    def lost(on_tents: np.ndarray) -> float:
        return float((weights @ (rows - basis.evaluate(on_tents, views)) ** 2).sum())

    straight = lost(brdf_matrix.project_on_tents(material, basis, n))
    errors = [
        lost(basis.project_coefficients(brdf_matrix.project(material, m, n).coefficients)) for m in (4, 6, 8)
    ]
    assert straight < min(errors)
    assert errors == sorted(errors, reverse=True)


# At the door


def test_a_lobe_too_sharp_for_the_nodes_warns(monkeypatch):
    monkeypatch.setattr(brdf_matrix, "_NODES", brdf_matrix._NODES[:2])
    with pytest.warns(RuntimeWarning, match="rows are only known to"):
        brdf_matrix.rows(brdf.AnisotropicGGX(1e-4, 1.0), VIEWS[:1], 1)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: brdf_matrix.project("ggx", 4, 4), TypeError, "brdf must be a material"),
        (lambda: brdf_matrix.project(AS, 0, 4), ValueError, "m must be in"),
        (lambda: brdf_matrix.project(AS, 4, 33), ValueError, "n must be in"),
        (lambda: brdf_matrix.project(AS, 4, 4, extension="odd"), ValueError, "extension must be one of"),
        (lambda: brdf_matrix.project(AS, 4, 4, window_above=4), ValueError, "window_above must be in"),
        (lambda: brdf_matrix.rows(AS, [[0, 0, -1.0]], 4), ValueError, "views must be above the horizon"),
        (lambda: brdf_matrix.rows(AS, np.zeros((0, 3)), 4), ValueError, "views must be at least one"),
        (lambda: brdf_matrix.rows(AS, [[0, 0, 2.0]], 4), ValueError, "views must be unit"),
        (lambda: brdf_matrix.project_on_tents(AS, 11, 4), TypeError, "basis must be a DirectionalBasis"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(call, error, text):
    with pytest.raises(error, match=text):
        call()
