"""Maps of half floats: the conversion against numpy's, what it costs in accuracy, and what it refuses."""

import os
import subprocess
import sys

import numpy as np
import pytest
from shrm import ReflectionMap, _core, brdf, prefilter
from shrm._core import processor
from shrm.environment import Environment
from shrm.frequency.rings import empty_halves
from support import oracles
from support.light import band_limited_environment

ALL_HALVES = np.arange(1 << 16, dtype=np.uint16).view(np.float16)


def tricky_floats() -> np.ndarray:
    """All halves, the ties between them, a bit to either side of those, limits, and bits at random."""
    finite = np.sort(ALL_HALVES[np.isfinite(ALL_HALVES)].astype(np.float64))
    ties = ((finite[1:] + finite[:-1]) / 2).astype(np.float32)  # exact: 12 bits
    inf = np.float32(np.inf)
    limits = np.array(
        [0.0, 65503.99, 65504, 65519.99, 65520, 65520.01, 65536, 1e38, np.inf, np.nan, 2**-24, 2**-25, 1e-45],
        dtype=np.float32,
    )
    bits = np.random.default_rng(1).integers(0, 1 << 32, 200_003, dtype=np.uint32).view(np.float32)
    values = [finite.astype(np.float32), ties, np.nextafter(ties, inf), np.nextafter(ties, -inf)]
    return np.concatenate([*values, limits, -limits, bits])


SCRIPT = """
import sys
import numpy as np
from shrm import _core

given = np.load(sys.argv[1])
halves = np.empty(given["floats"].shape, dtype=np.float16)
_core.to_half(given["floats"], halves)
# Maps of one function, Y_00, are read back as they are, but for that factor.
rings = given["halves"].reshape(16, 1, 3, -1)
pixels = np.empty((16, rings.shape[3], 3), dtype=np.float32)
view = np.array([[0.0, 0.0, 1.0]])
_core.view_map(rings=rings, cube=False, zonal=True, direction=view, pixels=pixels)
largest = _core.largest_magnitude(given["floats"][np.isfinite(given["floats"])])
np.savez(sys.argv[2], halves=halves, pixels=pixels, largest=largest)
"""


@pytest.fixture(scope="module", params=processor.instruction_sets())
def converted(request, tmp_path_factory):
    """What each instruction set makes of the tricky floats, and of all halves."""
    folder = tmp_path_factory.mktemp(request.param)
    columns = -(-len(ALL_HALVES) // (16 * 3 * 2)) * 2 + 18  # even; vectors, and what they leave
    halves = np.resize(ALL_HALVES, 16 * 3 * columns)
    np.savez(folder / "given.npz", floats=tricky_floats(), halves=halves)
    subprocess.run(
        [sys.executable, "-c", SCRIPT, str(folder / "given.npz"), str(folder / "made.npz")],
        check=True,
        env={**os.environ, "SHRM_INSTRUCTION_SET": request.param},
        timeout=60,
    )
    return {"given": halves.reshape(16, 3, columns), **np.load(folder / "made.npz")}


def test_floats_become_the_halves_that_numpy_makes(converted):
    floats, halves = tricky_floats(), converted["halves"]
    with np.errstate(over="ignore", invalid="ignore"):
        expected = floats.astype(np.float16)
    nan = np.isnan(floats)
    np.testing.assert_array_equal(np.isnan(halves), nan)
    np.testing.assert_array_equal(halves.view(np.uint16)[~nan], expected.view(np.uint16)[~nan])


def test_halves_are_read_as_numpy_reads_them(converted):
    """Subnormal, infinite and NaN ones too."""
    with np.errstate(invalid="ignore"):  # signalling NaNs
        expected = converted["given"].astype(np.float32) * np.float32(1 / np.sqrt(4 * np.pi))
    np.testing.assert_allclose(converted["pixels"].transpose(0, 2, 1), expected, rtol=2e-7, atol=0)


def test_the_largest_magnitude_is_found(converted):
    floats = tricky_floats()
    assert converted["largest"] == np.abs(floats[np.isfinite(floats)]).max()


@pytest.mark.parametrize("n", [1, 3, 7, 15, 16, 17, 31, 33, 100])
def test_any_number_of_floats(n):
    floats = np.random.default_rng(n).normal(size=n).astype(np.float32)
    floats[n // 2] = -9
    halves = np.zeros(n, dtype=np.float16)
    _core.to_half(floats, halves)
    np.testing.assert_array_equal(halves, floats.astype(np.float16))
    assert _core.largest_magnitude(floats) == 9


MATERIALS = [brdf.Lambert(0.7), brdf.Phong(20), brdf.KajiyaKay(8), brdf.GGX(0.3, f0=(0.9, 0.5, 0.2))]


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize("material", MATERIALS, ids=lambda m: m.name)
def test_a_view_of_halves_is_that_of_floats_but_for_rounding(material, layout):
    env = band_limited_environment(10, seed=1)
    options = {"orders": (10, 4), "size": 26, "layout": layout}
    whole, halves = prefilter(env, material, **options), prefilter(env, material, half=True, **options)
    part, coarse = whole.parts[0], halves.parts[0]
    assert coarse.rings.dtype == np.float16
    assert coarse.maps.shape == part.maps.shape
    np.testing.assert_array_equal(coarse.rings, part.rings.astype(np.float16))
    np.testing.assert_array_equal(coarse.coefficients, part.coefficients)

    view = np.array([0.48, -0.6, 0.64])
    if part.zonal:
        cosine = part.directions() @ view
        along = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], axis=-1).reshape(-1, 3)
        p = np.arange(part.P + 1)
        Y = oracles.real_harmonics(part.P, along)[:, p * (p + 1)].T.reshape(-1, *cosine.shape, 1)
    else:
        Y = oracles.real_harmonics(part.P, view[None]).reshape(-1, *[1] * (part.maps.ndim - 1))
    # Each map's value is off by 2^-11 of itself, or by half the last bit of subnormal halves, 2^-25; float32
    # sums by less than a tenth of that.
    bound = 1.1 * (np.abs(Y) * (2.0**-11 * np.abs(part.maps) + 2.0**-25)).sum(axis=0)
    expected = whole.at_view(view)
    difference = np.abs(halves.at_view(view) - expected)
    assert np.all(difference <= bound)
    # Roundings of many maps cancel: over the picture less than a single one is left.
    assert 0 < oracles.relative_rms(halves.at_view(view), expected) < 2.0**-11


def test_the_error_is_predicted_from_halves_as_well():
    env = band_limited_environment(8, seed=2)
    options = {"orders": (6, 2), "size": 32}
    whole, halves = (prefilter(env, brdf.GGX(0.4), half=half, **options) for half in (False, True))
    assert halves.error == pytest.approx(whole.error, rel=0.01)


def test_values_that_halves_do_not_reach_are_refused():
    env = band_limited_environment(4, seed=3)
    bright = Environment(env.pixels * np.float32(1e6))
    prefilter(bright, brdf.Lambert(1.0), orders=(4, 0), size=8)
    with pytest.raises(
        ValueError, match=r"maps must be at most 65504 to be half floats, got .*e\+06: use half=False"
    ):
        prefilter(bright, brdf.Lambert(1.0), orders=(4, 0), size=8, half=True)
    with pytest.raises(TypeError, match="half must be True or False, got 1"):
        prefilter(env, brdf.Lambert(1.0), orders=(4, 0), size=8, half=1)


def test_halves_of_halves_are_the_same():
    part = prefilter(
        band_limited_environment(4, seed=4), brdf.GGX(0.5), orders=(4, 1), size=8, half=True
    ).parts[0]
    assert part.as_half() is part


@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_a_saved_map_of_halves_is_read_back_as_it_was(layout, tmp_path):
    env = band_limited_environment(6, seed=5)
    rm = prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16, layout=layout, half=True)
    rm.save(tmp_path / "map.exr")
    back = ReflectionMap.load(tmp_path / "map.exr")
    assert back.parts[0].rings.dtype == np.float16
    np.testing.assert_array_equal(back.parts[0].maps, rm.parts[0].maps)
    view = [0.0, 0.6, 0.8]
    np.testing.assert_array_equal(back.at_view(view), rm.at_view(view))
    assert back.error == pytest.approx(rm.error, rel=1e-6)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_radiance_of_half_maps(layout):
    env = Environment.daylight(size=32)
    whole, half = (
        prefilter(env, brdf.GGX(0.4), orders=(8, 2), size=16, layout=layout, half=flag)
        for flag in (False, True)
    )
    rng = np.random.default_rng(8)
    N, V = rng.normal(size=(2, 500, 3))
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    V /= np.linalg.norm(V, axis=1, keepdims=True)
    exact = whole.radiance(N, V)
    # The relative rounding of a half, 2^-11, of maps whose sum has no more energy than they have.
    assert np.sqrt(((half.radiance(N, V) - exact) ** 2).mean() / (exact**2).mean()) < 2**-11


@pytest.mark.parametrize(
    ("shape", "layout", "border"), [((12, 4, 3, 30), "cube", 2), ((5, 9, 3, 10), "latlong", 0)]
)
def test_rows_of_halves_begin_at_multiples_of_16_bytes(shape, layout, border):
    halves = empty_halves(shape, layout)
    assert halves.shape == shape
    rows = halves.ctypes.data + 2 * border + np.arange(np.prod(shape[:3])) * halves.strides[2]
    assert not np.any(rows % 16)
    floats = np.random.default_rng(1).normal(size=shape).astype(np.float32)
    _core.to_half(floats, halves)
    np.testing.assert_array_equal(halves, floats.astype(np.float16))


def test_halves_of_no_regular_rows_are_refused():
    floats = np.zeros((4, 3, 8), dtype=np.float32)
    for halves in (np.zeros((4, 3, 16), np.float16)[..., ::2], np.zeros((4, 5, 8), np.float16)[:, :3]):
        with pytest.raises(TypeError, match="halves must be contiguous, or in rows equally far apart"):
            _core.to_half(floats, halves)
    with pytest.raises(ValueError, match="halves must have the shape"):
        _core.to_half(floats, np.zeros((4, 3, 9), np.float16))


def test_axes_of_one_row_may_have_any_stride():
    floats = np.random.default_rng(2).random((6, 3, 8), dtype=np.float32)
    halves = np.lib.stride_tricks.as_strided(np.zeros((6, 3, 8), np.float16), (6, 1, 3, 8), (48, 0, 16, 2))
    _core.to_half(floats[:, None].copy(), halves)
    np.testing.assert_array_equal(halves[:, 0], floats.astype(np.float16))
