"""Reading a picture as linear Rec. 709: channels, orientation, encoding, primaries."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from shrm import color
from shrm.arrays import Float32Array
from shrm.files import PathLike
from shrm.image_io.holes import finite
from shrm.image_io.image import DEFAULT_MAX_BYTES, Image, ImageError, warn
from shrm.image_io.source import metadata_of, open_source, read_pixels
from shrm.image_io.stated_layout import stated_layout


def read_image(path: PathLike, *, repair: bool = False, max_bytes: int = DEFAULT_MAX_BYTES) -> Image:
    """Read a picture as linear Rec. 709.

    Gray becomes RGB and alpha is dropped; integers (PNG, JPEG, ...) are decoded as sRGB unless the file
    says that it is linear; EXR `chromaticities` are converted; of a multi-part or mip-mapped file the
    first picture is read. Negative values are kept. Dropped alpha, decoding, conversion and negative values
    are reported by warnings.

    Parameters
    ----------
    path : path
        The file.
    repair : bool
        Replace texels that are NaN or infinite by the mean of their neighbors, with a warning.
    max_bytes : int
        Refuse pictures that are larger than this when decoded; checked before pixels are read.

    Raises
    ------
    ImageError
        The file is missing, empty, no picture, truncated, too large, or has NaN or infinite texels.
    """
    # The file as it is stored
    source, spec = open_source(path, max_bytes)
    try:
        columns, gray = _color_channels(path, spec)
        has_alpha = "A" in _short_names(spec)
        pixels = read_pixels(path, source, spec, subimage=0)[:, :, columns]
        metadata = metadata_of(spec)
        stored_as = str(spec.format)
        is_openexr = source.format_name() == "openexr"
    finally:
        source.close()

    # Three channels, upright
    if has_alpha:
        warn(path, "its alpha channel is dropped")
    if gray:
        pixels = np.repeat(pixels, 3, axis=2)
    pixels = _orient(path, pixels, metadata)

    # Linear Rec. 709
    is_linear = (
        stored_as in ("half", "float", "double") or "lin" in str(metadata.get("oiio:ColorSpace", "")).lower()
    )
    if not is_linear:
        warn(path, f"its {stored_as} values are decoded from sRGB to linear light")
        pixels = color.linear_from_srgb(pixels)
    pixels = finite(path, np.ascontiguousarray(pixels, dtype=np.float32), repair)
    pixels = _to_rec709(path, pixels, metadata)
    negative = int(np.count_nonzero((pixels < 0).any(axis=2)))
    if negative:
        warn(path, f"{negative} texels have negative values, the least {pixels.min():.4g}; they are kept")

    return Image(pixels, metadata, *stated_layout(metadata, is_openexr))


def _color_channels(path: PathLike, spec: Any) -> tuple[list[int], bool]:
    """Return the channels that are red, green, blue, or the one that is gray; and whether it is gray."""
    names = _short_names(spec)
    if all(c in names for c in "RGB"):
        return [names.index(c) for c in "RGB"], False
    for name in ("Y", "L", "GRAY", "GREY"):
        if name in names:
            return [names.index(name)], True
    colors = [k for k, name in enumerate(names) if name != "A"]
    if len(colors) in (1, 3):
        return colors, len(colors) == 1
    raise ImageError(f"{path}: its channels {', '.join(spec.channelnames)} are neither RGB nor gray")


def _short_names(spec: Any) -> list[str]:
    """Return the channels' names without those of layers, in capitals."""
    return [name.rsplit(".", 1)[-1].upper() for name in spec.channelnames]


def _orient(path: PathLike, pixels: Float32Array, metadata: Mapping[str, Any]) -> Float32Array:
    """Turn a picture upright as its attribute Orientation (EXIF) says."""
    turns: dict[int, Callable[[Float32Array], Float32Array]] = {
        2: lambda p: p[:, ::-1],
        3: lambda p: p[::-1, ::-1],
        4: lambda p: p[::-1],
        5: lambda p: p.transpose(1, 0, 2),
        6: lambda p: np.rot90(p, -1),
        7: lambda p: np.rot90(p, 2).transpose(1, 0, 2),
        8: lambda p: np.rot90(p, 1),
    }
    orientation = metadata.get("Orientation", 1)
    if orientation not in turns:
        return pixels
    warn(path, f"it is turned upright (orientation {orientation})")
    return turns[orientation](pixels)


def _to_rec709(path: PathLike, pixels: Float32Array, metadata: Mapping[str, Any]) -> Float32Array:
    """Convert a picture from the chromaticities of its file, if it names others than Rec. 709's."""
    chromaticities = metadata.get("chromaticities")
    if chromaticities is None or np.allclose(chromaticities, color.REC709, atol=2e-3):
        return pixels
    try:
        matrix = color.rec709_from_rgb(chromaticities)
    except ValueError as error:
        raise ImageError(f"{path}: {error}") from None
    warn(path, "its chromaticities are converted to linear Rec. 709")
    return np.ascontiguousarray(pixels @ matrix.T.astype(np.float32))
