"""The prefiltered maps of a material: one for each of its lobes, by the class that suits it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.arrays import Float32Array, FloatArray, RealArray
from shrm.brdf import BRDF, Material
from shrm.brdf.lobe import Center, Lobe, ZonalLobe, refuse_anisotropic
from shrm.environment import Environment
from shrm.files import PathLike
from shrm.frequency.analysis import analyse
from shrm.frequency.part import Part, zonal_harmonics
from shrm.frequency.reflection_map import ReflectionMap, require_no_residual
from shrm.frequency.rings import Interpolation
from shrm.lobes.center import gamma_table
from shrm.lobes.factored import MOST_LOBES, factored, factored_phong, symmetric
from shrm.lobes.reflection import Layout, Reflection
from shrm.prefiltered import file
from shrm.prefiltered.cabral import Cabral
from shrm.prefiltered.icosahedron import icosahedron
from shrm.prefiltered.layers import (
    MOST_SLICES,
    Integration,
    Layer,
    Method,
    largest_angle,
    require_material,
)
from shrm.prefiltered.one_shape import Diffuse, KautzMcCool2D, Phong, RadialMap
from shrm.prefiltered.prefiltered_map import PrefilteredMap, restored
from shrm.prefiltered.slices import SLICES, Anisotropic, KautzMcCool3D, SlicedMap
from shrm.validation import one_of, require_instance, whole_number

Technique = Literal["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"]

CLASSES: tuple[type[PrefilteredMap], ...] = (
    Diffuse,
    Phong,
    KautzMcCool3D,
    KautzMcCool2D,
    Cabral,
    Anisotropic,
)


@dataclass(frozen=True, eq=False, repr=False)
class Prefiltered(Reflection):
    """The prefiltered maps of a material of several lobes.

    Attributes
    ----------
    lobes : tuple of PrefilteredMap
        One for each lobe, whose sum is reflected.
    """

    lobes: tuple[PrefilteredMap, ...]

    @property
    def brdf(self) -> str:
        """The material's name."""
        return self.lobes[0].brdf

    @property
    def error(self) -> float:
        """The largest `PrefilteredMap.error` of the lobes; nan if one is not known."""
        return float(np.max([lobe.error for lobe in self.lobes]))

    @property
    def centers(self) -> tuple[Center, ...]:
        """The center of each lobe."""
        return tuple(lobe.center for lobe in self.lobes)

    @property
    def layout(self) -> Layout:
        """The grid of the layers: "latlong" or "cube"."""
        return self.lobes[0].layout

    @property
    def size(self) -> int:
        """Rows of a lat-long map, or of a cube's face."""
        return self.lobes[0].size

    @property
    def nbytes(self) -> int:
        """Bytes of the maps."""
        return sum(lobe.nbytes for lobe in self.lobes)

    def radiance(
        self,
        normals: npt.ArrayLike,
        views: npt.ArrayLike,
        tangents: npt.ArrayLike | None = None,
        *,
        interpolation: Interpolation = "cubic",
    ) -> Float32Array:
        """Return the radiance reflected towards the eye, (n, 3) float32; see `PrefilteredMap.radiance`."""
        of_lobes = [
            lobe.radiance(normals, views, tangents, interpolation=interpolation) for lobe in self.lobes
        ]
        return np.asarray(sum(of_lobes[1:], start=of_lobes[0]))

    def lobe_maps(self, view: FloatArray) -> Iterator[Float32Array]:
        """Yield the map of each lobe; see `shrm.lobes.reflection.Reflection`."""
        for lobe in self.lobes:
            yield from lobe.lobe_maps(view)

    def save(self, path: PathLike) -> None:
        """Write a file, in the format of `shrm.prefiltered.file`.

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """
        file.write(path, [lobe.saved() for lobe in self.lobes])

    @classmethod
    def load(cls, path: PathLike) -> Prefiltered:
        """Read what `save` of this class or of one of the maps wrote.

        Raises
        ------
        shrm.ImageError
            If it cannot be read, or is no such file.
        """
        return cls(restored(path, CLASSES))

    @classmethod
    def from_reflection_map(
        cls,
        rm: ReflectionMap,
        brdf: BRDF,
        *,
        technique: Technique = "kautz-mccool-3d",
        lobes: int = 1,
        slices: int = SLICES,
    ) -> Prefiltered:
        """Return the maps that a SHRM's light has for a technique, on its grid: in a fraction of a frame.

        Parameters
        ----------
        rm : ReflectionMap
            Cube maps, for maps that the GPU is to draw. Cabral's twelve maps are its own, for the twelve
            views.
        brdf : BRDF
            The material that it was prefiltered with.
        technique, lobes, slices
            As in `prefilter`.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described, or the SHRM was fitted to pictures or has a residual.
        """
        require_instance("rm", rm, ReflectionMap)
        require_no_residual(rm, "an earlier technique")
        require_material(brdf)
        one_of("technique", technique, get_args(Technique))
        _require_counts(lobes, slices)
        if brdf.name != rm.brdf or len(brdf.lobes) != len(rm.parts):
            raise ValueError(f"rm must have been prefiltered with {brdf.name}, got one of {rm.brdf}")
        pairs = zip(brdf.lobes, rm.expanded_parts(), strict=True)
        return cls(tuple(_from_part(lobe, part, rm, technique, lobes, slices) for lobe, part in pairs))

    def __repr__(self) -> str:
        classes = " + ".join(type(lobe).__name__ for lobe in self.lobes)
        return f"<Prefiltered {self.brdf}: {classes} {self.layout} {self.size}>"


# ---- From an environment


def prefilter(
    env: Environment,
    brdf: BRDF,
    *,
    technique: Technique = "kautz-mccool-3d",
    lobes: int = 1,
    slices: int = SLICES,
    method: Method = "hierarchical",
    tolerance: float = 0.01,
    size: int | None = None,
    layout: Layout = "latlong",
) -> Prefiltered:
    """Prefilter an environment for each lobe of a material, by the class that suits the lobe.

    Lobes of one shape take `Diffuse` or `Phong`, those about the tangent `Anisotropic`, exactly; for others
    the technique says which approximation is made.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material.
    technique : {"kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"}
        For lobes whose shape changes with the view. "miller-heidrich" is "kautz-mccool-2d" with one lobe,
        of Phong's shape.
    lobes, slices : int
        As in `KautzMcCool2D.prefilter`, `KautzMcCool3D.prefilter`.
    method, tolerance, size, layout
        As in `PrefilteredMap.prefilter`.

    Returns
    -------
    Prefiltered

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    one_of("technique", technique, get_args(Technique))
    _require_counts(lobes, slices)
    require_material(brdf)
    integration = Integration.requested(env, method, tolerance, size, layout)

    def lobe_map(lobe: Lobe) -> PrefilteredMap:
        refuse_anisotropic(lobe)
        material = Material((lobe,), brdf.name)
        if technique == "miller-heidrich" and class_for(lobe, technique) is KautzMcCool2D:
            return KautzMcCool2D.of_products(factored_phong(lobe), brdf.name, integration)
        return class_for(lobe, technique).integrated(material, integration, lobes=lobes, slices=slices)

    return Prefiltered(tuple(map(lobe_map, brdf.lobes)))


def class_for(lobe: Lobe, technique: Technique) -> type[PrefilteredMap]:
    """Return the class of map that a technique has for a lobe."""
    if lobe.kind == "radial":
        return Diffuse if lobe.center == "normal" else Phong
    if lobe.center == "tangent":
        return Anisotropic
    if technique == "cabral" and lobe.kind == "isotropic":
        return Cabral
    return KautzMcCool2D if technique in ("kautz-mccool-2d", "miller-heidrich") else KautzMcCool3D


def _require_counts(lobes: int, slices: int) -> None:
    """Check both numbers, whichever the technique uses."""
    whole_number("lobes", lobes, 1, MOST_LOBES)
    whole_number("slices", slices, 2, MOST_SLICES)


# ---- From a reflection map


def _from_part(
    lobe: Lobe, part: Part, rm: ReflectionMap, technique: Technique, lobes: int, slices: int
) -> PrefilteredMap:
    """Return the map of one lobe from its part of a reflection map."""
    cls = class_for(lobe, technique)
    if issubclass(cls, Cabral):
        return cls(_at_vertices(part, rm.clamp), rm.brdf)
    if issubclass(cls, RadialMap):
        return cls((_constant_layer(part),), rm.brdf)
    if issubclass(cls, SlicedMap):
        return cls(_slices(part, symmetric(lobe), rm.P, slices), rm.brdf)
    products = factored_phong(lobe) if technique == "miller-heidrich" else factored(lobe, lobes)
    layers = tuple(_constant_layer(_expanded(part, product.lobe, 0)) for product in products)
    return KautzMcCool2D(layers, rm.brdf, factors=np.stack([product.factor for product in products]))


def _expanded(part: Part, lobe: Lobe, P: int) -> Part:
    """Return zonal maps of another lobe for the light of a part, on its grid."""
    one_color = analyse(lobe, part.F, P).coefficients(part.F, P)
    rho = np.ascontiguousarray(np.broadcast_to(one_color, (*one_color.shape[:3], 3)))
    gamma = gamma_table(lobe.center)
    zonal = replace(part, center=lobe.center, gamma=gamma, zonal=True, rho=rho)
    return zonal.resized(part.size, part.layout)


def _slices(part: Part, lobe: ZonalLobe, P: int, slices: int) -> tuple[Layer, ...]:
    """Return layers of a zonal lobe: its maps at angles between C and V [RH02 eq. 6]."""
    zonal = _expanded(part, lobe, P)
    angles = np.linspace(0.0, largest_angle(lobe.center), slices)
    series = zonal_harmonics(P, np.cos(angles)).astype(np.float32)
    return tuple(
        _layer(zonal, np.einsum("p,hpcw->hcw", harmonics, zonal.rings)[:, None]) for harmonics in series
    )


def _constant_layer(part: Part) -> Layer:
    """Return the layer of a lobe of P = 0, whose radiance is B_00 Y_00 for all views."""
    return _layer(part, np.asarray(part.rings, np.float32) * np.float32(1.0 / np.sqrt(4.0 * np.pi)))


def _layer(part: Part, radiance: RealArray) -> Layer:
    """Return the layer on a part's grid with radiance (H, 1, 3, W)."""
    return Layer(part.center, part.gamma, part.layout, np.ascontiguousarray(radiance, np.float32))


def _at_vertices(part: Part, clamp: bool) -> tuple[Layer, ...]:
    """Return the maps of a lobe for each vertex of the icosahedron, borders included [RH02 eq. 12]."""
    Y = sh.evaluate(np.eye((part.P + 1) ** 2), icosahedron())
    rings = np.asarray(part.rings, np.float32)
    maps = np.tensordot(Y.astype(np.float32), rings, axes=(1, 1))
    if clamp:
        np.maximum(maps, 0.0, out=maps)
    return tuple(_layer(part, pixels[:, None]) for pixels in maps)
