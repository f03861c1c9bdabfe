"""The coefficient maps of one lobe, and the coefficients they are synthesised from [RH02 section 4].

For every central direction C a map's texel holds a spherical harmonic series in the view:

    radiance = sum_pq B~_pq(C) Y_pq(V)          [RH02] eq. 7

The maps are those of the *global* form: scalar functions on the sphere, band-limited to degree F + p, which
may be interpolated and resampled. Lobes without azimuth (radial, or about the tangent) keep only q = 0 of
the *local* form, P + 1 maps, and radiance = sum_p B_p0(C) Y_p0(angle between C and V)     [RH02] eq. 6.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.frequency.rings import BORDER, Interpolation, Rings, halved
from shrm.lobes.reflection import Layout
from shrm.sh import basis_size, degree_of

Maps = TypeVar("Maps", bound="CoefficientMaps")


@dataclass(frozen=True, eq=False, repr=False)
class CoefficientMaps(Rings):
    """The coefficient maps of one lobe: those that were fitted to pictures have no more than these.

    `maps` are ((P+1)^2, H, W, 3) at index p(p+1)+q of the real basis, or (P+1, H, W, 3) at index p if zonal.

    Attributes
    ----------
    center, gamma, layout, rings
        As in `shrm.frequency.rings.Rings`.
    zonal : bool
        True if the maps are B_p0, to be multiplied by Y_p0(angle between C and V); False if they are B~_pq,
        to be multiplied by Y_pq(V).
    """

    zonal: bool

    @property
    def P(self) -> int:
        """Largest order of the view."""
        return order_of(self.rings.shape[1], self.zonal)

    @property
    def F(self) -> int:
        """Largest degree of the light; -1 for maps that have no coefficients."""
        return -1

    def sum_for_view(self, view: FloatArray, pixels: Float32Array) -> None:
        """Sum the maps for a view (1, 3) into one of `shape` [RH02 eq. 12]; nothing is checked."""
        _core.view_map(
            rings=self.rings, cube=self.layout == "cube", zonal=self.zonal, direction=view, pixels=pixels
        )

    def looked_up(
        self, C: FloatArray, views: FloatArray, interpolation: Interpolation = "cubic"
    ) -> Float32Array:
        """Return the radiance from look-ups in the maps at central directions; (n, 3)."""
        return self.look_up(C, views, self.zonal, interpolation)

    def as_half(self: Maps) -> Maps:
        """Return the same maps as half floats.

        Raises
        ------
        ValueError
            If a value is beyond 65504, the largest of them.
        """
        if self.rings.dtype == np.float16:
            return self
        return replace(self, rings=halved(self.rings.astype(np.float32, copy=False), self.layout))

    def __repr__(self) -> str:
        degrees = f"F={self.F} " if self.F >= 0 else ""
        return (
            f"<{type(self).__name__} about the {self.center}: {degrees}P={self.P} {self.layout} {self.size}>"
        )


@dataclass(frozen=True, eq=False, repr=False)
class Part(CoefficientMaps):
    """The coefficient maps of one lobe with the coefficients of light and lobe that they come from.

    Attributes
    ----------
    center, gamma, layout, rings, zonal
        As in `CoefficientMaps`.
    light : ((F+1)^2, 3) float64
        L_lm in the real basis of `shrm.sh`.
    rho : (F+1, P+1, P+1, 3) float64
        rho_lpq at [l, p, q], zero where q > min(l, p); windows included.
    """

    light: FloatArray
    rho: FloatArray

    @property
    def F(self) -> int:
        """Largest degree of the light."""
        return degree_of(self.light)

    @cached_property
    def coefficients(self) -> FloatArray:
        """The spherical harmonic coefficients of the maps: the exact form, without resolution.

        ((F+P+1)^2, maps, 3) float64; ((F+1)^2, P+1, 3) if zonal.
        """
        if not self.zonal:
            return _core.global_coefficients(light=self.light, rho=self.rho)
        l = np.repeat(np.arange(self.F + 1), 2 * np.arange(self.F + 1) + 1)
        # [RH02] eq. 5 and eq. 14 at q = 0: B_p0 = sum_lm L_lm rho_lp0 d^l_m0 e^{i m beta}, and
        # d^l_m0 e^{i m beta} = Lambda_l Y_lm with Lambda_l = sqrt(4 pi / (2l+1))
        return np.asarray(
            self.light[:, None, :] * (np.sqrt(4 * np.pi / (2 * l + 1))[:, None, None] * self.rho[l, :, 0])
        )

    def series(self, C: FloatArray, views: FloatArray) -> FloatArray:
        """Return the radiance from the coefficients themselves, for central directions and views; (n, 3)."""
        flat = self.coefficients.reshape(len(self.coefficients), -1)
        coefficients = _core.evaluate(coefficients=flat, directions=C).reshape(len(C), -1, 3)
        return np.asarray(np.einsum("nz,nzc->nc", self._view_basis(C, views), coefficients))

    def _view_basis(self, C: FloatArray, views: FloatArray) -> FloatArray:
        """Return Y_pq(V), or Y_p0 at the angle between C and V if zonal; (n, maps)."""
        if not self.zonal:
            return _core.evaluate(coefficients=np.eye((self.P + 1) ** 2), directions=views)
        return zonal_harmonics(self.P, np.einsum("nc,nc->n", C, views))

    def local_maps(self, H: int, W: int | None = None) -> Float32Array:
        """Return the local form B_pq(alpha, beta) [RH02 eq. 14] on a lat-long grid.

        For q /= 0 these are spin functions, singular at the poles: use them on their own grid only.

        Parameters
        ----------
        H, W : int
            Size; W is 2 H unless given.

        Returns
        -------
        ((P+1)^2, H, W, 3) float32
            sqrt2 Re B_pq at p(p+1)+q, B_p0, and -sqrt2 Im B_pq at p(p+1)-q: the coefficients in the real
            basis of the view in the frame of C, for the sum [RH02] eq. 6.

        Raises
        ------
        ValueError
            If H or W is not positive.
        """
        width = 2 * H if W is None else W
        rings = _core.local_reflection_map(light=self.light, rho=self.rho, H=H, W=width)
        return np.asarray(rings.transpose(1, 0, 3, 2))

    def resized(self, size: int, layout: Layout) -> Part:
        """Return the same lobe on another grid, made from its coefficients.

        `size` is the rows of a lat-long map, or of a cube's face.
        """
        return replace(self, layout=layout, rings=synthesised(self.coefficients, size, layout))


def synthesised(coefficients: FloatArray, size: int, layout: Layout) -> Float32Array:
    """Return the rings (H, maps, 3, W) of maps from their coefficients, ((J+1)^2, maps, 3)."""
    count, maps = coefficients.shape[:2]
    columns = np.ascontiguousarray(coefficients.reshape(count, maps * 3))
    if layout == "latlong":
        rings = _core.synthesis(coefficients=columns, H=size, W=2 * size)
        return np.asarray(rings).reshape(size, maps, 3, 2 * size)
    rings = _core.cube_synthesis(coefficients=columns, N=size)
    return np.asarray(rings).reshape(len(rings), maps, 3, size + 2 * BORDER)


def zonal_harmonics(P: int, cosine: FloatArray) -> FloatArray:
    """Return Y_p0 at angles whose cosines are given, for all p <= P: one more axis, the last."""
    p = np.arange(P + 1)
    legendre = np.polynomial.legendre.legvander(np.clip(cosine, -1, 1), P)
    return np.asarray(legendre * np.sqrt((2 * p + 1) / (4 * np.pi)), np.float64)


def order_of(maps: int, zonal: bool) -> int:
    """Return P of a number of maps; ValueError if it is none that a lobe has."""
    P = maps - 1 if zonal else round(float(np.sqrt(maps))) - 1
    if P < 0 or (not zonal and basis_size(P) != maps):
        raise ValueError(f"a reflection map has (P+1)^2 maps, got {maps}")
    return P
