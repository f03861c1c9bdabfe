"""Reading of measured materials: the format of a file is recognised by its content, not by its name."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Protocol, get_args

from shrm.brdf.measured import alta, cornell, curet, merl, rgl
from shrm.brdf.measured.measured import Extrapolate, Measured, MeasurementError
from shrm.files import PathLike
from shrm.validation import one_of, whole_number


class Format(Protocol):
    """A module that reads one format."""

    def __hash__(self) -> int:
        """Return the module's hash, a part of the key under which materials are kept."""

    def recognises(self, head: bytes, size: int) -> bool:
        """Tell whether a file of `size` bytes that begins with `head` is of the format."""

    def read(self, path: Path, extrapolate: Extrapolate) -> Measured:
        """Read a file; ValueError, naming the file, if it is not as the format has it."""


FORMATS: Sequence[Format] = (rgl, alta, cornell, curet, merl)
"""Formats in the order in which they are tried: those with a magic word first."""

HEAD = 4096
"""Bytes at the beginning of a file by which formats recognise it: one page."""


def load(path: PathLike, *, extrapolate: Extrapolate = "nearest", sample: int | None = None) -> Measured:
    """Read a measured material from its file.

    MERL's `.binary`, RGL/EPFL's tensor files `.bsdf`, Cornell's goniometer data `.brdf`, CUReT's measurements
    and coefficients, ALTA's text; recognised by content.

    Parameters
    ----------
    path : path
        The file.
    extrapolate : {"nearest", "zero"}
        The filling of directions without data, at grazing angles above all: the nearest value in the
        coordinates of the file, or black.
    sample : int, optional
        The number of a sample in a file of several, as CUReT's are.

    Returns
    -------
    Measured
        A material like any other, in linear sRGB; the same object for a file that has not changed (except
        CUReT's, which may be several files). Errors of reciprocity and energy stay as they were measured:
        `shrm.lobes.measurement_quality` and `shrm info` report them.

    Raises
    ------
    OSError
        If the file cannot be read.
    MeasurementError
        If it is of none of the formats, or damaged, or has no such sample: a ValueError of one line that
        names it.
    ValueError
        If `extrapolate` is none of those.
    """
    one_of("extrapolate", extrapolate, get_args(Extrapolate))
    number = None if sample is None else whole_number("sample", sample, 0)

    # A regular file, of a known format
    file = Path(path)
    status = file.stat()
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode):  # a pipe would be waited for
        raise MeasurementError(f"{path}: is no regular file")
    file_format = recognised(file)
    if file_format is None:
        raise MeasurementError(
            f"{path}: {_why_unknown(file)} (MERL .binary, RGL .bsdf, Cornell .brdf, CUReT, ALTA)"
        )

    # Kept until the file changes; CUReT's reader also reads the files of other channels beside it.
    if file_format is curet:
        return _read(file_format, file, extrapolate, number)
    return _read_once(file_format, file, extrapolate, number, status.st_mtime_ns, status.st_size)


def _why_unknown(path: Path) -> str:
    """Describe a file that no format recognises."""
    with path.open("rb") as opened:
        head = opened.read(HEAD)
    if head.lstrip()[:1] == b"{":
        return "is JSON: for one of its fits say lafortune:FILE#NAME, abc:FILE#NAME or sgd:FILE#NAME"
    return "is no file of measurements that is known" if head else "is empty"


# A file that has not changed gives the same material, so that what is computed for it is found again.
@lru_cache(maxsize=8)
def _read_once(
    file_format: Format, path: Path, extrapolate: Extrapolate, sample: int | None, mtime: int, size: int
) -> Measured:
    """Read a file by its format, once for each time (ns) and size (bytes) of it."""
    return _read(file_format, path, extrapolate, sample)


def _read(file_format: Format, path: Path, extrapolate: Extrapolate, sample: int | None) -> Measured:
    """Read a file by its format; what is wrong with it is a MeasurementError."""
    try:
        if file_format is curet:
            return curet.read(path, extrapolate, sample=sample)
        if sample is not None:
            raise ValueError(f"{path}: holds one material, which has no number, got sample {sample}")
        return file_format.read(path, extrapolate)
    except ValueError as fault:
        raise MeasurementError(str(fault)) from None


def recognised(path: Path) -> Format | None:
    """Return the format that a file begins as, or None.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    if not path.is_file() and path.exists():
        return None
    with path.open("rb") as opened:
        head = opened.read(HEAD)
        size = os.fstat(opened.fileno()).st_size
    return next((each for each in FORMATS if each.recognises(head, size)), None)
