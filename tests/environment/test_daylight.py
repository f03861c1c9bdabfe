"""Daylight: the sun's energy at every size, published magnitudes, what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shrm import Environment
from shrm.environment import daylight, layouts


def sun_vector(elevation: float, azimuth: float) -> np.ndarray:
    e, a = math.radians(elevation), math.radians(azimuth)
    return np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])


@pytest.mark.parametrize("size", [2, 4, 16, 64, 256, 512])
@pytest.mark.parametrize(("elevation", "azimuth"), [(90, 0), (35, 50), (60, 180), (0.1, -90), (89.8, 10)])
def test_the_suns_irradiance_is_right_at_every_size(
    size: int, elevation: float, azimuth: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sun is what the picture has over the same picture without its disc."""
    arguments = (elevation, azimuth, 2.5, np.full(3, 0.2), size)
    pixels = daylight.daylight_pixels(*arguments).astype(np.float64)
    monkeypatch.setattr(daylight, "_spread_sun", lambda sun, size: np.zeros((size, 2 * size)))
    without = daylight.daylight_pixels(*arguments)
    areas = layouts.solid_angles("latlong", size, 2 * size)
    light = np.einsum("ij,ijc->c", areas, pixels - without)
    assert light == pytest.approx(daylight.sun_irradiance(elevation, 2.5), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("size", [64, 512, 2048])
def test_the_suns_disc_covers_the_texels_it_should(size: int) -> None:
    """Where texels are smaller than the sun, those inside have the disc's radiance."""
    sun = sun_vector(35, 50)
    share = daylight._spread_sun(sun, size)
    d = layouts.directions("latlong", size, 2 * size)
    center = np.einsum("ij,ijk->k", share, d)
    assert np.arccos(min(1.0, float(center @ sun / np.linalg.norm(center)))) < 0.5 * math.pi / size
    reach = math.radians(daylight.SUN_DIAMETER / 2) + 0.75 * math.pi / size
    assert np.all(d[share > 0] @ sun >= math.cos(reach))
    if size == 2048:
        solid = 2 * math.pi * (1 - math.cos(math.radians(daylight.SUN_DIAMETER / 2)))
        areas = layouts.solid_angles("latlong", size, 2 * size)
        inside = d @ sun > math.cos(math.radians(daylight.SUN_DIAMETER / 2) - 0.75 * math.pi / size)
        assert share[inside] / areas[inside] * solid == pytest.approx(1, abs=0.02)


def test_magnitudes() -> None:
    """Full sun is 60 to 110 klx on a plane that faces it, a clear sky 2 to 10 kcd/m^2, redder when low."""
    luminance = np.array([0.2126, 0.7152, 0.0722])
    high = daylight.sun_irradiance(60, 2.5)
    assert 80 < high @ luminance * daylight.RADIANCE_UNIT < 110
    low = daylight.sun_irradiance(5, 2.5)
    assert low[0] / low[2] > 2 * high[0] / high[2]
    assert low @ luminance < high @ luminance / 2
    pixels = Environment.daylight(size=64).pixels
    sky = np.median(pixels[:28] @ luminance) * daylight.RADIANCE_UNIT
    assert 2 < sky < 10
    assert np.all(np.median(pixels[:28], axis=(0, 1))[[0]] < np.median(pixels[:28], axis=(0, 1))[[2]])


def test_the_sky_at_the_zenith_is_the_published_luminance() -> None:
    """Preetham et al. 1999, appendix A.2, by hand for T = 3 and the sun at 60 degrees from the zenith."""
    sun = sun_vector(30, 0)
    chi = (4 / 9 - 3 / 120) * (math.pi - 2 * math.radians(60))
    expected = (4.0453 * 3 - 4.9710) * math.tan(chi) - 0.2155 * 3 + 2.4192
    sky = daylight.sky_radiance(np.array([[0.0, 0.0, 1.0]]), sun, 3.0)[0]
    # the luminance of Rec. 709; no channel is clipped there
    assert sky @ [0.2126, 0.7152, 0.0722] * daylight.RADIANCE_UNIT == pytest.approx(expected, rel=1e-3)


def test_the_ground_reflects_what_falls_on_it() -> None:
    """Radiosity = albedo x irradiance, both integrated from the picture."""
    size = 256
    pixels = Environment.daylight(albedo=0.5, size=size).pixels.astype(np.float64)
    areas, d = layouts.solid_angles("latlong", size, 2 * size), layouts.directions("latlong", size, 2 * size)
    up = np.maximum(d[..., 2], 0)
    irradiance = np.einsum("ij,ij,ijc->c", areas, up, pixels)
    assert pixels[-1, 0] * math.pi == pytest.approx(0.5 * irradiance, rel=5e-3)
    black = Environment.daylight(albedo=0.0, size=16).pixels
    assert not black[8:].any()


def test_every_setting_gives_a_valid_picture() -> None:
    for elevation in (0, 0.1, 2, 45, 90):
        for turbidity in (1.8, 4, 10):
            pixels = Environment.daylight(sun_elevation=elevation, turbidity=turbidity, size=16).pixels
            assert pixels.shape == (16, 32, 3)
            assert np.all(pixels >= 0)
            assert pixels[:8].max() > 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sun_elevation": -1}, r"sun_elevation must be in \[0, 90\], got -1"),
        ({"sun_elevation": math.nan}, "sun_elevation must"),
        ({"sun_azimuth": math.inf}, "sun_azimuth must"),
        ({"turbidity": 1}, r"turbidity must be in \[1.8, 10\]"),
        ({"albedo": 1.5}, "albedo must be"),
        ({"albedo": (0.1, 0.2)}, "albedo must be"),
        ({"size": 3}, "size must be even"),
        ({"size": 0}, "size must be at least 2"),
    ],
)
def test_refuses(arguments: dict[str, object], message: str) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        Environment.daylight(**arguments)  # type: ignore[arg-type]
