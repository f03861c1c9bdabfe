"""Arrays by name, as a file holds them: tables of two axes, and numbers of none; checked when they are read.

Classes that are saved have `to_arrays` and `from_arrays`; a file knows only names and arrays. Tables are
parts of an OpenEXR file, exact to the last bit; numbers are metadata, as text of full precision.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm import image_io
from shrm.arrays import FloatArray

NamedArrays = Mapping[str, npt.NDArray[Any]]
Parts = Mapping[str, image_io.Part]

SMALLEST = 1e-30
"""Bound below heights and scales, whose inverse bounds the values of tables: their squares are floats."""


def number(arrays: NamedArrays, name: str) -> float:
    """Return a number that is not negative, perhaps infinite.

    Raises
    ------
    KeyError, ValueError
        If there is none of that name, or it is not that.
    """
    value = float(arrays[name])
    if not value >= 0:
        raise ValueError(f"{name} = {value}")
    return value


def table(arrays: NamedArrays, name: str, shape: tuple[int | None, int | None]) -> FloatArray:
    """Return a table of numbers whose squares are floats; None in `shape` stands for any length.

    Raises
    ------
    KeyError, ValueError
        If there is none of that name, or it is not that.
    """
    values = np.asarray(arrays[name], np.float64)
    if any(length not in (None, actual) for length, actual in zip(shape, values.shape, strict=True)):
        raise ValueError(f"{name} of shape {values.shape}")
    if not np.all(np.abs(values) < 1 / SMALLEST):
        raise ValueError(f"{name} is not finite, or beyond {1 / SMALLEST:g}")
    return values


LARGEST_ANGLE = 3.2
"""Largest angle of a table, radians: pi with room for rounding."""


def angle_pairs(arrays: NamedArrays, name: str, rows: int | None) -> FloatArray:
    """Return a table of pairs of angles, radians, as (rows, 2); None stands for any number of rows.

    Raises
    ------
    KeyError, ValueError
        If there is none of that name, or it is not that.
    """
    pairs = table(arrays, name, (rows, 2))
    if not np.all(np.abs(pairs) < LARGEST_ANGLE):
        raise ValueError(f"{name} is none of angles")
    return pairs


def angles(arrays: NamedArrays, name: str) -> FloatArray:
    """Return a row of two angles or more, radians, as (n,).

    Raises
    ------
    KeyError, ValueError
        If there is none of that name, or it is not that.
    """
    row: FloatArray = table(arrays, name, (1, None))[0]
    if len(row) < 2:
        raise ValueError(f"{name} of {len(row)} angles")
    return row


# ---- Arrays and the parts of a file


def array_parts(
    arrays: NamedArrays, tables: str, numbers: str
) -> tuple[list[image_io.Part], dict[str, str | int | float]]:
    """Return arrays as parts and metadata of a file.

    Parameters
    ----------
    arrays : {name: array}
        Tables (rows, columns), and numbers ().
    tables, numbers : str
        What the names of parts, and those of metadata, begin with.
    """
    parts: list[image_io.Part] = []
    about: dict[str, str | int | float] = {}
    for name, array in arrays.items():
        if array.ndim:
            parts += image_io.table_parts(f"{tables}{name}", array[:, :, None])
        else:
            about[f"{numbers}{name}"] = repr(float(array))
    return parts, about


def arrays_of_parts(
    parts: Parts, about: Mapping[str, Any], tables: str, numbers: str, words: Collection[str] = ()
) -> dict[str, npt.NDArray[Any]]:
    """Return the arrays that `array_parts` made parts and metadata of.

    Parameters
    ----------
    parts : {name: Part}
        The parts of a file.
    about : mapping
        The metadata with the numbers.
    tables, numbers : str
        As in `array_parts`.
    words : collection of str
        Names of metadata that are no numbers.

    Raises
    ------
    KeyError, TypeError, ValueError
        If a table is not whole, or a number is none.
    """
    arrays: dict[str, npt.NDArray[Any]] = {}
    for part in parts.values():
        if part.name.startswith(tables) and not part.name.endswith(".rest"):
            arrays[part.name.removeprefix(tables)] = image_io.table_values(parts, part.name)[:, :, 0]
    for key, value in about.items():
        name = key.removeprefix(numbers)
        if key.startswith(numbers) and name not in words:
            arrays[name] = np.asarray(float(value))
    return arrays
