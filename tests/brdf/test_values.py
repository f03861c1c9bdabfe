"""Materials are values: equal, hashable and picklable where their parts are, so that caches find them."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from shrm import brdf
from shrm.brdf.lobe import Scaled
from shrm.brdf.measured import resampled
from shrm.frequency import orders
from shrm.frequency.analysis import analyse
from shrm.lobes.center import lobe_center
from support import rgl_format
from support.directions import hemisphere
from support.materials import MEASURED, MODELS, derived, doubled, glossy, write_measurements

WI, WO = hemisphere(200, 1), hemisphere(200, 2)


def evaluated(material: brdf.BRDF) -> np.ndarray:
    """What the lobes reflect at the same directions, (n, lobes * channels)."""
    return np.concatenate([lobe.transfer(WI, WO).reshape(len(WI), -1) for lobe in material.lobes], axis=1)


def require_equal(a: brdf.BRDF, b: brdf.BRDF) -> None:
    assert a == b
    assert hash(a) == hash(b)
    assert a.lobes == b.lobes
    np.testing.assert_array_equal(evaluated(a), evaluated(b))


def require_value(a: brdf.BRDF, b: brdf.BRDF) -> None:
    """Two that were made alike are equal, are found in a dictionary, and come back from a pickle."""
    require_equal(a, b)
    assert {a: 1}[b] == 1
    require_equal(pickle.loads(pickle.dumps(a)), a)
    for text in (repr(a), *map(repr, a.lobes)):
        assert "\n" not in text
        assert "array(" not in text
        assert len(text) < 400


def test_every_public_material_is_listed() -> None:
    listed = {type(making.same()) for making in MODELS.values()} | {brdf.Measured, brdf.BRDF}
    public = {getattr(brdf, name) for name in brdf.__all__}
    assert {kind for kind in public if isinstance(kind, type) and issubclass(kind, brdf.BRDF)} == listed


@pytest.mark.parametrize("name", MODELS)
def test_materials_are_equal_where_their_parameters_are(name: str) -> None:
    making = MODELS[name]
    require_value(making.same(), making.same())
    assert making.same() != making.changed()
    assert making.same() != making.same().name


@pytest.mark.parametrize("name", MODELS)
def test_what_is_made_of_equal_materials_is_equal(name: str) -> None:
    making = MODELS[name]
    first, second = derived(making.same()), derived(making.same())
    changed = derived(making.changed())
    for kind in first:
        require_value(first[kind], second[kind])
        assert first[kind] != changed.get(kind)
    assert len({making.same(), *(first[kind] for kind in ("sum", "product", "product of three"))}) == 4


@pytest.mark.parametrize("source", MEASURED)
def test_measured_materials_are_equal_where_their_contents_are(
    source: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(resampled, "SHAPE", (4, 5, 6))
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
    a, b = (brdf.load(write_measurements(tmp_path / name, source)) for name in "ab")
    other = brdf.load(write_measurements(tmp_path / "c", source, seed=1))
    black = brdf.load(
        tmp_path / "a" / f"paint{write_measurements(tmp_path / 'b', source).suffix}", extrapolate="zero"
    )
    assert a is not b
    require_value(a, b)
    assert a not in (other, black)
    np.testing.assert_array_equal(a.covers(WI, WO), pickle.loads(pickle.dumps(a)).covers(WI, WO))
    for made, again in zip(derived(a).values(), derived(b).values(), strict=True):
        require_value(made, again)


def test_what_is_computed_for_a_material_is_found_for_its_equals() -> None:
    analyse.cache_clear()
    lobe_center.cache_clear()
    for _ in range(3):
        for material in (
            brdf.GGX(0.3) + brdf.Lambert(0.5),
            0.5 * brdf.GGX(0.3),
            brdf.Tabulated(np.ones((4, 4, 4))),
            brdf.from_function(glossy),
        ):
            orders.analysed(material, 8, 2)
    assert analyse.cache_info()[:2] == (10, 5)  # hits, misses: a lobe each, and Lambert's
    assert lobe_center.cache_info().misses == 4


def test_a_function_that_has_changed_makes_another_material() -> None:
    height = 1.0

    def constant(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return np.full(len(wi), height)

    first = brdf.from_function(constant)
    assert brdf.from_function(constant) == first
    height = 2.0
    assert brdf.from_function(constant) != first
    assert brdf.from_function(lambda wi, wo: constant(wi, wo)) != brdf.from_function(constant)


def test_what_cannot_be_hashed_is_equal_to_itself_alone() -> None:
    @dataclass
    class Changing:
        scale: float = 1.0

        def __call__(self, cosine: np.ndarray) -> np.ndarray:
            return self.scale * np.maximum(cosine, 0.0)

    profile = Changing()
    a, b = (brdf.Material((brdf.RadialLobe("normal", profile),), "changing") for _ in range(2))
    assert a == a
    assert a != b
    assert hash(a) == hash(a)
    orders.analysed(a + brdf.Lambert(0.5), 4, 0)


def test_arrays_of_values_do_not_change() -> None:
    values = np.ones((4, 4, 4))
    material = brdf.Tabulated(values)
    values[:] = 2.0
    assert material == brdf.Tabulated(np.ones((4, 4, 4)))
    for same in (material, pickle.loads(pickle.dumps(material))):
        with pytest.raises(ValueError, match="read-only"):
            np.asarray(same.values)[0, 0, 0] = 2.0


def test_lobes_scaled_alike_are_equal() -> None:
    lobe = brdf.RadialLobe("normal", doubled)
    assert lobe.scaled(2.0) == lobe.scaled(2.0)
    assert lobe.scaled(2.0) != lobe.scaled(3.0)
    assert lobe.scaled(2.0).profile == Scaled(doubled, 2.0)
    assert lobe != brdf.RadialLobe("reflection", doubled)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: 1e40 * brdf.GGX(0.3), "factor must be in [0, 1e+30], got 1e+40"),
        (lambda: (1.0, 1e31, 0.0) * brdf.GGX(0.3), "factor must be in [0, 1e+30], got 1e+31"),
        (lambda: 1e20 * (1e20 * brdf.GGX(0.3)), "factor must be at most 1e+30, with the factors before it"),
        (lambda: brdf.Phong(1e13), "exponent must be in [0, 1e+12], got 1e+13"),
        (lambda: brdf.KajiyaKay(1e13), "exponent must be in [0, 1e+12], got 1e+13"),
        (lambda: brdf.MillerHeidrich(0.5, 1e13), "exponent must be in [0, 1e+12], got 1e+13"),
        (
            lambda: brdf.Lafortune([-1], [-1], [1], [1e13]),
            "exponent must be in [0, 1e+12], got 1e+13 to 1e+13",
        ),
        (lambda: brdf.Lafortune([-9], [-9], [9], [40]), "max(|x|, |z|)^exponent below 1e+30"),
        (
            lambda: brdf.Tabulated(np.full((2, 2, 2), 1e31)),
            "values must be in [0, 1e+30], got 1e+31 to 1e+31",
        ),
        (
            lambda: brdf.ABC(0.1, 1.0, 1e12, 100.0, 1.5),
            "ABC: B and C must make a lobe that falls to half at 1e-06",
        ),
        (
            lambda: brdf.from_function(lambda wi, wo: np.full(len(wi), 1e31)),
            "must be at most 1e+30 per steradian",
        ),
    ],
)
def test_what_maps_of_float32_cannot_hold_is_refused(make: Callable[[], brdf.BRDF], text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(text)):
        make()


def test_measurements_beyond_float32_are_refused(tmp_path: Path) -> None:
    """Each field is within its range, and what is computed of them is not."""
    fields = rgl_format.random(1)
    fields["ndf"] = fields["ndf"] * np.float32(1e25)
    fields["sigma"] = fields["sigma"] * np.float32(1e-20)
    path = tmp_path / "paint.bsdf"
    path.write_bytes(rgl_format.content(fields))
    with pytest.raises(brdf.MeasurementError, match=r"values times ndf / \(4 sigma\) must be below 1e\+30"):
        brdf.load(path)
