"""Linear RGB spaces: from chromaticities to matrices, and to Rec. 709, in which shrm works."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shrm.arrays import Float32Array, FloatArray

# x, y of red, green, blue and white, as in OpenEXR's attribute `chromaticities` [BT709].
REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)

_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)  # [Lam85]


def _xyz(x: float, y: float) -> FloatArray:
    """Return the XYZ of a chromaticity, Y = 1."""
    return np.array([x / y, 1.0, (1.0 - x - y) / y])


def xyz_from_rgb(chromaticities: Sequence[float]) -> FloatArray:
    """Return the (3, 3) matrix to CIE XYZ of the RGB space with these primaries and white [SMPTE177].

    Parameters
    ----------
    chromaticities : sequence of 8 floats
        x, y of red, green, blue, white. RGB (1, 1, 1) becomes the white with Y = 1.

    Raises
    ------
    ValueError
        Where they do not span a space of colors.
    """
    c = np.asarray(chromaticities, dtype=np.float64)
    if c.shape != (8,) or not np.all(np.isfinite(c)) or np.any(c[1::2] == 0):
        raise ValueError(
            "chromaticities must be 8 finite numbers, x and y of red, green, blue, white, y not 0, "
            f"got {list(chromaticities)}"
        )
    primaries = np.stack([_xyz(c[0], c[1]), _xyz(c[2], c[3]), _xyz(c[4], c[5])], axis=1)
    if abs(np.linalg.det(primaries)) < 1e-6:
        raise ValueError(
            f"chromaticities of red, green and blue must not lie on one line, got {list(chromaticities[:6])}"
        )
    return np.asarray(primaries * np.linalg.solve(primaries, _xyz(c[6], c[7])), dtype=np.float64)


def rec709_from_rgb(chromaticities: Sequence[float]) -> FloatArray:
    """Return the (3, 3) matrix from a linear RGB space to linear Rec. 709.

    White goes to white: other white points are adapted by the Bradford transform [Lam85].
    """
    to_xyz = xyz_from_rgb(chromaticities)
    white, d65 = to_xyz.sum(axis=1), xyz_from_rgb(REC709).sum(axis=1)
    adapt = np.linalg.solve(_BRADFORD, np.diag(_BRADFORD @ d65 / (_BRADFORD @ white)) @ _BRADFORD)
    return np.asarray(np.linalg.solve(xyz_from_rgb(REC709), adapt @ to_xyz), dtype=np.float64)


def rec709_from_xyz() -> FloatArray:
    """Return the (3, 3) matrix from CIE XYZ to linear Rec. 709."""
    return np.asarray(np.linalg.inv(xyz_from_rgb(REC709)), dtype=np.float64)


def linear_from_srgb(encoded: Float32Array) -> Float32Array:
    """Decode sRGB values in [0, 1] to linear light (IEC 61966-2-1)."""
    low = encoded / np.float32(12.92)
    high = ((np.maximum(encoded, 0) + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.where(encoded <= 0.04045, low, high).astype(np.float32)
