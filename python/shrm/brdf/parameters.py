"""The parameters of a BRDF: how narrow a lobe may be, and how numbers are written in its name.

Every model checks its parameters (see `shrm.validation`) when it is made, so that its formulas need no
guards against them later.
"""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

from shrm.validation import RGB

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

# Narrower lobes are mirrors to every environment map (an arc second is 5e-6 radians), and below
# this 1 / alpha^2 approaches the largest numbers that leave room for products of two of them.
NARROWEST = 1e-6

# Exponents of cosines: lobes cos^n are 1 / sqrt(n) radians wide.
SHARPEST = NARROWEST**-2

# Factors and values of a BRDF, per steradian: what float32, the type of maps, holds with room for the peaks
# of narrow lobes and for sums over the light.
LARGEST = 1e30


def text(value: float | RGB) -> str:
    """Write a parameter as the command line reads it: '0.1', '1/0.8/0.3'."""
    if isinstance(value, tuple):
        return "/".join(text(channel) for channel in value)
    short = f"{value:g}"
    return short if float(short) == value else repr(value)


def named(material: DataclassInstance, name: str) -> str:
    """Write a model and its parameters as `parse` reads it: 'abc(kD=0.1,...)'."""
    values = ((each.name, getattr(material, each.name)) for each in fields(material) if not each.kw_only)
    return f"{name}({','.join(f'{key}={text(value)}' for key, value in values)})"
