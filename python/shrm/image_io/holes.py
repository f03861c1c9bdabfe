"""Texels that are NaN or infinite: refused, or repaired from their neighbors."""

from __future__ import annotations

import numpy as np

from shrm.arrays import BoolArray, Float32Array
from shrm.files import PathLike
from shrm.image_io.image import ImageError, warn


def finite(path: PathLike, pixels: Float32Array, repair: bool) -> Float32Array:
    """Refuse, or repair with a warning, texels that are NaN or infinite."""
    bad: BoolArray = np.logical_not(np.isfinite(pixels).all(axis=2))
    count = int(np.count_nonzero(bad))
    if not count:
        return pixels
    row, column = np.argwhere(bad)[0]
    holes = f"{count} texels are NaN or infinite, the first at row {row}, column {column}"
    if not repair:
        raise ImageError(f"{path}: {holes}; repair=True replaces them by their neighbors")
    if count == bad.size:
        raise ImageError(f"{path}: all texels are NaN or infinite")

    # From the rim of each hole inwards: the mean of the neighbors that are known
    pixels = np.where(bad[:, :, None], np.float32(0), pixels)
    while bad.any():
        total = np.zeros(pixels.shape, dtype=np.float64)
        count_valid = np.zeros(bad.shape, dtype=np.int64)
        padded = np.pad(pixels, ((1, 1), (1, 1), (0, 0)))
        valid = np.pad(~bad, 1)
        for i in range(3):
            for j in range(3):
                window = np.s_[i : i + bad.shape[0], j : j + bad.shape[1]]
                total += padded[window]
                count_valid += valid[window]
        rim = bad & (count_valid > 0)
        pixels[rim] = (total[rim] / count_valid[rim, None]).astype(np.float32)
        bad &= ~rim
    warn(path, f"{holes}; replaced by the mean of their neighbors")
    return pixels
