"""Checks at the door: each names the argument, what it was and what it must be."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral, Real

import numpy as np
import numpy.typing as npt


def real_array(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return a finite float64 array.

    Raises
    ------
    TypeError
        If it is not made of real numbers.
    ValueError
        If a value is NaN or infinite.
    """
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise TypeError(f"{name} must be an array of real numbers, but its rows differ in length") from error
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} must be an array of real numbers, not of {array.dtype}")
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name} must be a plain array, but is masked: fill what is masked first")
    array = np.asarray(array, dtype=np.float64)
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        where = tuple(int(k) for k in bad[0])
        raise ValueError(f"{name} must be finite, but holds {len(bad)} values that are not, first at {where}")
    return array


def unit_vectors(name: str, value: npt.ArrayLike, count: int | None = None) -> npt.NDArray[np.float64]:
    """Return unit vectors as a C-contiguous (n, 3) float64 array.

    With `count`, one vector, (3,) or (1, 3), is repeated that many times, and any other number is refused.
    Lengths may differ from 1 by 1e-4, as those of interpolated float32 vectors do; nothing is normalised.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    array = real_array(name, value)
    needed = "(n, 3)" if count is None else f"({count}, 3) or (3,)"
    rows = array[None] if array.ndim == 1 and count is not None else array
    if rows.ndim != 2 or rows.shape[1] != 3 or (count is not None and len(rows) not in (1, count)):
        raise ValueError(f"{name} has the shape {array.shape}, but needs {needed}")
    lengths = np.linalg.norm(rows, axis=1)
    bad = np.flatnonzero(np.abs(lengths - 1) > 1e-4)
    if len(bad):
        raise ValueError(
            f"{name} must be unit vectors, but {len(bad)} are not, first at {bad[0]}, "
            f"of length {lengths[bad[0]]:g}"
        )
    if count is not None and len(rows) != count:
        rows = np.broadcast_to(rows, (count, 3))
    return np.ascontiguousarray(rows)


def fraction(name: str, value: float) -> float:
    """Return a number in [0, 1).

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, not {value!r}")
    if not 0 <= value < 1:
        raise ValueError(f"{name} must be at least 0 and below 1, not {value!r}")
    return float(value)


def whole_number(name: str, value: int, least: int, most: int) -> int:
    """Return a whole number in [least, most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, not {value!r}")
    if not least <= value <= most:
        raise ValueError(f"{name} must be between {least} and {most}, not {value!r}")
    return int(value)


def one_of(name: str, value: str, options: Iterable[str]) -> str:
    """Return one of the options.

    Raises
    ------
    ValueError
        If it is none of them.
    """
    options = tuple(options)
    if value not in options:
        raise ValueError(f"{name} must be one of {', '.join(options)}, not {value!r}")
    return value
