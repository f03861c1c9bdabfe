"""Under constant light: the directional albedo within the prediction, and exactly for radial lobes."""

import numpy as np
import pytest
from shrm import brdf, prefilter
from shrm.environment import Environment
from support import oracles


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize("material", [brdf.Lambert(0.7), brdf.Phong(30)], ids=["lambert", "phong"])
def test_white_furnace_is_exact_for_radial_lobes(material, layout):
    white = Environment(np.ones((32, 64, 3), np.float32))
    N, V = oracles.random_views(200, seed=9)
    expected = 0.7 if material.name.startswith("lambert") else 1.0
    radiance = prefilter(white, material, layout=layout).radiance(N, V)
    np.testing.assert_allclose(radiance, expected, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "material",
    [brdf.GGX(0.1), brdf.GGX(0.5), brdf.Microfacet(0.3), brdf.Beckmann(0.2), brdf.GGX(0.3, f0=0.04)],
)
def test_white_furnace_gives_the_directional_albedo(material):
    """Within the predicted error, which falls as P grows."""
    white = Environment(np.ones((32, 64, 3), np.float32))
    N, V = oracles.random_views(400, seed=10)
    # cos^2(theta_v) uniform, as the prediction has it, in 20 values at which the albedo is known exactly
    levels = np.sqrt((np.arange(20) + 0.5) / 20)
    cosine = np.tile(levels, 20)[:, None]
    across = V - np.sum(N * V, axis=1, keepdims=True) * N
    V = cosine * N + np.sqrt(1 - cosine**2) * across / np.linalg.norm(across, axis=1, keepdims=True)
    expected = np.tile(brdf.directional_albedo(material, levels)[:, 0], 20)
    errors = []
    for P in (1, 2, 4, 8):
        rm = prefilter(white, material, orders=(4, P))
        actual = rm.radiance(N, V)[:, 0]
        errors.append(oracles.relative_rms(actual, expected))
        assert errors[-1] <= 1.25 * rm.error + 1e-4, (P, errors[-1], rm.error)
    assert errors[-1] < errors[0]


@pytest.mark.parametrize(
    ("material", "transfer"),
    [
        (brdf.KajiyaKay(16), oracles.kajiya_kay(16)),
        (brdf.KajiyaKay(16, cone="mirror"), oracles.kajiya_kay(16, "mirror")),
        (brdf.Banks(0.2), oracles.banks(0.2)),
    ],
)
def test_white_furnace_about_the_tangent(material, transfer):
    """The integral of the lobe at each theta_o, within the predicted error, which falls as P grows."""
    white = Environment(np.ones((32, 64, 3), np.float32))
    T, N, V = oracles.random_hairs(200, seed=10)
    expected = oracles.reflected(
        white.pixels, transfer, N, V, T, frame="tangent", hemisphere=False, subsamples=3
    )
    errors = []
    for P in (1, 2, 4, 8, 12):
        rm = prefilter(white, material, orders=(4, P))
        errors.append(oracles.relative_rms(rm.radiance(N, V, T), expected))
        assert errors[-1] <= 1.25 * rm.error + 1e-4, (P, errors[-1], rm.error)
    assert errors[-1] < errors[0]


@pytest.mark.slow
def test_white_furnace_of_many_lobes():
    """Lafortune's lobes and a diffuse one, in three colors: the albedo within the predicted error."""
    white = Environment(np.ones((32, 64, 3), np.float32))
    lobes = {
        "x": [[-1.0, -0.9, -0.8]],
        "y": [[-1.0, -0.9, -0.8]],
        "z": [[0.9, 0.8, 0.7]],
        "exponent": [[9.0, 7, 5]],
    }
    material = brdf.Lafortune(**lobes, diffuse=(0.3, 0.2, 0.1))
    xy, z, exponent = (np.array(lobes[name]) for name in ("x", "z", "exponent"))
    glossy, matt = oracles.lafortune(xy, z, exponent), oracles.lambert((0.3, 0.2, 0.1))
    N, V = oracles.random_views(200, seed=11)
    expected = oracles.reflected(
        white.pixels, lambda wi, wo: glossy(wi, wo) + matt(wi, wo), N, V, subsamples=3
    )
    errors = []
    for P in (1, 2, 4, 8):
        rm = prefilter(white, material, orders=(4, P))
        errors.append(oracles.relative_rms(rm.radiance(N, V), expected))
        assert errors[-1] <= 1.25 * rm.error + 1e-4, (P, errors[-1], rm.error)
    assert errors[-1] < errors[0]
