"""The memory of reflection maps: rings, one row of texels of all maps after the other.

    rings (H, maps, 3, W), float32 or float16

so that synthesis writes whole rows, and the sum for a view streams the maps of a ring. The 6 (N + 4) rows of
a cube, of N + 4 texels, give each face a border of two texels in its own plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from shrm import _core
from shrm.arrays import Float16Array, Float32Array, FloatArray
from shrm.brdf.lobe import Center
from shrm.lobes.reflection import Layout

Interpolation = Literal["cubic", "bilinear"]

BORDER: int = _core.CUBE_BORDER
"""Texels around each face of a cube."""


@dataclass(frozen=True, eq=False, repr=False)
class Rings:
    """Maps over the central direction C, on a grid.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        The central direction C.
    gamma : (257,) float64
        The angle between C and N over theta_v in [0, pi/2], radians; empty about the tangent.
    layout : {"latlong", "cube"}
        The grid of central directions.
    rings : (H, maps, 3, W) float32 or float16
        The maps as they lie in memory: row by row. A cube has 6 (N + 4) rows of N + 4 texels, each face with
        a border of two texels in its own plane.
    """

    center: Center
    gamma: FloatArray
    layout: Layout
    rings: Float32Array | Float16Array

    @property
    def size(self) -> int:
        """Rows of a lat-long map, or of a cube's face."""
        return int(self.rings.shape[0] if self.layout == "latlong" else self.rings.shape[3] - 2 * BORDER)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one map: (H, W, 3), or (6, N, N, 3) for cubes."""
        N = self.size
        return (6, N, N, 3) if self.layout == "cube" else (*self.rings.shape[::3], 3)

    @property
    def maps(self) -> Float32Array | Float16Array:
        """The maps, a view: (maps, H, W, 3), or (maps, 6, N, N, 3) for cubes, faces +X -X +Y -Y +Z -Z."""
        if self.layout == "latlong":
            return self.rings.transpose(1, 0, 3, 2)
        side = self.rings.shape[3]
        faces = self.rings.reshape(6, side, *self.rings.shape[1:])
        inner = slice(BORDER, side - BORDER)
        return faces[:, inner, :, :, inner].transpose(2, 0, 1, 4, 3)

    def directions(self) -> FloatArray:
        """Return the central direction of every texel: (H, W, 3), or (6, N, N, 3) for cubes."""
        rings = ring_directions(self.size, self.layout, self.rings.shape[3])
        if self.layout == "latlong":
            return rings
        side = self.size + 2 * BORDER
        return rings.reshape(6, side, side, 3)[:, BORDER:-BORDER, BORDER:-BORDER]

    def look_up(
        self, C: FloatArray, views: FloatArray, zonal: bool, interpolation: Interpolation
    ) -> Float32Array:
        """Return sum_pq of the maps at C times Y_pq(V), or Y_p0 at the angle of C and V if zonal; (n, 3).

        C and views, (n, 3), are not checked.
        """
        return _core.look_up(
            rings=self.rings,
            cube=self.layout == "cube",
            zonal=zonal,
            C=C,
            views=views,
            bilinear=interpolation == "bilinear",
        )


def ring_directions(size: int, layout: Layout, columns: int | None = None) -> FloatArray:
    """Return the direction of every texel of rings, a cube's borders included: (rows, columns, 3).

    Lat-long maps have 2 `size` columns unless `columns` says otherwise.
    """
    if layout == "cube":
        return _core.cube_directions(N=size)
    H, W = size, 2 * size if columns is None else columns
    theta = (np.arange(H)[:, None] + 0.5) * np.pi / H
    phi = np.pi - 2 * np.pi * (np.arange(W) + 0.5) / W
    z = np.broadcast_to(np.cos(theta), (H, W))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), z], axis=-1)


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
    """Allocate half maps in which every row that is shown begins at a multiple of 16 bytes.

    So no eight of them lie across two lines of a cache, which would slow the sum for a view by a tenth.

    Parameters
    ----------
    shape : (H, maps, 3, W)
        The shape of the rings.
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
        raise ValueError(f"maps must be at most 65504 to be half floats, got {largest:.3g}: use half=False")
