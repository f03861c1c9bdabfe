"""Pictures and the parts of files as they are read and written, and reports of faults and changes."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from shrm.arrays import Float32Array
from shrm.files import PathLike

Metadata = Mapping[str, str | int | float | Sequence[float]]

DEFAULT_MAX_BYTES = 2 << 30
"""Largest decoded picture that is read by default, bytes: 8k x 16k texels of three float32."""


class ImageError(ValueError):
    """A picture cannot be read or written; the text names the file and the fault in one line."""


class ImageWarning(UserWarning):
    """A picture was changed while it was read or written, as the text says."""


@dataclass(frozen=True)
class Image:
    """A picture as read.

    Attributes
    ----------
    pixels : (H, W, 3) float32
        Linear Rec. 709, top row first.
    metadata : dict
        The file's attributes.
    layout : str or None
        The layout that the file states, see `shrm.image_io.stated_layout`.
    border : int
        The border that it states.
    """

    pixels: Float32Array
    metadata: dict[str, Any] = field(default_factory=dict)
    layout: str | None = None
    border: int = 0


@dataclass(frozen=True)
class Part:
    """One named part of a multi-part EXR.

    Attributes
    ----------
    name : str
        Unique in its file.
    pixels : (H, W, C) float32
        Any quantity: nothing is converted.
    channels : sequence of C str
        Unique names.
    metadata : mapping
        Text, numbers, or sequences of floats.
    """

    name: str
    pixels: Float32Array
    channels: Sequence[str]
    metadata: Metadata = field(default_factory=dict)


def warn(path: PathLike, change: str) -> None:
    """Warn of a change to a picture, in words that follow the name of its file."""
    warnings.warn(f"{os.fspath(path)}: {change}", ImageWarning, stacklevel=3)
