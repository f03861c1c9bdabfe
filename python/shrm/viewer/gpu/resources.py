"""What was put on the GPU for a frame, kept for the next as long as it is used."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Protocol, TypeVar, cast


class Releasable(Protocol):
    """Something on the GPU."""

    def release(self) -> object:
        """Free it."""


R = TypeVar("R", bound=Releasable)
S = TypeVar("S")


class Resources:
    """Resources by key, with what they were made of; what a frame does not use is freed after it."""

    def __init__(self) -> None:
        self._held: dict[Hashable, tuple[object, Releasable]] = {}
        self._used: set[Hashable] = set()

    def get(
        self,
        key: Hashable,
        source: S,
        make: Callable[[S], R],
        renew: Callable[[R, S], None] | None = None,
    ) -> R:
        """Return the resource of a key, which `make` has made of the source.

        If it was made of another source, it is renewed or, without `renew`, made again.
        """
        self._used.add(key)
        made_of, held = self._held.get(key, (None, None))
        if held is not None and made_of is source:
            return cast(R, held)
        if held is not None and renew is not None:
            renew(cast(R, held), source)
        else:
            if held is not None:
                held.release()
            held = make(source)
        self._held[key] = source, held
        return cast(R, held)

    def end_frame(self) -> None:
        """Free what was not asked for since the last call."""
        for key in self._held.keys() - self._used:
            self._held.pop(key)[1].release()
        self._used.clear()

    def release(self) -> None:
        """Free everything."""
        self._used.clear()
        self.end_frame()

    def __len__(self) -> int:
        return len(self._held)
