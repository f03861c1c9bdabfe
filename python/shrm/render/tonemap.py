"""From linear radiance to a display: exposure, a clip at white, the sRGB curve. Nothing else."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear Rec. 709


def srgb(linear: Float32Array) -> Float32Array:
    """Encode linear values for display by the curve of IEC 61966-2-1, clipped to [0, 1] first."""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1.0 / 2.4) - 0.055).astype(np.float32)


def automatic_exposure(radiance: Float32Array, coverage: Float32Array | None = None) -> float:
    """Return the stops that put the 90th percentile of the luminance at 0.7 of white.

    Parameters
    ----------
    radiance : (H, W, 3) float32
    coverage : (H, W) float32, optional
        Where given, only pixels that objects cover at least half count, if there are any.
    """
    luminance = radiance.astype(np.float64) @ LUMINANCE
    covered = None if coverage is None else luminance[coverage >= 0.5]
    counted = luminance if covered is None or covered.size == 0 else covered
    bright = float(np.percentile(counted, 90.0))
    return float(np.log2(0.7 / bright)) if bright > 0.0 else 0.0


def display(
    radiance: Float32Array, exposure: float = 0.0, coverage: Float32Array | None = None
) -> npt.NDArray[np.uint8]:
    """Return pixels for an 8-bit file.

    Parameters
    ----------
    radiance : (H, W, 3) float32
        Linear; with coverage, multiplied by it already.
    exposure : float
        In stops: radiance is multiplied by 2 ** exposure.
    coverage : (H, W) float32, optional
        Becomes the fourth channel; colors are then not multiplied by it, as PNG wants them.

    Returns
    -------
    (H, W, 3 or 4) uint8
    """
    gain = np.float32(2.0 ** np.clip(exposure, -100.0, 100.0))  # within float32, whatever is asked for
    if coverage is None:
        shown = srgb(gain * radiance)
    else:
        alpha = coverage[..., None]
        colors = gain * radiance / np.where(alpha > 0.0, alpha, 1.0)
        shown = np.concatenate([srgb(colors.astype(np.float32)), alpha], axis=2)
    return np.round(255.0 * shown).astype(np.uint8)
