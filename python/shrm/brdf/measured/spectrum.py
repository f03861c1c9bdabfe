"""Linear sRGB from spectra of reflectance, as the eye sees a surface under daylight.

    X = k int R(lambda) D65(lambda) xbar(lambda) dlambda,    Y, Z alike,    k = 1 / int D65 ybar dlambda

by the CIE 1931 standard observer (2 degrees) under the CIE standard illuminant D65, the white of sRGB
[CIE15]. Then the matrix to linear sRGB whose white is that of these sums, so that a surface that reflects
everything is exactly (1, 1, 1); the standard's own matrix, whose white is rounded to four digits, misses
that by 3e-4.

The sum goes over the table's wavelengths, 380 to 780 nm in steps of 5 nm. R is linear between its samples;
below its first wavelength and above its last one it keeps the value there. (From 400 to 700 nm, the range
of most instruments, that leaves .14% of X, .03% of Y and .19% of Z to assumption.) Colors that sRGB does
not hold have negative components and keep them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.color import REC709, xyz_from_rgb
from shrm.validation import real_array

WAVELENGTHS = np.arange(380.0, 781.0, 5.0)
"""Wavelengths of the tables below, nm."""

# fmt: off
OBSERVER = np.array([
    # xbar
    0.001368, 0.002236, 0.004243, 0.00765, 0.01431, 0.02319, 0.04351, 0.07763, 0.13438, 0.21477,
    0.2839, 0.3285, 0.34828, 0.34806, 0.3362, 0.3187, 0.2908, 0.2511, 0.19536, 0.1421,
    0.09564, 0.05795, 0.03201, 0.0147, 0.0049, 0.0024, 0.0093, 0.0291, 0.06327, 0.1096,
    0.1655, 0.22575, 0.2904, 0.3597, 0.43345, 0.51205, 0.5945, 0.6784, 0.7621, 0.8425,
    0.9163, 0.9786, 1.0263, 1.0567, 1.0622, 1.0456, 1.0026, 0.9384, 0.85445, 0.7514,
    0.6424, 0.5419, 0.4479, 0.3608, 0.2835, 0.2187, 0.1649, 0.1212, 0.0874, 0.0636,
    0.04677, 0.0329, 0.0227, 0.01584, 0.011359, 0.008111, 0.00579, 0.004109, 0.002899, 0.002049,
    0.00144, 0.001, 0.00069, 0.000476, 0.000332, 0.000235, 0.000166, 0.000117, 8.3e-05, 5.9e-05,
    4.2e-05,
    # ybar
    3.9e-05, 6.4e-05, 0.00012, 0.000217, 0.000396, 0.00064, 0.00121, 0.00218, 0.004, 0.0073,
    0.0116, 0.01684, 0.023, 0.0298, 0.038, 0.048, 0.06, 0.0739, 0.09098, 0.1126,
    0.13902, 0.1693, 0.20802, 0.2586, 0.323, 0.4073, 0.503, 0.6082, 0.71, 0.7932,
    0.862, 0.91485, 0.954, 0.9803, 0.99495, 1, 0.995, 0.9786, 0.952, 0.9154,
    0.87, 0.8163, 0.757, 0.6949, 0.631, 0.5668, 0.503, 0.4412, 0.381, 0.321,
    0.265, 0.217, 0.175, 0.1382, 0.107, 0.0816, 0.061, 0.04458, 0.032, 0.0232,
    0.017, 0.01192, 0.00821, 0.005723, 0.004102, 0.002929, 0.002091, 0.001484, 0.001047, 0.00074,
    0.00052, 0.000361, 0.000249, 0.000172, 0.00012, 8.5e-05, 6e-05, 4.2e-05, 3e-05, 2.1e-05,
    1.5e-05,
    # zbar
    0.00645, 0.01055, 0.02005, 0.03621, 0.06785, 0.1102, 0.2074, 0.3713, 0.6456, 1.03905,
    1.3856, 1.62296, 1.74706, 1.7826, 1.77211, 1.7441, 1.6692, 1.5281, 1.28764, 1.0419,
    0.81295, 0.6162, 0.46518, 0.3533, 0.272, 0.2123, 0.1582, 0.1117, 0.07825, 0.05725,
    0.04216, 0.02984, 0.0203, 0.0134, 0.00875, 0.00575, 0.0039, 0.00275, 0.0021, 0.0018,
    0.00165, 0.0014, 0.0011, 0.001, 0.0008, 0.0006, 0.00034, 0.00024, 0.00019, 0.0001,
    5e-05, 3e-05, 2e-05, 1e-05, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    0,
]).reshape(3, 81)
"""Color matching functions xbar, ybar, zbar of the CIE 1931 observer, (3, 81) [CIE15]."""

D65 = np.array([
    49.9755, 52.3118, 54.6482, 68.7015, 82.7549, 87.1204, 91.486, 92.4589, 93.4318, 90.057,
    86.6823, 95.7736, 104.865, 110.936, 117.008, 117.41, 117.812, 116.336, 114.861, 115.392,
    115.923, 112.367, 108.811, 109.082, 109.354, 108.578, 107.802, 106.296, 104.79, 106.239,
    107.689, 106.047, 104.405, 104.225, 104.046, 102.023, 100, 98.1671, 96.3342, 96.0611,
    95.788, 92.2368, 88.6856, 89.3459, 90.0062, 89.8026, 89.5991, 88.6489, 87.6987, 85.4936,
    83.2886, 83.4939, 83.6992, 81.863, 80.0268, 80.1207, 80.2146, 81.2462, 82.2778, 80.281,
    78.2842, 74.0027, 69.7213, 70.6652, 71.6091, 72.979, 74.349, 67.9765, 61.604, 65.7448,
    69.8856, 72.4863, 75.087, 69.3398, 63.5927, 55.0054, 46.4182, 56.6118, 66.8054, 65.0941,
    63.3828,
])
"""Relative spectral power of the illuminant, (81,), 100 at 560 nm [CIE15]."""
# fmt: on


def to_xyz(wavelengths: npt.ArrayLike, values: npt.ArrayLike) -> FloatArray:
    """Return CIE XYZ of spectra of reflectance under D65; Y of a perfect reflector is 1.

    Parameters
    ----------
    wavelengths : (K,) array_like
        Strictly increasing, nm; two or more, some of them in [380, 780].
    values : (..., K) array_like
        Reflectance, or a BRDF, at the wavelengths.

    Returns
    -------
    (..., 3) float64
        In the unit of `values`; at least 0 where these are.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    nm, spectra = real_array("wavelengths", wavelengths), real_array("values", values)
    if nm.ndim != 1 or len(nm) < 2 or np.any(np.diff(nm) <= 0):
        raise ValueError(f"wavelengths must be two or more strictly increasing numbers, got shape {nm.shape}")
    if nm[0] > WAVELENGTHS[-1] or nm[-1] < WAVELENGTHS[0]:
        raise ValueError(f"wavelengths must reach into 380 to 780 nm, got {nm[0]:g} to {nm[-1]:g}")
    if spectra.ndim == 0 or spectra.shape[-1] != len(nm):
        raise ValueError(f"values must have the shape (..., {len(nm)}), got {spectra.shape}")
    return np.asarray(spectra @ _weights(nm))


def to_linear_srgb(wavelengths: npt.ArrayLike, values: npt.ArrayLike) -> FloatArray:
    """Return linear sRGB of spectra of reflectance under D65; a perfect reflector is (1, 1, 1).

    Parameters
    ----------
    wavelengths : (K,) array_like
        Strictly increasing, nm; two or more, some of them in [380, 780].
    values : (..., K) array_like
        Reflectance, or a BRDF, at the wavelengths.

    Returns
    -------
    (..., 3) float64
        In the unit of `values`. Negative where sRGB does not hold the color.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    return linear_srgb_from_xyz(to_xyz(wavelengths, values))


def linear_srgb_from_xyz(xyz: FloatArray) -> FloatArray:
    """Return linear sRGB, (..., 3) float64, of what `to_xyz` returned; a perfect reflector is (1, 1, 1)."""
    X, Y, Z = OBSERVER @ D65
    white = (X / (X + Y + Z), Y / (X + Y + Z))
    return np.asarray(np.linalg.solve(xyz_from_rgb((*REC709[:6], *white)), xyz[..., None])[..., 0])


def _weights(nm: FloatArray) -> FloatArray:
    """Return the weights (K, 3) in X, Y and Z of samples at wavelengths (K,), nm."""
    response = OBSERVER * D65 / (OBSERVER[1] @ D65)
    # Linear interpolation, as the share of each sample at the wavelengths of the table.
    last = np.clip(np.searchsorted(nm, WAVELENGTHS), 1, len(nm) - 1)
    share = np.clip((WAVELENGTHS - nm[last - 1]) / (nm[last] - nm[last - 1]), 0.0, 1.0)
    weights = np.zeros((len(nm), 3))
    np.add.at(weights, last - 1, (response * (1.0 - share)).T)
    np.add.at(weights, last, (response * share).T)
    return weights
