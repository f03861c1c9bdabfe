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
"""Largest file that is read, bytes: far larger than published ones, yet held in memory without harm."""


def material(path: PathLike, name: str, contents: str, make: Callable[[Mapping[str, Any]], Model]) -> Model:
    """Make one material of a file.

    Parameters
    ----------
    path : path
        The file.
    name : str
        A material in it.
    contents : str
        The contents of such a file, for messages: "Lafortune coefficients".
    make : callable
        Maps the parameters of one material to the material.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is no such file, or has no material of that name; the text names those it has.
    """
    # A regular file of sound size: a pipe would be waited for, a device read for ever
    status = Path(path).stat()
    if not stat.S_ISREG(status.st_mode):
        raise ValueError(f"{path}: not a JSON file of {contents}: no regular file")
    if status.st_size > LARGEST:
        raise ValueError(
            f"{path}: not a JSON file of {contents}: {status.st_size} bytes are over the limit of {LARGEST}"
        )

    # The parameters of the one material
    try:
        materials = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError):  # no UTF-8, no JSON, a number of thousands of digits
        raise ValueError(f"{path}: not a JSON file of {contents}") from None
    if not isinstance(materials, dict):
        raise ValueError(f"{path}: must be a JSON object of materials, got {type(materials).__name__}")
    if name not in materials:
        raise ValueError(f"{path}: no material {name!r}; it has {', '.join(map(repr, materials)) or 'none'}")
    values = materials[name]
    if not isinstance(values, dict):
        raise ValueError(f"{path}: material {name!r}: must be a JSON object, got {type(values).__name__}")

    # The model, whose refusals are told with the file and the material
    try:
        return make(values)
    except KeyError as missing:
        raise ValueError(f"{path}: material {name!r}: has no {missing}") from None
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{path}: material {name!r}: {error}") from None
