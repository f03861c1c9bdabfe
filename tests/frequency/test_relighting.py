"""Relighting: an updated map is the map that prefiltering anew would give."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shrm import ReflectionMap, brdf, prefilter, sh
from shrm.brdf import BRDF
from shrm.environment import Environment
from shrm.frequency.part import Part
from shrm.frequency.relight import Prefilter
from support.light import band_limited_environment

ENVIRONMENTS = [band_limited_environment(10, seed=seed, H=24) for seed in (1, 2, 3)]
ORDERS = (8, 3)
OPTIONS = {"orders": ORDERS, "size": 16}
# A quarter and a half turn about z, half turns about x and y: texels go onto texels of a lat-long picture.
QUARTER = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
TEXEL_TURNS = [QUARTER, QUARTER @ QUARTER, QUARTER.T, np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1])]


def turns(n: int, seed: int) -> np.ndarray:
    return Rotation.random(n, rng=np.random.default_rng(seed)).as_matrix()


def turned(part: Part, R: np.ndarray | None) -> Part:
    """A part under rotated light, all its maps made anew."""
    if R is None:
        return part
    lit = replace(part, light=sh.rotate(part.light, R))
    fresh = lit.resized(part.size, part.layout)
    return fresh.as_half() if part.rings.dtype == np.float16 else fresh


def assert_same(updated: ReflectionMap, fresh: ReflectionMap, R: np.ndarray | None = None) -> None:
    """To float32 rounding, or to that of half floats, of the largest value of each part."""
    assert updated.brdf == fresh.brdf
    assert updated.criterion == fresh.criterion
    assert updated.window == fresh.window
    assert updated.clamp == fresh.clamp
    assert len(updated.parts) == len(fresh.parts)
    for have, want in zip(updated.parts, (turned(part, R) for part in fresh.parts), strict=True):
        assert (have.center, have.zonal, have.layout) == (want.center, want.zonal, want.layout)
        assert have.rings.dtype == want.rings.dtype
        np.testing.assert_array_equal(have.gamma, want.gamma)
        np.testing.assert_array_equal(have.rho, want.rho)
        np.testing.assert_allclose(have.light, want.light, rtol=0, atol=1e-6 * np.abs(want.light).max())
        rounding = 2.0**-10 if have.rings.dtype == np.float16 else 2e-6
        np.testing.assert_allclose(
            have.rings.astype(np.float32), want.rings, rtol=rounding, atol=2e-6 * np.abs(want.rings).max()
        )


@dataclass(frozen=True)
class Family:
    """Materials whose lobes are of one kind."""

    name: str
    materials: tuple[BRDF, ...]


FAMILIES = [
    Family("radial about R", (brdf.Phong(8), brdf.Phong(20), 0.5 * brdf.Phong(3))),
    Family("radial about N", (brdf.Lambert(0.8), brdf.Lambert((0.1, 0.5, 0.9)))),
    Family("tangent", (brdf.KajiyaKay(8), brdf.KajiyaKay(12, cone="mirror"), brdf.Banks(0.1))),
    Family("lobe", (brdf.GGX(0.3), brdf.GGX(0.5, f0=(0.9, 0.5, 0.2)), brdf.Beckmann(0.4))),
    Family(
        "two lobes",
        (
            brdf.Lambert(0.5) + brdf.GGX(0.3),
            brdf.Lambert((0.2, 0.3, 0.1)) + 0.3 * brdf.GGX(0.5),
            brdf.Lambert(0.1) + brdf.Beckmann(0.6),
        ),
    ),
]
CONFIGURATIONS = [
    {},
    {"layout": "cube"},
    {"half": True},
    {"layout": "cube", "half": True, "window": "lanczos"},
    {"window": "hann", "clamp": True, "criterion": "brdf"},
    {"center": "reflection"},
    {"center": "normal", "layout": "cube"},
]


def applies(family: Family, configuration: dict) -> bool:
    return "center" not in configuration or family.name in ("lobe", "two lobes")


CASES = [(f, c) for f in FAMILIES for c in CONFIGURATIONS if applies(f, c)]


@pytest.mark.parametrize(("family", "configuration"), CASES, ids=lambda x: getattr(x, "name", str(x)))
def test_any_sequence_of_updates_gives_the_map_made_anew(family, configuration):
    """Light, rotation and material change in any order and together; what is not given stays."""
    rng = np.random.default_rng(4)
    options = {**OPTIONS, **configuration}
    env, R, material = ENVIRONMENTS[0], None, family.materials[0]
    relit = Prefilter(env, material, **options)
    assert_same(relit.map, prefilter(env, material, **options))
    for _ in range(6):
        changes = {}
        if rng.random() < 0.5:
            env = changes["env"] = ENVIRONMENTS[rng.integers(len(ENVIRONMENTS))]
            R = None
        if rng.random() < 0.5:
            R = changes["rotation"] = Rotation.random(rng=rng).as_matrix()
        if rng.random() < 0.5:
            material = changes["brdf"] = family.materials[rng.integers(len(family.materials))]
        updated = relit.update(**changes)
        assert updated is relit.map
        assert_same(updated, prefilter(env, material, **options), R)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize("R", TEXEL_TURNS, ids=str)
def test_turning_coefficients_is_turning_texels(R, layout):
    """Where a rotation carries texels onto texels, the picture itself can be turned."""
    env = ENVIRONMENTS[0]
    relit = Prefilter(env, brdf.GGX(0.4), layout=layout, **OPTIONS)
    updated = relit.update(rotation=R)
    fresh = prefilter(env.rotated(R), brdf.GGX(0.4), layout=layout, **OPTIONS)
    scale = np.abs(fresh.parts[0].rings).max()
    np.testing.assert_allclose(updated.parts[0].rings, fresh.parts[0].rings, rtol=0, atol=1e-5 * scale)


def test_rotations_replace_one_another_and_a_new_light_has_none():
    relit = Prefilter(ENVIRONMENTS[0], brdf.GGX(0.4), **OPTIONS)
    first = relit.map.parts[0].rings.copy()
    A, B = turns(2, seed=5)
    relit.update(rotation=A)
    once = Prefilter(ENVIRONMENTS[0], brdf.GGX(0.4), **OPTIONS).update(rotation=B).parts[0].rings
    np.testing.assert_array_equal(relit.update(rotation=B).parts[0].rings, once)
    np.testing.assert_array_equal(relit.update().parts[0].rings, once)
    np.testing.assert_allclose(
        relit.update(ENVIRONMENTS[0]).parts[0].rings, first, rtol=0, atol=2e-6 * np.abs(first).max()
    )


def test_a_rotation_is_taken_as_it_was_given():
    relit = Prefilter(ENVIRONMENTS[0], brdf.GGX(0.4), **OPTIONS)
    R, other = turns(2, seed=6)
    rings = relit.update(rotation=R).parts[0].rings.copy()
    R[:] = other  # the caller's array is the caller's
    np.testing.assert_array_equal(relit.update().parts[0].rings, rings)


def test_a_tolerance_chooses_orders_once():
    """Later lights and materials keep them, and the first ones come back as they were."""
    first, second = brdf.GGX(0.3), brdf.GGX(0.6)
    relit = Prefilter(ENVIRONMENTS[0], first, tolerance=0.05)
    orders, size = (relit.map.F, relit.map.P), relit.map.parts[0].size
    before = relit.map.parts[0].rings.copy()
    other = relit.update(ENVIRONMENTS[1], brdf=second)
    assert ((other.F, other.P), other.parts[0].size) == (orders, size)
    # The material was analysed to more degrees than are kept, so that its integrals have other nodes.
    fresh = prefilter(ENVIRONMENTS[1], second, orders=orders, size=size).parts[0].rings
    np.testing.assert_allclose(other.parts[0].rings, fresh, rtol=0, atol=1e-3 * np.abs(fresh).max())
    back = relit.update(ENVIRONMENTS[0], brdf=first)
    np.testing.assert_allclose(back.parts[0].rings, before, rtol=0, atol=2e-6 * np.abs(before).max())


@pytest.mark.parametrize(
    ("material", "configuration"),
    [
        (brdf.Phong(20), {}),
        (brdf.GGX(0.4), {"layout": "cube"}),
        (brdf.GGX(0.4), {"window": "hann"}),
        (brdf.GGX(0.4), {"criterion": "brdf"}),
        (brdf.GGX(0.4), {"criterion": "bound"}),
        (brdf.GGX(0.4), {"center": "reflection", "half": True}),
        (brdf.Lambert(0.5) + brdf.GGX(0.4), {}),
        (brdf.KajiyaKay(8), {}),
    ],
    ids=lambda x: getattr(x, "name", str(x)),
)
def test_the_error_is_that_of_the_map_made_anew(material, configuration):
    """Within a few per cent: what interpolation adds is estimated from the spectra alone."""
    options = {"orders": (6, 2), "size": 48, **configuration}
    relit = Prefilter(ENVIRONMENTS[0], 0.5 * material, **options)
    updated = relit.update(ENVIRONMENTS[1], rotation=turns(1, seed=7)[0], brdf=material)
    fresh = prefilter(ENVIRONMENTS[1], material, **options)
    assert fresh.error > 0
    assert updated.error == pytest.approx(fresh.error, rel=0.05)


def test_the_error_of_an_earlier_map_is_its_own():
    """It is predicted when asked for, which may be after the maps were overwritten."""
    options = {"orders": (4, 2), "size": 32}
    relit = Prefilter(ENVIRONMENTS[0], brdf.GGX(0.3), **options)
    first, second = relit.map, relit.update(ENVIRONMENTS[1], brdf=brdf.GGX(0.7))
    relit.update(ENVIRONMENTS[2], brdf=brdf.Beckmann(0.2))
    assert first.error == prefilter(ENVIRONMENTS[0], brdf.GGX(0.3), **options).error
    expected = prefilter(ENVIRONMENTS[1], brdf.GGX(0.7), **options).error
    assert second.error == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_updates_share_memory_for_the_maps_alone(half, layout):
    relit = Prefilter(ENVIRONMENTS[0], brdf.GGX(0.4), layout=layout, half=half, **OPTIONS)
    first, rings = relit.map, relit.map.parts[0].rings.copy()
    second = relit.update(ENVIRONMENTS[1])
    light = second.parts[0].light.copy()
    third = relit.update(ENVIRONMENTS[2], rotation=turns(1, seed=8)[0])
    assert np.shares_memory(second.parts[0].rings, third.parts[0].rings)
    np.testing.assert_array_equal(second.parts[0].rings, third.parts[0].rings)
    assert not np.shares_memory(first.parts[0].rings, third.parts[0].rings)
    np.testing.assert_array_equal(first.parts[0].rings, rings)
    assert not np.shares_memory(second.parts[0].light, third.parts[0].light)
    np.testing.assert_array_equal(second.parts[0].light, light)


def test_an_updated_map_is_a_reflection_map_like_any_other(tmp_path):
    relit = Prefilter(ENVIRONMENTS[0], brdf.GGX(0.4), **OPTIONS)
    updated = relit.update(rotation=QUARTER)
    updated.save(tmp_path / "map.exr")
    np.testing.assert_array_equal(
        ReflectionMap.load(tmp_path / "map.exr").parts[0].rings, updated.parts[0].rings
    )
    out = np.full((16, 32, 3), np.nan, dtype=np.float32)
    assert updated.at_view([0, 0, 1.0], out=out) is out
    np.testing.assert_array_equal(out, updated.at_view([0, 0, 1.0]))


@pytest.mark.parametrize("orders", [(8, 0), (0, 0), (0, 2), (1, 3)])
@pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.name)
def test_the_smallest_orders_can_be_updated(family, orders):
    """A zonal lobe with P = 0 has one map, as a radial one has; more orders than degrees are zero."""
    relit = Prefilter(ENVIRONMENTS[0], family.materials[0], orders=orders, size=8)
    material = family.materials[1]
    updated = relit.update(ENVIRONMENTS[1], brdf=material)
    assert_same(updated, prefilter(ENVIRONMENTS[1], material, orders=orders, size=8))


BRIGHT = Environment(ENVIRONMENTS[1].pixels * np.float32(1e6))
# Finite texels whose sums are not.
BLINDING = Environment(np.full_like(ENVIRONMENTS[0].pixels, 3e38))


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize(
    ("change", "kind", "text"),
    [
        ({"env": ENVIRONMENTS[0].pixels}, TypeError, "env must be an Environment, got ndarray"),
        (
            {"env": band_limited_environment(4, seed=9, H=16)},
            ValueError,
            r"env must have the shape \(24, 48, 3\), got \(16, 32, 3\)",
        ),
        ({"env": BLINDING}, ValueError, "pixels must have sums that are finite"),
        ({"rotation": np.eye(2)}, ValueError, r"rotation must have the shape \(3, 3\)"),
        ({"rotation": np.diag([1.0, 1, -1])}, ValueError, "rotation must be a rotation"),
        ({"env": ENVIRONMENTS[1], "rotation": 2 * np.eye(3)}, ValueError, "rotation must be a rotation"),
        ({"brdf": "ggx"}, TypeError, "brdf must be a material of shrm.brdf, got str"),
        ({"env": ENVIRONMENTS[1], "brdf": brdf.GGX(0.3)}, ValueError, "brdf must have lobes as those of"),
        ({"brdf": brdf.GGX(0.3) + brdf.Lambert(0.5)}, ValueError, "brdf must have lobes as those of"),
        ({"brdf": brdf.Phong(4) + brdf.GGX(0.3)}, ValueError, "brdf must have lobes as those of"),
    ],
    ids=lambda x: None if isinstance(x, dict | type) else str(x)[:30],
)
def test_a_refused_update_changes_nothing(change, kind, text, half):
    """Neither the map nor what the next update starts from."""
    assert_refused(brdf.Lambert(0.5) + brdf.GGX(0.4), change, kind, text, half)


def assert_refused(material, change, kind, text, half):
    relit = Prefilter(ENVIRONMENTS[0], material, half=half, **OPTIONS)
    R = turns(1, seed=10)[0]
    before = relit.update(rotation=R)
    rings = [part.rings.copy() for part in before.parts]
    with pytest.raises(kind, match=text):
        relit.update(**change)
    assert relit.map is before
    for part, was in zip(before.parts, rings, strict=True):
        np.testing.assert_array_equal(part.rings, was)
    after = relit.update()
    assert after.brdf == material.name
    for part, was in zip(after.parts, rings, strict=True):
        np.testing.assert_array_equal(part.rings, was)


@pytest.mark.parametrize(
    "change",
    [
        {"env": BRIGHT},
        {"brdf": brdf.Lambert(0.5) + 1e6 * brdf.GGX(0.4)},  # the second lobe alone goes beyond
        {"env": BRIGHT, "rotation": QUARTER, "brdf": 1e-9 * brdf.Lambert(0.5) + brdf.GGX(0.6)},
    ],
    ids=["light", "material", "both"],
)
def test_what_half_floats_do_not_reach_is_refused_and_changes_nothing(change):
    material = brdf.Lambert(0.5) + brdf.GGX(0.4)
    assert_refused(material, change, ValueError, "maps must be at most 65504 to be half floats", half=True)


@pytest.mark.parametrize(
    ("out", "kind", "text"),
    [
        (np.zeros((16, 32, 3)), TypeError, "out must be an array of float32, got float64"),
        (np.zeros((16, 32, 4), np.float32), ValueError, r"out must have the shape \(16, 32, 3\)"),
        (np.zeros((3, 32, 16), np.float32).T, ValueError, "out must be contiguous in C order"),
    ],
)
def test_an_out_that_does_not_fit_is_named(out, kind, text):
    rm = prefilter(ENVIRONMENTS[0], brdf.GGX(0.4), **OPTIONS)
    with pytest.raises(kind, match=text):
        rm.at_view([0, 0, 1.0], out=out)
    two = prefilter(ENVIRONMENTS[0], brdf.Lambert(0.4) + brdf.GGX(0.4), **OPTIONS)
    with pytest.raises(ValueError, match="out is for materials of one lobe"):
        two.at_view([0, 0, 1.0], out=out)
