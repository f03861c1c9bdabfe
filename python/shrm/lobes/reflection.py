"""The result of every way of prefiltering: reflected radiance, point by point or as maps for a view.

A reflection map for a view is indexed by a central direction C. Lobes about the reflection share one C for
each normal, as do those about the normal and those about the tangent: their maps are summed. A lobe center is
its lobe's own, so each such lobe has a map to itself.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Literal, cast, get_args

import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center
from shrm.files import PathLike
from shrm.validation import one_of, unit_vectors

Layout = Literal["latlong", "cube"]
"""Grids of central directions."""


def map_layout(layout: str) -> Layout:
    """Return the layout of maps that a name asks for: "strip", the picture of a cube's faces, is "cube"."""
    return cast(Layout, one_of("layout", "cube" if layout == "strip" else layout, get_args(Layout)))


class Reflection(ABC):
    """The reflected radiance of one light under one material."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Rows of a lat-long map, or of a cube's face."""

    @property
    @abstractmethod
    def layout(self) -> Layout:
        """The grid of the maps: "latlong" or "cube"."""

    @property
    @abstractmethod
    def error(self) -> float:
        """The predicted error: relative RMS of the reflected radiance, unless the class says otherwise."""

    @property
    @abstractmethod
    def centers(self) -> tuple[Center, ...]:
        """The center of each lobe: "lobe", "reflection", "normal" or "tangent"."""

    @abstractmethod
    def radiance(
        self, normals: npt.ArrayLike, views: npt.ArrayLike, tangents: npt.ArrayLike | None = None
    ) -> Float32Array:
        """Return the radiance reflected towards the eye.

        Parameters
        ----------
        normals : (n, 3) array_like
            Unit vectors, world frame.
        views : (n, 3) or (3,) array_like
            Unit vectors from the surface to the eye; one for all points if the viewer is distant.
        tangents : (n, 3) array_like, optional
            Unit vectors, needed for lobes about the tangent.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described, or tangents are missing.
        """

    @abstractmethod
    def lobe_maps(self, view: FloatArray) -> Iterable[Float32Array]:
        """Return the map of each lobe for a view, in the order of `centers`; nothing is checked.

        Parameters
        ----------
        view : (1, 3) float64
            Unit vector to the eye.

        Returns
        -------
        iterable of (size, 2 size, 3) or (6, size, size, 3) float32
            Arrays that the caller may write to.
        """

    @abstractmethod
    def save(self, path: PathLike) -> None:
        """Write a file that `shrm.load`, and `load` of the class, read: all that is needed, but no code.

        Parameters
        ----------
        path : path
            An OpenEXR file, `.exr`; it appears whole or not at all.

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """

    def maps_at_view(self, view: npt.ArrayLike) -> dict[str, Float32Array]:
        """Return the reflection maps for a distant viewer, one for each center.

        Ordinary reflection maps: look each up at its central direction, and sum.

        Parameters
        ----------
        view : (3,) array_like
            Unit vector to the eye.

        Returns
        -------
        {name: (size, 2 size, 3) or (6, size, size, 3) float32}
            Radiance over the central direction. Names are centers; lobes about the same center are summed,
            but each lobe center is one of its own: "lobe", "lobe 2", ... in the order of the lobes.
            Directions of a lobe center that no visible normal has show the normal at the silhouette.

        Raises
        ------
        TypeError, ValueError
            If `view` is not a unit vector.
        """
        return sum_by_name(map_names(self.centers), self.lobe_maps(unit_vectors("view", view, 1)))

    def at_view(self, view: npt.ArrayLike) -> Float32Array:
        """Return the reflection map for a distant viewer, of a material with one center.

        Parameters
        ----------
        view : (3,) array_like
            Unit vector to the eye.

        Returns
        -------
        (size, 2 size, 3) or (6, size, size, 3) float32
            Radiance over the central direction.

        Raises
        ------
        TypeError, ValueError
            If `view` is not a unit vector, or the material has several centers: see `maps_at_view`.
        """
        names = list(dict.fromkeys(map_names(self.centers)))
        if len(names) > 1:
            raise ValueError(
                f"the material of at_view must have one center, got {', '.join(names)}: "
                "maps_at_view returns a map for each"
            )
        return self.maps_at_view(view)[names[0]]


def map_names(centers: Sequence[Center]) -> list[str]:
    """Return the names of the maps of lobes: their centers, but each lobe center is one of its own."""
    names: list[str] = []
    for k, center in enumerate(centers):
        before = centers[:k].count("lobe")
        names.append(f"lobe {before + 1}" if center == "lobe" and before else center)
    return names


def sum_by_name(names: Iterable[str], maps: Iterable[Float32Array]) -> dict[str, Float32Array]:
    """Return the sums of the maps that have the same name, in the order in which names come first."""
    sums: dict[str, Float32Array] = {}
    for name, pixels in zip(names, maps, strict=True):
        sums[name] = sums[name] + pixels if name in sums else pixels
    return sums
