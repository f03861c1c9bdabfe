"""Readers of the text of arguments; a wrong one is refused as "must be WHAT, got WHAT IT WAS"."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path


def refusal(text: str, needed: str) -> argparse.ArgumentTypeError:
    """Return the error for the text of an argument that must be what is needed."""
    return argparse.ArgumentTypeError(f"must be {needed}, got {text!r}")


def number(text: str, needed: str = "a number") -> float:
    """Read a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise refusal(text, needed)
    return value


def positive(text: str) -> float:
    """Read a finite number above 0."""
    return _between(text, 0.0, math.inf, "a number above 0")


def tolerance(text: str) -> float:
    """Read a number above 0 and below 1."""
    return _between(text, 0.0, 1.0, "a number between 0 and 1")


def field_of_view(text: str) -> float:
    """Read an angle above 0 and below 180 degrees."""
    return _between(text, 0.0, 180.0, "an angle between 0 and 180 degrees")


def _between(text: str, low: float, high: float, needed: str) -> float:
    """Read a number between two others, neither included."""
    value = number(text, needed)
    if not low < value < high:
        raise refusal(text, needed)
    return value


def count(text: str, least: int = 1) -> int:
    """Read a whole number of at least 1, or of at least `least`."""
    if not (text.isascii() and text.isdigit()) or int(text) < least:
        raise refusal(text, f"a whole number of at least {least}")
    return int(text)


def border(text: str) -> int:
    """Read a number of texels, 0 or more."""
    return count(text, 0)


def tents(text: str) -> int:
    """Read a number of tents to a side, at least 2."""
    return count(text, 2)


def orders(text: str) -> tuple[int, int]:
    """Read the orders F,P."""
    parts = text.split(",")
    if len(parts) != 2 or not all(part.isascii() and part.isdigit() for part in parts):
        raise refusal(text, "F,P: two whole numbers from 0, such as 30,4")
    return int(parts[0]), int(parts[1])


def shape(text: str) -> tuple[int, int]:
    """Read a width and a height, WxH, as the shape (H, W)."""
    parts = text.lower().split("x")
    if len(parts) != 2:
        raise refusal(text, "WxH, such as 1280x720")
    return count(parts[1]), count(parts[0])


def view(text: str) -> tuple[float, float]:
    """Read AZIMUTH,ELEVATION."""
    needed = "AZIMUTH,ELEVATION in degrees, the elevation from -90 to 90, such as 30,10"
    parts = text.split(",")
    if len(parts) != 2:
        raise refusal(text, needed)
    azimuth, elevation = (number(part, needed) for part in parts)
    if abs(elevation) > 90.0:
        raise refusal(text, needed)
    return azimuth, elevation


def file_name(*suffixes: str) -> Callable[[str], Path]:
    """Return a reader of file names that end in one of the suffixes."""

    def read(text: str) -> Path:
        if Path(text).suffix.lower() not in suffixes:
            raise refusal(text, f"a name that ends in {alternatives(suffixes)}")
        return Path(text)

    return read


def alternatives(names: tuple[str, ...]) -> str:
    """Return "A, B or C"."""
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
