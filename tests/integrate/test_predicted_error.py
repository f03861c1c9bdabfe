"""What the integrators predict of their error, against what exact sums measure."""

import pickle
from functools import cache

import numpy as np
import pytest
from shrm import brdf, prefilter_angular, prefilter_hierarchical
from shrm.environment import Environment
from shrm.integrate.angular import integrate
from support import oracles
from support.integrands import environment, noise

SUN = Environment.daylight(size=32)
NOISE = environment(noise(32, 64))
MATERIALS = {
    "phong": brdf.Phong(60),
    "lambert and phong": brdf.Lambert((0.8, 0.5, 0.2)) + 0.5 * brdf.Phong(30),
    "facets": brdf.Microfacet(0.3),
    "ggx": brdf.GGX(0.3, f0=(1.0, 0.7, 0.3)),
    "two lobes": 0.5 * brdf.GGX(0.25) + 0.5 * brdf.GGX(0.6),
}
MARGIN = 1.6
"""By how much more than predicted may be measured: both are means over hundreds of frames drawn at random,
and an error has long tails."""


@cache
def exact(light, material, subsamples):
    """Frames of every orientation, drawn near the light: normals, views, weights, exact radiance."""
    normals, views, weight = oracles.important_views(light.pixels, 500, seed=11)
    return normals, views, weight, integrate(light, material, normals, views, subsamples=subsamples)


def measured(reflection, light, material, subsamples):
    """Relative RMS error over frames of every orientation, weighted."""
    normals, views, weight, radiance = exact(light, material, subsamples)
    return oracles.relative_rms(reflection.radiance(normals, views), radiance, weight[:, None])


LIGHTS = {"sun": SUN, "noise": NOISE}
# Every material in both lights as a rule, and in one of them, by turns, with the other option.
STRICT = [(light, material) for material in MATERIALS for light in LIGHTS]
LOOSE = [(list(LIGHTS)[k % 2], material) for k, material in enumerate(MATERIALS)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("light", "material", "tolerance"), [(*case, 0.02) for case in STRICT] + [(*case, 0.1) for case in LOOSE]
)
def test_integration_is_as_exact_as_it_says(light, material, tolerance):
    light, material = LIGHTS[light], MATERIALS[material]
    integral = prefilter_angular(light, material, tolerance=tolerance)
    error = measured(integral, light, material, 4)
    assert error < MARGIN * integral.error
    assert integral.error < 1.3 * tolerance + 2e-3  # what tables and nodes add
    assert integral.table_error < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("light", "material", "options"),
    [(*case, {"tolerance": 0.02}) for case in STRICT] + [(*case, {"threshold": 0.05}) for case in LOOSE],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else value,
)
def test_a_descent_is_as_exact_as_it_says(light, material, options):
    light, material = LIGHTS[light], MATERIALS[material]
    descent = prefilter_hierarchical(light, material, size=32, **options)
    error = measured(descent, light, material, 1)
    assert error < MARGIN * descent.error
    if "tolerance" in options:
        assert descent.error < options["tolerance"] + 2e-3


def test_nothing_cut_leaves_tables_and_nodes():
    whole = prefilter_angular(SUN, brdf.Phong(60))
    assert whole.cutoff == 0
    assert whole.table_error <= whole.error < 1e-3
    assert prefilter_hierarchical(SUN, brdf.Phong(60), threshold=0.0).error < 1e-4


def test_another_light_has_an_error_of_its_own():
    descent = prefilter_hierarchical(NOISE, brdf.Phong(60), tolerance=0.02, size=32)
    before = descent.error
    descent.update(SUN)
    assert descent.error != before
    assert measured(descent, SUN, brdf.Phong(60), 1) < MARGIN * descent.error


@pytest.mark.parametrize("prefiltered", [prefilter_angular, prefilter_hierarchical])
@pytest.mark.parametrize("material", [MATERIALS["two lobes"], brdf.Phong(9), brdf.KajiyaKay(8)])
def test_results_are_pickled_and_have_a_line(prefiltered, material):
    reflection = prefiltered(NOISE, material, tolerance=0.05, size=6)
    again = pickle.loads(pickle.dumps(reflection))
    for name, pixels in reflection.maps_at_view([0.6, 0.0, 0.8]).items():
        np.testing.assert_array_equal(again.maps_at_view([0.6, 0.0, 0.8])[name], pixels)
    assert again.error == reflection.error
    assert repr(again) == repr(reflection)
    assert "\n" not in repr(reflection)
