"""Approximations by symmetric lobes: the nearest, by quadrature that shares no code with them."""

import numpy as np
import pytest
from shrm import brdf
from shrm.lobes.factored import VIEWS, factored, factored_phong, symmetric

GLOSSY = [brdf.GGX(0.1), brdf.GGX(0.4, (1.0, 0.7, 0.3)), brdf.Microfacet(0.2), brdf.Beckmann(0.6)]


def mean_over_azimuth(lobe, theta_i: float, theta_v: float) -> np.ndarray:
    """By 4000 azimuths about R, in the frame of the normal."""
    R = np.array([-np.sin(theta_v), 0.0, np.cos(theta_v)])
    x = np.array([np.cos(theta_v), 0.0, np.sin(theta_v)])
    phi = 2 * np.pi * (np.arange(4000) + 0.5) / 4000
    circle = np.cos(phi)[:, None] * x + np.sin(phi)[:, None] * np.array([0.0, 1.0, 0.0])
    wi = np.cos(theta_i) * R + np.sin(theta_i) * circle
    wo = np.tile([np.sin(theta_v), 0.0, np.cos(theta_v)], (4000, 1))
    return np.atleast_1d(lobe.transfer(wi, wo).mean(axis=0))


def over_lights(profile, n: int = 4000) -> np.ndarray:
    """The integral of a profile of theta_i over the sphere, by the middle of n rings, dense at the center."""
    t = (np.arange(n) + 0.5) / n
    theta = np.pi * t**2
    weight = 2 * np.pi * np.sin(theta) * 2 * np.pi * t / n
    values = profile(theta)
    return weight @ (values if values.ndim == 2 else values[:, None])


@pytest.mark.parametrize("material", GLOSSY, ids=lambda material: material.name)
def test_the_symmetric_lobe_is_the_mean_over_azimuth(material):
    (lobe,) = material.lobes
    round_ = symmetric(lobe)
    assert round_.center == "reflection"
    peak = mean_over_azimuth(lobe, 0.0, 0.0).max()
    for theta_v in (0.0, 0.3, 0.8, 1.2):
        for theta_i in (0.0, 0.02, 0.1, 0.5, 1.0, 2.0):
            found = round_.profile(np.array([theta_i]), np.array([2 * theta_v]))
            # Cells are small against the lobe: linear in between, to a part of its peak.
            np.testing.assert_allclose(
                np.ravel(found), mean_over_azimuth(lobe, theta_i, theta_v), atol=3e-3 * peak
            )


@pytest.mark.slow
@pytest.mark.parametrize("material", GLOSSY, ids=lambda material: material.name)
def test_symmetric_lobes_reflect_what_the_lobe_does(material):
    """A white light: the mean over azimuth leaves the integral as it is."""
    round_ = symmetric(*material.lobes)
    for cosine in (1.0, 0.8, 0.3):
        expected = brdf.directional_albedo(material, [cosine])[0]
        theta_o = 2 * np.arccos(cosine)
        found = over_lights(lambda theta, o=theta_o: round_.profile(theta, np.full_like(theta, o)))
        np.testing.assert_allclose(found, np.atleast_1d(expected), rtol=4e-3)


@pytest.mark.parametrize("fit", [lambda lobe: factored(lobe), lambda lobe: factored(lobe, 3), factored_phong])
@pytest.mark.parametrize("material", GLOSSY, ids=lambda material: material.name)
def test_factored_lobes_reflect_what_the_lobe_does(material, fit):
    (lobe,) = material.lobes
    parts = fit(lobe)
    for index in (0, 30, 70):
        theta_v = np.pi / 2 * index / (VIEWS - 1)
        expected = np.atleast_1d(brdf.directional_albedo(material, [np.cos(theta_v)])[0])
        found = sum(
            part.factor[index] * over_lights(lambda t, p=part: p.lobe.profile(np.cos(t))) for part in parts
        )
        np.testing.assert_allclose(np.broadcast_to(found, expected.shape), expected, rtol=1e-2)


def test_more_lobes_come_nearer():
    (lobe,) = brdf.GGX(0.3).lobes
    round_ = symmetric(lobe)
    theta_i, theta_o = np.meshgrid(np.linspace(0, 1.5, 60), np.linspace(0, 3.0, 40))
    expected = round_.profile(theta_i.ravel(), theta_o.ravel())
    place = theta_o.ravel() / np.pi * (VIEWS - 1)
    last = np.inf
    for lobes in (1, 2, 4, 8):
        found = sum(
            np.interp(place, np.arange(VIEWS), part.factor[:, 0]) * part.lobe.profile(np.cos(theta_i.ravel()))
            for part in factored(lobe, lobes)
        )
        off = float(np.sqrt(((found - expected) ** 2 * np.sin(theta_i.ravel())).mean()))
        assert off < last
        last = off
    assert last < 0.01 * np.sqrt((expected**2).mean())


def test_a_lobe_that_is_factored_is_found_again():
    """Miller and Heidrich's lobes are products themselves: one of each is exact."""
    material = brdf.MillerHeidrich((0.6, 0.4, 0.2), 30, f0=(0.04, 0.1, 0.5))
    theta_v = np.linspace(0, np.pi / 2, VIEWS)
    for lobe in material.lobes:
        for fit in (factored, factored_phong) if lobe.center == "reflection" else (factored,):
            (part,) = fit(lobe)
            assert part.lobe.center == lobe.center
            theta_i = np.array([0.01, 0.1, 0.3, 0.8])
            for k in (0, 40, 80):
                expected = lobe.profile(theta_i, np.full(4, lobe.theta_o(theta_v[k : k + 1])[0]))
                found = part.factor[k] * part.lobe.profile(np.cos(theta_i)).reshape(4, -1)
                np.testing.assert_allclose(found, expected, atol=0.05 * expected.max())


def test_lobes_without_a_view_are_refused():
    with pytest.raises(ValueError, match="no lobe to be made symmetric"):
        symmetric(brdf.Phong(3).lobes[0])
    with pytest.raises(ValueError, match="no lobe to be made symmetric"):
        factored(brdf.Banks(0.5).lobes[0])
    with pytest.raises(ValueError, match="lobes must be"):
        factored(brdf.GGX(0.3).lobes[0], 9)
    assert symmetric(brdf.Banks(0.5).lobes[0]).center == "tangent"
