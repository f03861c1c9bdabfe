"""Bilinear look-ups: an environment by direction, a texture by (u, v)."""

from __future__ import annotations

import numpy as np

from shrm.arrays import Float32Array, FloatArray, IntArray


def environment_lookup(pixels: Float32Array, directions: FloatArray) -> Float32Array:
    """Radiance of a lat-long picture in given directions, bilinear, seamless across edge and poles.

    Parameters
    ----------
    pixels : (H, W, C) float32
        Lat-long, as cpp/shrm/core.hpp defines it: the center looks along +x, the top row is +z.
    directions : (n, 3) float64
        Unit vectors.

    Returns
    -------
    (n, C) float32
    """
    H, W = pixels.shape[:2]
    # The place in texels from the first center, and the texels around it
    theta = np.arccos(np.clip(directions[:, 2], -1.0, 1.0))
    phi = np.arctan2(directions[:, 1], directions[:, 0])
    row = theta * (H / np.pi) - 0.5
    column = (np.pi - phi) * (W / (2.0 * np.pi)) - 0.5
    upper = np.floor(row).astype(np.int64)
    down = (row - upper).astype(np.float32)[:, None]
    upper, lower = np.clip(upper, 0, H - 1), np.clip(upper + 1, 0, H - 1)
    values = _mix(_along_row(pixels, upper, column), _along_row(pixels, lower, column), down)

    # From the first row's centers to the pole is half a texel; the pole itself is the row's mean.
    for edge, beyond in ((0, -row), (H - 1, row - (H - 1))):
        near = beyond > 0.0
        to_pole = (2.0 * beyond[near]).astype(np.float32)[:, None]
        values[near] = _mix(values[near], pixels[edge].mean(axis=0), to_pole)
    return values


def _along_row(pixels: Float32Array, row: IntArray, column: FloatArray) -> Float32Array:
    """Interpolate between the columns of rows (n,), at columns (n,) that wrap around."""
    W = pixels.shape[1]
    left = np.floor(column).astype(np.int64)
    right = (column - left).astype(np.float32)[:, None]
    return _mix(pixels[row, left % W], pixels[row, (left + 1) % W], right)


def texture_lookup(texture: Float32Array, uv: FloatArray) -> Float32Array:
    """Bilinear look-up in a repeating texture.

    Parameters
    ----------
    texture : (H, W, C) float32
        Linear; (u, v) = (0, 1) is its upper left corner.
    uv : (n, 2) float64

    Returns
    -------
    (n, C) float32
    """
    H, W = texture.shape[:2]
    x = uv[:, 0] * W - 0.5
    y = (1.0 - uv[:, 1]) * H - 0.5
    left, upper = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right, down = (x - left).astype(np.float32)[:, None], (y - upper).astype(np.float32)[:, None]
    columns, rows = (left % W, (left + 1) % W), (upper % H, (upper + 1) % H)
    top = _mix(texture[rows[0], columns[0]], texture[rows[0], columns[1]], right)
    bottom = _mix(texture[rows[1], columns[0]], texture[rows[1], columns[1]], right)
    return _mix(top, bottom, down)


def _mix(a: Float32Array, b: Float32Array, t: Float32Array) -> Float32Array:
    """Interpolate linearly from a, at t = 0, to b, at t = 1."""
    return np.asarray(a + t * (b - a), np.float32)
