"""What a valid parameter of a BRDF is: numbers in a range, and RGB triples of them.

Every model checks its parameters here when it is made, so that its formulas need no guards
against them later.
"""

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np
import numpy.typing as npt

RGB = tuple[float, float, float]

# Narrower lobes are mirrors to every environment map (an arc second is 5e-6 radians), and below
# this 1 / alpha^2 approaches the largest numbers that leave room for products of two of them.
NARROWEST = 1e-6


def number(model: str, name: str, value: object, low: float, high: float = math.inf) -> float:
    """Return `value` as a float in [low, high].

    Raises
    ------
    TypeError
        If `value` is not a real number.
    ValueError
        If it is not finite or lies outside the range.
    """
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        raise TypeError(f"{model}: {name} must be a number, got {value!r}")
    result = float(value)
    if not math.isfinite(result) or not low <= result <= high:
        raise ValueError(f"{model}: {name} must be {range_text(low, high)}, got {result:g}")
    return result


def number_or_rgb(model: str, name: str, value: object, low: float, high: float = math.inf) -> float | RGB:
    """Return `value` as a float, or as a triple of floats (R, G, B), in [low, high].

    Raises
    ------
    TypeError
        If `value` is neither a real number nor a sequence of three.
    ValueError
        If a number is not finite or lies outside the range.
    """
    if not isinstance(value, Sequence | np.ndarray) or isinstance(value, str | bytes) or np.ndim(value) == 0:
        return number(model, name, value, low, high)
    if len(value) != 3:
        raise TypeError(f"{model}: {name} must be a number or three (R, G, B), got {len(value)} values")
    red, green, blue = (number(model, name, channel, low, high) for channel in value)
    return red, green, blue


def array(model: str, name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return `value` as a float64 array of finite numbers.

    Raises
    ------
    TypeError
        If `value` is not an array of real numbers.
    ValueError
        If one of them is not finite.
    """
    try:
        raw = np.asarray(value)
    except ValueError:
        raise TypeError(f"{model}: {name} must be an array of numbers, got rows of unequal length") from None
    if raw.dtype.kind not in "fiu":
        raise TypeError(f"{model}: {name} must be an array of real numbers, got dtype {raw.dtype}")
    result = raw.astype(np.float64)
    bad = np.argwhere(~np.isfinite(result))
    if len(bad):
        where = tuple(int(i) for i in bad[0])
        raise ValueError(
            f"{model}: {name} must be finite, got {len(bad)} non-finite values, the first at {where}"
        )
    return result


def range_text(low: float, high: float) -> str:
    """Say the range as an error does: 'in [0, 1]', 'at least 0'."""
    return f"at least {low:g}" if high == math.inf else f"in [{low:g}, {high:g}]"


def text(value: float | RGB) -> str:
    """Write a parameter as the command line reads it: '0.1', '1/0.8/0.3'."""
    if isinstance(value, tuple):
        return "/".join(text(channel) for channel in value)
    short = f"{value:g}"
    return short if float(short) == value else repr(value)
