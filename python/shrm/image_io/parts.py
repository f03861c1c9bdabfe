"""Multi-part EXR files of any quantities, read and written as they are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own name for itself

from shrm.files import PathLike
from shrm.image_io.image import DEFAULT_MAX_BYTES, ImageError, Metadata, Part
from shrm.image_io.source import decoded_bytes, metadata_of, open_source, read_pixels, too_large
from shrm.image_io.target import set_metadata, write_whole

_CHANNEL_ORDER = "shrm:channels"  # EXR sorts channels by name; this attribute keeps our order


def read_parts(path: PathLike, *, max_bytes: int = DEFAULT_MAX_BYTES) -> list[Part]:
    """Read every part of an EXR as it is, without any conversion.

    Channels come back in the order in which `write_parts` was given them; those of other files in
    the file's order.

    Raises
    ------
    ImageError
        As `read_image`, but for NaN and infinite values, which are the caller's to judge.
    """
    source, spec = open_source(path, max_bytes)
    parts: list[Part] = []
    try:
        remaining_bytes = max_bytes
        subimage = 0
        while True:
            # The limit is one for all parts together.
            remaining_bytes -= decoded_bytes(spec)
            if remaining_bytes < 0:
                raise too_large(path, spec, max_bytes)

            # The part, its channels in the order in which they were written
            metadata = metadata_of(spec)
            pixels = read_pixels(path, source, spec, subimage)
            names = list(spec.channelnames)
            order = str(metadata.pop(_CHANNEL_ORDER, "")).split(",")
            if sorted(order) == sorted(names):
                pixels = np.ascontiguousarray(pixels[:, :, [names.index(name) for name in order]])
                names = order
            name = str(metadata.pop("oiio:subimagename", metadata.pop("name", "")))
            parts.append(Part(name, pixels, tuple(names), metadata))

            subimage += 1
            if not source.seek_subimage(subimage, 0):
                return parts
            spec = source.spec()
    finally:
        source.close()


def read_metadata(path: PathLike, *, max_bytes: int = DEFAULT_MAX_BYTES) -> Metadata:
    """Read the metadata of a picture, of the first part of a file of several; no pixels are decoded.

    Raises
    ------
    ImageError
        If the file cannot be read, or a part is larger than `max_bytes`.
    """
    source, spec = open_source(path, max_bytes)
    try:
        return metadata_of(spec)
    finally:
        source.close()


def write_parts(path: PathLike, parts: Sequence[Part]) -> None:
    """Write a multi-part float32 EXR with named channels, whole or not at all.

    Raises
    ------
    ImageError
        The file cannot be written, or is not named ``.exr``.
    TypeError, ValueError
        A part's array has another type or shape, or names are missing or repeated.
    """
    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise ImageError(f"{path}: parts are saved as .exr only")
    if not parts or len({part.name for part in parts}) != len(parts):
        given_names = ", ".join(part.name for part in parts) or "none"
        raise ValueError(f"parts must be one or more with unique names, got {given_names}")
    specs = []
    for part in parts:
        # What a part may be
        if part.pixels.dtype != np.float32:
            raise TypeError(f"pixels of part {part.name!r} must be float32, got {part.pixels.dtype}")
        if part.pixels.ndim != 3 or 0 in part.pixels.shape:
            raise ValueError(
                f"pixels of part {part.name!r} must have the shape (H, W, C), got {part.pixels.shape}"
            )
        height, width, count = part.pixels.shape
        names = list(part.channels)
        if len(names) != count or len(set(names)) != count or any("," in n or not n for n in names):
            raise ValueError(
                f"part {part.name!r} must have {count} unique channel names without commas, got {names}"
            )

        # Its header
        spec = oiio.ImageSpec(width, height, count, oiio.FLOAT)
        spec.channelnames = tuple(names)
        spec.full_height = max(p.pixels.shape[0] for p in parts)  # EXR: one display window for all parts
        spec.full_width = max(p.pixels.shape[1] for p in parts)
        spec.attribute("oiio:subimagename", part.name)
        spec.attribute("compression", "zip")
        spec.attribute(_CHANNEL_ORDER, ",".join(names))
        set_metadata(path, spec, part.metadata)
        specs.append(spec)
    write_whole(path, specs, [part.pixels for part in parts])
