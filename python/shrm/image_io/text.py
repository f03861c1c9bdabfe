"""Text in pictures."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio  # noqa: N813 - its own name for itself


def draw_text(pixels: npt.NDArray[np.uint8], text: str, x: int, y: int, size: int) -> npt.NDArray[np.uint8]:
    """Return an 8-bit picture with a line of white text.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        The picture, which stays as it is.
    text : str
        One line.
    x, y : int
        The middle of the text from left to right, and its base line, pixels.
    size : int
        Approximate height of the letters, pixels.
    """
    height, width, channels = pixels.shape
    picture = oiio.ImageBuf(oiio.ImageSpec(width, height, channels, oiio.UINT8))
    picture.set_pixels(picture.roi, np.ascontiguousarray(pixels))
    white = (1.0,) * channels
    oiio.ImageBufAlgo.render_text(picture, x, y, text, size, "DroidSans", white, "center", "baseline")
    return np.asarray(picture.get_pixels(oiio.UINT8)).reshape(pixels.shape)
