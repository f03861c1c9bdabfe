"""Pictures in and out: values, conversions that are said, faults in one line, whole files or none."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio  # noqa: N813 - to make files that image_io must cope with
import pytest
from shrm import color, image_io
from shrm.image_io import ImageError, ImageWarning, Part

Pixels = npt.NDArray[np.float32]


@pytest.fixture
def pixels() -> Pixels:
    return np.random.default_rng(0).random((6, 8, 3), dtype=np.float32) * 5


def write_raw(path: Path, array: npt.NDArray[np.generic], **attributes: object) -> Path:
    """Write any channels and attributes, past image_io."""
    h, w, c = array.shape
    kind = {"float32": oiio.FLOAT, "uint8": oiio.UINT8, "uint16": oiio.UINT16}[str(array.dtype)]
    spec = oiio.ImageSpec(w, h, c, kind)
    for name, value in attributes.items():
        if isinstance(value, tuple):
            semantics = oiio.VECSEMANTICS.NOSEMANTICS
            spec.attribute(
                name, oiio.TypeDesc(oiio.FLOAT, oiio.AGGREGATE.SCALAR, semantics, len(value)), value
            )
        else:
            spec.attribute(name, value)
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(array)
    assert out.close()
    return path


@pytest.mark.parametrize(("suffix", "relative"), [(".exr", 0), (".pfm", 0), (".tif", 0), (".hdr", 1 / 128)])
def test_round_trip(tmp_path: Path, pixels: Pixels, suffix: str, relative: float) -> None:
    """An .hdr has 8 bits of mantissa for the largest channel."""
    image_io.write_image(tmp_path / f"a{suffix}", pixels)
    back = image_io.read_image(tmp_path / f"a{suffix}").pixels
    assert back.dtype == np.float32
    assert back.flags.c_contiguous
    assert np.all(np.abs(back - pixels) <= relative * pixels.max(axis=2, keepdims=True))
    assert [p.name for p in tmp_path.iterdir()] == [f"a{suffix}"]


def test_pfm_is_upside_right(tmp_path: Path, pixels: Pixels) -> None:
    """By the format's definition: text header, then rows from the lowest up."""
    data = b"PF\n8 6\n-1.0\n" + pixels[::-1].tobytes()
    (tmp_path / "a.pfm").write_bytes(data)
    assert np.array_equal(image_io.read_image(tmp_path / "a.pfm").pixels, pixels)
    image_io.write_image(tmp_path / "b.pfm", pixels)
    assert (tmp_path / "b.pfm").read_bytes().endswith(pixels[::-1].tobytes())


def test_exr_keeps_metadata(tmp_path: Path, pixels: Pixels) -> None:
    metadata = {"text": "z up", "count": 3, "ratio": 0.5, "table": [1.0, 2.5, 3.0, 4.0, 5.0]}
    image_io.write_image(tmp_path / "a.exr", pixels, metadata=metadata)
    read = image_io.read_image(tmp_path / "a.exr").metadata
    assert {name: read[name] for name in ("text", "count", "ratio")} == {
        k: metadata[k] for k in ("text", "count", "ratio")
    }
    assert list(read["table"]) == metadata["table"]


def test_exr_envmap_attribute(tmp_path: Path, pixels: Pixels) -> None:
    for says, layout in (
        ("LatLong Environment", "openexr-latlong"),
        ("CubeFace Environment", "openexr-cube"),
    ):
        image_io.write_image(tmp_path / "a.exr", pixels, metadata={"textureformat": says})
        assert image_io.read_image(tmp_path / "a.exr").layout == layout
    image_io.write_image(tmp_path / "a.exr", pixels)
    assert image_io.read_image(tmp_path / "a.exr").layout is None


def test_parts_round_trip(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    parts = [
        Part(
            "maps", rng.normal(size=(4, 6, 12)).astype(np.float32), [f"p{k}.R" for k in range(12)], {"F": 3}
        ),
        Part("table", rng.normal(size=(1, 9, 1)).astype(np.float32), ["gamma"], {"note": '{"a": 1}'}),
    ]
    image_io.write_parts(tmp_path / "a.exr", parts)
    back = image_io.read_parts(tmp_path / "a.exr")
    for part, read in zip(parts, back, strict=True):
        assert (read.name, list(read.channels)) == (part.name, list(part.channels))
        assert np.array_equal(read.pixels, part.pixels)
        assert all(read.metadata[name] == value for name, value in part.metadata.items())
    assert [p.name for p in tmp_path.iterdir()] == ["a.exr"]


def test_of_several_parts_the_first_is_read(tmp_path: Path, pixels: Pixels) -> None:
    image_io.write_parts(tmp_path / "a.exr", [Part("a", pixels, "RGB"), Part("b", 2 * pixels, "RGB")])
    assert np.array_equal(image_io.read_image(tmp_path / "a.exr").pixels, pixels)


def test_grey_becomes_rgb(tmp_path: Path, pixels: Pixels) -> None:
    write_raw(tmp_path / "a.exr", np.ascontiguousarray(pixels[..., :1]))
    assert np.array_equal(
        image_io.read_image(tmp_path / "a.exr").pixels, np.repeat(pixels[..., :1], 3, axis=2)
    )


def test_alpha_is_dropped_and_said(tmp_path: Path, pixels: Pixels) -> None:
    rgba = np.concatenate([pixels, np.full((6, 8, 1), 0.5, np.float32)], axis=2)
    write_raw(tmp_path / "a.exr", rgba)
    with pytest.warns(ImageWarning, match=r"a\.exr: its alpha channel is dropped"):
        assert np.array_equal(image_io.read_image(tmp_path / "a.exr").pixels, pixels)


@pytest.mark.parametrize(("dtype", "suffix"), [(np.uint8, ".png"), (np.uint16, ".png"), (np.uint16, ".tif")])
def test_integers_are_decoded_and_said(tmp_path: Path, dtype: type, suffix: str) -> None:
    stored = np.random.default_rng(2).integers(0, np.iinfo(dtype).max, (5, 7, 3), endpoint=True).astype(dtype)
    write_raw(tmp_path / f"a{suffix}", stored)
    with pytest.warns(ImageWarning, match="decoded from sRGB to linear light"):
        read = image_io.read_image(tmp_path / f"a{suffix}").pixels
    v = stored / np.iinfo(dtype).max
    assert read == pytest.approx(np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4), abs=1e-6)


def test_chromaticities_are_converted_and_said(tmp_path: Path, pixels: Pixels) -> None:
    """Rec. 2020 shares the white of Rec. 709; the matrix is the published one (ITU-R BT.2087, inverted)."""
    rec2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)
    write_raw(tmp_path / "a.exr", pixels, chromaticities=rec2020)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        read = image_io.read_image(tmp_path / "a.exr").pixels
    assert "converted to linear Rec. 709" in str(said[0].message)
    m = np.array([[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]])
    assert read == pytest.approx(pixels @ m.T, abs=5e-4 * 5)


def test_another_white_goes_to_white() -> None:
    aces = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
    assert color.rec709_from_rgb(aces).sum(axis=1) == pytest.approx([1, 1, 1], abs=1e-9)
    assert color.rec709_from_rgb(color.REC709) == pytest.approx(np.eye(3), abs=1e-12)
    assert color.xyz_from_rgb(color.REC709)[1] == pytest.approx([0.2126, 0.7152, 0.0722], abs=1e-4)


def test_orientation(tmp_path: Path, pixels: Pixels) -> None:
    write_raw(tmp_path / "a.exr", np.ascontiguousarray(pixels[::-1]), Orientation=4)
    with pytest.warns(ImageWarning, match="turned upright"):
        assert np.array_equal(image_io.read_image(tmp_path / "a.exr").pixels, pixels)


def test_not_finite_is_refused_with_its_place(tmp_path: Path, pixels: Pixels) -> None:
    pixels[2, 3, 1], pixels[4, 5] = np.nan, np.inf
    write_raw(tmp_path / "a.exr", pixels)
    with pytest.raises(
        ImageError, match=r"a\.exr: 2 texels are NaN or infinite, the first at row 2, column 3"
    ):
        image_io.read_image(tmp_path / "a.exr")


def test_repair_takes_the_neighbors(tmp_path: Path) -> None:
    i, j = np.mgrid[0:9, 0:9]
    ramp = np.repeat((i + 2 * j)[..., None], 3, axis=2).astype(np.float32)
    holed = ramp.copy()
    holed[4, 4] = np.nan
    write_raw(tmp_path / "a.exr", holed)
    with pytest.warns(ImageWarning, match="replaced by the mean of their neighbors"):
        assert image_io.read_image(tmp_path / "a.exr", repair=True).pixels == pytest.approx(ramp)
    holed[1:8, 1:8] = np.inf
    write_raw(tmp_path / "b.exr", holed)
    with pytest.warns(ImageWarning, match="49 texels"):
        read = image_io.read_image(tmp_path / "b.exr", repair=True).pixels
    assert np.all((read >= 0) & (read <= ramp.max()))
    write_raw(tmp_path / "c.exr", np.full((2, 2, 3), np.nan, np.float32))
    with pytest.raises(ImageError, match="all texels"):
        image_io.read_image(tmp_path / "c.exr", repair=True)


def test_negative_values_are_kept_and_said_once(tmp_path: Path, pixels: Pixels) -> None:
    pixels[1, 1] = pixels[2, 2, 0] = -0.25
    image_io.write_image(tmp_path / "a.exr", pixels)
    with pytest.warns(ImageWarning, match="2 texels have negative values") as said:
        assert np.array_equal(image_io.read_image(tmp_path / "a.exr").pixels, pixels)
    assert len(said) == 1


@pytest.mark.parametrize(
    ("name", "content", "fault"),
    [
        ("missing.exr", None, "No such file"),
        ("empty.hdr", b"", "is empty"),
        ("text.hdr", b"To be or not to be", "is not a picture"),
        ("text.exr", b"To be or not to be", "is not a picture"),
        ("text.png", b"\xff\xfe" * 50, "is not a picture"),
        ("data.xyz", b"1 2 3\n", "is not a picture"),
    ],
)
def test_no_picture(tmp_path: Path, name: str, content: bytes | None, fault: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(ImageError, match=fault) as caught:
        image_io.read_image(tmp_path / name)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)
    with pytest.raises(ImageError):
        image_io.read_parts(tmp_path / name)


def test_a_folder_is_no_picture(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match="is a folder"):
        image_io.read_image(tmp_path)


def test_too_large_is_refused_from_the_header(tmp_path: Path) -> None:
    """Of a truncated file the size is the first complaint: only the header can have been read."""
    image_io.write_image(tmp_path / "a.hdr", np.ones((600, 800, 3), np.float32))
    (tmp_path / "a.hdr").write_bytes((tmp_path / "a.hdr").read_bytes()[:5000])
    with pytest.raises(
        ImageError, match="800 x 600 x 3 channels takes 5 MiB decoded, over the limit of 1 MiB"
    ):
        image_io.read_image(tmp_path / "a.hdr", max_bytes=1 << 20)
    with pytest.raises(ImageError, match="truncated or damaged"):
        image_io.read_image(tmp_path / "a.hdr")
    image_io.write_image(tmp_path / "b.exr", np.ones((10, 10, 3), np.float32))
    with pytest.raises(ImageError, match="over the limit"):
        image_io.read_image(tmp_path / "b.exr", max_bytes=1199)
    assert image_io.read_image(tmp_path / "b.exr", max_bytes=1200).pixels.shape == (10, 10, 3)


def test_nothing_is_left_of_a_failed_write(tmp_path: Path, pixels: Pixels) -> None:
    (tmp_path / "a.exr").mkdir()  # renaming onto a folder fails at the very end
    with pytest.raises(ImageError, match="cannot be written"):
        image_io.write_image(tmp_path / "a.exr", pixels)
    assert [p.name for p in tmp_path.iterdir()] == ["a.exr"]
    with pytest.raises(ImageError, match="cannot be written"):
        image_io.write_image(tmp_path / "no" / "folder.exr", pixels)


def test_writing_refuses(tmp_path: Path, pixels: Pixels) -> None:
    with pytest.raises(ImageError, match=r"cannot write \.bmp; use one of"):
        image_io.write_image(tmp_path / "a.bmp", pixels)
    with pytest.raises(TypeError, match=r"must be uint8 for \.png, got float32"):
        image_io.write_image(tmp_path / "a.png", pixels)
    with pytest.raises(ValueError, match=r"\(H, W, 3\), got \(6, 8\)"):
        image_io.write_image(tmp_path / "a.exr", pixels[..., 0])
    with pytest.raises(ImageError, match="NaN or infinite"):
        image_io.write_image(tmp_path / "a.exr", pixels * np.float32(np.inf))
    with pytest.warns(ImageWarning, match="no negative values"):
        image_io.write_image(tmp_path / "a.hdr", -pixels)
    with pytest.raises(ValueError, match="unique names"):
        image_io.write_parts(tmp_path / "a.exr", [])
    with pytest.raises(ValueError, match="must have 3 unique channel names"):
        image_io.write_parts(tmp_path / "a.exr", [Part("a", pixels, "RG")])


def test_png_is_written_as_given(tmp_path: Path) -> None:
    stored = np.random.default_rng(3).integers(0, 256, (4, 5, 3)).astype(np.uint8)
    image_io.write_image(tmp_path / "a.png", stored)
    assert np.array_equal(oiio.ImageInput.open(str(tmp_path / "a.png")).read_image(oiio.UINT8), stored)
