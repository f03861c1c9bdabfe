"""Writing a picture: floats as linear light, bytes as they are shown."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio  # noqa: N813 - its own name for itself

from shrm.files import PathLike
from shrm.image_io.holes import finite
from shrm.image_io.image import ImageError, Metadata, warn
from shrm.image_io.target import set_metadata, write_whole


def write_image(path: PathLike, pixels: npt.NDArray[Any], *, metadata: Metadata | None = None) -> None:
    """Write a picture; the format is the name's extension.

    Parameters
    ----------
    path : path
        ``.exr`` (float32), ``.hdr``, ``.pfm``, ``.tif`` (float32), or ``.png``, ``.jpg`` (8 bit).
    pixels : (H, W, 3) or, with alpha, (H, W, 4); float32, or uint8 for ``.png`` and ``.jpg``
        Linear Rec. 709, multiplied by alpha; the 8-bit formats take a picture that is tone-mapped and
        encoded already, not multiplied by alpha.
    metadata : mapping, optional
        Attributes to save where the format can (EXR).

    Raises
    ------
    ImageError
        The extension is unknown, the values do not fit the format, or the file cannot be written.
    TypeError, ValueError
        The array has another type or shape.
    """
    # The format, and the values that it takes
    path = Path(path)
    suffix = path.suffix.lower()
    eight_bit = suffix in (".png", ".jpg", ".jpeg")
    if not eight_bit and suffix not in (".exr", ".hdr", ".pfm", ".tif", ".tiff"):
        formats = ".exr, .hdr, .pfm, .tif, .png, .jpg"
        raise ImageError(f"{path}: cannot write {suffix or 'a file without extension'}; use one of {formats}")
    dtype: type[np.generic] = np.uint8 if eight_bit else np.float32
    if pixels.dtype != dtype:
        raise TypeError(f"pixels must be {dtype.__name__} for {suffix}, got {pixels.dtype}")
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or 0 in pixels.shape:
        raise ValueError(f"pixels must have the shape (H, W, 4) or (H, W, 3), got {pixels.shape}")
    if not eight_bit:
        finite(path, pixels, repair=False)
    if suffix == ".hdr" and np.any(pixels < 0):
        warn(path, "the format has no negative values; they become 0")

    # The file's header, and the file
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, oiio.UINT8 if eight_bit else oiio.FLOAT)
    if eight_bit:
        spec.attribute("oiio:UnassociatedAlpha", 1)
    if suffix == ".exr":
        spec.attribute("compression", "zip")
    spec.attribute("pnm:pfmflip", 1)  # a PFM's first row is the lowest; our first row is the highest
    set_metadata(path, spec, metadata or {})
    write_whole(path, [spec], [pixels])
