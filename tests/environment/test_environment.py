"""The environment: what it refuses, reading real files, energy, axes, irradiance."""

from __future__ import annotations

import json
import math
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from shrm import Environment, ImageError, ImageWarning, image_io
from shrm.environment import layouts
from support.data import environment, require

Array = npt.NDArray[np.float64]


@cache
def read(name: str) -> Environment:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImageWarning)
        return Environment.read(require(f"env/{name}"))


def integral(pixels: npt.NDArray[np.float32], layout: str = "latlong") -> Array:
    areas = layouts.solid_angles(layout, *pixels.shape[:2])
    return np.asarray(np.einsum("ij,ijc->c", areas, pixels))


def rotation(a: float, b: float, c: float) -> Array:
    def about(axis: int, t: float) -> Array:
        R = np.eye(3)
        i, j = [k for k in range(3) if k != axis]
        R[i, i] = R[j, j] = math.cos(t)
        R[i, j], R[j, i] = -math.sin(t), math.sin(t)
        return R

    return about(2, a) @ about(1, b) @ about(0, c)


# ---- the constructor


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_takes_floating_point(dtype: type) -> None:
    pixels = np.random.default_rng(0).random((4, 8, 3)).astype(dtype)
    env = Environment(pixels)
    assert env.pixels.dtype == np.float32
    assert env.pixels.flags.c_contiguous
    assert np.array_equal(env.pixels, pixels.astype(np.float32))
    with pytest.raises(ValueError, match="read-only"):
        env.pixels[0, 0, 0] = 1


def test_what_becomes_of_the_array_afterwards_does_not_matter() -> None:
    pixels = np.random.default_rng(0).random((4, 8, 3)).astype(np.float32)
    env, kept = Environment(pixels), pixels.copy()
    pixels[:] = np.nan
    assert np.array_equal(env.pixels, kept)


def test_refuses_a_masked_array() -> None:
    with pytest.raises(TypeError, match="masked"):
        Environment(np.ma.masked_less(np.ones((4, 8, 3), dtype=np.float32), 0))


@pytest.mark.parametrize("F", [2.5, "3", None, -1, 1001])
def test_refuses_degrees(F: object) -> None:
    with pytest.raises((TypeError, ValueError), match="F must be"):
        Environment(np.ones((4, 8, 3))).coefficients(F)  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", [(1, 8), (4, 3), (2.5, 8), ("4", 8), (10**9, 8), 8, (4, 8, 3), "48"])
def test_refuses_sizes(shape: tuple[object, object]) -> None:
    with pytest.raises((TypeError, ValueError), match=r"shape.* must be"):
        Environment(np.ones((4, 8, 3))).resized(shape)  # type: ignore[arg-type]


def test_radiance_that_overflows_is_told() -> None:
    env = Environment(np.full((4, 8, 3), 3e38, dtype=np.float32))
    with pytest.raises(ValueError, match="overflow"):
        env.coefficients(2)


def test_takes_views() -> None:
    pixels = np.random.default_rng(0).random((4, 8, 3)).astype(np.float32)
    assert np.array_equal(Environment(pixels[:, ::-1]).pixels, pixels[:, ::-1])


@pytest.mark.parametrize("shape", [(4, 8), (4, 8, 4), (1, 8, 3), (4, 3, 3), (0, 0, 3), (1, 1, 3)])
def test_refuses_shapes(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"pixels must have the shape \(H, W, 3\).*got"):
        Environment(np.zeros(shape))


def test_refuses_types() -> None:
    with pytest.raises(TypeError, match="floating-point numbers, got uint8"):
        Environment(np.zeros((4, 8, 3), np.uint8))  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="floating-point numbers, got list"):
        Environment([[1.0]])  # type: ignore[arg-type]


def test_refuses_not_finite() -> None:
    pixels = np.zeros((4, 8, 3))
    pixels[2, 5, 1], pixels[3, 0] = np.nan, 1e39  # beyond float32
    with pytest.raises(ValueError, match="finite, got 2 texels that are not, the first at row 2, column 5"):
        Environment(pixels)


# ---- files


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_write_and_read_keeps_energy(tmp_path: Path, layout: str) -> None:
    rng = np.random.default_rng(1)
    env = Environment((rng.random((32, 64, 3)) ** 8 * 100).astype(np.float32))
    env.write(tmp_path / "a.exr", layout)
    path = tmp_path / "a_{}.exr" if layout == "faces" else tmp_path / "a.exr"
    back = Environment.read(path, layout)
    assert integral(back.pixels) == pytest.approx(integral(env.pixels), rel=1e-4)


@pytest.mark.parametrize("layout", ["latlong", "vertical-cross", "horizontal-cross", "strip", "angular"])
def test_layouts_are_recognised_by_aspect(tmp_path: Path, layout: str) -> None:
    env = Environment.daylight(size=32)
    env.write(tmp_path / "a.exr", layout)
    assert np.array_equal(
        Environment.read(tmp_path / "a.exr").pixels, Environment.read(tmp_path / "a.exr", layout).pixels
    )


@pytest.mark.parametrize("layout", ["openexr-latlong", "openexr-cube"])
def test_layouts_are_recognised_by_metadata(tmp_path: Path, layout: str) -> None:
    env = Environment.daylight(size=32)
    env.write(tmp_path / "a.exr", layout)
    assert np.array_equal(
        Environment.read(tmp_path / "a.exr").pixels, Environment.read(tmp_path / "a.exr", layout).pixels
    )


@pytest.mark.parametrize(
    "names", ["px nx py ny pz nz", "posx negx posy negy posz negz", "right left top bottom front back"]
)
def test_six_faces_by_folder_and_by_pattern(tmp_path: Path, names: str) -> None:
    env = Environment.daylight(size=32)
    faces = env.picture("faces", 16)
    assert faces.shape == (6, 16, 16, 3)
    for name, face in zip(names.split(), faces, strict=True):
        image_io.write_image(tmp_path / f"sky_{name}.exr", face)
    expected = layouts.convert(faces.reshape(96, 16, 3), "faces", "latlong", 32)
    assert np.array_equal(Environment.read(tmp_path).pixels, expected)
    assert np.array_equal(Environment.read(tmp_path / "sky_{}.exr").pixels, expected)
    (tmp_path / f"sky_{names.split()[3]}.exr").unlink()
    with pytest.raises(ImageError, match="no six faces found there"):
        Environment.read(tmp_path)


def test_faces_must_be_squares_of_one_size(tmp_path: Path) -> None:
    for k, name in enumerate(["px", "nx", "py", "ny", "pz", "nz"]):
        image_io.write_image(tmp_path / f"{name}.exr", np.ones((4, 4 + (k == 3), 3), np.float32))
    with pytest.raises(ImageError, match="squares of one size, got 4 x 4, 4 x 4, 4 x 4, 5 x 4"):
        Environment.read(tmp_path)


def test_files_that_are_no_environment(tmp_path: Path) -> None:
    image_io.write_image(tmp_path / "one.exr", np.ones((1, 1, 3), np.float32))
    with pytest.raises(ImageError, match=r"one\.exr: a picture of 1 x 1 is too small"):
        Environment.read(tmp_path / "one.exr")
    image_io.write_image(tmp_path / "odd.exr", np.ones((5, 7, 3), np.float32))
    with pytest.raises(
        ImageError, match=r"odd\.exr: a picture must have a layout's aspect, got 7 x 5; .*strip"
    ):
        Environment.read(tmp_path / "odd.exr")
    with pytest.raises(ImageError, match=r"odd\.exr: a picture of layout strip is n x 6n or 6n x n"):
        Environment.read(tmp_path / "odd.exr", "strip")
    assert Environment.read(tmp_path / "odd.exr", "latlong").pixels.shape == (5, 7, 3)
    with pytest.raises(ValueError, match="layout must be one of"):
        Environment.read(tmp_path / "odd.exr", "sphere")


# ---- real environments


@pytest.mark.slow
@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_quarry_keeps_its_sun(layout: str) -> None:
    """The sun is over 1e4, the median 0.1; all of it must arrive, there and back."""
    env = environment("quarry_01_1k.hdr", 128, 256)
    before = integral(env.pixels)
    for size in (64, 16):
        picture = env.picture(layout, size)
        flat = picture.reshape(-1, *picture.shape[-2:]) if layout == "faces" else picture
        assert integral(flat, layout) == pytest.approx(before, rel=1e-3)
    back = layouts.convert(flat, layout, "latlong", 32)
    assert integral(back) == pytest.approx(before, rel=1e-3)


@pytest.mark.slow
def test_orientation_charts_agree() -> None:
    """OpenEXR's cube and lat-long show one chart; the same texels must be dark in both."""
    with pytest.warns(ImageWarning, match="alpha"):
        images = [
            image_io.read_image(require(f"env/openexr_Orientation{kind}.exr")) for kind in ("LatLong", "Cube")
        ]
    assert [image.layout for image in images] == ["openexr-latlong", "openexr-cube"]
    latlong, cube = (layouts.convert(image.pixels, str(image.layout), "latlong", 128) for image in images)
    # away from the poles, where the chart's own lat-long is smeared
    a, b = (pixels[20:-20].mean(axis=2) for pixels in (latlong, cube))
    agreement = np.corrcoef(a.ravel(), b.ravel())[0, 1]
    assert agreement > 0.97
    for other in (b[:, ::-1], b[::-1], np.roll(b, 64, axis=1), np.roll(b, 2, axis=1), np.roll(b, 1, axis=0)):
        assert np.corrcoef(a.ravel(), other.ravel())[0, 1] < agreement - 0.05


@pytest.mark.slow
def test_the_kerner_pair_has_one_mean() -> None:
    means = [integral(read(f"openexr_KernerEnv{kind}.exr").pixels) for kind in ("LatLong", "Cube")]
    assert means[0] == pytest.approx(means[1], rel=3e-4)


def nine_terms(d: Array) -> Array:
    """The positive real basis up to degree 2 with the constants printed by Ramamoorthi and Hanrahan 2001."""
    x, y, z = np.moveaxis(d, -1, 0)
    linear = [0.282095 + 0 * x, 0.488603 * y, 0.488603 * z, 0.488603 * x]
    mixed = [1.092548 * x * y, 1.092548 * y * z, 0.315392 * (3 * z * z - 1), 1.092548 * x * z]
    return np.stack([*linear, *mixed, 0.546274 * (x * x - y * y)], axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "layout", "title", "accuracy", "converted"),
    [
        ("debevec_rnl_probe.hdr", "angular", "Eucalyptus Grove", 4.1e-3, False),
        ("debevec_rnl_probe.hdr", "angular", "Eucalyptus Grove", 4.1e-3, True),
        ("debevec_grace_cross.hdr", "vertical-cross", "Grace Cathedral", 5.1e-3, False),
        ("debevec_grace_cross.hdr", "vertical-cross", "Grace Cathedral", 5.1e-3, True),
        ("debevec_stpeters_cross.hdr", "vertical-cross", "St. Peter's Basilica", 2.0e-3, False),
    ],
)
def test_published_coefficients(name: str, layout: str, title: str, accuracy: float, converted: bool) -> None:
    """Up to one scale each. The table's axes are x right, y up, z to the probe's center: (-y, z, x) here.

    As read, the figures are those that the data's notes state, to half a digit; converted to latitude and
    longitude, texels are areas twice, which costs another 1e-3 at most.
    """
    published = np.array(
        json.loads(require("env/sh9_published_debevec_probes.json").read_text())["coeffs"][title]
    )
    pixels = image_io.read_image(require(f"env/{name}")).pixels
    if converted:
        pixels, layout = read(name).pixels, "latlong"
    d = np.nan_to_num(layouts.directions(layout, *pixels.shape[:2]))
    areas = layouts.solid_angles(layout, *pixels.shape[:2])
    basis = nine_terms(np.stack([-d[..., 1], d[..., 2], d[..., 0]], axis=-1))
    L = np.tensordot(basis * areas[..., None], pixels.astype(np.float64), axes=([0, 1], [0, 1]))
    scaled = L * (L * published).sum() / (L * L).sum()
    error = np.linalg.norm(scaled - published) / np.linalg.norm(published)
    assert error < accuracy + (1e-3 if converted else 5e-5)


# ---- rotation and size


def test_rotated_moves_light_as_stated() -> None:
    """L'(w) = L(R^T w): what was seen in direction d is seen in R d."""
    d = layouts.directions("latlong", 64, 128)
    axis = np.array([0.6, -0.48, 0.64])
    pixels = np.exp(20 * (d @ axis - 1))[..., None].repeat(3, axis=2)
    R = rotation(0.7, 1.1, -2.0)
    turned = Environment(pixels).rotated(R).pixels
    expected = np.exp(20 * (d @ (R @ axis) - 1))
    # texels are flat and shared out twice: an error of a part of a texel, pi/64, times the slope, at most 2.7
    assert np.abs(turned[..., 0] - expected).max() < 2.7 * math.pi / 64 * 0.5
    assert integral(turned) == pytest.approx(integral(pixels.astype(np.float32)), rel=1e-5)


@pytest.mark.parametrize(
    "R", [np.eye(2), np.ones((3, 3)), -np.eye(3), np.diag([1, 1, 1.001]), np.full((3, 3), np.nan)]
)
def test_only_rotations(R: Array) -> None:
    with pytest.raises(ValueError, match="R must"):
        Environment.daylight(size=4).rotated(R)


def test_resized() -> None:
    env = Environment(np.random.default_rng(2).random((32, 64, 3)))
    for H, W in ((16, 32), (20, 50), (64, 128), (2, 4)):
        assert env.resized((H, W)).pixels.shape == (H, W, 3)
        assert integral(env.resized((H, W)).pixels) == pytest.approx(integral(env.pixels), rel=1e-5)
    with pytest.raises(ValueError, match=r"shape\[0\] must be in \[2, 65536\], got 1"):
        env.resized((1, 4))
    with pytest.raises(ValueError, match=r"shape\[1\] must be in \[4, 65536\], got 3"):
        env.resized((2, 3))


def test_black_is_valid() -> None:
    black = Environment(np.zeros((8, 16, 3)))
    assert not black.rotated(rotation(1, 2, 3)).pixels.any()
    assert not black.picture("angular").any()


def test_small_pictures_convert() -> None:
    env = Environment(np.ones((2, 4, 3)))
    for layout in layouts.LAYOUTS:
        assert env.picture(layout, 2).max() == pytest.approx(1, abs=1e-6)


# ---- spherical harmonics


def test_coefficients_of_a_constant_and_cache() -> None:
    env = Environment(np.ones((32, 64, 3)))
    c = env.coefficients(4)
    assert c.shape == (25, 3)
    assert c[0] == pytest.approx(math.sqrt(4 * math.pi), rel=1e-6)
    assert np.abs(c[1:]).max() < 1e-6
    assert np.array_equal(env.coefficients(2), c[:9])
    with pytest.raises(ValueError, match=r"F must be in \[0, 1000\]"):
        env.coefficients(-1)


def test_irradiance_against_integration() -> None:
    """For light of degree 2 the nine terms are all there are."""
    d = layouts.directions("latlong", 128, 256)
    light = 2 + d @ np.array([[0.5, 0.1, -0.3], [0.2, 0.4, 0.3], [-0.2, 0.5, 0.1]])
    light += (d[..., :1] * d[..., 1:2]) * 0.7 + d[..., 2:] ** 2 * 0.4
    normals = np.random.default_rng(3).normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    areas = layouts.solid_angles("latlong", 128, 256)
    cosine = np.maximum(d @ normals.T, 0)
    expected = np.einsum("ij,ijn,ijc->nc", areas, cosine, light)
    # texels of pi/128 as areas: (pi/128)^2 of the curvature, for both ways of integrating
    assert Environment(light).irradiance(normals) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("normals", [np.ones(3), np.ones((2, 3)), np.ones((2, 2))])
def test_irradiance_refuses(normals: Array) -> None:
    with pytest.raises(ValueError, match="normals must"):
        Environment(np.zeros((4, 8, 3))).irradiance(normals)


def test_an_environment_is_said_in_one_line() -> None:
    pixels = np.zeros((4, 8, 3), np.float32)
    pixels[:2] = (1.0, 2.0, 4.0)  # the upper half
    assert repr(Environment(pixels)) == "<Environment 4 x 8, mean radiance 0.5, 1, 2>"


def test_an_environment_is_an_array_of_its_pixels() -> None:
    env = Environment(np.random.default_rng(3).random((4, 8, 3), np.float32))
    np.testing.assert_array_equal(np.asarray(env), env.pixels)
    assert np.shares_memory(np.asarray(env), env.pixels)
    assert np.asarray(env).dtype == np.float32
    copied = np.array(env)
    copied[:] = 0.0  # may be written to, and is its own
    assert env.pixels.any()
    assert np.asarray(env, np.float64).dtype == np.float64
    with pytest.raises(ValueError, match="copy"):
        np.asarray(env, np.float64, copy=False)


def test_a_strip_may_be_called_a_cube(tmp_path: Path) -> None:
    env = Environment(np.random.default_rng(4).random((8, 16, 3), np.float32))
    np.testing.assert_array_equal(env.picture("cube"), env.picture("strip"))
    np.testing.assert_array_equal(env.picture("cube", 5), env.picture("strip", 5))
    env.write(tmp_path / "cube.exr", "cube")
    again = [Environment.read(tmp_path / "cube.exr", layout).pixels for layout in ("cube", "strip")]
    np.testing.assert_array_equal(*again)
