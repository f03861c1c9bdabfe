"""Pictures state the layout and the border that they were written with, and are read as that."""

from pathlib import Path

import numpy as np
import pytest
from shrm import Environment, ImageError, image_io
from shrm.environment.layouts import LAYOUTS
from shrm.image_io import layout_metadata
from shrm.image_io.stated_layout import stated_layout
from support.light import band_limited_environment

ONE_PICTURE = [layout for layout in LAYOUTS if layout != "faces"]


@pytest.mark.parametrize("suffix", [".exr", ".tif"])
@pytest.mark.parametrize("layout", ONE_PICTURE)
def test_what_is_written_is_read_without_a_word(tmp_path: Path, layout: str, suffix: str) -> None:
    path = tmp_path / f"sky{suffix}"
    band_limited_environment(3, seed=1, H=32).write(path, layout, size=16)
    np.testing.assert_array_equal(Environment.read(path).pixels, Environment.read(path, layout).pixels)


@pytest.mark.parametrize("suffix", [".exr", ".tif"])
def test_a_border_is_stated_and_may_be_said_otherwise(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"sky{suffix}"
    band_limited_environment(3, seed=1, H=32).write(path, "dual-paraboloid", size=16, border=2)
    read = Environment.read(path).pixels
    for given in ({"layout": "dual-paraboloid"}, {"border": 2}, {"layout": "dual-paraboloid", "border": 2}):
        np.testing.assert_array_equal(Environment.read(path, **given).pixels, read)
    assert not np.array_equal(Environment.read(path, border=0).pixels, read)
    # what is said goes before what is stated, and a border is stated of its own layout alone
    other = Environment.read(path, "latlong").pixels
    np.testing.assert_array_equal(other, image_io.read_image(path).pixels)


@pytest.mark.parametrize("layout", ONE_PICTURE)
@pytest.mark.parametrize("suffix", [".exr", ".TIF", ".tiff"])
def test_statements_are_understood(layout: str, suffix: str) -> None:
    assert stated_layout(layout_metadata(suffix, layout, 3), suffix == ".exr") == (layout, 3)


@pytest.mark.parametrize(
    "metadata",
    [
        {},
        {"ImageDescription": "shrm:layout= shrm:border=2"},
        {"ImageDescription": "a photograph"},
        {"textureformat": "Plain Texture"},
    ],
)
def test_other_metadata_state_nothing(metadata: dict[str, str]) -> None:
    assert stated_layout(metadata, True) == (None, 0)


def test_a_layout_that_is_none_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "sky.exr"
    image_io.write_image(path, np.ones((8, 16, 3), np.float32), metadata={"shrm:layout": "round"})
    with pytest.raises(ImageError, match=r"sky\.exr: layout must be one of .*, got 'round'"):
        Environment.read(path)
    assert Environment.read(path, "latlong").pixels.shape == (8, 16, 3)
