"""Saved reflection maps: the same radiance when loaded, readable by others, honest about damage."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from shrm import Environment, ImageError, ReflectionMap, brdf, image_io, prefilter
from shrm.frequency.part import CoefficientMaps
from shrm.prefiltered import explicit
from shrm.prefiltered.icosahedron import icosahedron
from support import oracles

MATERIALS = [
    brdf.Lambert((0.8, 0.5, 0.2)),
    brdf.GGX(0.3, f0=(1.0, 0.8, 0.4)),
    brdf.Microfacet(0.3).recentered("reflection"),
    brdf.KajiyaKay(8),
    brdf.Lambert(0.3) + 0.5 * brdf.GGX(0.3),
]


@pytest.fixture(scope="module")
def env() -> Environment:
    return Environment.daylight(size=64)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize("material", MATERIALS, ids=[m.name for m in MATERIALS])
def test_round_trip(env, material, layout, tmp_path):
    rm = prefilter(env, material, orders=(8, 3), size=32, layout=layout, window="hann", clamp=True)
    path = tmp_path / "map.exr"
    rm.save(path)
    back = ReflectionMap.load(path)
    assert (back.F, back.P, back.layout, back.brdf) == (rm.F, rm.P, layout, material.name)
    assert (back.window, back.clamp, back.criterion) == ("hann", True, "light")
    assert back.error == rm.error
    T, N, V = oracles.random_hairs(100, seed=1)
    np.testing.assert_array_equal(back.radiance(N, V, T), rm.radiance(N, V, T))
    for mine, theirs in zip(rm.parts, back.parts, strict=True):
        np.testing.assert_array_equal(theirs.maps, mine.maps)
        np.testing.assert_array_equal(theirs.gamma, mine.gamma)
        for name in ("light", "rho"):
            np.testing.assert_array_equal(getattr(theirs, name), getattr(mine, name))


def test_other_programs_find_named_channels_and_the_conventions(env, tmp_path):
    prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16).save(tmp_path / "map.exr")
    first, *others = image_io.read_parts(tmp_path / "map.exr")
    assert first.name == "0.maps"
    assert first.pixels.shape == (16, 32, 27)
    assert list(first.channels[:6]) == ["B_0_0.R", "B_0_0.G", "B_0_0.B", "B_1_-1.R", "B_1_-1.G", "B_1_-1.B"]
    names = [part.name for part in others if not part.name.endswith(".rest")]
    assert names == ["0.light", "0.rho", "0.gamma"]
    for word in ("z up", "Condon-Shortley", "towards the eye", "theta_v"):
        assert any(word in str(value) for value in first.metadata.values())


def changed(path, part, **metadata):
    """The file with other metadata in its first part, or other texels there."""
    first, *others = image_io.read_parts(path)
    about = {**first.metadata, **{f"shrm:{name}": value for name, value in metadata.items()}}
    pixels = first.pixels if part is None else np.full_like(first.pixels, part)
    image_io.write_parts(path, [image_io.Part(first.name, pixels, first.channels, about), *others])


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize(
    ("texels", "metadata"), [(np.nan, {}), (None, {"lobes": 0}), (None, {"lobes": float("inf")})]
)
def test_damage_is_told(env, texels, metadata, layout, tmp_path):
    path = tmp_path / "map.exr"
    prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16, layout=layout).save(path)
    changed(path, texels, **metadata)
    with pytest.raises(ImageError, match="damaged"):
        ReflectionMap.load(path)


def test_a_map_is_pickled_with_its_error(env):
    rm = prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16)
    back = pickle.loads(pickle.dumps(rm))
    assert back.error == rm.error
    V = oracles.random_hairs(10, seed=1)[2]
    np.testing.assert_array_equal(back.radiance(V, V), rm.radiance(V, V))


def test_a_fitted_map_is_saved_without_coefficients(env, tmp_path):
    rm = prefilter(env, brdf.GGX(0.4).recentered("reflection"), orders=(6, 2), size=16)
    fitted = explicit.fit(explicit.icosahedral_maps(rm), icosahedron(), P=1)
    fitted.save(tmp_path / "fit.exr")
    back = ReflectionMap.load(tmp_path / "fit.exr")
    np.testing.assert_array_equal(back.parts[0].maps, fitted.parts[0].maps)
    assert back.P == 1


def test_every_truncation_is_refused_in_one_line(env, tmp_path):
    path = tmp_path / "map.exr"
    prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16).save(path)
    whole = path.read_bytes()
    for length in (0, 1, 100, len(whole) // 3, len(whole) // 2, len(whole) - 1000):
        path.write_bytes(whole[:length])
        with pytest.raises(ImageError) as fault:
            ReflectionMap.load(path)
        assert "map.exr" in str(fault.value)
        assert "\n" not in str(fault.value)


def test_corrupted_bytes_never_crash(env, tmp_path):
    path = tmp_path / "map.exr"
    prefilter(env, brdf.GGX(0.4), orders=(4, 1), size=8).save(path)
    whole = bytearray(path.read_bytes())
    rng = np.random.default_rng(2)
    loaded = 0
    for _ in range(150):
        damaged = bytearray(whole)
        for position in rng.integers(0, min(len(whole), 6000), size=4):
            damaged[position] = rng.integers(256)
        path.write_bytes(damaged)
        text = ""
        try:
            ReflectionMap.load(path).radiance([[0, 0, 1.0]], [0, 0, 1.0])
            loaded += 1
        except ImageError as fault:
            text = str(fault)
        assert "\n" not in text
    assert loaded < 150


def test_other_pictures_are_no_reflection_maps(env, tmp_path):
    env.write(tmp_path / "light.exr")
    with pytest.raises(ImageError, match=r"light\.exr: no reflection map"):
        ReflectionMap.load(tmp_path / "light.exr")
    with pytest.raises(ImageError, match=r"nothing\.exr"):
        ReflectionMap.load(tmp_path / "nothing.exr")


def test_nothing_is_left_of_a_file_that_cannot_be_written(env, tmp_path):
    rm = prefilter(env, brdf.Lambert(1.0))
    with pytest.raises(ImageError):
        rm.save(tmp_path / "absent" / "map.exr")
    assert list(tmp_path.iterdir()) == []


def test_cubes_without_coefficients_are_not_saved(env, tmp_path):
    rm = prefilter(env, brdf.GGX(0.4), orders=(4, 1), size=8, layout="cube")
    (part,) = rm.parts
    bare = CoefficientMaps(part.center, part.gamma, part.layout, part.rings, part.zonal)
    with pytest.raises(ValueError, match="cannot be saved, take lat-long maps"):
        replace(rm, parts=(bare,)).save(tmp_path / "cube.exr")
    assert not list(tmp_path.iterdir())


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_maps_beyond_float32_are_not_saved(env, tmp_path):
    lobe = brdf.RadialLobe("normal", lambda cosine: 1e40 * np.maximum(cosine, 0.0))
    rm = prefilter(env, brdf.Material((lobe,), "bright"), orders=(4, 1), size=8)
    with pytest.raises(ValueError, match="cannot be saved"):
        rm.save(tmp_path / "map.exr")
    assert not list(tmp_path.iterdir())
