"""Reprs of one line for classes that hold arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import ClassVar

import numpy as np


class Described:
    """A class whose repr is one line: arrays are given by dtype and shape, dicts by their keys.

    Attributes
    ----------
    shown : tuple of str
        Names of the attributes in the repr; of a dataclass all fields unless it says which.
    """

    shown: ClassVar[tuple[str, ...]] = ()

    def __repr__(self) -> str:
        names = self.shown
        if not names and is_dataclass(self):
            names = tuple(field.name for field in fields(self))
        content = ", ".join(f"{name}={_text(getattr(self, name))}" for name in names)
        return f"{type(self).__name__}({content})"


def _text(value: object) -> str:
    """Return a value in few words."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, Mapping):
        return f"{{{', '.join(map(str, value))}}}"
    return repr(value)
