"""Damaged text files of measurements: a valid material or one line that names the file, never a crash."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from shrm.brdf.measured import alta, cornell, curet, resampled, text
from shrm.brdf.measured.measured import Measured
from support.directions import hemisphere

Read = Callable[[Path], Measured]
Recognises = Callable[[bytes, int], bool]

WORDS = (
    b"nan",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"-1",
    b"0",
    b"1000000000",
    b"red",
    b"#",
    b"#DIM 1000000000 3\n",
    b"\n",
    b"\x00",
    b"\xff\xfe",
    b"1.5707963267948966",
    b"90",
    b"1_0",
    "\u0663".encode(),
)


@pytest.fixture(autouse=True)
def small_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resampled, "SHAPE", (4, 4, 4))


def rows_of(values: np.ndarray) -> bytes:
    return "\n".join(" ".join(f"{x:.4f}" for x in row) for row in values).encode() + b"\n"


def made_cornell() -> bytes:
    rng = np.random.default_rng(0)
    angles = rng.uniform(size=(14, 4)) * [1.3, 0.0, 1.3, 3.0]
    rows = np.concatenate([angles, rng.uniform(size=(14, 3))], axis=1)
    return b"# a paint\n3\n400 550 700\n" + rows_of(rows)


def made_curet() -> bytes:
    rng = np.random.default_rng(0)
    angles = rng.uniform(size=(60, 4)) * [1.3, 6.0, 1.3, 6.0]
    return rows_of(np.concatenate([angles, rng.uniform(size=(60, 3))], axis=1))


def made_coefficients() -> bytes:
    return rows_of(np.concatenate([[1.0], np.random.default_rng(0).normal(size=55)])[None]).replace(
        b"1.0000", b"1", 1
    )


def made_alta_1() -> bytes:
    rows = np.random.default_rng(0).uniform(size=(12, 4))
    return b"#DIM 1 3\n#PARAM_IN COS_TH\n#PARAM_OUT RGB_COLOR\n" + rows_of(rows)


def made_alta_3() -> bytes:
    rows = np.random.default_rng(0).uniform(size=(20, 4))
    return b"#DIM 3 1\n#PARAM_IN RUSIN_TH_TD_PD\n#PARAM_OUT INV_STERADIAN\n" + rows_of(rows)


FORMATS: dict[str, tuple[bytes, Read, Recognises]] = {
    "cornell": (made_cornell(), cornell.read, cornell.recognises),
    "curet": (made_curet(), curet.read, curet.recognises),
    "coefficients": (made_coefficients(), curet.read, curet.recognises),
    "alta of one angle": (made_alta_1(), alta.read, alta.recognises),
    "alta of three": (made_alta_3(), alta.read, alta.recognises),
}

WI, WO = hemisphere(50, 1), hemisphere(50, 2)


def material_or_one_line(read: Read, path: Path) -> bool:
    """Whether a file is read, to finite values; otherwise the fault must be one line that names it."""
    try:
        material = read(path)
    except ValueError as fault:
        message = str(fault)
        assert message.startswith(f"{path}: "), message
        assert "\n" not in message, message
        assert len(message) < 400 + len(str(path)), message
        return False
    values = material.function(WI, WO)
    assert values.shape == (50, 3)
    assert np.all(np.isfinite(values))
    assert material.covers(WI, WO).shape == (50,)
    return True


@pytest.mark.parametrize("name", FORMATS)
def test_what_is_made_is_read(tmp_path: Path, name: str) -> None:
    whole, read, recognises = FORMATS[name]
    path = tmp_path / "whole.txt"
    path.write_bytes(whole)
    assert recognises(whole[:4096], len(whole))
    others = [other for _, _, other in FORMATS.values() if other is not recognises]
    assert not any(other(whole[:4096], len(whole)) for other in others)
    assert material_or_one_line(read, path)


@pytest.mark.parametrize("name", FORMATS)
def test_damage_is_found_or_does_no_harm(tmp_path: Path, name: str) -> None:
    whole, read, recognises = FORMATS[name]
    path = tmp_path / "damaged.txt"
    rng = np.random.default_rng(3)
    for cut in np.unique(np.linspace(0, len(whole) - 1, 40).astype(int)):
        path.write_bytes(whole[:cut])
        recognises(whole[: min(cut, 4096)], int(cut))
        material_or_one_line(read, path)
    for _ in range(250):
        damaged = bytearray(whole)
        for _ in range(rng.integers(1, 4)):
            at = int(rng.integers(len(damaged)))
            if rng.random() < 0.5:
                damaged[at] = rng.integers(0, 256)
            else:  # a word in place of some bytes
                damaged[at : at + int(rng.integers(0, 8))] = WORDS[rng.integers(len(WORDS))]
        path.write_bytes(damaged)
        recognises(bytes(damaged[:4096]), len(damaged))
        material_or_one_line(read, path)


@pytest.mark.parametrize("name", FORMATS)
def test_whole_lines_lost_or_twice(tmp_path: Path, name: str) -> None:
    whole, read, _ = FORMATS[name]
    lines, path = whole.splitlines(keepends=True), tmp_path / "damaged.txt"
    for k in range(min(len(lines), 12)):
        for content in (lines[:k] + lines[k + 1 :], lines[:k] + lines[k : k + 1] + lines[k:]):
            path.write_bytes(b"".join(content))
            material_or_one_line(read, path)


@pytest.mark.parametrize("name", FORMATS)
def test_garbage_is_refused(tmp_path: Path, name: str) -> None:
    _, read, recognises = FORMATS[name]
    path = tmp_path / "garbage.bin"
    rng = np.random.default_rng(4)
    for size in (0, 1, 10, 5000):
        content = rng.integers(0, 256, size, dtype=np.uint8).tobytes()
        path.write_bytes(content)
        assert not recognises(content[:4096], size)
        assert not material_or_one_line(read, path)


@pytest.mark.parametrize("read", [cornell.read, curet.read, alta.read])
def test_a_file_too_large_is_refused_before_it_is_parsed(tmp_path: Path, read: Read) -> None:
    path = tmp_path / "large.txt"
    with path.open("wb") as file:
        file.truncate(1 << 33)  # no such space is used
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"large\.txt: is larger than 8 MiB"):
            read(path)
        assert tracemalloc.get_traced_memory()[1] < 4 * text.LARGEST
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("read", "content"),
    [
        (cornell.read, b"1000000000\n400 410\n"),
        (cornell.read, b"999999999999999999999999\n400 410\n"),
        (alta.read, b"#DIM 1000000000 3\n#PARAM_IN COS_TH\n#PARAM_OUT RGB_COLOR\n1 1 1 1\n"),
        (alta.read, b"#DIM 1 1000000000\n#PARAM_IN COS_TH\n#PARAM_OUT RGB_COLOR\n1 1 1 1\n"),
    ],
)
def test_counts_that_are_absurd_allocate_nothing(tmp_path: Path, read: Read, content: bytes) -> None:
    path = tmp_path / "absurd.txt"
    path.write_bytes(content)
    tracemalloc.start()
    try:
        assert not material_or_one_line(read, path)
        assert tracemalloc.get_traced_memory()[1] < 2 * text.LARGEST
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("read", [cornell.read, curet.read, alta.read])
def test_a_file_that_is_not_there_is_an_oserror(tmp_path: Path, read: Read) -> None:
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "none.txt")
