"""Materials as the panel shows them: a kind, and sliders for its parameters."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from shrm import brdf

RGB = tuple[float, float, float]


@dataclass(frozen=True)
class Parameter:
    """A parameter of a kind of material.

    Attributes
    ----------
    name : str
        Of the material's class.
    label : str
    low, high : float
        Ends of its slider.
    logarithmic : bool
        Whether the slider is.
    color : bool
        Whether it is three numbers, or one for all of them.
    meaning : str
        What it does, for those who do not know its letter.
    """

    name: str
    label: str
    low: float
    high: float
    logarithmic: bool = False
    color: bool = False
    meaning: str = ""


@dataclass(frozen=True)
class Kind:
    """A kind of material.

    Attributes
    ----------
    model : type
        Its class.
    label : str
    example : str
        What it begins with, as `shrm.brdf.parse` reads it.
    parameters : tuple of Parameter
    """

    model: type[brdf.BRDF]
    label: str
    example: str
    parameters: tuple[Parameter, ...]


_ROUGHNESS = Parameter(
    "alpha",
    "roughness alpha",
    0.03,
    1.0,
    logarithmic=True,
    meaning="How steep the microfacets are: how wide reflections.",
)
_F0 = Parameter(
    "f0",
    "f0 (at normal)",
    0.0,
    1.0,
    color=True,
    meaning="Share of the light that is reflected at normal incidence: .04 for plastic, a color for metals.",
)

KINDS: Mapping[str, Kind] = {
    "lambert": Kind(
        brdf.Lambert, "Lambert (matt)", "lambert:0.8", (Parameter("albedo", "albedo", 0.0, 1.0, color=True),)
    ),
    "phong": Kind(
        brdf.Phong, "Phong", "phong:32", (Parameter("exponent", "exponent s", 1.0, 500.0, logarithmic=True),)
    ),
    "microfacet": Kind(
        brdf.Microfacet,
        "microfacets, Gaussian (2002)",
        "microfacet:0.2",
        (Parameter("sigma", "roughness sigma", 0.03, 0.8, logarithmic=True),),
    ),
    "ggx": Kind(brdf.GGX, "GGX microfacets", "ggx:0.3", (_ROUGHNESS, _F0)),
    "beckmann": Kind(brdf.Beckmann, "Beckmann microfacets", "beckmann:0.3", (_ROUGHNESS, _F0)),
    "kajiya-kay": Kind(
        brdf.KajiyaKay,
        "Kajiya-Kay (hair)",
        "kajiya-kay:16",
        (Parameter("exponent", "exponent s", 1.0, 64.0, logarithmic=True),),
    ),
    "banks": Kind(
        brdf.Banks, "Banks (brushed)", "banks:0.5", (Parameter("sharpness", "sharpness s", 0.0, 0.95),)
    ),
}


def kind_of(material: brdf.BRDF) -> str | None:
    """Return a material's name in `KINDS`; None for sums and others, which have no sliders."""
    return next((name for name, kind in KINDS.items() if type(material) is kind.model), None)


def exchanged(material: brdf.BRDF, kind: Kind) -> str:
    """Return the text of a kind's example with what it has in common with a material: parameters by name."""
    example = brdf.parse(kind.example)
    if kind_of(material) is None:
        return example.name
    common = {parameter.name for parameter in KINDS[kind_of(material) or ""].parameters}
    same = {p.name: getattr(material, p.name) for p in kind.parameters if p.name in common}
    return dataclasses.replace(example, **same).name  # type: ignore[type-var]


def value_of(material: brdf.BRDF, parameter: Parameter) -> float | RGB:
    """Return a parameter's value: three numbers if it is a color."""
    value: Any = getattr(material, parameter.name)
    if not parameter.color:
        return float(value)
    return (value, value, value) if isinstance(value, float) else value


def with_value(material: brdf.BRDF, parameter: Parameter, value: float | RGB) -> str:
    """Return the text of a material with another value of a parameter, within its slider's ends."""
    if isinstance(value, tuple):
        r, g, b = (_rounded(x, parameter) for x in value)
        new: float | RGB = r if r == g == b else (r, g, b)
    else:
        new = _rounded(value, parameter)
    return dataclasses.replace(material, **{parameter.name: new}).name  # type: ignore[type-var]


def _rounded(value: float, parameter: Parameter) -> float:
    return round(min(max(value, parameter.low), parameter.high), 3)
