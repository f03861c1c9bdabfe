"""The prefiltered maps of a material: one for each of its lobes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.brdf import BRDF, Material
from shrm.brdf.lobe import refuse_anisotropic
from shrm.environment import Environment
from shrm.icosahedral import icosahedron
from shrm.kautz_mccool import factored, factored_phong
from shrm.prefiltered import file
from shrm.prefiltered.layers import Y00, Integrator, Layers
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
from shrm.reflection_map import Interpolation, Part, ReflectionMap, zonal_harmonics
from shrm.rings import Float32Array, Layout
from shrm.validation import one_of

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


def twelve_views(rm: ReflectionMap) -> Prefiltered:
    """Return the maps that a SHRM has for Cabral's twelve views: between them it is not asked.

    Parameters
    ----------
    rm : ReflectionMap
        Of any material; each of its lobes gets twelve maps of its own, about its centre and on its grid,
        which is a cube for maps that the GPU is to draw.

    Raises
    ------
    TypeError
        If it is no reflection map.
    """
    if not isinstance(rm, ReflectionMap):
        raise TypeError(f"rm must be a ReflectionMap, got {type(rm).__name__}")
    return Prefiltered(tuple(Cabral(_at_vertices(part, rm.clamp), rm.brdf) for part in rm.parts))


def _at_vertices(part: Part, clamp: bool) -> tuple[Part, ...]:
    """The maps of one lobe for each vertex, borders included [RH02 eq. 12]."""
    views = icosahedron()
    rings = np.asarray(part.rings, np.float32)
    if part.zonal:  # the angle between C and V is another one at every texel
        C = part.ring_directions()
        of_views = [
            np.einsum("hwp,hpcw->hcw", zonal_harmonics(part.P, C @ view), rings, optimize=True)
            for view in views
        ]
    else:
        Y = sh.evaluate(np.eye((part.P + 1) ** 2), views)
        of_views = list(np.tensordot(Y.astype(np.float32), rings, axes=(1, 1)))
    if clamp:
        of_views = [np.maximum(of_view, 0.0) for of_view in of_views]
    return tuple(
        replace(
            part,
            zonal=False,
            light=np.zeros((0, 3)),
            rho=np.zeros((0, 1, 1, 3)),
            rings=np.ascontiguousarray(of_view[:, None] / np.float32(Y00), np.float32),
        )
        for of_view in of_views
    )
