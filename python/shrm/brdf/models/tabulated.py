"""Isotropic BRDFs from a regular table, interpolated linearly in its three angles.

    rho_hat = table(angles of L and V) N.L    where N.L > 0

The table holds the BRDF itself, per steradian and WITHOUT the cosine. Two sets of axes:

    axes="angles"       values[i, j, k] at theta_i, theta_o in [0, pi/2], phi = |phi_i - phi_o| in [0, pi]
    axes="half-angle"   values[i, j, k] at theta_h, theta_d in [0, pi/2], phi_d = |phi_d| in [0, pi]

Samples lie at equal steps with the first and the last on the ends of the interval. theta_h is the angle
of the half vector from the normal, (theta_d, phi_d) the direction of L in the frame of H [R98]; the
second set follows glossy lobes with far fewer samples.

Centered on the lobe, or on the reflection.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.angle_table import AngleTable, Axes
from shrm.brdf.half_vector import above_horizon
from shrm.brdf.lobe import IsotropicLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method, Value
from shrm.validation import one_of, real_array


@dataclass(frozen=True, eq=False, repr=False)
class Tabulated(BRDF, Value):
    """An isotropic BRDF on a regular grid.

    Parameters
    ----------
    values : (n1, n2, n3) or (n1, n2, n3, 3) array_like
        The BRDF without the cosine, per steradian, in [0, 1e30]; two samples or more per axis.
    axes : {"angles", "half-angle"}
        What the axes are: (theta_i, theta_o, phi) or (theta_h, theta_d, phi_d).

    Raises
    ------
    TypeError, ValueError
        If `values` has another shape or type, or a value is negative or not finite.
    """

    values: npt.ArrayLike
    axes: Axes = "angles"

    def __post_init__(self) -> None:
        values = real_array("Tabulated: values", self.values).copy(order="C")
        if values.ndim not in (3, 4) or min(values.shape[:3]) < 2 or values.shape[3:] not in ((), (3,)):
            raise ValueError(
                "Tabulated: values must have the shape (n1, n2, n3) or (n1, n2, n3, 3), n >= 2, "
                f"got {values.shape}"
            )
        if values.min() < 0.0 or values.max() > parameters.LARGEST:
            raise ValueError(
                f"Tabulated: values must be in [0, {parameters.LARGEST:g}], "
                f"got {values.min():g} to {values.max():g}"
            )
        one_of("Tabulated: axes", self.axes, get_args(Axes))
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe center."""
        return (IsotropicLobe("lobe", Method(Tabulated._transfer, self)),)

    @property
    def name(self) -> str:
        """A description such as "tabulated(32 x 32 x 64 angles)", which `parse` does not read."""
        return f"tabulated({' x '.join(str(n) for n in np.shape(self.values)[:3])} {self.axes})"

    @cached_property
    def _table(self) -> AngleTable:
        values = np.asarray(self.values)
        return AngleTable(values.reshape((*values.shape[:3], -1)), self.axes)

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        cosine = np.where(above_horizon(wi, wo), wi[:, 2], 0.0)
        values = self._table(wi, wo) * cosine[:, None]
        return values if np.ndim(self.values) == 4 else values[:, 0]
