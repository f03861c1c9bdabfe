"""Checks of arrays: what their values are, which shape they have, how they lie in memory."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float16Array, Float32Array, FloatArray, Int32Array, RealArray

Shape = tuple[int | str, ...]
"""Lengths of axes; one given by a name, such as "n", may be any."""

StoredArray = Float32Array | Float16Array
"""Arrays as files hold them."""

_BLOCK = 1 << 20
"""Values whose finiteness is tested at once: memory stays small beside the array."""


def real_array(name: str, value: npt.ArrayLike, *shapes: Shape, empty: bool = True) -> FloatArray:
    """Return a finite float64 array; `value` itself if it is one.

    Where shapes are named it has one of them, and with `empty=False` at least one value.

    Raises
    ------
    TypeError
        If it is not made of real numbers.
    ValueError
        If a value is NaN or infinite, or the shape is another.
    """
    array = np.asarray(_numeric_array(name, value, "fiu", "real"), dtype=np.float64)
    if shapes:
        require_shape(name, array, *shapes, empty=empty)
    require_finite(name, array)
    return array


def float32_array(name: str, value: npt.ArrayLike, *shapes: Shape, empty: bool = True) -> Float32Array:
    """Return a finite float32 array in C order, shaped as `real_array` has it.

    Raises
    ------
    TypeError
        If it is not made of real numbers.
    ValueError
        If a value is NaN or infinite, or beyond the range of float32, or the shape is another.
    """
    array = _numeric_array(name, value, "fiu", "real")
    if shapes:
        require_shape(name, array, *shapes, empty=empty)
    with np.errstate(over="ignore"):  # refused below
        result: Float32Array = np.ascontiguousarray(array, dtype=np.float32)
    if not _all_finite(result):
        require_finite(name, array)
        largest = np.abs(array).max()
        raise ValueError(f"{name} must be within the range of float32, got {largest:.3g}")
    return result


def stored_array(name: str, value: npt.ArrayLike, *shapes: Shape) -> StoredArray:
    """Return a finite array of float32 or float16, not empty, in C order, of one of these shapes.

    Those of these types stay what they are, without a copy where there need be none; other real numbers
    become float32.

    Raises
    ------
    TypeError
        If it is not made of real numbers.
    ValueError
        If a value is NaN or infinite, or beyond the range of float32, or the shape is another.
    """
    array = _numeric_array(name, value, "fiu", "real")
    if array.dtype not in (np.float32, np.float16):
        return float32_array(name, array, *shapes, empty=False)
    require_shape(name, array, *shapes, empty=False)
    require_finite(name, array)
    return np.ascontiguousarray(array)


def indices(name: str, value: npt.ArrayLike, below: int, *shapes: Shape, empty: bool = True) -> Int32Array:
    """Return indices in [0, below) as an int32 array in C order, shaped as `real_array` has it.

    Raises
    ------
    TypeError
        If it is not made of whole numbers.
    ValueError
        If one is out of range, or the shape is another.
    """
    array = _numeric_array(name, value, "iu", "whole")
    if shapes:
        require_shape(name, array, *shapes, empty=empty)
    if array.size and (array.min() < 0 or array.max() >= below):
        count = np.count_nonzero((array < 0) | (array >= below))
        raise ValueError(
            f"{name} must be in [0, {below}), got {count} that are not, from {array.min()} to {array.max()}"
        )
    return np.ascontiguousarray(array, np.int32)


def _numeric_array(name: str, value: npt.ArrayLike, kinds: str, adjective: str) -> npt.NDArray[Any]:
    """Return an array whose dtype is of one of numpy's kinds; refuse masked and ragged ones."""
    what = f"an array of {adjective} numbers"
    try:
        array = np.asarray(value)
    except ValueError:
        raise TypeError(f"{name} must be {what}, got rows of unequal length") from None
    if array.dtype.kind not in kinds:
        raise TypeError(f"{name} must be {what}, got dtype {array.dtype}")
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name} must be a plain array, got a masked one: fill what is masked first")
    return array


def require_shape(name: str, value: npt.NDArray[Any], *shapes: Shape, empty: bool = True) -> None:
    """Refuse an array that has none of some shapes; with `empty=False`, also one without values.

    Raises
    ------
    ValueError
        If it has none of them.
    """
    fits = value.shape in shapes or any(  # sizes alone are compared at once: updates check in microseconds
        len(shape) == value.ndim
        and all(isinstance(n, str) or n == m for n, m in zip(shape, value.shape, strict=True))
        for shape in shapes
    )
    if fits and (empty or value.size):
        return
    needed = " or ".join(_shape_text(shape) for shape in shapes)
    raise ValueError(
        f"{name} must have the shape {needed}{'' if empty else ', not empty'}, got {value.shape}"
    )


def _all_finite(value: RealArray) -> bool:
    """Tell whether no value is NaN or infinite, with little memory."""
    if value.ndim == 0 or value.size <= _BLOCK:
        return bool(np.isfinite(value).all())
    rows = max(1, _BLOCK * len(value) // value.size)
    return all(np.isfinite(value[start : start + rows]).all() for start in range(0, len(value), rows))


def require_finite(name: str, value: RealArray) -> None:
    """Refuse an array with values that are NaN or infinite.

    Raises
    ------
    ValueError
        If there is one; the text counts them and names the first.
    """
    if not _all_finite(value):
        bad = np.argwhere(~np.isfinite(value))
        where = tuple(int(k) for k in bad[0])
        raise ValueError(f"{name} must be finite, got {len(bad)} values that are not, the first at {where}")


def require_stored(name: str, value: object, *shapes: Shape, finite: bool = True) -> None:
    """Refuse what is not an array of float32 or float16, not empty, of one of these shapes.

    It must be finite, too, unless that is not asked for, as of large arrays that are mapped from disk.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, np.ndarray) or value.dtype not in (np.float32, np.float16):
        kind = value.dtype if isinstance(value, np.ndarray) else type(value).__name__
        raise TypeError(f"{name} must be an array of float32 or float16, got {kind}")
    require_shape(name, value, *shapes, empty=False)
    if finite:
        require_finite(name, value)


def require_array(
    name: str, value: object, shape: tuple[int, ...], dtype: npt.DTypeLike, *, writeable: bool = False
) -> None:
    """Refuse what is not an array of exactly this shape and type, in C order: what is taken as it is.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    needed = np.dtype(dtype)
    if not isinstance(value, np.ndarray) or value.dtype != needed:
        kind = value.dtype if isinstance(value, np.ndarray) else type(value).__name__
        raise TypeError(f"{name} must be an array of {needed}, got {kind}")
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{name} must be a plain array, got a masked one: fill what is masked first")
    require_shape(name, value, shape)
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


_IDENTITY = np.eye(3)


def rotation(name: str, value: npt.ArrayLike) -> FloatArray:
    """Return a rotation as a C-contiguous (3, 3) float64 array: orthogonal to 1e-6, determinant 1.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    matrix = np.ascontiguousarray(real_array(name, value, (3, 3)))
    error = float(np.abs(matrix @ matrix.T - _IDENTITY).max())
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()  # many times as fast as numpy's, of so small a matrix
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    if error > 1e-6 or determinant < 0:
        raise ValueError(
            f"{name} must be a rotation, orthogonal to 1e-6 with determinant 1, "
            f"got one off by {error:.2g} with determinant {determinant:.6g}"
        )
    return matrix


def require_rotations(name: str, value: RealArray, tolerance: float = 1e-6) -> None:
    """Refuse an array (n, 3, 3) of matrices that are no rotations: orthogonal to a tolerance, determinant 1.

    Raises
    ------
    ValueError
        If one is none; the text counts them and names the first.
    """
    error = np.abs(np.swapaxes(value, 1, 2) @ value - np.eye(3, dtype=value.dtype))
    bad = np.flatnonzero((error.max(axis=(1, 2), initial=0.0) > tolerance) | (np.linalg.det(value) < 0))
    if len(bad):
        raise ValueError(
            f"{name} must be rotations, orthogonal to {tolerance:g} with determinant 1, "
            f"got {len(bad)} that are not, the first at {bad[0]}"
        )


def _shape_text(shape: Shape) -> str:
    """Write a shape as Python does: '(n, 3)', '(V,)'."""
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
