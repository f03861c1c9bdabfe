"""Checks of single values: numbers, names, flags, objects."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from numbers import Integral, Real

import numpy as np

RGB = tuple[float, float, float]
"""Red, green, blue."""


def number(name: str, value: object, least: float = -math.inf, most: float = math.inf) -> float:
    """Return a finite number in [least, most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, got {value!r}")
    result = float(value)
    if not math.isfinite(result):
        raise ValueError(f"{name} must be {_range(least, most) or 'finite'}, got {result:g}")
    if not least <= result <= most:
        raise ValueError(f"{name} must be {_range(least, most)}, got {result:g}")
    return result + 0.0  # -0 is 0


def number_or_rgb(name: str, value: object, least: float, most: float = math.inf) -> float | RGB:
    """Return a number, or a triple of numbers (R, G, B), in [least, most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Sequence | np.ndarray) or isinstance(value, str | bytes) or np.ndim(value) == 0:
        return number(name, value, least, most)
    if len(value) != 3:
        raise TypeError(f"{name} must be a number or three (R, G, B), got {len(value)} values")
    red, green, blue = (number(name, channel, least, most) for channel in value)
    return red, green, blue


def fraction(name: str, value: object) -> float:
    """Return a number in [0, 1).

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    result = number(name, value)
    if not 0 <= result < 1:
        raise ValueError(f"{name} must be in [0, 1), got {result:g}")
    return result


def positive(name: str, value: object, below: float = math.inf) -> float:
    """Return a finite number above 0 and below another.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    result = number(name, value)
    if not 0 < result < below:
        needed = "above 0" if below == math.inf else f"above 0 and below {below:g}"
        raise ValueError(f"{name} must be {needed}, got {result:g}")
    return result


def whole_number(name: str, value: object, least: int, most: int | None = None) -> int:
    """Return a whole number in [least, most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, got {value!r}")
    result = int(value)
    if result < least or (most is not None and result > most):
        raise ValueError(f"{name} must be {_range(least, math.inf if most is None else most)}, got {result}")
    return result


def picture_shape(
    name: str, value: object, least: tuple[int, int] = (1, 1), most: int = 65536
) -> tuple[int, int]:
    """Return the shape (H, W) of a picture, H in [least[0], most] and W in [least[1], most].

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """
    if not isinstance(value, Sequence) or isinstance(value, str | bytes) or len(value) != 2:
        raise TypeError(f"{name} must be a pair (H, W), got {value!r}")
    H, W = (whole_number(f"{name}[{k}]", value[k], least[k], most) for k in (0, 1))
    return H, W


def one_of(name: str, value: str, options: Iterable[str]) -> str:
    """Return one of the options.

    Raises
    ------
    ValueError
        If it is none of them.
    """
    options = tuple(options)
    if value not in options:
        raise ValueError(f"{name} must be one of {', '.join(options)}, got {value!r}")
    return value


def flag(name: str, value: object) -> bool:
    """Return True or False.

    Raises
    ------
    TypeError
        If it is neither.
    """
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def string(name: str, value: object) -> str:
    """Return a string.

    Raises
    ------
    TypeError
        If it is none.
    """
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a string, got {value!r}")
    return value


def require_instance(name: str, value: object, *kinds: type, what: str | None = None) -> None:
    """Refuse what is of none of some classes.

    Parameters
    ----------
    name : str
        The argument.
    value : object
        What it was given.
    *kinds : type
        The classes.
    what : str, optional
        What it must be, in words; by default the names of the classes.

    Raises
    ------
    TypeError
        If it is of none of them.
    """
    if not isinstance(value, kinds):
        needed = what or " or ".join(_with_article(kind.__name__) for kind in kinds)
        raise TypeError(f"{name} must be {needed}, got {type(value).__name__}")


def _range(least: float, most: float) -> str:
    """Say a range as an error does: 'in [0, 1]', 'at least 0'; nothing for all numbers."""
    if most < math.inf:
        return f"in [{least:g}, {most:g}]"
    return f"at least {least:g}" if least > -math.inf else ""


def _with_article(name: str) -> str:
    """Put 'a' or 'an' before the name of a class."""
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
