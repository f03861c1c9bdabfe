"""Checks at the door: each names the argument, what it was and what it must be."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from numbers import Integral, Real

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray

RGB = tuple[float, float, float]


def number(name: str, value: object, least: float = -math.inf, most: float = math.inf) -> float:
    """Return a finite number in [least, most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, got {value!r}")
    result = float(value)
    if not math.isfinite(result):
        raise ValueError(f"{name} must be {_range(least, most) or 'finite'}, got {result:g}")
    if not least <= result <= most:
        raise ValueError(f"{name} must be {_range(least, most)}, got {result:g}")
    return result


def number_or_rgb(name: str, value: object, least: float, most: float = math.inf) -> float | RGB:
    """Return a number, or a triple of numbers (R, G, B), in [least, most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Sequence | np.ndarray) or isinstance(value, str | bytes) or np.ndim(value) == 0:
        return number(name, value, least, most)
    if len(value) != 3:
        raise TypeError(f"{name} must be a number or three (R, G, B), got {len(value)} values")
    red, green, blue = (number(name, channel, least, most) for channel in value)
    return red, green, blue


def fraction(name: str, value: object) -> float:
    """Return a number in [0, 1).

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    result = number(name, value)
    if not 0 <= result < 1:
        raise ValueError(f"{name} must be in [0, 1), got {result:g}")
    return result


def whole_number(name: str, value: object, least: int, most: int | None = None) -> int:
    """Return a whole number in [least, most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, got {value!r}")
    result = int(value)
    if result < least or (most is not None and result > most):
        raise ValueError(f"{name} must be {_range(least, math.inf if most is None else most)}, got {result}")
    return result


def one_of(name: str, value: str, options: Iterable[str]) -> str:
    """Return one of the options.

    Raises
    ------
    ValueError
        If it is none of them.
    """
    options = tuple(options)
    if value not in options:
        raise ValueError(f"{name} must be one of {', '.join(options)}, got {value!r}")
    return value


def real_array(name: str, value: npt.ArrayLike) -> FloatArray:
    """Return a finite float64 array; `value` itself if it is one.

    Raises
    ------
    TypeError
        If it is not made of real numbers.
    ValueError
        If a value is NaN or infinite.
    """
    try:
        array = np.asarray(value)
    except ValueError:
        raise TypeError(f"{name} must be an array of real numbers, got rows of unequal length") from None
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} must be an array of real numbers, got dtype {array.dtype}")
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name} must be a plain array, got a masked one: fill what is masked first")
    array = np.asarray(array, dtype=np.float64)
    if not np.isfinite(array).all():
        bad = np.argwhere(~np.isfinite(array))
        where = tuple(int(k) for k in bad[0])
        raise ValueError(f"{name} must be finite, got {len(bad)} values that are not, the first at {where}")
    return array


def require_array(
    name: str, value: object, shape: tuple[int, ...], dtype: npt.DTypeLike, *, writeable: bool = False
) -> None:
    """Refuse what is not an array of exactly this shape and type, in C order: what is taken as it is.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    wanted = np.dtype(dtype)
    if not isinstance(value, np.ndarray) or value.dtype != wanted:
        kind = value.dtype if isinstance(value, np.ndarray) else type(value).__name__
        raise TypeError(f"{name} must be an array of {wanted}, got {kind}")
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name} must be a plain array, got a masked one: fill what is masked first")
    if value.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, got {value.shape}")
    if not (value.flags.c_contiguous and value.flags.aligned):
        raise ValueError(f"{name} must be contiguous in C order, got strides {value.strides}")
    if writeable and not value.flags.writeable:
        raise ValueError(f"{name} must be writeable, got a read-only array")


def unit_vectors(name: str, value: npt.ArrayLike, count: int | None = None) -> FloatArray:
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
        raise ValueError(f"{name} must have the shape {needed}, got {array.shape}")
    lengths = np.linalg.norm(rows, axis=1)
    bad = np.flatnonzero(np.abs(lengths - 1) > 1e-4)
    if len(bad):
        raise ValueError(
            f"{name} must be unit vectors, got {len(bad)} that are not, "
            f"the first at {bad[0]} of length {lengths[bad[0]]:g}"
        )
    if count is not None and len(rows) != count:
        rows = np.broadcast_to(rows, (count, 3))
    return np.ascontiguousarray(rows)


def rotation(name: str, value: npt.ArrayLike) -> FloatArray:
    """Return a rotation as a C-contiguous (3, 3) float64 array: orthogonal to 1e-6, determinant 1.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    matrix = np.ascontiguousarray(real_array(name, value))
    if matrix.shape != (3, 3):
        raise ValueError(f"{name} must have the shape (3, 3), got {matrix.shape}")
    error = float(np.abs(matrix @ matrix.T - np.eye(3)).max())
    determinant = float(np.linalg.det(matrix))
    if error > 1e-6 or determinant < 0:
        raise ValueError(
            f"{name} must be a rotation, orthogonal to 1e-6 with determinant 1, "
            f"got one off by {error:.2g} with determinant {determinant:.6g}"
        )
    return matrix


def _range(least: float, most: float) -> str:
    """Say a range as an error does: 'in [0, 1]', 'at least 0'; nothing for all numbers."""
    if most < math.inf:
        return f"in [{least:g}, {most:g}]"
    return f"at least {least:g}" if least > -math.inf else ""
