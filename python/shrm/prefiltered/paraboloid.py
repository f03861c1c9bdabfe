"""Dual-paraboloid maps as materials: look-ups without a seam between the two faces.

Sources: [HS98], [KVHS00].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.environment.paraboloid import face_positions
from shrm.lobes.directions import across, central_directions
from shrm.lobes.factored import factor_at
from shrm.validation import one_of, real_array, require_instance, unit_vectors, whole_number

RadialCenter = Literal["reflection", "normal"]


def blended_band(size: int, border: int) -> float:
    """Return |z| up to which look-ups blend both faces; half of the border is within it."""
    rim = 1.0 + border / size
    return (rim**2 - 1.0) / (rim**2 + 1.0)


@dataclass(frozen=True, eq=False, repr=False)
class ParaboloidMap:
    """The dual-paraboloid map of one lobe.

    Parameters
    ----------
    pixels : (2, side, side, 3) float32
        Radiance by the central direction; side = size + 2 border, finite.
    border : int
        Texels beyond the disc on each side, at least 1.
    center : {"reflection", "normal"}
        The central direction at which it is looked up.
    factor : (T, 1 or 3) float64, optional
        Factor of the radiance, uniform in theta_v over [0, pi/2]: that of a `shrm.lobes.factored` lobe.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    pixels: Float32Array
    border: int
    center: RadialCenter = "reflection"
    factor: FloatArray = field(default_factory=lambda: np.ones((2, 1)))

    def __post_init__(self) -> None:
        pixels = real_array("pixels", self.pixels)
        if pixels.ndim != 4 or pixels.shape != (2, pixels.shape[1], pixels.shape[1], 3):
            raise ValueError(f"pixels must have the shape (2, side, side, 3), got {pixels.shape}")
        if pixels.shape[1] - 2 * whole_number("border", self.border, 1) < 2:
            raise ValueError(
                f"pixels must hold a disc of at least 2 texels within a border of {self.border}, "
                f"got faces of {pixels.shape[1]}"
            )
        one_of("center", self.center, ("reflection", "normal"))
        factor = real_array("factor", self.factor)
        if factor.ndim != 2 or len(factor) < 2 or factor.shape[1] not in (1, 3):
            raise ValueError(f"factor must have the shape (T, 1 or 3), T at least 2, got {factor.shape}")
        object.__setattr__(self, "pixels", np.ascontiguousarray(self.pixels, np.float32))

    @property
    def size(self) -> int:
        """Texels across the disc."""
        return int(self.pixels.shape[1]) - 2 * self.border

    def about(self, centers: FloatArray) -> FloatArray:
        """Look up directions (n, 3), unit: radiance (n, 3), linear between texels and between faces.

        Faces are blended across z = 0, where both show the same directions: their values differ there as far
        as the filter that made them is inexact.
        """
        upper = np.clip(0.5 + 0.5 * centers[:, 2] / blended_band(self.size, self.border), 0.0, 1.0)
        share = np.stack([upper, 1.0 - upper])
        result = np.zeros((len(centers), 3))
        places = face_positions(centers, self.size, self.border)
        for face, place, weight in zip(self.pixels, places, share, strict=True):
            visible = np.flatnonzero(weight > 0.0)
            result[visible] += weight[visible, None] * _bilinear(face, place[visible])
        return result

    def __repr__(self) -> str:
        return f"<ParaboloidMap about the {self.center}: {self.size} texels, a border of {self.border}>"


def _bilinear(face: Float32Array, positions: FloatArray) -> FloatArray:
    """Return the pixels of a face at positions (n, 2) in texels; (n, 3)."""
    last = len(face) - 1
    corner = np.floor(positions - 0.5)
    x, y = (positions - 0.5 - corner).T[:, :, None]
    (j0, i0), (j1, i1) = (np.clip(corner.astype(int) + k, 0, last).T for k in (0, 1))
    above = (1 - x) * face[i0, j0] + x * face[i0, j1]
    below = (1 - x) * face[i1, j0] + x * face[i1, j1]
    return np.asarray((1 - y) * above + y * below)


class ParaboloidMaps:
    """A material as dual-paraboloid maps, one for each of its lobes: `shrm.render` and the GPU draw it.

    Parameters
    ----------
    maps : sequence of ParaboloidMap
        Their sum is reflected.

    Raises
    ------
    TypeError, ValueError
        If there are none, or one is not a `ParaboloidMap`.
    """

    def __init__(self, maps: Sequence[ParaboloidMap]) -> None:
        if not maps:
            raise ValueError("maps must be at least one, got none")
        for map in maps:
            require_instance("maps", map, ParaboloidMap, what="of ParaboloidMap")
        self.maps = tuple(maps)

    def radiance(
        self, normals: npt.ArrayLike, views: npt.ArrayLike, tangents: npt.ArrayLike | None = None
    ) -> Float32Array:
        """Return the reflected radiance.

        Parameters
        ----------
        normals, views : (n, 3) array_like
            Unit vectors, from the surface; one view (3,) may serve all.
        tangents : (n, 3) array_like, optional
            Not needed: no lobe depends on them.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        n = unit_vectors("normals", normals)
        v = unit_vectors("views", views, len(n))
        theta_v = across(n, v)[1]
        # Of normals that face away the reflection is two-sided; about the normal V is brought to the horizon.
        theta_of_center = {"reflection": np.minimum(theta_v, np.pi - theta_v), "normal": theta_v}
        total = sum(
            factor_at(part.factor, theta_of_center[part.center])
            * part.about(central_directions(part.center, n, v, n))
            for part in self.maps
        )
        return np.asarray(total, np.float32)

    def __repr__(self) -> str:
        return f"<ParaboloidMaps: {len(self.maps)}, about the {', '.join(map.center for map in self.maps)}>"
