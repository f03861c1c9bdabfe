"""Materials of a JSON file: an object of materials by name, each an object of a model's parameters."""

from __future__ import annotations

import json
import stat
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from shrm.files import PathLike

Model = TypeVar("Model")

LARGEST = 64 << 20
"""Bytes of a file that are read."""


def material(path: PathLike, name: str, what: str, make: Callable[[Mapping[str, Any]], Model]) -> Model:
    """Make one material of a file.

    Parameters
    ----------
    path : path
        The file.
    name : str
        A material in it.
    what : str
        What such a file holds, for messages: "Lafortune coefficients".
    make : callable
        The parameters of one material to the material.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is no such file, or has no material of that name; the text names those it has.
    """
    at = Path(path).stat()
    if not stat.S_ISREG(at.st_mode):  # a pipe would be waited for, a device read for ever
        raise ValueError(f"{path}: not a JSON file of {what}: no regular file")
    if at.st_size > LARGEST:
        raise ValueError(
            f"{path}: not a JSON file of {what}: {at.st_size} bytes are over the limit of {LARGEST}"
        )
    try:
        materials = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError):  # no UTF-8, no JSON, a number of thousands of digits
        raise ValueError(f"{path}: not a JSON file of {what}") from None
    if not isinstance(materials, dict):
        raise ValueError(f"{path}: must be a JSON object of materials, got {type(materials).__name__}")
    if name not in materials:
        raise ValueError(f"{path}: no material {name!r}; it has {', '.join(map(repr, materials)) or 'none'}")
    found = materials[name]
    if not isinstance(found, dict):
        raise ValueError(f"{path}: material {name!r}: must be a JSON object, got {type(found).__name__}")
    try:
        return make(found)
    except KeyError as missing:
        raise ValueError(f"{path}: material {name!r}: has no {missing}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{path}: material {name!r}: {error}") from None
