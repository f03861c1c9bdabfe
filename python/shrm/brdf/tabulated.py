"""Isotropic BRDFs from a regular table, interpolated linearly in its three angles.

    rho_hat = table(angles of L and V) N.L    where N.L > 0

The table holds the BRDF itself, per steradian and WITHOUT the cosine. Two sets of axes:

    axes="angles"       values[i, j, k] at theta_i, theta_o in [0, pi/2], phi = |phi_i - phi_o| in [0, pi]
    axes="half-angle"   values[i, j, k] at theta_h, theta_d in [0, pi/2], phi_d = |phi_d| in [0, pi]

Samples lie at equal steps with the first and the last on the ends of the interval. theta_h is the angle
of the half vector from the normal, (theta_d, phi_d) the direction of L in the frame of H [R98]; the
second set follows glossy lobes with far fewer samples.

Centred on the lobe, or on the reflection.

References
----------
[R98] S. Rusinkiewicz. A New Change of Variables for Efficient BRDF Representation. EGWR 1998.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from shrm.brdf.half_vector import above_horizon
from shrm.brdf.lobe import BRDF, FloatArray, IsotropicLobe
from shrm.validation import one_of, real_array


@dataclass(frozen=True, eq=False, repr=False)
class Tabulated(BRDF):
    """An isotropic BRDF on a regular grid.

    Parameters
    ----------
    values : (n1, n2, n3) or (n1, n2, n3, 3) array_like
        The BRDF without the cosine, per steradian, at least 0; two samples or more per axis.
    axes : {"angles", "half-angle"}
        What the axes are: (theta_i, theta_o, phi) or (theta_h, theta_d, phi_d).

    Raises
    ------
    TypeError, ValueError
        If `values` has another shape or type, or a value is negative or not finite.
    """

    values: npt.ArrayLike
    axes: Literal["angles", "half-angle"] = "angles"

    def __post_init__(self) -> None:
        values = real_array("Tabulated: values", self.values).copy()
        if values.ndim not in (3, 4) or min(values.shape[:3]) < 2 or values.shape[3:] not in ((), (3,)):
            raise ValueError(
                "Tabulated: values must have the shape (n1, n2, n3) or (n1, n2, n3, 3), n >= 2, "
                f"got {values.shape}"
            )
        if values.min() < 0.0:
            raise ValueError(f"Tabulated: values must be at least 0, got {values.min():g}")
        one_of("Tabulated: axes", self.axes, ("angles", "half-angle"))
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe centre."""
        return (IsotropicLobe("lobe", self._transfer),)

    @property
    def name(self) -> str:
        """Such as "tabulated(32 x 32 x 64 angles)"; no text for `parse`."""
        return f"tabulated({' x '.join(str(n) for n in np.shape(self.values)[:3])} {self.axes})"

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        table = np.asarray(self.values)
        angles = _difference_angles(wi, wo) if self.axes == "angles" else _half_angles(wi, wo)
        values = _trilinear(table, *angles)
        cosine = np.where(above_horizon(wi, wo), wi[:, 2], 0.0)
        return np.asarray(values * (cosine if values.ndim == 1 else cosine[:, None]))


def _difference_angles(wi: FloatArray, wo: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """theta_i, theta_o, |phi_i - phi_o|."""
    theta_i, theta_o = (np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]) for w in (wi, wo))
    across = wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]
    along = wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1]
    return theta_i, theta_o, np.arctan2(np.abs(across), along)


def _half_angles(wi: FloatArray, wo: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """theta_h, theta_d, |phi_d| [R98]: L in the frame of H, whose x axis leads away from the normal."""
    h = wi + wo
    across = np.hypot(h[:, 0], h[:, 1])
    theta_h = np.arctan2(across, h[:, 2])
    theta_d = np.arctan2(np.linalg.norm(wi - wo, axis=1), np.linalg.norm(h, axis=1))
    # The azimuth of H; that of L where H is the normal, which makes phi_d 0 and keeps isotropy exact.
    tilted = across > 1e-14
    x = np.where(tilted, h[:, 0], wi[:, 0])
    y = np.where(tilted, h[:, 1], wi[:, 1])
    length = np.maximum(np.hypot(x, y), 1e-300)
    x, y = x / length, y / length
    sin_h, cos_h = np.sin(theta_h), np.cos(theta_h)
    d_x = (wi[:, 0] * x + wi[:, 1] * y) * cos_h - wi[:, 2] * sin_h
    d_y = wi[:, 1] * x - wi[:, 0] * y
    return theta_h, theta_d, np.arctan2(np.abs(d_y), d_x)


def _trilinear(table: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Interpolate (n1, n2, n3, ...) at angles in [0, pi/2], [0, pi/2], [0, pi]; clamped at the ends."""
    cells, fractions = [], []
    for angle, end, n in zip((a, b, c), (np.pi / 2, np.pi / 2, np.pi), table.shape[:3], strict=True):
        position = np.clip(angle * ((n - 1) / end), 0.0, n - 1.0)
        cell = np.minimum(position.astype(np.intp), n - 2)
        cells.append(cell)
        fractions.append(position - cell)
    total = np.zeros((len(a), *table.shape[3:]))
    for corner in np.ndindex(2, 2, 2):
        index = tuple(cell + step for cell, step in zip(cells, corner, strict=True))
        weight = np.ones(len(a))
        for fraction, step in zip(fractions, corner, strict=True):
            weight *= fraction if step else 1.0 - fraction
        total += table[index] * (weight if total.ndim == 1 else weight[:, None])
    return total
