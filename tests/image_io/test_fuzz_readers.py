"""Damaged files: a valid picture or one line, never a crash."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from shrm import Environment, ImageError, ImageWarning, image_io
from support.data import require

FILES = ("debevec_rnl_probe.hdr", "quarry_01_1k.hdr", "blender_studio.exr", "openexr_OrientationLatLong.exr")


def made(path: Path) -> bytes:
    """A small file of the same kind, for the many trials that the large ones would make slow."""
    pixels = np.random.default_rng(0).random((8, 16, 3), dtype=np.float32)
    if path.suffix == ".png":
        image_io.write_image(path, (pixels * 255).astype(np.uint8))
    else:
        image_io.write_image(path, pixels)
    return path.read_bytes()


def one_line_fault(read: Callable[[], object], path: Path) -> bool:
    """Whether reading failed; if so, in one line that names the file."""
    try:
        read()
    except ImageError as error:
        text = str(error)
        if "\n" in text or path.name not in text:
            pytest.fail(f"not one line that names the file: {text!r}")
        return True
    return False


def read_or_fail_in_one_line(path: Path) -> None:
    """Environment refuses values that are not finite, so that what is read is valid."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImageWarning)
        one_line_fault(lambda: Environment.read(path, "latlong", max_bytes=1 << 26), path)
        one_line_fault(lambda: image_io.read_parts(path, max_bytes=1 << 26), path)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".exr", ".hdr", ".pfm", ".tif", ".png"])
def test_small_files(tmp_path: Path, suffix: str) -> None:
    whole = made(tmp_path / f"whole{suffix}")
    rng = np.random.default_rng(1)
    path = tmp_path / f"damaged{suffix}"
    for cut in np.unique(np.linspace(0, len(whole) - 1, 60).astype(int)):
        path.write_bytes(whole[:cut])
        read_or_fail_in_one_line(path)
    for _ in range(800):
        damaged = bytearray(whole)
        # most of the damage where the header is
        for at in rng.integers(
            0, len(whole) if rng.random() < 0.3 else min(400, len(whole)), rng.integers(1, 6)
        ):
            damaged[at] = rng.integers(0, 256)
        path.write_bytes(damaged)
        read_or_fail_in_one_line(path)


@pytest.mark.parametrize("name", FILES)
def test_real_files(tmp_path: Path, name: str) -> None:
    whole = require(f"env/{name}").read_bytes()
    rng = np.random.default_rng(2)
    path = tmp_path / name
    for cut in (10, 100, 300, 1000, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:cut])
        read_or_fail_in_one_line(path)
        if cut < len(whole) // 2:
            with pytest.raises(ImageError):
                image_io.read_image(path)
    for _ in range(12):
        damaged = bytearray(whole)
        for at in rng.integers(0, len(whole) if rng.random() < 0.5 else 400, 4):
            damaged[at] = rng.integers(0, 256)
        path.write_bytes(damaged)
        read_or_fail_in_one_line(path)
