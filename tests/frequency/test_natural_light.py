"""The promise: the measured error is at most 1.25 times the predicted one plus 1e-4, under natural light.

Models of every kind, about the paper's reflection and about its lobe, against a float64 integral over the
texels' areas, in the measure that the prediction uses: frames of every orientation, cos^2(theta_v) uniform,
colors pooled. Environments are brought to 64 x 128 texels (the integral then takes seconds, not hours);
prediction and integral see the same picture. The margin of 1.25 covers the sampling of the mean, about 20%
of an error whose square has a long tail. `pytest -rP tests/frequency/test_natural_light.py` prints the table.
"""

import json
import warnings

import numpy as np
import pytest
from shrm import ToleranceWarning, brdf, prefilter
from support import oracles
from support.data import environment, require

# The first two come with the tests, the others are real and lie beside the project.
OWN = ("sun.hdr", "lamps.hdr")
REAL = (
    "debevec_grace_cross.hdr",
    "debevec_rnl_probe.hdr",
    "debevec_stpeters_cross.hdr",
    "spica_uffizi.hdr",
    "venice_sunset_1k.hdr",
)


def skin() -> tuple[brdf.BRDF, oracles.Transfer]:
    material = brdf.Lafortune.read(require("brdf/lafortune_pbrt1.json"), "skin")
    table = json.loads(require("brdf/lafortune_pbrt1.json").read_text())["skin"]
    xy, z, e = (np.array([table[f"{name}{k}"] for k in range(3)]) for name in ("xy", "z", "e"))
    glossy = oracles.lafortune(xy, z, e)
    diffuse = oracles.lambert(table["diffuse"])
    return material, lambda wi, wo: glossy(wi, wo) + diffuse(wi, wo)


MATERIALS = {
    "lambert": lambda: (brdf.Lambert(0.8), oracles.lambert(0.8)),
    "phong": lambda: (brdf.Phong(32), oracles.phong(32)),
    "microfacet": lambda: (brdf.Microfacet(0.2), oracles.microfacet(0.2)),
    "ggx .1": lambda: (brdf.GGX(0.1), oracles.ggx(0.1)),
    "ggx .3 rgb": lambda: (brdf.GGX(0.3, f0=(1.0, 0.7, 0.3)), oracles.ggx(0.3, (1.0, 0.7, 0.3))),
    "beckmann": lambda: (brdf.Beckmann(0.2), oracles.beckmann(0.2)),
    "lafortune skin": skin,
    "kajiya-kay": lambda: (brdf.KajiyaKay(16), oracles.kajiya_kay(16)),
    "kajiya-kay mirror": lambda: (brdf.KajiyaKay(32, cone="mirror"), oracles.kajiya_kay(32, "mirror")),
    "banks": lambda: (brdf.Banks(0.2), oracles.banks(0.2)),
}


# Every material in both lights of our own, and in one of the real ones: each of these has two materials.
CASES = [
    *((light, material) for light in OWN for material in MATERIALS),
    *((REAL[k % 5], material) for k, material in enumerate(MATERIALS)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("light", "material"), CASES)
def test_measured_error_is_within_the_prediction(light, material):
    env = environment(light)
    model, transfer = MATERIALS[material]()
    frame = "tangent" if model.lobes[0].center == "tangent" else "normal"
    radial = all(isinstance(lobe, brdf.RadialLobe) for lobe in model.lobes)
    if frame == "tangent":
        T, N, V = oracles.random_hairs(300, seed=1)
        weights = np.ones(300)
    else:
        T = None
        N, V, weights = oracles.important_views(env.pixels, 300 if radial else 800, seed=1)
    hemisphere = material != "phong" and frame == "normal"
    # Texels are 3 degrees wide: of lobes of 12 degrees and more one node in each errs by 0.7% of the light at
    # most, against four; of the one of 6 degrees by 4%, which is as much as the errors that are measured.
    subsamples = 2 if material == "ggx .1" else 1
    expected = oracles.reflected(
        env.pixels, transfer, N, V, T, frame=frame, hemisphere=hemisphere, subsamples=subsamples
    )
    for center in ("reflection", None) if not radial and frame == "normal" else (None,):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ToleranceWarning)
            rm = prefilter(env, model, tolerance=0.05, center=center)
        measured = oracles.relative_rms(rm.radiance(N, V, T), expected, weights)
        about = center or model.lobes[-1].center
        print(
            f"{light:26s} {material:18s} about the {about:10s} F={rm.F:3d} P={rm.P} "
            f"predicted {rm.error:.4f} measured {measured:.4f}"
        )
        assert measured <= 1.25 * rm.error + 1e-4


@pytest.mark.slow
def test_a_cap_on_P_is_told_and_the_error_is_right():
    """About R a GGX lobe cannot reach 1% within P = 8: the prediction says so, and says it rightly."""
    env = environment("lamps.hdr")
    with pytest.warns(ToleranceWarning, match="not met with P <= 8"):
        rm = prefilter(env, brdf.GGX(0.3), tolerance=0.01, center="reflection")
    N, V, weights = oracles.important_views(env.pixels, 800, seed=2)
    expected = oracles.reflected(env.pixels, oracles.ggx(0.3), N, V)
    measured = oracles.relative_rms(rm.radiance(N, V), expected, weights)
    assert rm.error > 0.01
    assert rm.error / 1.3 < measured < 1.25 * rm.error


ODD = {
    "a disc about R, with a jump all round": (
        lambda wi, wo: (dot(wi, wo * [-1, -1, 1]) > 0.95) * 1.0,
        "reflection",
    ),
    "grazing light and view only": (lambda wi, wo: np.exp(-30 * (wi[:, 2] + wo[:, 2])), "lobe"),
    "towards the eye": (lambda wi, wo: np.maximum(dot(wi, wo), 0) ** 20, "lobe"),
}


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("orders", [(10, 2), (30, 8)])
def test_odd_functions_do_not_fool_the_prediction(name, orders):
    """Jumps that a quadrature misses, and fits over the views that are ill-conditioned."""
    env = environment("lamps.hdr")
    function, center = ODD[name]
    rm = prefilter(env, brdf.from_function(function, center=center), orders=orders)
    N, V, weights = oracles.important_views(env.pixels, 400, seed=3)
    expected = oracles.reflected(
        env.pixels, lambda wi, wo: function(wi, wo) * np.maximum(wi[:, 2], 0), N, V, subsamples=2
    )
    measured = oracles.relative_rms(rm.radiance(N, V), expected, weights)
    assert measured <= 1.25 * rm.error + 1e-4, (measured, rm.error)
