"""Every result of prefiltering can be saved, and comes back bit for bit; others are refused."""

import inspect
import pickle
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shrm
from shrm import Environment, ImageError, brdf, image_io, prefiltered
from shrm.integrate.angular import AngularReflection
from shrm.integrate.hierarchical import HierarchicalReflection
from shrm.lobes.reflection import Reflection
from shrm.prefiltered.prefiltered_map import PrefilteredMap
from shrm.result_files import CLASSES
from support import oracles

T, N, V = oracles.random_hairs(60, seed=12)
VIEW = np.array([0.48, -0.6, 0.64])

SLOW = pytest.mark.slow

Make = Callable[..., Reflection]

SUM = 0.5 * brdf.Lambert(0.4) + brdf.GGX(0.2) + brdf.KajiyaKay(5)
MATERIALS = {
    "radial": brdf.Phong(20),
    "radial of three": brdf.Lambert((0.8, 0.5, 0.2)),
    "zonal": brdf.KajiyaKay(9),
    "half angle": brdf.Microfacet(0.3),
    "isotropic": brdf.GGX(0.3),
    "isotropic of three": brdf.GGX(0.3, (1.0, 0.8, 0.3)),
    "several centers": SUM,
}


def integrated(method: Make, material: brdf.BRDF, **accuracy: object) -> Make:
    """A result of an integrator."""
    return lambda env, **grid: method(env, material, size=8, **accuracy, **grid)


def earlier(cls: type[PrefilteredMap], material: brdf.BRDF, **options: object) -> Make:
    """Maps of an earlier technique, of one lobe."""
    return lambda env, **grid: cls.prefilter(env, material, size=8, tolerance=0.05, **options, **grid)


def with_residual(env: Environment, layout: str) -> Reflection:
    """A reflection map whose lobe is too sharp for it."""
    return shrm.prefilter(
        env, brdf.GGX(0.05), size=16, layout=layout, tolerance=0.1, F_max=8, P_max=2, residual="auto"
    )


def of_halves(env: Environment, layout: str) -> Reflection:
    """A reflection map of float16."""
    return shrm.prefilter(env, brdf.GGX(0.3), orders=(6, 2), size=16, layout=layout, half=True)


MAKERS: dict[str, Make] = {
    **{f"angular, {k}": integrated(shrm.prefilter_angular, m, tolerance=0.05) for k, m in MATERIALS.items()},
    "angular, all of a lobe": integrated(shrm.prefilter_angular, brdf.GGX(0.3), symmetry=False, subsamples=2),
    "angular, cut texels": integrated(shrm.prefilter_angular, brdf.Phong(1e5), cutoff=0.01),
    **{f"hierarchical, {name}": integrated(shrm.prefilter_hierarchical, m) for name, m in MATERIALS.items()},
    "hierarchical, threshold": integrated(shrm.prefilter_hierarchical, brdf.GGX(0.3), threshold=0.05),
    "shrm": lambda env, **grid: shrm.prefilter(env, SUM, orders=(6, 2), size=16, **grid),
    "shrm with residual": with_residual,
    "shrm of halves": of_halves,
    "diffuse": earlier(prefiltered.Diffuse, brdf.Lambert(0.5)),
    "phong": earlier(prefiltered.Phong, brdf.Phong(12)),
    "3d": earlier(prefiltered.KautzMcCool3D, brdf.GGX(0.4), slices=5),
    "2d": earlier(prefiltered.KautzMcCool2D, brdf.GGX(0.4, (1, 0.5, 0.2)), lobes=2),
    "cabral": earlier(prefiltered.Cabral, brdf.GGX(0.4)),
    "anisotropic": earlier(prefiltered.Anisotropic, brdf.Banks(0.3), slices=5),
    "prefiltered": lambda env, **grid: prefiltered.prefilter(env, SUM, size=8, **grid),
}  # fmt: skip
"""Results of every class, under an environment and with the layout of their maps."""

DAMAGED = [
    pytest.param(name, marks=() if name == "radial" else SLOW)
    for name in ("radial", "zonal", "half angle", "isotropic")
]
"""Materials whose results are damaged, one for each way to hold a lobe."""

QUICK = ["angular, radial", "angular, half angle", "hierarchical, zonal", "hierarchical, radial of three"]
QUICK += ["shrm", "shrm of halves", "diffuse", "phong", "3d", "2d", "cabral", "anisotropic", "prefiltered"]
"""Results that take the time of a quick test, some of each class."""

INTEGRATORS = {"angular": AngularReflection, "hierarchical": HierarchicalReflection}


@pytest.fixture(scope="module")
def env() -> Environment:
    return Environment.daylight(size=32)


def classes(base: type[Reflection] = Reflection) -> Iterator[type[Reflection]]:
    """All classes of results, of the package, that can be made."""
    for cls in base.__subclasses__():
        if not inspect.isabstract(cls) and not cls.__subclasses__():
            yield cls
        yield from classes(cls)


def assert_same(actual: Reflection, expected: Reflection) -> None:
    np.testing.assert_array_equal(actual.radiance(N, V, T), expected.radiance(N, V, T))
    maps = expected.maps_at_view(VIEW)
    assert list(actual.maps_at_view(VIEW)) == list(maps)
    for name, pixels in actual.maps_at_view(VIEW).items():
        np.testing.assert_array_equal(pixels, maps[name])
    if len(maps) == 1:
        np.testing.assert_array_equal(actual.at_view(VIEW), expected.at_view(VIEW))
    for name in ("error", "size", "layout", "centers", "brdf"):
        assert getattr(actual, name) == getattr(expected, name)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize(
    "make",
    [pytest.param(make, id=name, marks=() if name in QUICK else SLOW) for name, make in MAKERS.items()],
)
def test_results_come_back_bit_for_bit(env, make, layout, tmp_path):
    result = make(env, layout=layout)
    result.save(tmp_path / "result.exr")
    for back in (shrm.load(tmp_path / "result.exr"), type(result).load(tmp_path / "result.exr")):
        assert isinstance(back, type(result)) or back.lobes[0].__class__ is type(result)
        assert_same(back, result)
    assert_same(pickle.loads(pickle.dumps(result)), result)
    # and again of what was loaded, whose error is known now
    shrm.load(tmp_path / "result.exr").save(tmp_path / "again.exr")
    assert_same(shrm.load(tmp_path / "again.exr"), result)


@SLOW
def test_every_class_of_results_is_among_them(env):
    few = ["angular, radial", "hierarchical, radial", "shrm", "prefiltered"]
    few += ["diffuse", "phong", "3d", "2d", "cabral", "anisotropic"]
    saved = {type(MAKERS[name](env, layout="latlong")) for name in few}
    assert {cls for cls in classes() if cls.__module__.startswith("shrm.")} == saved
    for cls in saved:
        assert issubclass(cls, (*CLASSES.values(), PrefilteredMap))


# ---- What is refused


@pytest.mark.parametrize("method", INTEGRATORS)
@pytest.mark.parametrize("name", DAMAGED)
def test_a_part_that_is_missing_cut_or_not_finite_is_damage(env, method, name, tmp_path):
    MAKERS[f"{method}, {name}"](env).save(tmp_path / "result.exr")
    light, *tables = image_io.read_parts(tmp_path / "result.exr")
    assert tables
    dark = replace(light, pixels=np.full_like(light.pixels, np.nan))
    image_io.write_parts(tmp_path / "bad.exr", [dark, *tables])
    refused(tmp_path / "bad.exr", "damaged")
    for k, part in enumerate(tables):
        infinite = replace(part, pixels=np.full_like(part.pixels, np.inf))
        for damaged in ([], [replace(part, pixels=part.pixels[:, :1])], [infinite]):
            image_io.write_parts(tmp_path / "bad.exr", [light, *tables[:k], *damaged, *tables[k + 1 :]])
            refused(tmp_path / "bad.exr", "damaged")


@pytest.mark.parametrize("method", INTEGRATORS)
@pytest.mark.parametrize("name", DAMAGED)
def test_metadata_that_are_none_are_damage(env, method, name, tmp_path):
    MAKERS[f"{method}, {name}"](env).save(tmp_path / "result.exr")
    light, *tables = image_io.read_parts(tmp_path / "result.exr")
    names = {key for key in light.metadata if key.startswith("shrm:")}
    for key in names - {"shrm:axes", "shrm:integrated", "shrm:method", "shrm:brdf"}:
        others = {other: value for other, value in light.metadata.items() if other != key}
        spoilt = [{**others, key: value} for value in ("-1", "nan")]
        # an error that is not in the file is found again
        for metadata in spoilt if key.endswith("error") and "table" not in key else [others, *spoilt]:
            image_io.write_parts(tmp_path / "bad.exr", [replace(light, metadata=metadata), *tables])
            refused(tmp_path / "bad.exr", "damaged")


def refused(path: Path, text: str) -> None:
    """A file is refused in one line, by name."""
    with pytest.raises(ImageError, match=text) as fault:
        shrm.load(path)
    assert path.name in str(fault.value)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize("name", ["angular, half angle", "hierarchical, radial", "shrm", "3d"])
def test_every_truncation_is_refused(env, name, tmp_path):
    path = tmp_path / "result.exr"
    MAKERS[name](env, layout="latlong").save(path)
    whole = path.read_bytes()
    for length in (0, 1, 8, 100, len(whole) // 3, len(whole) // 2, len(whole) - 100):
        path.write_bytes(whole[:length])
        refused(path, "result")


@pytest.mark.parametrize("method", INTEGRATORS)
@pytest.mark.parametrize("name", ["radial", "half angle", "zonal"])
def test_corrupted_bytes_never_crash(env, method, name, tmp_path):
    path = tmp_path / "result.exr"
    MAKERS[f"{method}, {name}"](env).save(path)
    whole = path.read_bytes()
    rng = np.random.default_rng(4)
    loaded = 0
    for _ in range(60):
        damaged = bytearray(whole)
        for position in rng.integers(0, min(len(whole), 8000), size=4):
            damaged[position] = rng.integers(256)
        path.write_bytes(damaged)
        text = ""
        try:
            shrm.load(path).radiance(N[:4], V[:4], T[:4])
            loaded += 1
        except ImageError as fault:
            text = str(fault)
        assert "\n" not in text
    assert loaded < 60


def test_other_files_are_refused(env, tmp_path):
    env.write(tmp_path / "light.exr")
    refused(tmp_path / "light.exr", "no result of prefiltering")
    refused(tmp_path / "nothing.exr", "nothing")
    (tmp_path / "text.exr").write_text("no picture")
    refused(tmp_path / "text.exr", "not a picture")


def test_a_class_loads_its_own_results_only(env, tmp_path):
    path = tmp_path / "result.exr"
    results = {kind: MAKERS[kind](env, layout="latlong") for kind in ("shrm", "prefiltered")}
    results |= {method: MAKERS[f"{method}, radial"](env) for method in INTEGRATORS}
    for result in results.values():
        result.save(path)
        for other in {type(one) for one in results.values()} - {type(result)}:
            with pytest.raises(ImageError, match=r"result\.exr: (no|a result of)"):
                other.load(path)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_files_of_other_versions_are_refused(env, method, tmp_path):
    MAKERS[f"{method}, radial"](env).save(tmp_path / "result.exr")
    light, *tables = image_io.read_parts(tmp_path / "result.exr")
    light = replace(light, metadata={**light.metadata, "shrm:integrated": 7})
    image_io.write_parts(tmp_path / "result.exr", [light, *tables])
    refused(tmp_path / "result.exr", "version 7, this reads version 1")


@pytest.mark.parametrize("name", ["angular, radial", "hierarchical, radial", "shrm", "3d", "prefiltered"])
def test_nothing_is_left_of_a_file_that_cannot_be_written(env, name, tmp_path):
    result = MAKERS[name](env, layout="latlong")
    for path in (tmp_path / "absent" / "result.exr", tmp_path / "result.png"):
        with pytest.raises(ImageError):
            result.save(path)
    assert list(tmp_path.iterdir()) == []
