"""Arrays by name, as a file holds them: tables of two axes, and numbers of none; checked when they are read.

Classes that are saved have `to_arrays` and `from_arrays`; a file knows only names and arrays.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray

NamedArrays = Mapping[str, npt.NDArray[Any]]

SMALLEST = 1e-30
"""Heights and scales are above it, and all values of tables below its inverse: their squares are floats."""


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
