"""Values: frozen objects that are equal where what they hold is, so that what is computed for one is kept.

Value     what materials, lobes, tables and their functions are
Method    a model's method as a value
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray

Result = TypeVar("Result")


class Value:
    """A frozen dataclass, equal to another of its class where all fields are, arrays by their contents.

    Arrays are hashed once and must not change: classes make theirs read-only. One with a field that cannot be
    hashed, such as a function object that may change, is equal to itself alone. Pickled are the fields.
    Declare `@dataclass(frozen=True, eq=False, repr=False)`.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        return bool(self._key == other._key)

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        parts = (f"{each.name}={_text(getattr(self, each.name))}" for each in fields(self))
        return f"{type(self).__name__}({', '.join(parts)})"

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, part in state.items():
            if isinstance(part, np.ndarray):
                part.setflags(write=False)
            object.__setattr__(self, name, part)

    @cached_property
    def _key(self) -> tuple[object, ...]:
        key = tuple(_hashable(getattr(self, each.name)) for each in fields(self))
        try:
            hash(key)
        except TypeError:
            return (object(),)
        return key


@dataclass(frozen=True, eq=False, repr=False)
class Method(Value, Generic[Result]):
    """A model's method, equal to that of an equal model; Python's own are equal for the same object alone.

    Attributes
    ----------
    function : callable
        The method as its class has it, such as `GGX._transfer`.
    model : object
        What it is called on.
    """

    function: Callable[..., Result]
    model: object

    def __call__(self, *arguments: FloatArray) -> Result:
        """Call the method."""
        return self.function(self.model, *arguments)

    def __repr__(self) -> str:
        return f"<{self.function.__qualname__} of {self.model!r}>"


def _hashable(part: object) -> object:
    """Return a field as it is compared: of an array its type, shape and digest."""
    if not isinstance(part, np.ndarray):
        return part
    digest = hashlib.blake2b(np.ascontiguousarray(part).data, digest_size=16).digest()
    return part.dtype.str, part.shape, digest


def _text(part: object) -> str:
    """Write a field in one line, an array by its shape and type."""
    if isinstance(part, np.ndarray):
        return _array_text(part)
    return " ".join(repr(part).split())


def _array_text(array: npt.NDArray[Any]) -> str:
    return f"<{' x '.join(map(str, array.shape))} {array.dtype}>"
