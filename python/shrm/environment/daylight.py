"""Daylight from published formulas: the sky, the sun and a plain ground.

The sky's luminance and chromaticity are Perez distributions with the zenith's values [PSS99, eqs. 3, 4
and appendix A.2]. The sun is a black body of 5778 K by Planck's law, dimmed by the atmosphere's Rayleigh
scattering and haze [PSS99, appendix A.1]; ozone and water vapour are left out (less than 5%). Colors come
from spectra by the CIE 1931 observer, approximated by [WSS13]. The ground is a diffuse plane of one albedo,
lit by sky and sun.
"""

from __future__ import annotations

import math

import numpy as np

from shrm import color
from shrm.arrays import Float32Array, FloatArray
from shrm.environment import layouts
from shrm.vectors import golden_azimuths

__all__ = ["RADIANCE_UNIT", "SUN_DIAMETER", "daylight_pixels", "sky_radiance", "sun_irradiance"]

RADIANCE_UNIT = 20.0  # kcd/m^2: 1.0 is about a white diffuse surface in full daylight
SUN_DIAMETER = 0.533  # degrees


_SUN_TEMPERATURE = 5778.0  # kelvin, of the black body whose power is the sun's
_SUN_SAMPLES = 1 << 15  # equal parts of its disc, shared out among texels


def sun_irradiance(elevation: float, turbidity: float) -> FloatArray:
    """Return the sun's irradiance on a plane that faces it.

    Parameters
    ----------
    elevation : float
        Elevation of the sun, degrees above the horizon.
    turbidity : float
        Haze: 2 is very clear, 10 is hazy.

    Returns
    -------
    (3,) float64
        Linear Rec. 709 in `RADIANCE_UNIT` x steradian: luminance is illuminance.
    """
    wavelength = np.arange(0.380, 0.7801, 0.005)  # micrometers
    # Relative optical mass and transmittances, [PSS99] appendix A.1.
    zenith = 90.0 - elevation
    mass = 1.0 / (math.cos(math.radians(zenith)) + 0.15 * (93.885 - zenith) ** -1.253)
    rayleigh = np.exp(-0.008735 * wavelength**-4.08 * mass)
    haze = np.exp(-(0.04608 * turbidity - 0.04586) * wavelength**-1.3 * mass)

    # The spectrum by Planck's law, W/(m^2 sr) per meter of wavelength:
    # 2 h c^2 / lambda^5 / (exp(h c / (lambda k T)) - 1)
    meters = wavelength * 1e-6
    radiance = 2 * 6.62607015e-34 * 299792458.0**2 / meters**5
    radiance /= np.expm1(6.62607015e-34 * 299792458.0 / (meters * 1.380649e-23 * _SUN_TEMPERATURE))
    solid_angle = 2 * math.pi * (1 - math.cos(math.radians(SUN_DIAMETER / 2)))
    spectrum = radiance * rayleigh * haze * solid_angle
    xyz = 683.0 * (_observer(wavelength * 1000) @ spectrum) * 0.005e-6  # lux
    result: FloatArray = np.maximum(color.rec709_from_xyz() @ xyz, 0) / (1000 * RADIANCE_UNIT)
    return result


def _observer(nm: FloatArray) -> FloatArray:
    """Return the CIE 1931 color matching functions, (3, n) [WSS13, eqs. 4 to 6 of the multi-lobe fit]."""

    def lobe(scale: float, center: float, below: float, above: float) -> FloatArray:
        t = (nm - center) * np.where(nm < center, below, above)
        result: FloatArray = scale * np.exp(-0.5 * t * t)
        return result

    x = (
        lobe(0.362, 442.0, 0.0624, 0.0374)
        + lobe(1.056, 599.8, 0.0264, 0.0323)
        - lobe(0.065, 501.1, 0.0490, 0.0382)
    )
    y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322)
    z = lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725)
    return np.stack([x, y, z])


# Perez coefficients A to E = slope * turbidity + offset, for Y, x, y [PSS99, appendix A.2].
_PEREZ = {
    "Y": ((0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)),
    "x": ((-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)),
    "y": ((-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)),
}
# Zenith chromaticities: (T^2, T, 1) M (s^3, s^2, s, 1), s the sun's zenith angle [PSS99, appendix A.2].
_ZENITH = {
    "x": (
        (0.00166, -0.00375, 0.00209, 0.0),
        (-0.02903, 0.06377, -0.03202, 0.00394),
        (0.11693, -0.21196, 0.06052, 0.25886),
    ),
    "y": (
        (0.00275, -0.00610, 0.00317, 0.0),
        (-0.04214, 0.08970, -0.04153, 0.00516),
        (0.15346, -0.26756, 0.06670, 0.26688),
    ),
}


def sky_radiance(directions: FloatArray, sun: FloatArray, turbidity: float) -> FloatArray:
    """Return the sky's radiance, without the sun.

    Parameters
    ----------
    directions : (n, 3) float64
        Unit vectors; those below the horizon see the horizon's sky.
    sun : (3,) float64
        Unit vector to the sun, above the horizon.
    turbidity : float
        Haze, as in `sun_irradiance`.

    Returns
    -------
    (n, 3) float64
        Linear Rec. 709 in units of `RADIANCE_UNIT`; colors outside Rec. 709 are clipped at 0.
    """
    s = math.acos(min(1.0, max(0.0, float(sun[2]))))
    cos_theta = np.maximum(directions[:, 2], 1e-3)
    cos_gamma = np.clip(directions @ sun, -1.0, 1.0)

    def perez(name: str, cos_theta: FloatArray | float, cos_gamma: FloatArray | float) -> FloatArray:
        a, b, c, d, e = (slope * turbidity + offset for slope, offset in _PEREZ[name])  # [PSS99] eq. 3
        gamma = np.arccos(cos_gamma)
        result: FloatArray = (1 + a * np.exp(b / cos_theta)) * (
            1 + c * np.exp(d * gamma) + e * np.square(cos_gamma)
        )
        return result

    def zenith(name: str) -> float:
        if name == "Y":
            chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2 * s)
            kilocandela = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
            return max(kilocandela, 0.0)
        powers = np.array([s**3, s**2, s, 1.0])
        return float(np.array([turbidity**2, turbidity, 1.0]) @ np.array(_ZENITH[name]) @ powers)

    # Luminance and chromaticity, [PSS99] eq. 4, as linear Rec. 709
    Y, x, y = (
        zenith(name) * perez(name, cos_theta, cos_gamma) / perez(name, 1.0, math.cos(s)) for name in "Yxy"
    )
    Y = np.maximum(Y, 0.0)
    xyz = np.stack([x / y * Y, Y, (1 - x - y) / y * Y], axis=1)
    result: FloatArray = np.maximum(xyz @ color.rec709_from_xyz().T, 0) / RADIANCE_UNIT
    return result


def daylight_pixels(
    sun_elevation: float, sun_azimuth: float, turbidity: float, albedo: FloatArray, size: int
) -> Float32Array:
    """Return daylight as a lat-long picture of size x 2 size, size even; the arguments are valid already.

    The sun's light is cut into equal parts over its disc, and each part goes to the texel in which it lies,
    so that the sum is right at every size.
    """
    elevation, azimuth = math.radians(sun_elevation), math.radians(sun_azimuth)
    sun = np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )
    sun_light = sun_irradiance(sun_elevation, turbidity)
    radiance = np.empty((size, 2 * size, 3))

    # The sky: four samples per texel, so that the bright part round the sun is not jagged; row by row, to
    # save memory
    offsets = np.array([0.25, 0.75])
    columns = (np.arange(2 * size)[:, None] + offsets).ravel()
    for i in range(size // 2):
        x, y = np.meshgrid(columns, i + offsets)
        rays = layouts.rays("latlong", size, 2 * size, np.stack([x.ravel(), y.ravel()], axis=1))
        radiance[i] = sky_radiance(rays, sun, turbidity).reshape(2, 2 * size, 2, 3).mean(axis=(0, 2))

    # The ground: its irradiance is the sky's and the sun's, and it looks the same from everywhere.
    area = layouts.solid_angles("latlong", size, 2 * size)
    cosine = np.cos((np.arange(size // 2) + 0.5) * math.pi / size)
    lit = np.einsum("i,ij,ijc->c", cosine, area[: size // 2], radiance[: size // 2]) + sun_light * sun[2]
    radiance[size // 2 :] = albedo * lit / math.pi

    # The sun
    radiance += (_spread_sun(sun, size) / area)[:, :, None] * sun_light
    return radiance.astype(np.float32)


def _spread_sun(sun: FloatArray, size: int) -> FloatArray:
    """Return the fraction of the sun's disc in each texel, (size, 2 size); the sum is 1."""
    # Equal areas of the disc on a spiral of golden angles
    k = np.arange(_SUN_SAMPLES)
    cap = 1 - math.cos(math.radians(SUN_DIAMETER / 2))
    cosine = 1 - cap * (k + 0.5) / _SUN_SAMPLES
    angle = -golden_azimuths(_SUN_SAMPLES)

    # Their directions about the sun, and the texels that they lie in
    aside = np.array([1.0, 0.0, 0.0]) if abs(sun[2]) > 0.9 else np.array([0.0, 0.0, 1.0])
    right = np.cross(aside, sun)
    right /= np.linalg.norm(right)
    up = np.cross(sun, right)
    sine = np.sqrt(1 - cosine**2)
    points = (
        cosine[:, None] * sun + (sine * np.cos(angle))[:, None] * right + (sine * np.sin(angle))[:, None] * up
    )
    column, row = layouts.positions("latlong", size, 2 * size, points).astype(np.int64).T
    count = np.bincount(row * 2 * size + column, minlength=2 * size * size)
    return count.reshape(size, 2 * size) / _SUN_SAMPLES
