"""Prefiltered maps of all classes: against brute-force sums under the kernel that each of them assumes."""

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from shrm import Environment, ImageError, brdf, image_io
from shrm.frequency.prefilter import prefilter as prefilter_in_frequency
from shrm.integrate.angular import integrate
from shrm.lobes.factored import VIEWS, factored, symmetric
from shrm.prefiltered import (
    Anisotropic,
    Cabral,
    Diffuse,
    KautzMcCool2D,
    KautzMcCool3D,
    Phong,
    Prefiltered,
    prefilter,
)
from shrm.prefiltered.icosahedron import icosahedron
from support import oracles
from support.light import band_limited_environment

METHODS = ["frequency", "angular", "hierarchical"]


def by_all_methods(first, second):
    """One thing by every method, and another by the first of them: what a method does with it is the same."""
    return [(first, method) for method in METHODS] + [(second, METHODS[0])]


N, V = oracles.random_views(400, seed=1)
T = oracles.random_hairs(400, seed=2)[0]


ENV = band_limited_environment(6, seed=3, H=32)
"""Smooth: what is left to err are the maps, not the texels."""


@pytest.fixture
def env() -> Environment:
    return ENV


@cache
def of_kernel(lobe) -> np.ndarray:
    """Brute force, under a lobe as it is."""
    return integrate(ENV, brdf.Material((lobe,), "kernel"), N, V, T, subsamples=2)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("cls", "material"), [(Diffuse, brdf.Lambert((0.8, 0.5, 0.2))), (Phong, brdf.Phong(20))]
)
def test_lobes_of_one_shape_are_exact(env, cls, material, method):
    found = cls.prefilter(env, material, method=method, tolerance=0.005, size=48)
    assert found.maps.shape == (1, 48, 96, 3)
    assert oracles.relative_rms(found.radiance(N, V), of_kernel(*material.lobes)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(("material", "method"), by_all_methods(brdf.GGX(0.3), brdf.Microfacet(0.3)), ids=str)
def test_three_dimensions_hold_the_symmetric_lobe(env, material, method):
    found = KautzMcCool3D.prefilter(env, material, method=method, tolerance=0.005, size=32)
    expected = of_kernel(symmetric(*material.lobes))
    assert oracles.relative_rms(found.radiance(N, V), expected) < 0.01
    # which is not the lobe itself
    assert 0.001 < oracles.relative_rms(expected, of_kernel(*material.lobes)) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize(("lobes", "method"), by_all_methods(3, 1))
def test_two_dimensions_hold_factored_lobes(env, lobes, method):
    material = brdf.GGX(0.3, (1.0, 0.7, 0.3))
    found = KautzMcCool2D.prefilter(env, material, lobes=lobes, method=method, tolerance=0.005, size=48)
    assert len(found.layers) == lobes
    place = np.arccos(np.einsum("nc,nc->n", N, V)) / (np.pi / 2) * (VIEWS - 1)
    expected = 0.0
    for part in factored(*material.lobes, lobes):
        factor = np.stack([np.interp(place, np.arange(VIEWS), column) for column in part.factor.T], axis=1)
        expected = expected + factor * of_kernel(part.lobe)
    assert oracles.relative_rms(found.radiance(N, V), expected) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("material", [brdf.Banks(0.5), brdf.KajiyaKay(12)], ids=lambda m: m.name)
def test_anisotropic_maps_hold_lobes_about_the_tangent(env, material, method):
    found = Anisotropic.prefilter(env, material, method=method, tolerance=0.005, size=32)
    assert oracles.relative_rms(found.radiance(N, V, T), of_kernel(*material.lobes)) < 0.01
    with pytest.raises(ValueError, match="needs tangents"):
        found.radiance(N, V)


@pytest.mark.slow
@pytest.mark.parametrize(("center", "method"), by_all_methods("lobe", "reflection"))
def test_cabral_is_integration_at_its_twelve_views(env, center, method):
    material = brdf.GGX(0.4).recentered(center)
    found = Cabral.prefilter(env, material, method=method, tolerance=0.005, size=32)
    for view in icosahedron()[[0, 4, 7]]:
        seen = N[N @ view > 0.05]
        views = np.broadcast_to(view, seen.shape)
        expected = integrate(env, material, seen, views, subsamples=2)
        assert oracles.relative_rms(found.radiance(seen, view), expected) < 0.015


@pytest.mark.slow
@pytest.mark.parametrize("technique", ["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"])
def test_a_material_of_several_lobes_has_a_map_for_each(env, technique):
    material = brdf.Lambert(0.5) + 0.3 * brdf.Phong(10) + brdf.GGX(0.4)
    found = prefilter(env, material, technique=technique, size=24, slices=17)
    assert [type(one).__name__ for one in found.lobes[:2]] == ["Diffuse", "Phong"]
    exact = integrate(env, material, N, V, subsamples=2)
    assert oracles.relative_rms(found.radiance(N, V), exact) < 0.12
    np.testing.assert_allclose(
        found.radiance(N, V), sum(one.radiance(N, V) for one in found.lobes), rtol=1e-6
    )


@pytest.mark.slow
def test_miller_and_heidrich_s_material_takes_two_maps(env):
    material = brdf.MillerHeidrich((0.6, 0.4, 0.2), 20, f0=0.1)
    found = prefilter(env, material, technique="kautz-mccool-2d", size=48, tolerance=0.005)
    assert [len(one.layers) for one in found.lobes] == [1, 1]
    assert [one.center for one in found.lobes] == ["normal", "reflection"]
    exact = integrate(env, material, N, V, subsamples=2)
    assert oracles.relative_rms(found.radiance(N, V), exact) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("technique", ["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"])
def test_a_white_light_shows_the_albedo(technique):
    """Energy: approximations keep what is reflected of it, for every view."""
    white = Environment(np.ones((32, 64, 3), np.float32))
    cosine = np.einsum("nc,nc->n", N, V)
    inside = np.flatnonzero(cosine > 0.3)[:24]  # twelve views are far apart at grazing ones
    for material in (brdf.GGX(0.3), brdf.MillerHeidrich(0.5, 20), brdf.Lambert(0.7)):
        found = prefilter(white, material, technique=technique, size=8, layout="cube", tolerance=0.005)
        expected = brdf.directional_albedo(material, cosine[inside])
        got = found.radiance(N[inside], V[inside])[:, 0]
        assert oracles.relative_rms(got, np.ravel(expected)) < (0.05 if technique == "cabral" else 0.015)


MAKERS = {
    "diffuse": lambda env, **o: Diffuse.prefilter(env, brdf.Lambert(0.5), **o),
    "3d": lambda env, **o: KautzMcCool3D.prefilter(env, brdf.GGX(0.4), slices=5, **o),
    "2d": lambda env, **o: KautzMcCool2D.prefilter(env, brdf.GGX(0.4, (1, 0.5, 0.2)), lobes=2, **o),
    "cabral": lambda env, **o: Cabral.prefilter(env, brdf.GGX(0.4), **o),
    "anisotropic": lambda env, **o: Anisotropic.prefilter(env, brdf.Banks(0.3), slices=5, **o),
    "sum": lambda env, **o: prefilter(
        env, brdf.Lambert(0.5) + brdf.GGX(0.3), technique="kautz-mccool-2d", **o
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "layout"), [(name, ("latlong", "cube")[k % 2]) for k, name in enumerate(MAKERS)]
)
def test_files_and_pickles_bring_them_back(env, tmp_path, name, layout):
    saved = MAKERS[name](env, size=8, layout=layout, tolerance=0.02)
    saved.save(tmp_path / "map.exr")
    back = Prefiltered.load(tmp_path / "map.exr")
    kinds = [type(one) for one in (saved.lobes if isinstance(saved, Prefiltered) else (saved,))]
    assert [type(one) for one in back.lobes] == kinds
    expected = saved.radiance(N, V, T)
    for again in (back, type(saved).load(tmp_path / "map.exr"), pickle.loads(pickle.dumps(saved))):
        np.testing.assert_array_equal(again.radiance(N, V, T), expected)
        assert again.error == saved.error
        assert (again.size, again.layout, again.brdf) == (8, layout, saved.brdf)
    assert "\n" not in repr(saved)
    assert len(repr(saved)) < 200


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_maps_at_a_view_are_looked_up_at_the_central_direction(env, make, layout):
    """Both are cubic look-ups, of layers or of their sum: alike but for shares between texels."""
    maps = make(env, size=32, layout=layout, tolerance=0.05)  # both sides look up the same layers
    view = np.array([0.48, -0.6, 0.64])
    seen = N[N @ view > 0.2]
    tangents = T[N @ view > 0.2]
    views = np.broadcast_to(view, seen.shape)
    found = np.zeros(seen.shape)
    lobes = maps.lobes if isinstance(maps, Prefiltered) else (maps,)
    at_view = maps.maps_at_view(view)
    assert len(at_view) == len(lobes)
    for pixels, lobe in zip(at_view.values(), lobes, strict=True):
        rings = np.zeros_like(np.asarray(lobe.layers[0].rings))
        layer = replace(lobe.layers[0], rings=bordered(pixels, lobe.layers[0], rings))
        found += layer.radiance(np.ascontiguousarray(lobe.central_directions(seen, views, tangents)))
    # Shares bend between texels of 5.6 degrees: linear ones have corners.
    assert oracles.relative_rms(found, maps.radiance(seen, view, tangents)) < 0.01


def bordered(pixels, layer, rings):
    """A map as rings; a cube's border is not asked for."""
    if layer.layout == "latlong":
        return np.ascontiguousarray(pixels.transpose(0, 2, 1)[:, None])
    side = rings.shape[3]
    padded = np.pad(pixels, ((0, 0), (2, 2), (2, 2), (0, 0)), mode="edge")
    return np.ascontiguousarray(padded.transpose(0, 1, 3, 2).reshape(6 * side, 1, 3, side))


def test_errors_are_what_layers_were_integrated_to(env):
    material = brdf.Lambert(0.5) + brdf.GGX(0.5)
    assert prefilter(env, material, size=8, tolerance=0.03).error == 0.03
    assert np.isnan(Cabral.fitted(np.zeros((12, 4, 8, 3))).error)
    rm = prefilter_in_frequency(env, material, orders=(4, 2), size=8)
    assert np.isnan(Prefiltered.from_reflection_map(rm, material).error)


def test_a_class_loads_its_own_maps_only(env, tmp_path):
    path = tmp_path / "map.exr"
    Diffuse.prefilter(env, brdf.Lambert(0.5), size=4).save(path)
    with pytest.raises(ImageError, match="a Diffuse map where it must be Phong"):
        Phong.load(path)
    prefilter(env, brdf.Lambert(0.5) + brdf.Phong(9), size=4).save(path)
    with pytest.raises(ImageError, match="the maps of 2 lobes"):
        Diffuse.load(path)


@pytest.mark.slow
@pytest.mark.parametrize("technique", ["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"])
def test_maps_of_a_shrm_are_those_of_its_light(technique):
    """By coefficients as by integration, for each kind of lobe."""
    env = band_limited_environment(4, seed=5, H=16)
    material = brdf.MillerHeidrich(0.5, 12, 0.2) + 0.4 * brdf.Lambert(0.5) + brdf.GGX(0.5)
    rm = prefilter_in_frequency(env, material, orders=(8, 6), size=32)
    found = Prefiltered.from_reflection_map(rm, material, technique=technique)
    expected = prefilter(env, material, technique=technique, size=32, tolerance=0.003)
    assert [type(one) for one in found.lobes] == [type(one) for one in expected.lobes]
    assert oracles.relative_rms(found.radiance(N, V), expected.radiance(N, V)) < 0.02
    with pytest.raises(ValueError, match="must have been prefiltered with"):
        Prefiltered.from_reflection_map(rm, brdf.GGX(0.3), technique=technique)


@pytest.mark.slow
@pytest.mark.parametrize("technique", ["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"])
def test_black_lobes_and_channels_reflect_nothing(env, technique):
    for material in (0.0 * brdf.GGX(0.3), (1, 0, 0) * brdf.GGX(0.3), 0.0 * brdf.Phong(20)):
        maps = prefilter(env, material, technique=technique, size=8, layout="cube", tolerance=0.05)
        found = maps.radiance(N, V)
        assert np.isfinite(found).all()
        assert not found[:, 1:].any()


def test_no_points_reflect_no_light(env):
    found = KautzMcCool2D.prefilter(env, brdf.GGX(0.4), size=4)
    assert found.radiance(N[:0], V[:0]).shape == (0, 3)
    assert len(repr(prefilter(env, brdf.GGX(0.4), size=4))) < 200


def test_damaged_files_are_refused_in_one_line(env, tmp_path):
    path = tmp_path / "map.exr"
    KautzMcCool2D.prefilter(env, brdf.GGX(0.4), size=8).save(path)
    parts = image_io.read_parts(path)
    for change in (
        {"shrm:class": "Mirror"},
        {"shrm:center": "edge"},
        {"shrm:lobes": 0},
        {"shrm:lobes": 2},
        {"shrm:layout": "cube"},
        {"shrm:class": "Cabral"},
        {"shrm:class": "Anisotropic"},
        {"shrm:center": "lobe"},
    ):
        first = parts[0]
        changed = [type(first)(first.name, first.pixels, first.channels, {**first.metadata, **change})]
        image_io.write_parts(path, changed + list(parts[1:]))
        with pytest.raises(ImageError, match="damaged") as fault:
            Prefiltered.load(path)
        assert "\n" not in str(fault.value)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(ImageError, match=r"map\.exr"):
        Prefiltered.load(path)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (
            lambda e: Diffuse.prefilter(e, brdf.Phong(3)),
            ValueError,
            "Diffuse holds a lobe that is radial about the normal",
        ),
        (lambda e: Phong.prefilter(e, brdf.GGX(0.3)), ValueError, "Phong holds a lobe that is radial"),
        (lambda e: KautzMcCool3D.prefilter(e, brdf.Banks(0.3)), ValueError, "KautzMcCool3D holds"),
        (lambda e: KautzMcCool2D.prefilter(e, brdf.Phong(3)), ValueError, "KautzMcCool2D holds"),
        (
            lambda e: Anisotropic.prefilter(e, brdf.GGX(0.3)),
            ValueError,
            "Anisotropic holds a lobe that is zonal about",
        ),
        (
            lambda e: Cabral.prefilter(e, brdf.GGX(0.3) + brdf.Lambert(1)),
            ValueError,
            "has 2: use prefiltered",
        ),
        (
            lambda e: Diffuse.prefilter(e, brdf.Lambert(1), method="magic"),
            ValueError,
            "method must be",
        ),
        (
            lambda e: Diffuse.prefilter(e, brdf.Lambert(1), tolerance=0),
            ValueError,
            "tolerance must be above 0",
        ),
        (lambda e: Diffuse.prefilter(e, brdf.Lambert(1), size=1), ValueError, "size must be"),
        (lambda e: Diffuse.prefilter(e, brdf.Lambert(1), layout="disc"), ValueError, "layout must be"),
        (lambda e: Diffuse.prefilter(e.pixels, brdf.Lambert(1)), TypeError, "env must be"),
        (lambda e: Diffuse.prefilter(e, "lambert"), TypeError, "brdf must be"),
        (lambda e: KautzMcCool3D.prefilter(e, brdf.GGX(0.3), slices=1), ValueError, "slices must be"),
        (lambda e: KautzMcCool2D.prefilter(e, brdf.GGX(0.3), lobes=0), ValueError, "lobes must be"),
        (lambda e: prefilter(e, brdf.GGX(0.3), technique="5d"), ValueError, "technique must be"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(env, call, error, text):
    with pytest.raises(error, match=text) as fault:
        call(env)
    assert "\n" not in str(fault.value)
