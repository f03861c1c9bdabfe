"""Frames of tangent, bitangent and normal, and spherical harmonics turned into many of them at once.

A frame is the rotation global_from_local, with the columns x = tangent, y = normal x tangent, z = normal.
Light with the coefficients l in global coordinates has R_p l in those of the frame of vertex p
[LK03 section 3.1], [LK03 eq. 5]. R_p is block-diagonal, a block D_l for each degree: the values of the
harmonics of degree l at fixed directions d_k determine an expansion of that degree, and turned they are its
values at the turned directions,

    Y_l(d) D_l = Y_l(frame d)        D_l = Y_l(d)^+ Y_l(frame d)

`shrm.sh.rotate` turns one function by one rotation, to any degree.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.arrays import FloatArray
from shrm.validation import real_array, require_rotations, whole_number
from shrm.vectors import golden_spiral

MOST_ORDER = 32
"""The largest order n, degrees 0 to n - 1."""

_BLOCK = 4096
"""Frames whose harmonics are evaluated together, so that their memory stays small."""


def vertex_frames(normals: npt.ArrayLike, tangents: npt.ArrayLike | None = None) -> FloatArray:
    """Return frames at vertices: z along the normal, x along the tangent's part square to it.

    Parameters
    ----------
    normals : (k, 3) array_like
        Normals of any length. Where one is zero, as at vertices of no face, the frame's normal is the
        world's z.
    tangents : (k, 3) array_like, optional
        Tangents of any length. Where one is zero or along the normal, or none are given, x is square to the
        normal in a direction that does not matter to isotropic materials.

    Returns
    -------
    (k, 3, 3) float64
        Rotations global_from_local: columns x, y, z.

    Raises
    ------
    TypeError, ValueError
        If an array is not of this shape, or not finite.
    """
    n = real_array("normals", normals, ("k", 3))
    t = np.zeros_like(n) if tangents is None else real_array("tangents", tangents, n.shape)

    # The normal, and the tangent's part across it
    z = _unit(n, np.array([0.0, 0.0, 1.0]))
    t = _unit(t, np.zeros(3))
    across = t - np.einsum("kc,kc->k", t, z)[:, None] * z

    # The axis of the world that is farthest from the normal, where there is no tangent
    spare = np.eye(3)[np.argmin(np.abs(z), axis=1)]
    spare = spare - np.einsum("kc,kc->k", spare, z)[:, None] * z
    defined = np.einsum("kc,kc->k", across, across) > 1e-12
    x = _unit(np.where(defined[:, None], across, spare), np.zeros(3))
    x = _unit(x - np.einsum("kc,kc->k", x, z)[:, None] * z, np.zeros(3))  # to the last digit
    return np.stack([x, np.cross(z, x), z], axis=2)


def band_rotations(frames: npt.ArrayLike, n: int) -> tuple[FloatArray, ...]:
    """Return the rotations of harmonics into frames, degree by degree.

    Parameters
    ----------
    frames : (k, 3, 3) array_like
        Rotations global_from_local, orthogonal to 1e-6.
    n : int
        Order of the harmonics, degrees 0 to n - 1, in [1, 32].

    Returns
    -------
    tuple of (k, 2l+1, 2l+1) float64
        D_l for l = 0 to n - 1: local coefficients l^2 to (l+1)^2 - 1 from those in global coordinates, in the
        real basis of `shrm.sh`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    R, n = real_array("frames", frames, ("k", 3, 3)), whole_number("n", n, 1, MOST_ORDER)
    require_rotations("frames", R)
    directions, inverses = _sampling(n)
    result = [np.empty((len(R), 2 * l + 1, 2 * l + 1)) for l in range(n)]
    for start in range(0, len(R), _BLOCK):
        block = R[start : start + _BLOCK]
        turned = np.einsum("kij,dj->kdi", block, directions).reshape(-1, 3)
        Y = sh.evaluate(np.eye(n * n), turned).reshape(len(block), len(directions), -1)
        for l in range(n):
            result[l][start : start + _BLOCK] = inverses[l] @ Y[:, :, l * l : (l + 1) ** 2]
    return tuple(result)


def local_coefficients(coefficients: npt.ArrayLike, frames: npt.ArrayLike) -> FloatArray:
    """Return the coefficients in each frame's coordinates of functions in global ones: R_p l [LK03 eq. 5].

    Parameters
    ----------
    coefficients : (n^2, channels) or (k, n^2, channels) array_like
        Coefficients of one function, or one for each frame; order n, degrees 0 to n - 1, at most 32.
    frames : (k, 3, 3) array_like
        Rotations global_from_local, orthogonal to 1e-6.

    Returns
    -------
    (k, n^2, channels) float64

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    R = real_array("frames", frames, ("k", 3, 3))
    array = real_array("coefficients", coefficients, ("n^2", "channels"), (len(R), "n^2", "channels"))
    n = sh.degree_of(np.moveaxis(array, -2, 0)) + 1
    bands = band_rotations(R, n)
    parts = [bands[l] @ array[..., l * l : (l + 1) ** 2, :] for l in range(n)]
    return np.concatenate(parts, axis=1)


@lru_cache(maxsize=8)
def _sampling(n: int) -> tuple[FloatArray, tuple[FloatArray, ...]]:
    """Return directions (d, 3), and for each degree l < n the pseudo-inverse (2l+1, d) of its harmonics.

    They lie on a spiral over a hemisphere: of one degree, the other has the same values but for a sign. 2l+1
    of them determine degree l, and half as many more keep the condition number of every degree below 10.
    """
    count = 3 * n - 1
    directions = golden_spiral(1 - (np.arange(count) + 0.5) / count)
    Y = sh.evaluate(np.eye(n * n), directions)
    return directions, tuple(np.asarray(np.linalg.pinv(Y[:, l * l : (l + 1) ** 2])) for l in range(n))


def _unit(v: FloatArray, otherwise: FloatArray) -> FloatArray:
    """Return unit vectors (k, 3), or `otherwise` for those that are zero."""
    largest = np.abs(v).max(axis=1, initial=0.0, keepdims=True)
    scaled = v / np.where(largest > 0, largest, 1.0)  # squares neither overflow nor vanish
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.where(length > 0, scaled / np.where(length > 0, length, 1.0), otherwise)
