"""The prefiltered maps of a material: one for each of its lobes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.arrays import Float32Array, RealArray
from shrm.brdf import BRDF, Material
from shrm.brdf.lobe import Lobe, ZonalLobe, refuse_anisotropic
from shrm.environment import Environment
from shrm.frequency.analysis import analyse
from shrm.frequency.part import Part, zonal_harmonics
from shrm.frequency.reflection_map import ReflectionMap, require_no_residual
from shrm.frequency.rings import Interpolation
from shrm.lobes.center import gamma_table
from shrm.lobes.factored import MOST_LOBES, factored, factored_phong, symmetric
from shrm.lobes.reflection import Layout
from shrm.prefiltered import file
from shrm.prefiltered.icosahedron import icosahedron
from shrm.prefiltered.layers import MOST_SLICES, Integrator, Layer, Layers, largest_angle, require_material
from shrm.prefiltered.maps import (
    SLICES,
    Anisotropic,
    Cabral,
    Diffuse,
    KautzMcCool2D,
    KautzMcCool3D,
    Phong,
    PrefilteredMap,
)
from shrm.validation import one_of, whole_number

Technique = Literal["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"]


def prefilter(
    env: Environment,
    brdf: BRDF,
    technique: Technique = "kautz-mccool-3d",
    *,
    lobes: int = 1,
    slices: int = SLICES,
    integrator: Integrator = "hierarchical",
    error: float = 0.01,
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
    integrator, error, size, layout
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
    how = Layers.checked(env, brdf, integrator, error, size, layout)
    maps: list[PrefilteredMap] = []
    for lobe in brdf.lobes:
        refuse_anisotropic(lobe)
        one = Material((lobe,), brdf.name)
        if lobe.kind == "radial":
            maps.append((Diffuse if lobe.center == "normal" else Phong)._made(one, how))
        elif lobe.center == "tangent":
            maps.append(Anisotropic._made(one, how, slices))
        elif technique == "cabral" and lobe.kind == "isotropic":
            maps.append(Cabral._made(one, how))
        elif technique in ("kautz-mccool-2d", "miller-heidrich"):
            fit = factored_phong(lobe) if technique == "miller-heidrich" else factored(lobe, lobes)
            maps.append(KautzMcCool2D._of(fit, one, how))
        else:
            maps.append(KautzMcCool3D._made(one, how, slices))
    return Prefiltered(tuple(maps))


@dataclass(frozen=True, eq=False)
class Prefiltered:
    """The maps of a material of several lobes.

    Attributes
    ----------
    lobes : tuple of PrefilteredMap
        One for each, whose sum is reflected.
    """

    lobes: tuple[PrefilteredMap, ...]

    @property
    def nbytes(self) -> int:
        """Bytes of the maps."""
        return sum(one.nbytes for one in self.lobes)

    def radiance(
        self,
        normals: npt.ArrayLike,
        views: npt.ArrayLike,
        tangents: npt.ArrayLike | None = None,
        *,
        interpolation: Interpolation = "cubic",
    ) -> Float32Array:
        """Return the radiance reflected towards the eye, (n, 3) float32; see `PrefilteredMap.radiance`."""
        parts = [one.radiance(normals, views, tangents, interpolation=interpolation) for one in self.lobes]
        return np.asarray(sum(parts[1:], start=parts[0]))

    def save(self, path: str | Path) -> None:
        """Write a file (`shrm.prefiltered.file` says what is in it).

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """
        file.save(self.lobes, path)

    @classmethod
    def load(cls, path: str | Path) -> Prefiltered:
        """Read what `save` of this class or of one of the maps wrote.

        Raises
        ------
        shrm.ImageError
            If it cannot be read, or is no such file.
        """
        return cls(file.load(path))


def of_reflection_map(
    rm: ReflectionMap, brdf: BRDF, technique: Technique, lobes: int = 1, slices: int = SLICES
) -> Prefiltered:
    """Return the maps that a SHRM's light has for a technique, on its grid: fast enough to follow changes.

    Parameters
    ----------
    rm : ReflectionMap
        Cube maps, for maps that the GPU is to draw. Cabral's twelve maps are its own, for the twelve views.
    brdf : BRDF
        The material that it was prefiltered with.
    technique, lobes, slices
        As in `prefilter`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described, or the SHRM was fitted to pictures or has a residual.
    """
    if not isinstance(rm, ReflectionMap):
        raise TypeError(f"rm must be a ReflectionMap, got {type(rm).__name__}")
    require_no_residual(rm, "an earlier technique")
    require_material(brdf)
    one_of("technique", technique, get_args(Technique))
    _require_counts(lobes, slices)
    if brdf.name != rm.brdf or len(brdf.lobes) != len(rm.parts):
        raise ValueError(f"rm must have been prefiltered with {brdf.name}, got one of {rm.brdf}")
    maps: list[PrefilteredMap] = []
    for lobe, part in zip(brdf.lobes, rm.expanded_parts(), strict=True):
        if technique == "cabral" and lobe.kind == "isotropic":
            maps.append(Cabral(_at_vertices(part, rm.clamp), rm.brdf))
        elif lobe.kind == "radial":
            cls = Diffuse if part.center == "normal" else Phong
            maps.append(cls((_constant_layer(part),), rm.brdf))
        elif technique in ("kautz-mccool-3d", "cabral") or lobe.center == "tangent":
            found = symmetric(lobe)
            sliced = Anisotropic if found.center == "tangent" else KautzMcCool3D
            maps.append(sliced(_slices(part, found, rm.P, slices), rm.brdf))
        else:
            fit = factored_phong(lobe) if technique == "miller-heidrich" else factored(lobe, lobes)
            layers = tuple(_constant_layer(_expanded(part, one.lobe, 0)) for one in fit)
            maps.append(KautzMcCool2D(layers, rm.brdf, np.stack([one.factor for one in fit])))
    return Prefiltered(tuple(maps))


def _require_counts(lobes: int, slices: int) -> None:
    """Checked whatever the technique has use for."""
    whole_number("lobes", lobes, 1, MOST_LOBES)
    whole_number("slices", slices, 2, MOST_SLICES)


def _expanded(part: Part, lobe: Lobe, P: int) -> Part:
    """Zonal maps of another lobe for the light of a part, on its grid."""
    of_lobe = analyse(lobe, part.F, P).coefficients(part.F, P)
    rho = np.ascontiguousarray(np.broadcast_to(of_lobe, (*of_lobe.shape[:3], 3)))
    gamma = gamma_table(lobe.center)
    zonal = replace(part, center=lobe.center, gamma=gamma, zonal=True, rho=rho)
    return zonal.resized(part.size, part.layout)


def _slices(part: Part, lobe: ZonalLobe, P: int, slices: int) -> tuple[Layer, ...]:
    """Layers of a zonal lobe: its maps at angles between C and V [RH02 eq. 6]."""
    zonal = _expanded(part, lobe, P)
    angles = np.linspace(0.0, largest_angle(lobe.center), slices)
    shares = zonal_harmonics(P, np.cos(angles))
    return tuple(
        _layer(zonal, np.einsum("p,hpcw->hcw", share.astype(np.float32), zonal.rings)[:, None])
        for share in shares
    )


def _constant_layer(part: Part) -> Layer:
    """The layer of a lobe of P = 0, whose radiance is B_00 Y_00 for all views."""
    return _layer(part, np.asarray(part.rings, np.float32) * np.float32(1.0 / np.sqrt(4.0 * np.pi)))


def _layer(part: Part, radiance: RealArray) -> Layer:
    """The layer of the grid of a part that holds radiance, (H, 1, 3, W)."""
    return Layer(part.center, part.gamma, part.layout, np.ascontiguousarray(radiance, np.float32))


def _at_vertices(part: Part, clamp: bool) -> tuple[Layer, ...]:
    """The maps of one lobe for each vertex, borders included [RH02 eq. 12]."""
    Y = sh.evaluate(np.eye((part.P + 1) ** 2), icosahedron())
    rings = np.asarray(part.rings, np.float32)
    of_views = list(np.tensordot(Y.astype(np.float32), rings, axes=(1, 1)))
    if clamp:
        of_views = [np.maximum(of_view, 0.0) for of_view in of_views]
    return tuple(_layer(part, of_view[:, None]) for of_view in of_views)
