"""Tables of float64 in files of float32: exact to the last bit, or refused."""

from dataclasses import replace

import numpy as np
import pytest
from shrm import image_io
from shrm.image_io import Part


def read(path) -> dict[str, Part]:
    return {part.name: part for part in image_io.read_parts(path)}


@pytest.mark.parametrize("channels", [("Y",), ("R", "G", "B")])
def test_a_table_comes_back_to_the_last_bit(tmp_path, channels):
    rng = np.random.default_rng(5)
    shape = (7, 9, len(channels))
    exponents = rng.integers(
        -90, 120, size=shape
    )  # 53 bits below the first are above float32's least, 2^-149
    values = rng.normal(size=shape) * 2.0**exponents
    image_io.write_parts(tmp_path / "t.exr", image_io.table_parts("table", values, channels))
    parts = read(tmp_path / "t.exr")
    np.testing.assert_array_equal(image_io.table_values(parts, "table"), values)
    # what knows nothing of the rest reads float32
    np.testing.assert_array_equal(parts["table"].pixels, values.astype(np.float32))
    assert tuple(parts["table"].channels) == channels


def test_what_is_float32_takes_one_part(tmp_path):
    values = np.random.default_rng(6).normal(size=(3, 4, 1)).astype(np.float32)
    (part,) = image_io.table_parts("table", values)
    np.testing.assert_array_equal(image_io.table_values({"table": part}, "table"), values)


def test_a_rest_that_is_missing_or_does_not_fit_is_refused():
    first, rest = image_io.table_parts("table", np.full((2, 3, 1), 0.1))
    with pytest.raises(KeyError):
        image_io.table_values({"table": first}, "table")
    with pytest.raises(ValueError, match="the rest of table"):
        image_io.table_values({"table": first, "table.rest": replace(rest, pixels=rest.pixels[:1])}, "table")


def test_metadata_are_those_of_the_first_part(tmp_path):
    parts = [Part(name, np.zeros((2, 2, 1), np.float32), ["Y"], {"shrm:k": name}) for name in ("a", "b")]
    image_io.write_parts(tmp_path / "t.exr", parts)
    assert image_io.read_metadata(tmp_path / "t.exr")["shrm:k"] == "a"
