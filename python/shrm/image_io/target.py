"""A file that is written through OpenImageIO: beside first, then renamed; so it is whole or not there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio  # noqa: N813 - its own name for itself

from shrm.files import PathLike, replacing
from shrm.image_io.image import ImageError, Metadata
from shrm.image_io.source import fault


def set_metadata(path: PathLike, spec: Any, metadata: Metadata) -> None:
    """Save attributes: text, numbers, or sequences of floats."""
    for name, value in metadata.items():
        if isinstance(value, (str, int, float)):
            spec.attribute(name, value)
            continue
        values = tuple(float(v) for v in value)
        if not values:
            raise ImageError(f"{path}: attribute {name!r} is an empty sequence")
        kind = oiio.TypeDesc(
            oiio.BASETYPE.FLOAT, oiio.AGGREGATE.SCALAR, oiio.VECSEMANTICS.NOSEMANTICS, len(values)
        )
        spec.attribute(name, kind, values)


def write_whole(path: Path, specs: Sequence[Any], pictures: Sequence[npt.NDArray[Any]]) -> None:
    """Write pictures as the parts of a file, whole or not at all.

    Raises
    ------
    ImageError
        If the file cannot be written.
    """
    output = oiio.ImageOutput.create(path.suffix.lower().lstrip("."))
    if output is None:
        raise ImageError(f"{path}: cannot be written ({fault(oiio.geterror)})")
    try:
        with replacing(path) as beside:
            # The first part is opened with the headers of all, others are appended.
            for part, (spec, pixels) in enumerate(zip(specs, pictures, strict=True)):
                if part:
                    opened = output.open(str(beside), spec, "AppendSubimage")
                elif len(specs) > 1:
                    opened = output.open(str(beside), tuple(specs))
                else:
                    opened = output.open(str(beside), spec)
                if not opened or not output.write_image(np.ascontiguousarray(pixels)):
                    raise ImageError(f"{path}: cannot be written ({fault(output.geterror)})")
            if not output.close():
                raise ImageError(f"{path}: cannot be written ({fault(output.geterror)})")
    except OSError as error:
        raise ImageError(f"{path}: cannot be written ({error.strerror or error})") from None
