"""Color from spectra of reflectance, against colors that are known without it."""

import numpy as np
import pytest
from shrm.brdf.measured.spectrum import D65, OBSERVER, WAVELENGTHS, to_linear_srgb, to_xyz

# Averages of thirty charts, 380 to 730 nm in steps of 10 nm (D. Pascale, The ColorChecker, BabelColor 2012).
DARK_SKIN = """.055 .058 .061 .062 .062 .062 .062 .062 .062 .062 .062 .063 .065 .070 .076 .079 .081 .084 .091
.103 .119 .134 .143 .147 .151 .158 .168 .179 .188 .190 .186 .181 .182 .187 .196 .209"""
RED = """.050 .049 .048 .047 .047 .047 .047 .047 .046 .045 .044 .044 .045 .046 .047 .048 .049 .050 .054 .060
.072 .104 .178 .312 .467 .581 .644 .675 .690 .698 .706 .715 .724 .730 .734 .738"""


def chromaticity(spectrum):
    xyz = OBSERVER @ spectrum
    return xyz[:2] / xyz.sum()


def test_the_illuminants_have_their_published_chromaticities():
    # CIE 15:2004, table T.3, to the digits that are common to sums in steps of 1 and of 5 nm.
    np.testing.assert_allclose(chromaticity(D65), [0.3127, 0.3290], atol=5e-5)
    np.testing.assert_allclose(chromaticity(np.ones(81)), [1 / 3, 1 / 3], atol=5e-5)
    # Illuminant A is Planck's law at 2848 K with c2 = 1.435e7 nm K (CIE 15:2004, eq. 3.1).
    A = WAVELENGTHS**-5 / np.expm1(1.435e7 / (2848 * WAVELENGTHS))
    np.testing.assert_allclose(chromaticity(A), [0.4476, 0.4074], atol=1e-4)


def test_the_tables_are_those_of_the_standard_at_its_landmarks():
    assert OBSERVER[1].max() == OBSERVER[1, WAVELENGTHS == 555.0] == 1.0
    assert D65[WAVELENGTHS == 560.0] == 100.0
    # The three functions have one integral, 21.371 in steps of 5 nm, by definition of the space.
    np.testing.assert_allclose(OBSERVER.sum(axis=1), 21.371, rtol=1e-4)


@pytest.mark.parametrize(
    "wavelengths",
    [np.arange(400, 701, 10), np.arange(360, 1001, 3.3), [500, 600], [381.3, 455.5, 470.0, 779.0]],
    ids=["goniometer", "wide", "two", "uneven"],
)
def test_white_is_white(wavelengths):
    white = to_linear_srgb(wavelengths, np.full(len(wavelengths), 0.7))
    np.testing.assert_allclose(white, 0.7, rtol=1e-14)


def test_a_patch_of_the_color_checker_has_its_published_color():
    nm = np.arange(380, 731, 10)
    linear = to_linear_srgb(nm, [[float(r) for r in text.split()] for text in (DARK_SKIN, RED)])
    encoded = 255 * (1.055 * linear ** (1 / 2.4) - 0.055)
    # As published by the maker, of a nominal chart and through D50; charts differ by some levels of 255.
    np.testing.assert_allclose(encoded, [[115, 82, 68], [175, 54, 60]], atol=4.5)


def test_a_linear_spectrum_is_integrated_exactly_from_few_samples():
    few, many = np.array([380.0, 503.0, 780.0]), WAVELENGTHS
    np.testing.assert_allclose(to_xyz(few, few / 780), to_xyz(many, many / 780), rtol=1e-13)


def test_values_beyond_the_samples_are_those_at_the_ends():
    nm = np.array([450.0, 550.0, 650.0])
    wider = np.array([380.0, 450.0, 550.0, 650.0, 780.0])
    np.testing.assert_allclose(
        to_xyz(nm, [0.2, 0.5, 0.9]), to_xyz(wider, [0.2, 0.2, 0.5, 0.9, 0.9]), rtol=1e-13
    )


def test_spectral_colors_keep_their_negative_components():
    # Every spectral color lies outside the triangle of the primaries.
    narrow = np.exp(-(((WAVELENGTHS - np.arange(420, 681, 10)[:, None]) / 4) ** 2))
    assert np.all(to_linear_srgb(WAVELENGTHS, narrow).min(axis=1) < 0)
    assert np.all(to_xyz(WAVELENGTHS, narrow) >= 0)


def test_it_is_linear_and_keeps_the_shape():
    spectra = np.random.default_rng(1).uniform(size=(2, 5, 31))
    nm = np.arange(400, 701, 10)
    rgb = to_linear_srgb(nm, spectra)
    assert rgb.shape == (2, 5, 3)
    assert rgb.dtype == np.float64
    np.testing.assert_allclose(to_linear_srgb(nm, 3 * spectra[1]), 3 * rgb[1], rtol=1e-12)


@pytest.mark.parametrize(
    ("wavelengths", "values", "text"),
    [
        ([400], [1], "two or more strictly increasing"),
        ([500, 400], [1, 1], "two or more strictly increasing"),
        ([500, 500], [1, 1], "two or more strictly increasing"),
        ([[400, 500]], [1, 1], "two or more strictly increasing"),
        ([800, 900], [1, 1], "must reach into 380 to 780 nm, got 800 to 900"),
        ([0.4, 0.7], [1, 1], "must reach into 380 to 780 nm"),
        ([400, 500], [1, 1, 1], r"must have the shape \(\.\.\., 2\), got \(3,\)"),
        ([400, 500], 1.0, "must have the shape"),
        ([400, np.nan], [1, 1], "wavelengths must be finite"),
        ([400, 500], [1, np.inf], "values must be finite"),
    ],
)
def test_what_is_no_spectrum_is_refused(wavelengths, values, text):
    with pytest.raises(ValueError, match=text):
        to_linear_srgb(wavelengths, values)
