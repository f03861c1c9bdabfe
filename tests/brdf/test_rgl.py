"""RGL/EPFL files: equal to an independent reading of the format; what is damaged is refused in one line."""

import struct
from pathlib import Path

import numpy as np
import pytest
from shrm import _core, brdf
from shrm.brdf.measured import rgl
from shrm.brdf.measured.spectrum import to_linear_srgb
from support import rgl_format
from support.data import require
from support.directions import direction, hemisphere

FILES = ["aurora_white_rgb", "cm_military_green_rgb", "ilm_solo_m_68_rgb", "vch_golden_yellow_rgb"]
Fields = dict[str, np.ndarray]


def pairs(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Anywhere above the horizon; a fifth each with a grazing light or eye, near mirror, near retro."""
    rng = np.random.default_rng(seed)
    wi, wo = hemisphere(n, seed + 1), hemisphere(n, seed + 2)
    kinds = np.arange(n) % 5
    wi[kinds == 1, 2] *= 1e-3
    wo[kinds == 2, 2] *= 1e-3
    near = rng.normal(size=(n, 3)) * 10 ** rng.uniform(-4, -1, (n, 1))
    wi = np.where(
        (kinds == 3)[:, None], wo * [-1, -1, 1] + near, np.where((kinds == 4)[:, None], wo + near, wi)
    )
    wi[:, 2] = np.abs(wi[:, 2])
    return tuple(w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))


def written(folder: Path, fields: Fields) -> Path:
    path = folder / "sample.bsdf"
    path.write_bytes(rgl_format.content(fields))
    return path


def require_equal(fields: Fields, material: brdf.Measured, wi: np.ndarray, wo: np.ndarray) -> None:
    # The core keeps vndf's integrals as float32: x and y, quotients of two, are within 2^-23 and the samples,
    # n - 1 to the unit, differ by no more than their range from one to the next.
    rgb = fields["rgb"][0]
    steps = 2 * (rgb.shape[-1] - 1) * 2.0**-23 * np.ptp(rgb, axis=(0, 2, 3))
    floor = rgl_format.factor(fields, wo, wi)[:, None] * steps
    expected = rgl_format.evaluate(fields, wo, wi)
    difference = np.abs(material.function(wi, wo) - expected)
    assert np.all(difference <= 1e-5 * expected + floor)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_real_files_equal_an_independent_reading(name: str) -> None:
    path = require(f"brdf/{name}.bsdf")
    material = rgl.read(path)
    wi, wo = pairs(10_000, 1)
    require_equal(rgl_format.read(path), material, wi, wo)
    assert (material.label, material.source) == (name, "RGL")
    assert material.notes[0] == rgl_format.read(path)["description"].tobytes().decode()


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_real_materials_are_their_own_mirror_images_and_reflect_less_than_all(name: str) -> None:
    material = brdf.load(require(f"brdf/{name}.bsdf"))
    wi, wo = pairs(5000, 2)
    values, mirror = material.transfer(wi, wo), np.array([1, -1, 1])
    assert np.abs(material.transfer(wi * mirror, wo * mirror) - values).max() < 1e-3 * values.max()
    assert values.min() >= 0.0
    with pytest.warns(RuntimeWarning, match="only known to"):  # the table's cells have kinks
        albedo = brdf.directional_albedo(material, [1.0, 0.5, 0.05])
    assert albedo.min() > 0.01
    assert albedo.max() < 1.0


@pytest.mark.parametrize("name", FILES)
def test_valid_samples_are_those_above_the_horizon(name: str) -> None:
    """What the mask is taken for; in one of the files it is the complement."""
    fields = rgl_format.read(require(f"brdf/{name}.bsdf"))
    slices, _, k, _ = fields["rgb"][0].shape
    bits = np.unpackbits(fields["valid"]).reshape(slices, k, k).astype(bool)
    y, x = (grid.ravel() for grid in np.meshgrid(*2 * [np.linspace(0, 1, k)], indexing="ij"))
    at = 3
    u, v = rgl_format.half_vectors(rgl_format.densities(fields["vndf"][0, at : at + 1])[0], y, x)
    theta_i, theta_m, phi_m = fields["theta_i"][at], u**2 * np.pi / 2, (2 * v - 1) * np.pi
    i_m = np.cos(theta_i) * np.cos(theta_m) + np.sin(theta_i) * np.sin(theta_m) * np.cos(phi_m)
    above = (2 * i_m * np.cos(theta_m) - np.cos(theta_i) > 0).reshape(k, k)
    np.testing.assert_array_equal(bits[at] == bits[0, 0, 0], above)


@pytest.mark.parametrize("changes", [{}, {"jacobian": np.zeros(1, np.uint8)}, {"theta_i": 1}])
def test_small_files_equal_an_independent_reading(tmp_path: Path, changes: dict) -> None:
    fields = rgl_format.random(3, slices=changes.pop("theta_i", 3)) | changes
    wi, wo = pairs(10_000, 3)
    require_equal(fields, rgl.read(written(tmp_path, fields)), wi, wo)


@pytest.mark.slow
def test_a_model_written_to_the_format_reads_back(tmp_path: Path) -> None:
    """GGX against its formula: V is the direction of theta_i, and the cosine is that of L."""
    alpha, relative = 0.2, []
    model = brdf.GGX(alpha, 1.0)
    wi, wo = hemisphere(8000, 4), hemisphere(8000, 5)
    clear = (wi[:, 2] > 0.3) & (wo[:, 2] > 0.2)  # of the horizon, where the samples end in a kink
    wi, wo = wi[clear], wo[clear]
    expected = model.transfer(wi, wo)
    for slices, k in ((8, 16), (16, 32)):
        material = rgl.read(written(tmp_path, rgl_format.ggx(alpha, slices, k)))
        difference = material.function(wi, wo) - expected[:, None]
        relative.append(np.sqrt(np.mean(difference**2) / np.mean(expected**2)))
    # Linear interpolation: twice as fine, four times as good; three, for the finer one has vndf's error too.
    assert relative[1] < 0.003
    assert relative[1] < relative[0] / 3


def test_a_constant_without_the_factor_is_that_constant(tmp_path: Path) -> None:
    fields = rgl_format.random(5) | {"jacobian": np.zeros(1, np.uint8)}
    fields["rgb"] = np.broadcast_to(np.float32([0.1, 0.2, 0.3])[:, None, None], fields["rgb"].shape).copy()
    wi, wo = pairs(1000, 6)
    values = rgl.read(written(tmp_path, fields)).function(wi, wo)
    np.testing.assert_allclose(values, np.broadcast_to(np.float32([0.1, 0.2, 0.3]), (1000, 3)), rtol=1e-14)


def test_grey_spectra_are_grey(tmp_path: Path) -> None:
    fields = rgl_format.random(6)
    grey = fields["rgb"][:, :, :1]
    fields["rgb"] = np.repeat(grey, 3, axis=2)
    wi, wo = pairs(1000, 7)
    expected = rgl.read(written(tmp_path, fields)).function(wi, wo)
    del fields["rgb"]
    fields |= {
        "wavelengths": np.linspace(360, 1000, 33, dtype=np.float32),
        "spectra": np.repeat(grey, 33, axis=2),
    }
    material = rgl.read(written(tmp_path, fields))
    # In sRGB, equal energy at every wavelength is grey under the illuminant the colors are made for.
    np.testing.assert_allclose(material.function(wi, wo), expected, rtol=1e-6)


def test_colors_are_those_of_the_spectra(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    fields = rgl_format.random(8)
    wavelengths = np.linspace(400, 700, 16, dtype=np.float32)
    spectra = rng.uniform(0.2, 1, (1, 3, 16, 4, 4)).astype(np.float32)
    colors = to_linear_srgb(wavelengths.astype(float), np.moveaxis(spectra, 2, -1).astype(float))
    wi, wo = pairs(1000, 9)
    rgb = np.moveaxis(colors, -1, 2).astype(np.float32)
    expected = rgl.read(written(tmp_path, fields | {"rgb": rgb})).function(wi, wo)
    del fields["rgb"]
    material = rgl.read(written(tmp_path, fields | {"wavelengths": wavelengths, "spectra": spectra}))
    np.testing.assert_allclose(material.function(wi, wo), expected, rtol=1e-6, atol=1e-7)


def test_directions_of_any_strides_and_none(tmp_path: Path) -> None:
    material = rgl.read(written(tmp_path, rgl_format.random(10)))
    wi, wo = pairs(1001, 10)
    values = material.function(wi, wo)
    np.testing.assert_array_equal(material.function(np.asfortranarray(wi), wo[::-1][::-1]), values)
    np.testing.assert_array_equal(material.function(wi[::-3], wo[::-3]), values[::-3])
    assert material.function(wi[:0], wo[:0]).shape == (0, 3)
    assert material.transfer(-wi, wo).max() == 0.0


def test_the_eye_above_the_surface_sees_no_azimuth(tmp_path: Path) -> None:
    material = rgl.read(written(tmp_path, rgl_format.random(11)))
    above = np.repeat(direction(1.0, 0.0), 5, axis=0)
    light = np.concatenate([direction(0.6, phi) for phi in np.linspace(0, 6, 5)])
    values = material.function(light, above)
    np.testing.assert_allclose(values, np.broadcast_to(values[0], (5, 3)), rtol=1e-12)


# Coverage -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("complement", [False, True])
def test_covered_is_where_the_nearest_sample_is_valid(tmp_path: Path, complement: bool) -> None:
    fields = rgl_format.random(12)
    bits = np.random.default_rng(12).random((3, 4, 4)) < 0.6
    bits[0, 0, 0] = True
    fields["valid"] = np.packbits(bits ^ complement)
    path = written(tmp_path, fields)
    wi, wo = pairs(4000, 13)
    place = rgl_format.samples(fields, wo, wi) * [1, 3, 3]
    clear = np.all(np.abs(place % 1 - 0.5) > 1e-5, axis=1)  # of two equally near samples either will do
    expected = bits[tuple(np.rint(place).astype(int).T)]
    nearest, zero = rgl.read(path), rgl.read(path, "zero")
    covered = nearest.covers(wi, wo)
    np.testing.assert_array_equal(covered[clear], expected[clear])
    np.testing.assert_array_equal(zero.covers(wi, wo), covered)
    np.testing.assert_array_equal(zero.function(wi, wo), nearest.function(wi, wo) * covered[:, None])
    assert (zero.extrapolate, nearest.extrapolate) == ("zero", "nearest")


def test_without_a_mask_all_is_covered(tmp_path: Path) -> None:
    fields = rgl_format.random(13)
    del fields["valid"]
    assert rgl.read(written(tmp_path, fields)).covers(*pairs(100, 14)).all()


# What is odd, and what is wrong -------------------------------------------------------------------


def test_what_is_odd_is_noted(tmp_path: Path) -> None:
    fields = rgl_format.random(14)
    fields["rgb"][0, 0, 0, 0, 0] = -0.5
    fields["vndf"][0, 0, 0, :2] = -1e-9
    notes = "\n".join(rgl.read(written(tmp_path, fields)).notes)
    assert "noise\n" in notes
    assert "1 of 144 colors were negative" in notes
    assert "2 of 108 values of vndf were negative" in notes
    assert "from its mirror image" in notes


def without(name: str) -> Fields:
    fields = rgl_format.random(15)
    del fields[name]
    return fields


def changed(name: str, value: np.ndarray) -> Fields:
    return rgl_format.random(15) | {name: value}


def replaced(name: str, value: float) -> Fields:
    fields = rgl_format.random(15)
    fields[name].flat[0] = value
    return fields


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        *((without(name), f"has no field '{name}'") for name in ("phi_i", "theta_i", "ndf", "sigma", "vndf")),
        (without("rgb"), "has no field 'rgb'"),
        (without("jacobian"), "has no field 'jacobian'"),
        (changed("phi_i", np.zeros(8, np.float32)), "is anisotropic, it has 8 phi_i"),
        (changed("theta_i", np.float32([0, 1, 1])), "theta_i must rise"),
        (changed("theta_i", np.float32([0, 1, 2])), "theta_i must rise"),
        (changed("theta_i", np.float32([0, 1])), r"vndf must have the shape \(1, 2, n, n\)"),
        (
            changed("theta_i", np.float64([0, 1, 1.5])),
            "theta_i must have 1 dimensions of type f4, got 1 of type f8",
        ),
        (changed("ndf", np.ones((1, 5), np.float32)), "ndf must have two rows"),
        (changed("rgb", np.ones((1, 3, 4, 4, 4), np.float32)), r"rgb must have the shape \(1, 3, 3, n, n\)"),
        (changed("rgb", np.ones((1, 3, 3, 4), np.float32)), "rgb must have 5 dimensions"),
        (changed("rgb", np.ones((1, 3, 3, 0, 4), np.float32)), "rgb must have 1 to"),
        (changed("vndf", np.zeros((1, 3, 4, 4), np.float32)), "vndf must not be 0"),
        (replaced("vndf", np.nan), "vndf must be finite and below .*, got 1 values"),
        (replaced("rgb", np.inf), "rgb must be finite"),
        (replaced("sigma", 0), "sigma must be positive"),
        (replaced("jacobian", 7), "jacobian must be 0 or 1"),
        (changed("valid", np.zeros(2, np.uint8)), "valid must have 6 bytes, got 2"),
        (changed("größe", np.zeros(2, np.uint8)), "the name of a field must be an ASCII identifier"),
        (
            without("rgb")
            | {"spectra": np.ones((1, 3, 2, 4, 4), np.float32), "wavelengths": np.float32([500, 400])},
            "wavelengths must be two or more strictly",
        ),
        (
            without("rgb")
            | {"spectra": np.ones((1, 3, 2, 4, 4), np.float32), "wavelengths": np.float32([1, 2, 3])},
            r"spectra must have the shape \(1, 3, 3, n, n\)",
        ),
    ],
)
def test_fields_that_are_wrong_are_refused_by_name(tmp_path: Path, fields: Fields, text: str) -> None:
    require_refusal(written(tmp_path, fields), text)


def at(name: str, within: int, value: bytes) -> bytes:
    """A file with other bytes where its header says type (0), offset (1) or shape (9) of a field."""
    whole = bytearray(rgl_format.content(rgl_format.random(16)))
    place = whole.index(name.encode()) + len(name) + 2 + within
    whole[place : place + len(value)] = value
    return bytes(whole)


WHOLE = rgl_format.content(rgl_format.random(16))


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"", "is no tensor file"),
        (b"tensor_fil\0\0" + WHOLE[12:], "is no tensor file"),
        (WHOLE[:12] + b"\2" + WHOLE[13:], "version 1.0, got 2.0"),
        (WHOLE[:14] + b"\xff\xff\xff\xff" + WHOLE[18:], "at most 64 fields, got 4294967295"),
        (WHOLE[:14] + struct.pack("<I", 40) + WHOLE[18:], "identifier|dimensions|type|truncated|two fields"),
        (WHOLE[:100], "the header is truncated"),
        (WHOLE[:-1], "truncated or damaged"),
        (at("vndf", 0, b"\0"), "vndf must be of a type from 1 to 11, got 0"),
        (at("vndf", -2, b"\xff\xff"), "vndf must have at most 8 dimensions, got 65535"),
        (at("vndf", 1, struct.pack("<Q", 2**64 - 8)), "vndf, .* ends at byte"),
        (at("vndf", 1, struct.pack("<Q", 8)), "vndf starts at byte 8, within"),
        (at("vndf", 9, struct.pack("<4Q", *4 * [2**32])), "vndf, .* ends at byte 13611294676837538538"),
        (at("vndf", 9, struct.pack("<4Q", 2**62, 2**62, 2**62, 0)), "vndf must have 1 to"),
        (at("ndf", 9, struct.pack("<2Q", 3, 5)), "starts at byte .*, within"),
    ],
)
def test_containers_that_are_wrong_are_refused(tmp_path: Path, content: bytes, text: str) -> None:
    path = tmp_path / "sample.bsdf"
    path.write_bytes(content)
    require_refusal(path, text)


def require_refusal(path: Path, text: str) -> None:
    with pytest.raises(ValueError, match=text) as caught:
        rgl.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "shape"),
    [("theta_i", (0,)), ("vndf", (3, 1, 4)), ("values", (3, 2, 2, 1)), ("ndf", (1, 3)), ("sigma", (1,))],
)
def test_the_core_guards_memory(name: str, shape: tuple[int, ...]) -> None:
    shapes = {"theta_i": (3,), "vndf": (3, 4, 4), "values": (3, 2, 2, 3), "ndf": (2, 3), "sigma": (2,)}
    tables = {
        key: np.ones(extents, np.float64 if key == "theta_i" else np.float32)
        for key, extents in (shapes | {name: shape}).items()
    }
    with pytest.raises(ValueError, match=name):
        _core.AdaptiveParameterization(**tables)


def test_a_missing_file_is_an_oserror(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        rgl.read(tmp_path / "none.bsdf")


def test_tensor_files_are_recognised() -> None:
    assert rgl.recognises(WHOLE[:4096], len(WHOLE))
    assert not rgl.recognises(WHOLE[1:], len(WHOLE))
    assert not rgl.recognises(b"", 0)
