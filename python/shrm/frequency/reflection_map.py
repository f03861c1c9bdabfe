"""The spherical harmonic reflection map (SHRM) [RH02 section 4].

For every central direction C a map's texel holds a spherical harmonic series in the view:

    radiance = sum_pq B~_pq(C) Y_pq(V)          [RH02] eq. 7

The maps are those of the *global* form: scalar functions on the sphere, band-limited to degree F + p, which
may be interpolated and resampled. Lobes without azimuth (radial, or about the tangent) keep only q = 0 of
the *local* form, P + 1 maps, and radiance = sum_p B_p0(C) Y_p0(angle between C and V)     [RH02] eq. 6.

A material of several lobes has a part for each, about its own center.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float16Array, Float32Array, FloatArray
from shrm.brdf.lobe import Center
from shrm.frequency.rings import BORDER, halved, synthesised
from shrm.integrate.residual import Residual
from shrm.lobes.reflection import Layout, Reflection
from shrm.sh import basis_size, degree_of
from shrm.validation import one_of, require_array, unit_vectors

Interpolation = Literal["cubic", "bilinear"]


@dataclass(frozen=True, eq=False)
class Part:
    """The maps of one lobe.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        What C is.
    gamma : (257,) float64
        The angle between C and N over theta_v in [0, pi/2], radians; empty about the tangent.
    zonal : bool
        Whether the maps are B_p0, to go with Y_p0(angle of C and V), else B~_pq, to go with Y_pq(V).
    layout : {"latlong", "cube"}
        The grid of central directions.
    light : ((F+1)^2, 3) float64
        L_lm in the real basis of `shrm.sh`; (0, 3) for maps fitted to pictures.
    rho : (F+1, P+1, P+1, 3) float64
        rho_lpq at [l, p, q], zero where q > min(l, p); windows included.
    rings : (H, maps, 3, W) float32 or float16
        The maps as they lie in memory: row by row. A cube has 6 (N + 4) rows of N + 4 texels, each face with
        a border of two texels in its own plane.
    """

    center: Center
    gamma: FloatArray
    zonal: bool
    layout: Layout
    light: FloatArray
    rho: FloatArray
    rings: Float32Array | Float16Array

    @property
    def F(self) -> int:
        """Largest degree of the light; -1 for maps fitted to pictures, which have no coefficients."""
        return degree_of(self.light) if len(self.light) else -1

    @property
    def P(self) -> int:
        """Largest order of the view."""
        maps = self.rings.shape[1]
        return maps - 1 if self.zonal else round(float(np.sqrt(maps))) - 1

    @property
    def size(self) -> int:
        """Rows of a lat-long map, or of a cube's face."""
        return int(self.rings.shape[0] if self.layout == "latlong" else self.rings.shape[3] - 2 * BORDER)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one map: (H, W, 3), or (6, N, N, 3) for cubes."""
        N = self.size
        return (6, N, N, 3) if self.layout == "cube" else (*self.rings.shape[::3], 3)

    @property
    def maps(self) -> Float32Array | Float16Array:
        """The coefficient maps, a view.

        ((P+1)^2, H, W, 3) float32 at index p(p+1)+q of the real basis, or (P+1, H, W, 3) at index p if
        zonal; for cubes H, W become 6, N, N with the faces in the order +X -X +Y -Y +Z -Z.
        """
        if self.layout == "latlong":
            return self.rings.transpose(1, 0, 3, 2)
        side = self.rings.shape[3]
        faces = self.rings.reshape(6, side, *self.rings.shape[1:])
        inner = slice(BORDER, side - BORDER)
        return faces[:, inner, :, :, inner].transpose(2, 0, 1, 4, 3)

    def directions(self) -> FloatArray:
        """Return the central direction of every texel: (H, W, 3), or (6, N, N, 3) for cubes."""
        rings = self.ring_directions()
        if self.layout == "latlong":
            return rings
        side = self.size + 2 * BORDER
        return rings.reshape(6, side, side, 3)[:, BORDER:-BORDER, BORDER:-BORDER]

    def ring_directions(self) -> FloatArray:
        """Return the central direction of every texel of the rings, a cube's borders included: (H, W, 3)."""
        if self.layout == "cube":
            return _core.cube_directions(N=self.size)
        H, W = self.rings.shape[0], self.rings.shape[3]
        theta = (np.arange(H)[:, None] + 0.5) * np.pi / H
        phi = np.pi - 2 * np.pi * (np.arange(W) + 0.5) / W
        z = np.broadcast_to(np.cos(theta), (H, W))
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), z], axis=-1)

    @cached_property
    def coefficients(self) -> FloatArray:
        """Spherical harmonic coefficients of the maps: the exact, resolution-free form.

        ((F+P+1)^2, maps, 3) float64; ((F+1)^2, P+1, 3) if zonal. Maps fitted to pictures have none.
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

    def sum_for_view(self, view: FloatArray, pixels: Float32Array) -> None:
        """Sum the maps for a view (1, 3) into one of `shape` [RH02 eq. 12]; nothing is checked."""
        _core.view_map(
            rings=self.rings, cube=self.layout == "cube", zonal=self.zonal, direction=view, pixels=pixels
        )

    def looked_up(
        self, C: FloatArray, views: FloatArray, interpolation: Interpolation = "cubic"
    ) -> Float32Array:
        """Return the radiance from look-ups in the maps at central directions; (n, 3)."""
        radiance = np.zeros(C.shape, dtype=np.float32)
        _core.add_radiance(
            rings=self.rings,
            cube=self.layout == "cube",
            zonal=self.zonal,
            centre="tangent",  # the axis is C itself
            gamma=np.zeros(0),
            axes=C,
            views=views,
            bilinear=interpolation == "bilinear",
            radiance=radiance,
        )
        return radiance

    def _view_basis(self, C: FloatArray, views: FloatArray) -> FloatArray:
        """Y_pq(V), or Y_p0 at the angle between C and V if zonal; (n, maps)."""
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
            If H or W is not positive, or the maps were fitted to pictures.
        """
        width = 2 * H if W is None else W
        rings = _core.local_reflection_map(light=self.light, rho=self.rho, H=H, W=width)
        return np.asarray(rings.transpose(1, 0, 3, 2))

    def as_half(self) -> Part:
        """Return the same maps as half floats.

        Raises
        ------
        ValueError
            If a value is beyond 65504, the largest of them.
        """
        if self.rings.dtype == np.float16:
            return self
        return replace(self, rings=halved(self.rings.astype(np.float32, copy=False), self.layout))

    def resized(self, size: int, layout: Layout) -> Part:
        """Return the same lobe on another grid, made from its coefficients.

        `size` is the rows of a lat-long map, or of a cube's face.
        """
        return replace(self, layout=layout, rings=synthesised(self.coefficients, size, layout))


@dataclass(frozen=True, eq=False)
class ReflectionMap(Reflection):
    """A prefiltered environment: what `shrm.prefilter` returns.

    Attributes
    ----------
    parts : tuple of Part
        One for each lobe of the material.
    brdf : str
        The material's name.
    criterion : str
        The measure of `error`.
    window : str or None
        The window on the degrees.
    clamp : bool
        Whether negative radiance is set to zero when read, lobe by lobe.
    predict : callable
        Computes `error` when it is first asked for: it takes longer than the maps.
    residual : Residual or None
        What the orders cannot hold of sharp lobes: `radiance` and `maps_at_view` add it. `Residual.radiance`
        and `Residual.maps_at_view` are it alone.
    """

    parts: tuple[Part, ...]
    brdf: str
    criterion: str
    window: str | None
    clamp: bool
    predict: Callable[[], float]
    residual: Residual | None = None

    @property
    def F(self) -> int:
        """Largest degree of the light, over the parts."""
        return max(part.F for part in self.parts)

    @property
    def P(self) -> int:
        """Largest order of the view, over the parts."""
        return max(part.P for part in self.parts)

    @property
    def layout(self) -> Layout:
        """The grid of the maps."""
        return self.parts[0].layout

    @property
    def size(self) -> int:
        """Rows of a lat-long map, or of a cube's face."""
        return self.parts[0].size

    @cached_property
    def error(self) -> float:
        """The error predicted, in the criterion's measure.

        For `light`: the relative RMS of the reflected radiance over all frames (N, V), of truncation and
        interpolation together. For the others: the fraction of energy that truncation leaves out. For maps
        fitted to pictures: the relative RMS of the fit.
        """
        return self.predict()

    def radiance(
        self,
        normals: npt.ArrayLike,
        views: npt.ArrayLike,
        tangents: npt.ArrayLike | None = None,
        *,
        interpolation: Interpolation = "cubic",
    ) -> Float32Array:
        """Return the radiance reflected towards the eye [RH02 eq. 7].

        Normals that face away from the eye, as interpolated ones do at silhouettes, are shaded as the paper's
        reflection formula has it (two-sided), or as seen from their horizon (about the lobe and the normal).

        Parameters
        ----------
        normals : (n, 3) array_like
            Unit vectors, world frame.
        views : (n, 3) or (3,) array_like
            Unit vectors from the surface to the eye; one for all points if the viewer is distant.
        tangents : (n, 3) array_like, optional
            Unit vectors, needed for lobes about the tangent.
        interpolation : {"cubic", "bilinear"}
            Between the maps' texels. Bilinear look-ups, as graphics hardware makes them, lose a few per cent
            of the highest degrees.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        ValueError, TypeError
            If an argument has another shape, or is not of unit vectors; if a lobe about the tangent is given
            no tangents.
        """
        one_of("interpolation", interpolation, ("cubic", "bilinear"))
        N = unit_vectors("normals", normals)
        V = unit_vectors("views", views, 1 if np.ndim(views) == 1 else len(N))
        T = N
        if any(part.center == "tangent" for part in self.parts):
            if tangents is None:
                raise ValueError(f"{self.brdf} has a lobe about the tangent: radiance needs tangents")
            T = unit_vectors("tangents", tangents, len(N))
        radiance = np.zeros(N.shape, dtype=np.float32)
        for part in self.parts:
            of_lobe = np.zeros_like(radiance) if self.clamp else radiance
            _core.add_radiance(
                rings=part.rings,
                cube=part.layout == "cube",
                zonal=part.zonal,
                centre=part.center,
                gamma=part.gamma,
                axes=T if part.center == "tangent" else N,
                views=V,
                bilinear=interpolation == "bilinear",
                radiance=of_lobe,
            )
            if self.clamp:
                radiance += np.maximum(of_lobe, 0)
        if self.residual is not None:
            radiance += self.residual.radiance(N, V)
        return radiance

    @property
    def centers(self) -> tuple[Center, ...]:
        """The center of each part."""
        return tuple(part.center for part in self.parts)

    def lobe_maps(self, view: FloatArray) -> Iterator[Float32Array]:
        """Yield the map of each part, without the residual; see `shrm.lobes.reflection.Reflection`."""
        for part in self.parts:
            pixels = np.empty(part.shape, dtype=np.float32)
            self._sum_for_view(part, view, pixels)
            yield pixels

    def maps_at_view(self, view: npt.ArrayLike) -> dict[str, Float32Array]:
        """Return the dynamic reflection maps of a distant viewer [RH02 eq. 12], one for each center.

        See `shrm.lobes.reflection.Reflection.maps_at_view`.
        """
        maps = super().maps_at_view(view)
        if self.residual is not None:
            for name, pixels in self.residual.maps_at_view(view).items():
                maps[name] += pixels
        return maps

    def at_view(self, view: npt.ArrayLike, out: Float32Array | None = None) -> Float32Array:
        """Return the dynamic reflection map of a distant viewer [RH02 eq. 12], of a material with one center.

        An ordinary reflection map: look it up at the central direction C of each point.

        Parameters
        ----------
        view : (3,) array_like
            Unit vector towards the eye.
        out : float32 array, optional
            Takes the map of a material of one lobe, of the shape returned, in C order.

        Returns
        -------
        (H, W, 3) float32, or (6, N, N, 3) for cubes

        Raises
        ------
        ValueError, TypeError
            If view is not a unit vector, or the material has several centers: see `maps_at_view`; if out has
            another shape, type or order, or the material more than one lobe.
        """
        if out is None:
            return super().at_view(view)
        V = unit_vectors("view", view, 1)
        if len(self.parts) > 1:
            raise ValueError(f"out is for materials of one lobe, and {self.brdf} has {len(self.parts)}")
        part = self.parts[0]
        require_array("out", out, part.shape, np.float32, writeable=True)
        self._sum_for_view(part, V, out)
        if self.residual is not None:
            for pixels in self.residual.maps_at_view(view).values():
                out += pixels
        return out

    def _sum_for_view(self, part: Part, view: FloatArray, pixels: Float32Array) -> None:
        part.sum_for_view(view, pixels)
        if self.clamp:
            np.maximum(pixels, 0, out=pixels)

    def save(self, path: str | Path) -> None:
        """Write an OpenEXR file with the maps, the coefficients and every convention in its metadata.

        See `shrm.frequency.file` for what it holds.

        Raises
        ------
        shrm.ImageError
            If the file cannot be written.
        """
        from shrm.frequency.file import save

        save(self, path)

    @classmethod
    def load(cls, path: str | Path) -> ReflectionMap:
        """Read what `save` wrote.

        Raises
        ------
        shrm.ImageError
            If the file cannot be read, or is no reflection map.
        """
        from shrm.frequency.file import load

        return load(path)

    def __getstate__(self) -> dict[str, object]:
        """Return what is pickled: the error itself in place of how it is predicted."""
        return {**self.__dict__, "predict": partial(float, self.error)}

    def __repr__(self) -> str:
        return f"<ReflectionMap {self.brdf}: F={self.F} P={self.P} {self.layout} {self.parts[0].size}>"


def require_no_residual(rm: ReflectionMap, what: str) -> None:
    """Raise ValueError if a map has a residual, which `what` would lose."""
    if rm.residual is not None:
        raise ValueError(
            f"{rm.brdf} has a residual, which {what} cannot hold: prefilter without residual='auto'"
        )


def zonal_harmonics(P: int, cosine: FloatArray) -> FloatArray:
    """Y_p0 at angles whose cosines are given, for all p <= P: one more axis, the last."""
    p = np.arange(P + 1)
    legendre = np.polynomial.legendre.legvander(np.clip(cosine, -1, 1), P)
    return np.asarray(legendre * np.sqrt((2 * p + 1) / (4 * np.pi)), np.float64)


def require_maps(maps: int, zonal: bool) -> int:
    """Return P of a number of maps, or raise ValueError."""
    P = maps - 1 if zonal else round(float(np.sqrt(maps))) - 1
    if P < 0 or (not zonal and basis_size(P) != maps):
        raise ValueError(f"a reflection map has (P+1)^2 maps, got {maps}")
    return P
