"""Dual-paraboloid maps with a border: where their texels look, and pictures of them.

The axes are those of the layout ``dual-paraboloid`` (`shrm.environment.layouts`), with a picture for each of
the two faces: in the first, which looks along +z, right is -y and up is -x; in the second, along -z, right is
-y and up is +x. In each a direction at the angle theta from its axis is tan(theta / 2) from its center, in
radii of a disc.
The border continues the paraboloid beyond the disc and so shows what the other face shows too, so that
look-ups and filters need not stop at the rim [KVHS00 section 5.2].

Sources: [HS98].
"""

from __future__ import annotations

import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.environment import layouts

SAMPLES = 8
"""Samples along each side of a texel of the border, whose mean it is."""


def face_directions(size: int, border: int, samples: int = 1) -> FloatArray:
    """Return where the texel centers of both faces look, border and corners too.

    Parameters
    ----------
    size : int
        Texels across the disc.
    border : int
        Texels beyond the disc on each side.
    samples : int
        Samples along each side of a texel, in place of its center.

    Returns
    -------
    (2, samples (size + 2 border), samples (size + 2 border), 3) float64
        Unit vectors.
    """
    side = samples * (size + 2 * border)
    along = (2.0 * np.arange(side) + 1.0 - side) / (samples * size)  # in radii
    right, down = np.meshgrid(along, along)
    square = right**2 + down**2
    faces = [np.stack([sign * 2 * down, -2 * right, sign * (1 - square)], axis=-1) for sign in (1.0, -1.0)]
    return np.stack(faces) / (1 + square)[None, :, :, None]


def face_positions(directions: FloatArray, size: int, border: int) -> FloatArray:
    """Return where directions (n, 3) fall in each face: (2, n, 2), x right and y down in texels."""
    x, y, z = directions.T
    faces = []
    for sign in (1.0, -1.0):
        st = np.stack([-y, sign * x], axis=1) / np.maximum(1.0 + sign * z, 1e-12)[:, None]
        faces.append(0.5 * size * (st + 1.0) + border)
    return np.stack(faces)


def bordered(latlong: Float32Array, picture: Float32Array, border: int) -> Float32Array:
    """Return a dual-paraboloid picture (n, 2n, 3) of a lat-long one with a border round each face.

    Texels within the discs stay as they are. Those that the rims cut, and those beyond, are the mean of
    `SAMPLES` x `SAMPLES` places on the continued paraboloid.

    Returns
    -------
    (n + 2 border, 2 (n + 2 border), 3) float32
    """
    # Both faces of the continued paraboloid, the mean of samples in each texel
    n = len(picture)
    side = n + 2 * border
    D = face_directions(n, border, SAMPLES)
    H, W, _ = latlong.shape
    x, y = layouts.positions("latlong", H, W, D.reshape(-1, 3)).T
    samples = latlong[np.clip(y.astype(int), 0, H - 1), x.astype(int) % W]
    faces = samples.reshape(2, side, SAMPLES, side, SAMPLES, 3).mean(axis=(2, 4), dtype=np.float64)

    # Whole texels of the discs as they are in the picture
    edge = (np.abs(2.0 * np.arange(n) + 1.0 - n) + 1.0) / n
    inside = edge[:, None] ** 2 + edge**2 <= 1.0
    middle = faces[:, border : border + n, border : border + n]
    middle[:, inside] = np.stack(np.split(picture, 2, axis=1))[:, inside]
    return np.concatenate(list(faces), axis=1).astype(np.float32)


def without_border(pixels: Float32Array, border: int) -> Float32Array:
    """Return a dual-paraboloid picture without the border round each face: the discs in their squares.

    Raises
    ------
    ValueError
        If it is not twice as wide as high, or the border leaves nothing.
    """
    side = len(pixels)
    if pixels.shape[1] != 2 * side or side - 2 * border < 2:
        raise ValueError(
            f"a dual paraboloid with a border of {border} is 2 x as wide as high and larger than the border, "
            f"and the picture has {pixels.shape[1]} x {side} texels"
        )
    faces = np.split(pixels, 2, axis=1)
    inner = slice(border, side - border)
    return np.concatenate([face[inner, inner] for face in faces], axis=1)
