"""The memory of reflection maps: rings, one row of texels of all maps after the other.

    rings (H, maps, 3, W), float32 or float16

so that synthesis writes whole rows, and the sum for a view streams the maps of a ring. The 6 (N + 4) rows of
a cube, of N + 4 texels, give each face a border of two texels in its own plane.
"""

from __future__ import annotations

import numpy as np

from shrm import _core
from shrm.arrays import Float16Array, Float32Array, FloatArray
from shrm.lobes.reflection import Layout

BORDER: int = _core.CUBE_BORDER


def halved(rings: Float32Array, layout: Layout) -> Float16Array:
    """Return maps as half floats.

    Raises
    ------
    ValueError
        If a value is beyond 65504, the largest of them.
    """
    require_half_range(rings)
    halves = empty_halves(rings.shape, layout)
    _core.to_half(rings, halves)
    return halves


def empty_halves(shape: tuple[int, ...], layout: Layout) -> Float16Array:
    """Memory for half maps in which every row that is shown begins at a multiple of 16 bytes.

    So no eight of them lie across two lines of a cache, which would slow the sum for a view by a tenth.

    Parameters
    ----------
    shape : (H, maps, 3, W)
        Of the rings.
    layout : {"latlong", "cube"}
        A cube's rows are shown but for the border.

    Returns
    -------
    (H, maps, 3, W) float16
        A view: rows of W lie further apart where W is no multiple of 8.
    """
    W = shape[-1]
    pitch, line = -(-W // 8) * 8, 32  # halves in a line of the cache
    flat = np.empty(shape[0] * shape[1] * shape[2] * pitch + line, dtype=np.float16)
    first = (-flat.ctypes.data // 2 - (BORDER if layout == "cube" else 0)) % line
    return flat[first : first + len(flat) - line].reshape(*shape[:-1], pitch)[..., :W]


def require_half_range(rings: Float32Array) -> None:
    """Raise ValueError if maps hold values that half floats do not reach."""
    largest = _core.largest_magnitude(rings)
    if largest > float(np.finfo(np.float16).max):
        raise ValueError(f"half floats end at 65504, and the maps reach {largest:.3g}: use half=False")


def synthesised(coefficients: FloatArray, size: int, layout: Layout) -> Float32Array:
    """Rings (H, maps, 3, W) of a `Part` from the coefficients of its maps, ((J+1)^2, maps, 3)."""
    count, maps = coefficients.shape[:2]
    columns = np.ascontiguousarray(coefficients.reshape(count, maps * 3))
    if layout == "latlong":
        rings = _core.synthesis(coefficients=columns, H=size, W=2 * size)
        return np.asarray(rings).reshape(size, maps, 3, 2 * size)
    rings = _core.cube_synthesis(coefficients=columns, N=size)
    return np.asarray(rings).reshape(len(rings), maps, 3, size + 2 * BORDER)
