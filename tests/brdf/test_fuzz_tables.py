"""Damaged .bsdf and MERL files: a material of finite values or one line, in little memory."""

import struct
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from shrm.brdf import Measured
from shrm.brdf.measured import merl, rgl
from support import rgl_format
from support.directions import hemisphere
from support.rgl_format import content

WI, WO = hemisphere(20, 1), hemisphere(20, 2)
LITTLE = 2_000_000  # bytes; files here are of 10,000 at most

RGB = rgl_format.random(3)
SPECTRAL = {name: values for name, values in RGB.items() if name not in ("rgb", "valid", "luminance")}
SPECTRAL["wavelengths"] = np.linspace(400, 700, 4, dtype=np.float32)
SPECTRAL["spectra"] = np.ones((1, 3, 4, 4, 4), np.float32)
MERL = struct.pack("<3i", 3, 4, 5) + np.random.default_rng(4).uniform(-0.1, 1, 180).tobytes()


def header(fields: dict[str, np.ndarray]) -> int:
    return len(rgl_format.header(fields, dict.fromkeys(fields, 0)))


Read = Callable[[Path], Measured]


def read_or_refused_in_one_line(read: Read, path: Path) -> None:
    tracemalloc.start()
    try:
        material = read(path)
        assert np.isfinite(material.function(WI, WO)).all()
        assert material.covers(WI, WO).shape == (20,)
    except ValueError as error:
        text = str(error)
        if not text.startswith(f"{path}: ") or "\n" in text:
            pytest.fail(f"not one line that names the file: {text!r}")
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < LITTLE


def with_every_number_of_the_header_odd(whole: bytes, header: int) -> Iterator[bytes]:
    """Each 1, 2 and 8 bytes of a header, wherever they start, set to nothing and to what may overflow."""
    for width in (1, 2, 8):
        for value in (0, 2 ** (8 * width - 1), 2 ** (8 * width) - 1):
            for at in range(0, header - width + 1):
                yield whole[:at] + value.to_bytes(width, "little") + whole[at + width :]


def with_random_damage(whole: bytes, header: int, trials: int) -> Iterator[bytes]:
    rng = np.random.default_rng(5)
    for _ in range(trials):
        damaged = bytearray(whole)
        for at in rng.integers(0, header if rng.random() < 0.5 else len(whole), rng.integers(1, 9)):
            damaged[at] = rng.integers(0, 256)
        yield bytes(damaged)


CASES = {
    "rgb": (rgl.read, content(RGB), header(RGB)),
    "spectral": (rgl.read, content(SPECTRAL), header(SPECTRAL)),
    "merl": (merl.read, MERL, 12),
}


@pytest.mark.parametrize("kind", CASES)
def test_truncated_files(kind: str, tmp_path: Path) -> None:
    read, whole, header = CASES[kind]
    path = tmp_path / "cut"
    for cut in [*range(header + 20), *range(header + 20, len(whole), 97), len(whole) - 1]:
        path.write_bytes(whole[:cut])
        with pytest.raises(ValueError, match="cut: "):
            read(path)
        read_or_refused_in_one_line(read, path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", CASES)
def test_headers_with_odd_numbers(kind: str, tmp_path: Path) -> None:
    read, whole, header = CASES[kind]
    path = tmp_path / "odd"
    for damaged in with_every_number_of_the_header_odd(whole, header):
        path.write_bytes(damaged)
        read_or_refused_in_one_line(read, path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", CASES)
def test_files_with_bytes_changed(kind: str, tmp_path: Path) -> None:
    read, whole, header = CASES[kind]
    path = tmp_path / "damaged"
    for damaged in with_random_damage(whole, header, 600):
        path.write_bytes(damaged)
        read_or_refused_in_one_line(read, path)
