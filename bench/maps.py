"""Reflection maps to measure with: light, material, coefficients, and the exact values at some texels."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from inputs import FloatArray, coefficients, latlong_directions
from shrm import _core, brdf
from shrm.frequency import orders
from shrm.frequency.rings import BORDER


@dataclass(frozen=True)
class Product:
    """Coefficients of light, of a material about R, and of their global maps."""

    F: int
    P: int
    light: FloatArray
    rho: FloatArray
    coefficients: FloatArray

    @property
    def maps(self) -> int:
        return (self.P + 1) ** 2

    @property
    def degree(self) -> int:
        return self.F + self.P

    @property
    def flat(self) -> FloatArray:
        """The coefficients with maps and channels in one index."""
        return self.coefficients.reshape(len(self.coefficients), -1)


def product(F: int, P: int) -> Product:
    """A material's product with light of a natural spectrum."""
    light = coefficients(F)
    rho = orders.analysed(brdf.GGX(0.2).recentered("reflection"), F, P)[0].coefficients(F, P)
    rho = np.ascontiguousarray(np.broadcast_to(rho, (*rho.shape[:3], 3)))
    return Product(F, P, light, rho, _core.global_coefficients(light=light, rho=rho))


def some_rows(layout: str, size: int) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Twelve rows of the rings of a map, and the directions of their texels (12, W, 3)."""
    if layout == "latlong":
        directions = latlong_directions(size, 2 * size)
    else:
        side = size + 2 * BORDER
        directions = _core.cube_directions(N=size).reshape(6 * side, side, 3)
    rows = np.linspace(0, len(directions) - 1, 12).astype(np.intp)
    return rows, np.ascontiguousarray(directions[rows])


def exact_rows(flat: FloatArray, directions: FloatArray) -> FloatArray:
    """The series of all maps in float64 at the texels of some rows: (rows, maps * channels, W)."""
    n, W, _ = directions.shape
    values = _core.evaluate(coefficients=np.ascontiguousarray(flat), directions=directions.reshape(-1, 3))
    return values.reshape(n, W, -1).transpose(0, 2, 1)
