"""Materials of the MERL database: .binary, isotropic RGB over half angles [MPBM03].

    int32 (3)                         n_h, n_d, n_phi: 90, 90, 180; little-endian, as all
    float64 (3, n_h, n_d, n_phi)      red, green, blue, times 1/1500, 1.15/1500, 1.66/1500 the BRDF

An entry is a bin: even in the square root of theta_h, which gathers them about the mirror direction, in
theta_d over [0, pi/2], and in phi_d over [0, pi); by reciprocity that is all of it. Here values belong to the
centers of the bins and are interpolated linearly between them, in the coordinates that the bins are even in.

Negative entries mark what could not be measured, at grazing angles, and what lies below the horizon; one
negative channel is enough. They are filled, with 0 or once and for all with the nearest entry that has data:
along phi_d, on which lobes depend least, then what still lacks it along theta_d, then along theta_h; of two
equally near ones with that of the smaller angle, up to phi_d = pi/2, and beyond it by the symmetry below.
What is filled counts as not covered, to the nearest bin.

An isotropic material without handedness is its own mirror image, which takes phi_d to pi - phi_d: entries are
the mean of the file's and its mirror image's, where both have data. That keeps reciprocity and energy.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shrm.arrays import BoolArray, Float32Array, FloatArray
from shrm.brdf.angle_table import AngleTable
from shrm.brdf.measured.measured import Extrapolate, Measured
from shrm.brdf.value import Method, Value

SCALE = (1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0)
"""Factors, by channel, from the numbers of a file to the BRDF, per steradian."""

_PUBLISHED = (90, 90, 180)
_MOST_ENTRIES = 4_000_000  # 96 MB; a file of the database has 1,458,000
_LARGEST = 1e30  # what float32 holds, with room for sums


def recognises(head: bytes, size: int) -> bool:
    """Tell whether a file has the database's dimensions, or others that its size agrees with."""
    shape = _shape(head)
    return shape is not None and (shape == _PUBLISHED or (_is_sound(shape) and size == _size(shape)))


def read(path: Path, extrapolate: Extrapolate = "nearest") -> Measured:
    """Read a material.

    Parameters
    ----------
    path : Path
        The .binary file.
    extrapolate : {"nearest", "zero"}
        What entries without data are filled with.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If its size is not that of its dimensions, they are absurd, or it has no data or data that are not
        finite, in one line that names it.
    """
    # What the file has
    values = _entries(path)
    has_data: BoolArray = np.all(values >= 0.0, axis=-1)
    if not has_data.any():
        raise ValueError(f"{path}: has no data, every entry is negative")
    notes = _notes(values, has_data)

    # A table without handedness and without holes
    _symmetrise(values, has_data)
    if extrapolate == "zero":
        values[~has_data] = 0.0
    else:
        _fill(values, has_data)
    has_data.setflags(write=False)
    table = MerlTable(AngleTable(values, "half-angle", "centers", "square-root"), has_data)
    evaluate = MerlTable.covered_values if extrapolate == "zero" else MerlTable.values
    covers = Method(MerlTable.covers, table)
    return Measured(path.stem, "MERL", Method(evaluate, table), covers, extrapolate, notes)


@dataclass(frozen=True, eq=False, repr=False)
class MerlTable(Value):
    """A table of the database, filled, and which of its entries were measured.

    Attributes
    ----------
    table : AngleTable
        The BRDF without the cosine.
    has_data : (n_h, n_d, n_phi) bool
        False where an entry was filled.
    """

    table: AngleTable
    has_data: BoolArray

    def values(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, (n, 3) float64, at unit vectors (n, 3) above the horizon."""
        values = self.table(wi, wo)
        values *= wi[:, 2:]
        return values

    def covered_values(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, black where there is no data."""
        return np.asarray(self.values(wi, wo) * self.covers(wi, wo)[:, None])

    def covers(self, wi: FloatArray, wo: FloatArray) -> BoolArray:
        """Tell, (n,) bool, whether the nearest entry was measured."""
        return self.has_data.reshape(-1)[self.table.nearest(wi, wo)]


def _shape(head: bytes) -> tuple[int, int, int] | None:
    return struct.unpack_from("<3i", head) if len(head) >= 12 else None


def _is_sound(shape: tuple[int, int, int]) -> bool:
    return min(shape) >= 2 and math.prod(shape) <= _MOST_ENTRIES


def _size(shape: tuple[int, int, int]) -> int:
    return 12 + 3 * 8 * math.prod(shape)


def _entries(path: Path) -> Float32Array:
    """Read the BRDF, (n_h, n_d, n_phi, 3), negative where there is none."""
    with path.open("rb") as file:
        # The shape, checked against the size of the file
        shape, size = _shape(file.read(12)), file.seek(0, 2)
        if shape is None:
            raise ValueError(f"{path}: a MERL file starts with three numbers, this one has {size} bytes")
        if not _is_sound(shape):
            raise ValueError(
                f"{path}: must have 2 or more entries along each axis and at most {_MOST_ENTRIES} in all, "
                f"got {' x '.join(str(n) for n in shape)}"
            )
        if size != _size(shape):
            raise ValueError(
                f"{path}: {' x '.join(str(n) for n in shape)} entries take {_size(shape)} bytes, "
                f"but the file has {size}"
            )

        # One channel after another, in little memory
        file.seek(12)
        values = np.empty((*shape, 3), np.float32)
        for channel, (color, scale) in enumerate(zip(("red", "green", "blue"), SCALE, strict=True)):
            data = np.frombuffer(file.read(8 * math.prod(shape)), "<f8")
            if data.size < math.prod(shape):  # it has become shorter since
                raise ValueError(f"{path}: is truncated within {color}")
            wrong = ~(np.abs(data) < _LARGEST)  # NaN too
            if wrong.any():
                raise ValueError(
                    f"{path}: {color} must be finite and below {_LARGEST:g}, got {np.sum(wrong)} entries "
                    f"that are not, the first {data[np.argmax(wrong)]:g}"
                )
            values[..., channel] = (scale * data).reshape(shape)
    return values


def _notes(values: Float32Array, has_data: BoolArray) -> tuple[str, ...]:
    """Describe what a table lacks: data, and likeness to its mirror image."""
    notes = []
    if missing := int(np.sum(~has_data)):
        notes.append(f"{missing} of {has_data.size} entries have no data")
    both = has_data & has_data[:, :, ::-1]
    size = values[both].sum(dtype=np.float64)
    difference = np.abs(values[both] - values[:, :, ::-1][both]).sum(dtype=np.float64)
    if difference > 1e-3 * size:
        notes.append(f"differs by {difference / size:.1%} from its mirror image: the mean of both is taken")
    return tuple(notes)


def _symmetrise(values: Float32Array, has_data: BoolArray) -> None:
    """Make a table its own mirror image, in place: the mean of both sides, or the one that has data."""
    original, mirrored = has_data.copy(), has_data[:, :, ::-1].copy()
    image = values[:, :, ::-1].copy()
    np.copyto(image, values, where=(original & ~mirrored)[..., None])
    np.copyto(values, image, where=(~original & mirrored)[..., None])
    values += image
    values *= 0.5
    has_data |= mirrored


def _fill(values: Float32Array, has_data: BoolArray) -> None:
    """Fill entries without data from the nearest along phi_d, then theta_d, then theta_h, in place.

    The table is its own mirror image and stays it: half of it is filled, and has the nearest entries of all.
    """
    half = (values.shape[2] + 1) // 2
    table, values, filled = values, values[:, :, :half], has_data[:, :, :half]
    for axis in (2, 1, 0):
        # The nearest entries with data before and after each; -n and 2 n where there is none
        n = filled.shape[axis]
        index = np.arange(n, dtype=np.int32).reshape([n if k == axis else 1 for k in range(3)])
        before = np.maximum.accumulate(np.where(filled, index, -n), axis=axis)
        after = np.flip(np.minimum.accumulate(np.flip(np.where(filled, index, 2 * n), axis), axis=axis), axis)

        # The nearer of the two, copied to the entries that it fills
        source = np.where(index - before <= after - index, before, after)
        has_source = (source >= 0) & (source < n)
        holes = np.nonzero(has_source & ~filled)
        origin = list(holes)
        origin[axis] = source[holes]
        values[holes] = values[tuple(origin)]
        filled = has_source
    table[:, :, -half:] = values[:, :, ::-1].copy()  # of an odd number, the middle one is in both halves
