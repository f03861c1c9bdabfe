"""Materials from text, as the command line takes them.

    material  = term { "+" term }
    term      = { factor "*" } name [ ":" arguments | "(" arguments ")" ]
    arguments = value | key "=" value, separated by commas; positions as in the class
    factor, value = a number, or three separated by slashes for R, G, B: 1/0.8/0.3

    microfacet:0.2
    ggx:alpha=0.1,f0=1.0/0.8/0.3
    0.5*lambert:0.8 + ggx:0.2
    merl-abc:blue-metallic-paint      a published fit by its name: merl-abc, merl-sgd, lafortune
    lafortune:mine.json#skin          material "skin" of a file of fits: abc, sgd, lafortune
    krylon_blue.brdf                  a file of measurements, see `shrm.brdf.load`
    krylon_blue.brdf:extrapolate=zero black where it has none; by default nearest
    kp8.dat:sample=12                 of a file of several samples, CUReT's

The name of every analytic material and every published fit, such as "ggx(alpha=0.1)", is such a text. (In
sums and products the path of a file cannot contain "+" or "*".)
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from shrm.brdf import fits
from shrm.brdf.material import BRDF
from shrm.brdf.measured import Extrapolate, load
from shrm.brdf.models.abc_model import ABC
from shrm.brdf.models.anisotropic_ggx import AnisotropicGGX
from shrm.brdf.models.ashikhmin_shirley import AshikhminShirley
from shrm.brdf.models.banks import Banks
from shrm.brdf.models.beckmann import Beckmann
from shrm.brdf.models.ggx import GGX
from shrm.brdf.models.kajiya_kay import KajiyaKay
from shrm.brdf.models.lafortune import Lafortune
from shrm.brdf.models.lambert import Lambert
from shrm.brdf.models.microfacet import Microfacet
from shrm.brdf.models.miller_heidrich import MillerHeidrich
from shrm.brdf.models.phong import Phong
from shrm.brdf.models.sgd import SGD
from shrm.validation import RGB

MODELS: Mapping[str, type[BRDF]] = {
    "lambert": Lambert,
    "phong": Phong,
    "microfacet": Microfacet,
    "ggx": GGX,
    "beckmann": Beckmann,
    "miller-heidrich": MillerHeidrich,
    "kajiya-kay": KajiyaKay,
    "banks": Banks,
    "ashikhmin-shirley": AshikhminShirley,
    "anisotropic-ggx": AnisotropicGGX,
    "abc": ABC,
    "sgd": SGD,
}

FILES: Mapping[str, Callable[[str, str], BRDF]] = {
    "lafortune": Lafortune.read,
    "abc": ABC.read,
    "sgd": SGD.read,
}
"""Readers of a material in a file of fits, FILE#NAME."""

_TERM = re.compile(r"(?P<name>[A-Za-z][\w-]*)\s*(?::(?P<after>.*)|\((?P<within>.*)\))?", re.DOTALL)
_PLUS = re.compile(r"(?<![\d.][eE])\+")  # not the plus of 1e+3


def parse(text: str) -> BRDF:
    """Make a material from text such as "0.5*lambert:0.8 + ggx:alpha=0.1,f0=0.04".

    Raises
    ------
    TypeError
        If `text` is not a string.
    ValueError
        If it names no known model, or arguments that the model does not take or that are out of
        range; the text lists the known ones. If it names a file that holds something else.
    OSError
        If it names a file that cannot be read.
    """
    if not isinstance(text, str):
        raise TypeError(f"a material's text must be a string, got {text!r}")
    if (file := _file(text)) is not None:  # whose path may contain + and *
        return file.load()
    first, *others = (_term(term.strip(), text) for term in _PLUS.split(text))
    return sum(others, start=first)


def filled(text: str, extrapolate: Extrapolate) -> str:
    """Return the text of the same material with its files of measurements extrapolated.

    Parameters
    ----------
    text : str
        A material's text as `parse` reads it; files with an extrapolation of their own keep it.
    extrapolate : {"nearest", "zero"}
        See `shrm.brdf.load`.
    """

    def extrapolated(file: _File) -> str:
        return file._replace(extrapolate=file.extrapolate or extrapolate).text

    def term(text: str) -> str:
        *factors, material = (part.strip() for part in text.split("*"))
        file = _file(material)
        return "*".join([*factors, material if file is None else extrapolated(file)])

    file = _file(text)
    return " + ".join(map(term, _PLUS.split(text))) if file is None else extrapolated(file)


def _term(term: str, text: str) -> BRDF:
    """Make the material of a term, its factors included; errors quote the whole text."""
    *factors, factorless = (part.strip() for part in term.split("*"))
    material = _factorless(factorless, text)
    for factor in reversed(factors):
        weight = _number_or_rgb(factor)
        if weight is None:
            raise ValueError(f"{text!r}: a factor must be a number or R/G/B, got {factor!r}")
        material = weight * material
    return material


def _factorless(term: str, text: str) -> BRDF:
    """Make the material of a term without factors: of a file, a fit, or a model."""
    # A file of measurements, or a name with arguments
    if (file := _file(term)) is not None:
        return file.load()
    match = _TERM.fullmatch(term)
    names = ", ".join(dict.fromkeys([*MODELS, *fits.MAKERS]))
    if match is None:
        raise ValueError(
            f"{text!r}: expected a material such as ggx:0.1, or a file of measurements, at {term!r}; "
            f"known are {names}"
        )
    name, arguments = match["name"].lower(), (match["after"] or match["within"] or "").strip()

    # A material of a file of fits, a published fit, or a model
    path, hash_sign, material = arguments.rpartition("#")
    if name in FILES and hash_sign:
        if not (path and material):
            raise ValueError(f"{name}: needs a file and a material in it, FILE#NAME, got {arguments!r}")
        return FILES[name](path, material)
    if name in fits.MAKERS:
        if not arguments:
            raise ValueError(f"{name}: needs the name of a material; it has {', '.join(fits.names(name))}")
        return fits.fit(name, arguments)
    if name in MODELS:
        return _model(name, arguments)
    raise ValueError(f"{text!r}: no material or file {match['name']!r}; known are {names}")


SUFFIXES = (".brdf", ".bsdf", ".binary", ".alta")
"""Endings of names that are taken for files even where there is no such file."""

_FILE = re.compile(r"(?P<path>.+?)(?P<with>[:(](?:(?:extrapolate|sample)=[^,)]*,?)+\)?)?", re.DOTALL)


class _File(NamedTuple):
    """A file of measurements, how it is filled, and the number of a sample in it."""

    path: str
    extrapolate: str | None
    sample: str | None

    def load(self) -> BRDF:
        sample = self.sample
        if sample is not None and not (sample.isascii() and sample.isdigit() and len(sample) < 10):
            raise ValueError(f"{self.path}: sample must be a whole number, got {sample!r}")
        return load(
            self.path,
            extrapolate="nearest" if self.extrapolate is None else self.extrapolate,  # type: ignore[arg-type]
            sample=None if sample is None else int(sample),
        )

    @property
    def text(self) -> str:
        values = {"sample": self.sample, "extrapolate": self.extrapolate}
        arguments = ",".join(f"{key}={value}" for key, value in values.items() if value is not None)
        return f"{self.path}:{arguments}" if arguments else self.path


def _file(term: str) -> _File | None:
    """Return the file that a text names, or None: one that is there, or a name that is nothing else."""
    # A file that is there, or a name that can be nothing else
    match = _FILE.fullmatch(term)
    if match is None:
        return None
    path = match["path"]
    try:
        exists = Path(path).is_file()
    except (OSError, ValueError):  # too long for a path, or with a zero in it
        return None
    alone = not _PLUS.search(path) and "*" not in path
    a_name = "/" in re.split("[:(]", path)[0] or Path(path).suffix.lower() in SUFFIXES
    if not (exists or (alone and a_name)):
        return None

    # Its arguments, each once
    pairs = re.findall(r"(extrapolate|sample)=([^,)]*)", match["with"] or "")
    arguments = dict(pairs)
    if len(pairs) > len(arguments):
        raise ValueError(f"{path}: {pairs[-1][0]} is given twice")
    return _File(path, arguments.get("extrapolate"), arguments.get("sample"))


def _model(name: str, arguments: str) -> BRDF:
    """Make a material whose arguments are its class's parameters."""
    # Arguments by position, then by name
    fields = _fields(name)
    names = [field.name for field in fields]
    values: dict[str, float | RGB | str] = {}
    for position, argument in enumerate(arguments.split(",") if arguments else []):
        key, equals, value = (part.strip() for part in argument.partition("="))
        if not equals:
            if position >= len(names):
                raise ValueError(f"{name}: too many arguments, it takes {_signature(name)}")
            key, value = names[position], key
        if key not in names:
            raise ValueError(f"{name}: no parameter {key!r}, it takes {_signature(name)}")
        if key in values:
            raise ValueError(f"{name}: {key} is given twice")
        number = _number_or_rgb(value)
        values[key] = value if number is None else number

    # All that have no default must be there.
    missing = [
        field.name for field in fields if field.default is dataclasses.MISSING and field.name not in values
    ]
    if missing:
        raise ValueError(f"{name}: {', '.join(missing)} is missing, it takes {_signature(name)}")
    try:
        return MODELS[name](**values)
    except TypeError as error:  # of the wrong kind, such as alpha=shiny
        raise ValueError(str(error)) from None


def _number_or_rgb(text: str) -> float | RGB | None:
    """Return a number, or three separated by slashes; None if the text is neither."""
    parts = text.split("/")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        return None
    if len(numbers) == 1:
        return numbers[0]
    return (numbers[0], numbers[1], numbers[2]) if len(numbers) == 3 else None


def _signature(name: str) -> str:
    """Return the parameters of a model as text: 'alpha, f0=1'."""
    return ", ".join(
        field.name if field.default is dataclasses.MISSING else f"{field.name}={field.default}"
        for field in _fields(name)
    )


def _fields(name: str) -> list[dataclasses.Field[object]]:
    """Return a model's parameters, without what can be given by keyword alone: its label."""
    fields = dataclasses.fields(MODELS[name])  # type: ignore[arg-type]
    return [field for field in fields if not field.kw_only]
