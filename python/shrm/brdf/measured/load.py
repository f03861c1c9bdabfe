"""Which format a file of measurements has: recognised by its content, not by its name."""

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
        """As every module has: what is kept is found by it."""

    def recognises(self, head: bytes, size: int) -> bool:
        """Whether a file begins so, the first `HEAD` bytes of `size`."""

    def read(self, path: Path, extrapolate: Extrapolate) -> Measured:
        """Read it; ValueError, naming the file, if it is not as the format has it."""


FORMATS: Sequence[Format] = (rgl, alta, cornell, curet, merl)
"""In the order they are asked: those with a magic word first."""

HEAD = 4096
"""Bytes that tell."""


def load(path: PathLike, *, extrapolate: Extrapolate = "nearest", sample: int | None = None) -> Measured:
    """Read a measured material from its file.

    MERL's `.binary`, RGL/EPFL's tensor files `.bsdf`, Cornell's goniometer data `.brdf`, CUReT's measurements
    and coefficients, ALTA's text; recognised by content.

    Parameters
    ----------
    path : path
        The file.
    extrapolate : {"nearest", "zero"}
        How directions without data, at grazing angles above all, are filled: with the nearest value in the
        coordinates of the file, or black.
    sample : int, optional
        The number of a sample in a file of several, as CUReT's are.

    Returns
    -------
    Measured
        A material like any other, in linear sRGB; the same one for a file that has not changed (but
        for CUReT's, which may be several). What it lacks in reciprocity, or has too much of energy, is as it
        was measured: `shrm.lobes.measurement_quality` and `shrm info` report it.

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
    file = Path(path)
    at = file.stat()
    if stat.S_ISDIR(at.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(at.st_mode):  # a pipe would be waited for
        raise MeasurementError(f"{path}: is no regular file")
    number = None if sample is None else whole_number("sample", sample, 0)
    known = recognised(file)
    if known is None:
        raise MeasurementError(
            f"{path}: {_what_else(file)} (MERL .binary, RGL .bsdf, Cornell .brdf, CUReT, ALTA)"
        )
    if known is curet:  # reads the files of other channels beside it
        return _read(known, file, extrapolate, number)
    return _kept(known, file, extrapolate, number, at.st_mtime_ns, at.st_size)


def _what_else(path: Path) -> str:
    """What a file is that no format recognises."""
    with path.open("rb") as opened:
        head = opened.read(HEAD)
    if head.lstrip()[:1] == b"{":
        return "is JSON: for one of its fits say lafortune:FILE#NAME, abc:FILE#NAME or sgd:FILE#NAME"
    return "is no file of measurements that is known" if head else "is empty"


# A file that has not changed gives the same material, so that what is computed for it is found again.
@lru_cache(maxsize=8)
def _kept(
    known: Format, path: Path, extrapolate: Extrapolate, sample: int | None, mtime: int, size: int
) -> Measured:
    return _read(known, path, extrapolate, sample)


def _read(known: Format, path: Path, extrapolate: Extrapolate, sample: int | None) -> Measured:
    try:
        if known is curet:
            return curet.read(path, extrapolate, sample=sample)
        if sample is not None:
            raise ValueError(f"{path}: holds one material, which has no number, got sample {sample}")
        return known.read(path, extrapolate)
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
    return next((known for known in FORMATS if known.recognises(head, size)), None)
