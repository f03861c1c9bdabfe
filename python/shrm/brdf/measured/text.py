"""Files of measurements that are text: their lines and numbers, with errors that name the file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from shrm.arrays import FloatArray

LARGEST = 8 << 20
"""Largest text file that is read, bytes: about ten times the largest published one of these formats."""


def lines(path: Path) -> list[str]:
    """Return the lines of a text file, without spaces at their ends; those that are empty are left out.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is larger than `LARGEST`, or no text.
    """
    with path.open("rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"{path}: is larger than {LARGEST >> 20} MiB, as no file of this format is")
    text = decoded(content)
    if text is None:
        raise ValueError(f"{path}: is not text")
    return [line for line in (raw.strip() for raw in text.splitlines()) if line]


def decoded(content: bytes) -> str | None:
    """Return bytes as text, or None where they hold what text does not."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        if fault.end < len(content) or fault.reason != "unexpected end of data":
            return None
        text = content[: fault.start].decode("utf-8-sig")  # the head of a file ends within a character
    return None if any(c < " " and not c.isspace() for c in text) else text


def numbers(path: Path, words: Sequence[str]) -> FloatArray:
    """Return words as finite numbers, (n,) float64.

    Raises
    ------
    ValueError
        If one is not that; the text names it.
    """
    try:
        values = np.array(words, dtype=np.float64)
    except ValueError:
        wrong = next(word for word in words if not is_number(word))
        raise ValueError(f"{path}: expected a number, got {wrong[:40]!r}") from None
    finite = np.isfinite(values)
    if not finite.all():
        first = words[int(np.argmin(finite))]
        raise ValueError(f"{path}: {np.sum(~finite)} numbers are not finite, the first is {first[:40]!r}")
    return values


def rows(path: Path, content: Sequence[str]) -> FloatArray:
    """Return lines of equally many numbers as an array, (lines, numbers) float64.

    Raises
    ------
    ValueError
        If there is no line, or they differ in length, or hold something else.
    """
    words = [line.replace(",", " ").split() for line in content]
    if not words:
        raise ValueError(f"{path}: has no rows of numbers")
    for count, row in enumerate(words):
        if len(row) != len(words[0]):
            raise ValueError(
                f"{path}: row {count + 1} has {len(row)} numbers where the first has {len(words[0])}"
            )
    return numbers(path, [word for row in words for word in row]).reshape(len(words), -1)


def require_range(path: Path, name: str, values: FloatArray, least: float, most: float) -> None:
    """Refuse values outside [least, most].

    Raises
    ------
    ValueError
        If there are any; the text names the file, what they are and the first of them.
    """
    outside = (values < least) | (values > most)
    if outside.any():
        first = values[outside][0]
        raise ValueError(f"{path}: {name} must be in [{least:.7g}, {most:.7g}], got {first:g}")


def is_number(word: str) -> bool:
    """Tell whether a word is a number as `float` takes it."""
    try:
        float(word)
    except ValueError:
        return False
    return True
