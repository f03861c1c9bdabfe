"""The classes of prefiltered maps, each with what it keeps of L(v, n, t) [KVHS00 section 4].

References
----------
[KVHS00] J. Kautz, P.-P. Vazquez, W. Heidrich, H.-P. Seidel. A Unified Approach to Prefiltered Environment
    Maps. Eurographics Workshop on Rendering 2000.
[KM00] J. Kautz, M. McCool. Approximation of Glossy Reflection with Prefiltered Environment Maps. Graphics
    Interface 2000.
[CON99] B. Cabral, M. Olano, P. Nemec. Reflection Space Image Based Rendering. SIGGRAPH 1999.
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, get_args

import numpy as np
import numpy.typing as npt

from shrm.brdf import BRDF, Material
from shrm.brdf.lobe import Center, refuse_anisotropic
from shrm.central_direction import gamma_at, gamma_table
from shrm.environment import Environment
from shrm.explicit import fit
from shrm.icosahedral import icosahedron, weights
from shrm.kautz_mccool import FactoredLobe, factored, symmetric
from shrm.lobe_integrals import across, central_directions, normals_of
from shrm.prefiltered.layers import (
    Y00,
    FloatArray,
    Layers,
    largest_angle,
    radial_layers,
    require_material,
    sliced_layers,
)
from shrm.reflection_map import Interpolation, Part
from shrm.rings import Float32Array, Layout
from shrm.validation import one_of, real_array, unit_vectors

SLICES = 33
"""Layers of a map of three dimensions."""


@dataclass(frozen=True, eq=False)
class PrefilteredMap(ABC):
    """A prefiltered map of one lobe.

    Attributes
    ----------
    keeps : str
        Of v, n and t, what it depends on.
    assumes : str
        When that is all there is.
    layers : tuple of Part
        Reflection maps over C, P = 0.
    brdf : str
        The material's name.
    """

    layers: tuple[Part, ...]
    brdf: str

    keeps: ClassVar[str]
    assumes: ClassVar[str]

    @property
    def center(self) -> Center:
        """The direction C that layers are looked up at."""
        return self.layers[0].center

    @property
    def layout(self) -> Layout:
        """The grid of the layers."""
        return self.layers[0].layout

    @property
    def size(self) -> int:
        """Rows of a lat-long map, or of a cube's face."""
        return self.layers[0].size

    @property
    def maps(self) -> Float32Array:
        """Radiance of the layers: (K, H, W, 3), or (K, 6, N, N, 3)."""
        return np.concatenate([layer.maps for layer in self.layers]) * np.float32(Y00)

    @property
    def nbytes(self) -> int:
        """Bytes of the maps."""
        return sum(layer.rings.nbytes for layer in self.layers)

    @abstractmethod
    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """Return the layers' shares for angles between C and V, (n,), and views, (n, 3): (n, K or K, 3)."""

    def radiance(
        self,
        normals: npt.ArrayLike,
        views: npt.ArrayLike,
        tangents: npt.ArrayLike | None = None,
        *,
        interpolation: Interpolation = "cubic",
    ) -> Float32Array:
        """Return the radiance reflected towards the eye.

        Parameters
        ----------
        normals : (n, 3) array_like
            Unit vectors, world frame.
        views : (n, 3) or (3,) array_like
            Unit vectors from the surface to the eye.
        tangents : (n, 3) array_like, optional
            Unit vectors, needed about the tangent.
        interpolation : {"cubic", "bilinear"}
            Between the layers' texels.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described, or tangents are missing.
        """
        one_of("interpolation", interpolation, get_args(Interpolation))
        N = unit_vectors("normals", normals)
        V = np.broadcast_to(unit_vectors("views", views, 1 if np.ndim(views) == 1 else len(N)), N.shape)
        T = N
        if self.center == "tangent":
            if tangents is None:
                raise ValueError(f"{self.brdf} has a lobe about the tangent: radiance needs tangents")
            T = unit_vectors("tangents", tangents, len(N))
        C = np.ascontiguousarray(self._central(N, V, T))
        shares = self.shares(across(C, V)[1], V)
        result = np.zeros(N.shape, np.float32)
        for k, layer in enumerate(self.layers):
            share = shares[:, k].reshape(len(N), -1)
            near = np.flatnonzero(share.any(axis=1))
            if len(near):
                result[near] += share[near] * layer.looked_up(C[near], C[near], interpolation)
        return result

    def _central(self, N: FloatArray, V: FloatArray, T: FloatArray) -> FloatArray:
        return central_directions(self.center, N, V, T)

    def save(self, path: str | Path) -> None:
        """Write a file; `Prefiltered.load` reads it.

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """
        from shrm.prefiltered.file import save  # a map's save is the file's

        save((self,), path)


class Diffuse(PrefilteredMap):
    """Miller's: what a matt surface reflects [KVHS00 section 4]."""

    keeps = "(n)"
    assumes = "a diffuse surface"

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        return np.ones((len(views), 1))

    @classmethod
    def prefilter(cls, env: Environment, brdf: BRDF, **options: Any) -> Diffuse:
        """Prefilter; `options` are integrator, error, size and layout, as `prefilter` has them.

        Raises
        ------
        TypeError, ValueError
            As `prefilter`, or if the material is not one radial lobe about the normal.
        """
        return cls._made(_one(brdf, cls, ("radial",), "normal"), Layers.checked(env, brdf, **options))

    @classmethod
    def _made(cls, one: Material, how: Layers) -> Diffuse:
        return cls(radial_layers([one], how), one.name)


class Phong(PrefilteredMap):
    """Miller's and Heidrich's: a lobe of one shape about the reflection [KVHS00 section 4]."""

    keeps = "(r_v)"
    assumes = "a lobe of one shape, symmetric about the reflection"

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        return np.ones((len(views), 1))

    @classmethod
    def prefilter(cls, env: Environment, brdf: BRDF, **options: Any) -> Phong:
        """Prefilter; `options` are integrator, error, size and layout, as `prefilter` has them.

        Raises
        ------
        TypeError, ValueError
            As `prefilter`, or if the material is not one radial lobe about the reflection.
        """
        return cls._made(_one(brdf, cls, ("radial",), "reflection"), Layers.checked(env, brdf, **options))

    @classmethod
    def _made(cls, one: Material, how: Layers) -> Phong:
        return cls(radial_layers([one], how), one.name)


class _Slices(PrefilteredMap):
    """Layers at equal steps of theta_o, linear between them."""

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        K = len(self.layers)
        place = np.clip(theta_o / largest_angle(self.center) * (K - 1), 0.0, K - 1)
        return np.maximum(1.0 - np.abs(place[:, None] - np.arange(K)), 0.0)


class KautzMcCool3D(_Slices):
    """Kautz and McCool's of three dimensions: a lobe symmetric about the reflection for every view [KM00]."""

    keeps = "(r_v, n.r_v)"
    assumes = "a lobe symmetric about the reflection; other isotropic lobes lose their azimuth about it"

    @classmethod
    def prefilter(
        cls, env: Environment, brdf: BRDF, *, slices: int = SLICES, **options: Any
    ) -> KautzMcCool3D:
        """Prefilter.

        Parameters
        ----------
        env : Environment
        brdf : BRDF
            Of one lobe, isotropic or zonal but not about the tangent.
        slices : int
            Layers, 2 to 1024, at equal steps of theta_o.
        **options
            integrator, error, size and layout, as `prefilter` has them.

        Raises
        ------
        TypeError, ValueError
            As `prefilter`, or if the material is not one such lobe.
        """
        how = Layers.checked(env, brdf, **options)
        return cls._made(_one(brdf, cls, ("isotropic", "zonal"), "reflection", "normal"), how, slices)

    @classmethod
    def _made(cls, one: Material, how: Layers, slices: int) -> KautzMcCool3D:
        return cls(sliced_layers(symmetric(one.lobes[0]), one.name, how, slices), one.name)


class Anisotropic(_Slices):
    """Of lobes about the tangent that depend on two angles, such as Banks' [KVHS00 section 5.3]."""

    keeps = "(t, v.t)"
    assumes = "no self-shadowing: light from below the surface is reflected too"

    @classmethod
    def prefilter(cls, env: Environment, brdf: BRDF, *, slices: int = SLICES, **options: Any) -> Anisotropic:
        """Prefilter; see `KautzMcCool3D.prefilter`, for a material of one lobe about the tangent."""
        how = Layers.checked(env, brdf, **options)
        return cls._made(_one(brdf, cls, ("zonal",), "tangent"), how, slices)

    @classmethod
    def _made(cls, one: Material, how: Layers, slices: int) -> Anisotropic:
        return cls(sliced_layers(symmetric(one.lobes[0]), one.name, how, slices), one.name)


@dataclass(frozen=True, eq=False)
class KautzMcCool2D(PrefilteredMap):
    """Kautz and McCool's of two dimensions: lobes of one shape, times factors of the view [KM00].

    Attributes
    ----------
    factors : (K, VIEWS, 1 or 3) float64
        Of each layer, uniform in theta_v over [0, pi/2].
    """

    factors: FloatArray = field(default_factory=lambda: np.ones((1, 2, 1)))

    keeps = "(r_v), F(n.r_v)"
    assumes = "a lobe symmetric about the reflection that keeps its shape"

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        last = self.factors.shape[1] - 1
        place = np.clip(theta_o / largest_angle(self.center), 0.0, 1.0) * last
        low = np.minimum(place.astype(int), last - 1)
        t = (place - low)[:, None]
        mixed = (1 - t) * self.factors[:, low] + t * self.factors[:, low + 1]  # (K, n, channels)
        return np.asarray(np.broadcast_to(mixed.transpose(1, 0, 2), (len(place), len(mixed), 3)))

    @classmethod
    def prefilter(cls, env: Environment, brdf: BRDF, *, lobes: int = 1, **options: Any) -> KautzMcCool2D:
        """Prefilter.

        Parameters
        ----------
        env : Environment
        brdf : BRDF
            Of one lobe, isotropic or zonal but not about the tangent.
        lobes : int
            How many products of a shape and a factor are summed, 1 to 8.
        **options
            integrator, error, size and layout, as `prefilter` has them.

        Raises
        ------
        TypeError, ValueError
            As `prefilter`, or if the material is not one such lobe.
        """
        how = Layers.checked(env, brdf, **options)
        one = _one(brdf, cls, ("isotropic", "zonal"), "reflection", "normal")
        return cls._of(factored(one.lobes[0], lobes), one, how)

    @classmethod
    def _of(cls, fit: Sequence[FactoredLobe], one: Material, how: Layers) -> KautzMcCool2D:
        layers = radial_layers([Material((part.lobe,), one.name) for part in fit], how)
        return cls(layers, one.name, np.stack([part.factor for part in fit]))


class Cabral(PrefilteredMap):
    """Cabral's of four dimensions: maps for twelve views, blended for others [CON99].

    [CON99] has maps over normals, warped along R to the new view; maps over R need no warp
    [RH02 section 3.1]. All of a lobe is kept at the twelve views.
    """

    keeps = "(v, n), v at twelve places"
    assumes = "a distant viewer; highlights that move little between the views of an icosahedron"

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        return weights(views)

    def _central(self, N: FloatArray, V: FloatArray, T: FloatArray) -> FloatArray:
        if self.center != "lobe":
            return super()._central(N, V, T)
        x, theta_v = across(N, V)
        gamma = gamma_at(self.layers[0].gamma, theta_v)[:, None]
        return np.asarray(np.cos(gamma) * N - np.sin(gamma) * x)

    @classmethod
    def prefilter(cls, env: Environment, brdf: BRDF, **options: Any) -> Cabral:
        """Prefilter; `options` are integrator, error, size and layout, as `prefilter` has them.

        Raises
        ------
        TypeError, ValueError
            As `prefilter`, or if the material is not one isotropic lobe.
        """
        return cls._made(_one(brdf, cls, ("isotropic",)), Layers.checked(env, brdf, **options))

    @classmethod
    def fitted(
        cls, maps: npt.ArrayLike, center: Center = "reflection", name: str = "twelve pictures"
    ) -> Cabral:
        """Return them from pictures.

        Parameters
        ----------
        maps : (12, H, 2 H, 3) array_like
            Lat-long maps over the central direction, H even, in the order of `shrm.icosahedral.icosahedron`.
        center : {"reflection", "normal", "tangent"}
            The central direction by which they are looked up.
        name : str
            What the material is called.

        Raises
        ------
        TypeError, ValueError
            If the maps have another shape.
        """
        pixels, views = real_array("maps", maps), icosahedron()
        if pixels.ndim != 4 or len(pixels) != len(views):
            raise ValueError(f"maps must have the shape (12, H, 2 H, 3), got {pixels.shape}")
        one = [slice(k, k + 1) for k in range(len(views))]
        return cls(tuple(fit(pixels[k], views[k], P=0, center=center).parts[0] for k in one), name)

    @classmethod
    def _made(cls, one: Material, how: Layers) -> Cabral:
        lobe = one.lobes[0]
        gamma = gamma_table(lobe.center, lobe.transfer)
        reflection = how.integrated(one)

        def at(view: FloatArray) -> Callable[[FloatArray], Float32Array]:
            def radiance(C: FloatArray) -> Float32Array:
                V = np.ascontiguousarray(np.broadcast_to(view, C.shape))
                return reflection.radiance(normals_of(lobe.center, lobe.transfer, C, V), V)

            return radiance

        return cls(tuple(how.layer(lobe.center, at(view), gamma) for view in icosahedron()), one.name)


def _one(brdf: BRDF, cls: type, kinds: tuple[str, ...], *centers: Center) -> Material:
    """A material of one lobe of given kinds; other than isotropic ones about given centres."""
    require_material(brdf)
    if len(brdf.lobes) != 1:
        raise ValueError(
            f"{cls.__name__} holds one lobe, and {brdf.name} has {len(brdf.lobes)}: use prefiltered.prefilter"
        )
    (lobe,) = brdf.lobes
    refuse_anisotropic(lobe)
    if lobe.kind not in kinds or not (lobe.kind == "isotropic" or lobe.center in centers):
        about = f" about the {' or the '.join(centers)}" if centers else ""
        raise ValueError(
            f"{cls.__name__} holds a lobe that is {' or '.join(kinds)}{about}, and that of {brdf.name} is"
            f" {lobe.kind}, about the {lobe.center}"
        )
    return Material((lobe,), brdf.name)
