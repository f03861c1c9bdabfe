"""The spherical harmonic reflection map (SHRM) [RH02 section 4]: a part for each lobe of a material."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center
from shrm.files import PathLike
from shrm.frequency import file
from shrm.frequency.part import CoefficientMaps, Part
from shrm.frequency.prediction import Prediction
from shrm.frequency.rings import Interpolation
from shrm.integrate.residual import Residual
from shrm.lobes.reflection import Layout, Reflection
from shrm.validation import one_of, require_array, unit_vectors


@dataclass(frozen=True, eq=False)
class ReflectionMap(Reflection):
    """A prefiltered environment: the result of `shrm.prefilter`.

    Attributes
    ----------
    parts : tuple of CoefficientMaps
        One for each lobe of the material; all that prefiltering returns are a `Part`.
    brdf : str
        The material's name.
    criterion : str
        The measure of `error`.
    window : str or None
        The window on the degrees.
    clamp : bool
        True if negative radiance is set to zero when read, lobe by lobe.
    prediction : float or Prediction
        The error, or what predicts it when it is first asked for: that takes longer than the maps.
    residual : Residual or None
        The cores of sharp lobes, which the orders cannot hold: `radiance` and `maps_at_view` add them.
        `Residual.radiance` and `Residual.maps_at_view` return them alone.
    """

    parts: tuple[CoefficientMaps, ...]
    brdf: str
    criterion: str
    window: str | None
    clamp: bool
    prediction: float | Prediction
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

    @property
    def error(self) -> float:
        """The predicted error, in the criterion's measure.

        For `light`: the relative RMS of the reflected radiance over all frames (N, V), of truncation and
        interpolation together. For the others: the fraction of energy that truncation leaves out. For maps
        fitted to pictures: the relative RMS of the fit.
        """
        return self.prediction.error if isinstance(self.prediction, Prediction) else self.prediction

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
        # Directions; normals stand in for tangents that no lobe needs.
        one_of("interpolation", interpolation, ("cubic", "bilinear"))
        N = unit_vectors("normals", normals)
        V = unit_vectors("views", views, 1 if np.ndim(views) == 1 else len(N))
        T = N
        if any(part.center == "tangent" for part in self.parts):
            if tangents is None:
                raise ValueError(f"{self.brdf} has a lobe about the tangent: radiance needs tangents")
            T = unit_vectors("tangents", tangents, len(N))

        # The sum over the lobes, each set to zero where it is negative if it is to be, and the residual
        radiance = np.zeros(N.shape, dtype=np.float32)
        for part in self.parts:
            of_lobe = np.zeros_like(radiance) if self.clamp else radiance
            _core.add_radiance(
                rings=part.rings,
                cube=part.layout == "cube",
                zonal=part.zonal,
                center=part.center,
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

    def _sum_for_view(self, part: CoefficientMaps, view: FloatArray, pixels: Float32Array) -> None:
        """Sum the maps of a part for a view (1, 3) into pixels, set to zero where negative if it is to be."""
        part.sum_for_view(view, pixels)
        if self.clamp:
            np.maximum(pixels, 0, out=pixels)

    def save(self, path: PathLike) -> None:
        """Write an OpenEXR file with the maps, the coefficients and every convention in its metadata.

        See `shrm.frequency.file` for what it holds.

        Raises
        ------
        shrm.ImageError
            If the file cannot be written.
        """
        saved = file.SavedMap(
            self.parts, self.brdf, self.criterion, self.window, self.clamp, self.error, self.residual
        )
        file.write(path, saved)

    @classmethod
    def load(cls, path: PathLike) -> ReflectionMap:
        """Read what `save` wrote.

        Raises
        ------
        shrm.ImageError
            If the file cannot be read, or is no reflection map.
        """
        saved = file.read(path)
        return cls(
            saved.parts, saved.brdf, saved.criterion, saved.window, saved.clamp, saved.error, saved.residual
        )

    def expanded_parts(self) -> tuple[Part, ...]:
        """Return the parts, all of which have coefficients.

        Raises
        ------
        ValueError
            If the maps were fitted to pictures, and have none.
        """
        parts = tuple(part for part in self.parts if isinstance(part, Part))
        if len(parts) < len(self.parts):
            raise ValueError(f"{self.brdf} was fitted to pictures, and has no coefficients")
        return parts

    def __repr__(self) -> str:
        return f"<ReflectionMap {self.brdf}: F={self.F} P={self.P} {self.layout} {self.parts[0].size}>"


def require_no_residual(rm: ReflectionMap, recipient: str) -> None:
    """Raise ValueError if a map has a residual, which the recipient of its maps would lose."""
    if rm.residual is not None:
        raise ValueError(
            f"{rm.brdf} has a residual, which {recipient} cannot hold: prefilter without residual='auto'"
        )
