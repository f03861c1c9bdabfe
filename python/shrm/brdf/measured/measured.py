"""A material read from a file of measurements: its values, where it has any, and how the rest is filled.

    rho_hat = function(wi, wo)    where N.L > 0 and N.V >= 0, the cosine in it

Measurements do not cover every direction: goniometers stop before grazing angles, tables mark what they
lack. A reader fills those directions as it is told (`Extrapolate`) and `covers` says which they are.
Reciprocity and energy are not touched: what is measured may be less than reciprocal, or reflect more than it
receives. What a reader must change so that the values are light (negative colors, a fit below zero, a table
that is not its own mirror image) its module says, and a note where it acts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from shrm.arrays import BoolArray, FloatArray
from shrm.brdf.half_vector import above_horizon
from shrm.brdf.lobe import IsotropicLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method, Value

Extrapolate = Literal["nearest", "zero"]
"""The filling of directions without data: "nearest", the default, takes the value of the nearest with data in
the coordinates of the file (RGL's files continue their values themselves); "zero" leaves them black."""


class MeasurementError(ValueError):
    """A file of measurements is of no known format, or not as its format has it; one line that names it."""


@dataclass(frozen=True, eq=False, repr=False)
class Measured(BRDF, Value):
    """A measured isotropic material.

    Attributes
    ----------
    label : str
        What it is called, such as the stem of its file.
    source : str
        The format it was read from, such as "MERL".
    function : callable
        wi, wo, (n, 3) float64 unit vectors, to rho_hat (n, 3) float64, the cosine included; asked for
        N.L > 0 and N.V >= 0 only. A value, as `covers`: materials are equal where these are.
    covers : callable
        wi, wo, (n, 3) float64, to (n,) bool: where there is data; elsewhere `function` fills.
    extrapolate : {"nearest", "zero"}
        The filling of directions without data.
    notes : tuple of str
        Remarks, a line each: a description, the illuminant, values that were negative.
    """

    label: str
    source: str
    function: Callable[[FloatArray, FloatArray], FloatArray]
    covers: Callable[[FloatArray, FloatArray], BoolArray]
    extrapolate: Extrapolate = "nearest"
    notes: tuple[str, ...] = ()

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe center."""
        return (IsotropicLobe("lobe", Method(Measured._transfer, self)),)

    @property
    def name(self) -> str:
        """A description such as "krylon_blue (Cornell)", which `parse` does not read: it needs the file."""
        return f"{self.label} ({self.source})"

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        above = above_horizon(wi, wo)
        if above.all():  # as at the nodes of an analysis: no copies
            return self.function(wi, wo)
        values = np.zeros((len(wi), 3))
        values[above] = self.function(wi[above], wo[above])
        return values
