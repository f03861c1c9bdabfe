"""A file that is read through OpenImageIO: its header, its pixels as they are, its attributes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own name for itself

from shrm.arrays import Float32Array
from shrm.files import PathLike
from shrm.image_io.image import ImageError


def open_source(path: PathLike, max_bytes: int) -> tuple[Any, Any]:
    """Open a file and check its header; return OpenImageIO's input and its ImageSpec.

    Raises
    ------
    ImageError
        If it is no flat picture that can be read, or takes more than `max_bytes` when decoded.
    """
    # A file that is there and not empty
    path = Path(path)
    try:
        if path.is_dir():
            raise ImageError(f"{path}: is a folder, not a picture")
        if path.stat().st_size == 0:
            raise ImageError(f"{path}: is empty")
        with path.open("rb"):
            pass
    except OSError as error:
        raise ImageError(f"{path}: {error.strerror or error}") from None
    except ValueError as error:
        raise error if isinstance(error, ImageError) else ImageError(f"{path!r}: {error}") from None

    # A picture
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # colors as stored, not multiplied by alpha
    config.attribute("pnm:pfmflip", 1)  # a PFM's first row is the lowest; our first row is the highest
    source = _careful(lambda: oiio.ImageInput.open(str(path), config))
    if source is None:
        raise ImageError(f"{path}: is not a picture that can be read ({fault(oiio.geterror)})")

    # Flat, not empty, not too large
    try:
        spec = source.spec()
        if spec.deep or spec.depth > 1:
            raise ImageError(f"{path}: is a deep or volume picture; a flat one is needed")
        if min(spec.width, spec.height, spec.nchannels) < 1:
            raise ImageError(f"{path}: has no pixels")
        if decoded_bytes(spec) > max_bytes:
            raise too_large(path, spec, max_bytes)
    except BaseException:
        source.close()
        raise
    return source, spec


def read_pixels(path: PathLike, source: Any, spec: Any, subimage: int) -> Float32Array:
    """Return all channels as float32, (H, W, channels)."""
    pixels = _careful(lambda: source.read_image(subimage, 0, 0, spec.nchannels, oiio.FLOAT))
    if pixels is None or source.has_error:
        raise ImageError(f"{path}: is truncated or damaged ({fault(source.geterror)})")
    result: Float32Array = np.asarray(pixels, dtype=np.float32).reshape(
        spec.height, spec.width, spec.nchannels
    )
    return result


def metadata_of(spec: Any) -> dict[str, Any]:
    """Return the attributes of a file; those whose text cannot be decoded are left out."""
    result: dict[str, Any] = {}
    for attribute in spec.extra_attribs:
        name = _careful(lambda a=attribute: a.name)  # type: ignore[misc]
        value = _careful(lambda a=attribute: a.value)  # type: ignore[misc]
        if name is not None and value is not None:
            result[name] = value
    return result


def decoded_bytes(spec: Any) -> int:
    """Return the size of the pixels as float32, bytes."""
    return int(spec.width) * int(spec.height) * int(spec.nchannels) * 4


def too_large(path: PathLike, spec: Any, max_bytes: int) -> ImageError:
    """Return the refusal of a picture whose pixels take more than `max_bytes`."""
    size = f"{spec.width} x {spec.height} x {spec.nchannels} channels"
    need = (
        f"takes {decoded_bytes(spec) / 2**20:.0f} MiB decoded, over the limit of {max_bytes / 2**20:.0f} MiB"
    )
    return ImageError(f"{path}: {size} {need}; raise max_bytes to read it")


def fault(text: Callable[[], str]) -> str:
    """Return the first line of OpenImageIO's account of a failure."""
    lines = str(_careful(text) or "").strip().splitlines()
    return lines[0] if lines else "no further detail"


def _careful(call: Callable[[], Any]) -> Any:
    """Call OpenImageIO, whose texts from damaged files may not be UTF-8; None where they are not."""
    try:
        return call()
    except UnicodeDecodeError:
        return None
