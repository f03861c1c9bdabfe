"""Published fits to measured materials, by name: the parameters stand beside this file, with their sources.

    merl-abc     100 materials of MERL, by the ABC model [LKYU12]
    merl-sgd     86 of them, by the shifted gamma distribution [BSH12]
    lafortune    skin, clay, felt, blue paint, brushed metal and primer, by generalised cosine lobes [LFTG97]

On the command line: merl-abc:blue-metallic-paint.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from shrm.brdf.material import BRDF
from shrm.brdf.models.abc_model import ABC
from shrm.brdf.models.lafortune import Lafortune
from shrm.brdf.models.sgd import SGD
from shrm.validation import one_of

Parameters = Mapping[str, Any]
"""Parameters of one material by their names: a number each, or a tuple of three for R, G, B."""

MAKERS: Mapping[str, Callable[[Parameters, str], BRDF]] = {
    "merl-abc": lambda fit, name: ABC(**fit, label=f"merl-abc:{name}"),
    "merl-sgd": lambda fit, name: SGD(**fit, label=f"merl-sgd:{name}"),
    "lafortune": Lafortune.from_coefficients,
}
"""Functions that make a material of its parameters and its name, by source."""


def names(source: str) -> tuple[str, ...]:
    """Return the materials of a source, in alphabetical order.

    Raises
    ------
    ValueError
        If there is no such source.
    """
    return tuple(_parameters(one_of("source", source, MAKERS)))


def fit(source: str, name: str) -> BRDF:
    """Make the material of a published fit.

    Parameters
    ----------
    source : {"merl-abc", "merl-sgd", "lafortune"}
        Who published it, and the model.
    name : str
        One of `names(source)`.

    Raises
    ------
    ValueError
        If there is no such source or material; the text names those there are.
    """
    materials = names(source)
    if name not in materials:
        raise ValueError(f"{source}: no material {name!r}; it has {', '.join(materials)}")
    return MAKERS[source](_parameters(source)[name], name)


@cache
def _parameters(source: str) -> Mapping[str, Parameters]:
    """Return the parameters of all materials of a source, by name."""
    lines = files(__name__).joinpath(f"{source}.csv").read_text(encoding="utf-8").splitlines()
    parameters: dict[str, dict[str, Any]] = {}
    # Rows are material, parameter, and one value or three; the first row names the columns.
    for name, parameter, *values in list(csv.reader(line for line in lines if not line.startswith("#")))[1:]:
        numbers = tuple(float(value) for value in values)
        parameters.setdefault(name, {})[parameter] = numbers if len(numbers) > 1 else numbers[0]
    return parameters
