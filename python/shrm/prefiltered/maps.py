"""The classes of prefiltered maps, each with what it keeps of L(v, n, t) [KVHS00 section 4]."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, TypeVar, get_args

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF, Material
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.frequency.rings import Interpolation
from shrm.integrate.angular_lobes import across, central_directions, normals_of
from shrm.lobes.center import gamma_at, gamma_table
from shrm.lobes.factored import FactoredLobe, factor_at, factored, symmetric
from shrm.lobes.reflection import Layout
from shrm.prefiltered.explicit import lat_long_pictures
from shrm.prefiltered.icosahedron import icosahedron, weights
from shrm.prefiltered.layers import (
    Integrator,
    Layer,
    Layers,
    largest_angle,
    one_lobe,
    radial_layers,
    sliced_layers,
)
from shrm.validation import one_of, unit_vectors

S = TypeVar("S", bound="_OneShape")
D = TypeVar("D", bound="_Slices")

SLICES = 33
"""Layers of a map of three dimensions."""


@dataclass(frozen=True, eq=False, repr=False)
class PrefilteredMap(ABC):
    """A prefiltered map of one lobe.

    Attributes
    ----------
    keeps : str
        Of v, n and t, what it depends on.
    assumes : str
        When that is all there is.
    kinds, centers : tuple of str
        Of the lobes that it holds; isotropic ones may have any center.
    layers : tuple of Layer
        Maps of radiance over C.
    brdf : str
        The material's name.
    """

    layers: tuple[Layer, ...]
    brdf: str

    keeps: ClassVar[str]
    assumes: ClassVar[str]
    kinds: ClassVar[tuple[str, ...]]
    centers: ClassVar[tuple[Center, ...]]

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
        return np.concatenate([layer.maps for layer in self.layers])

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
            share = shares[:, k] if shares.ndim == 3 else shares[:, k, None]
            near = np.flatnonzero(share.any(axis=1))
            if len(near):
                result[near] += share[near] * layer.radiance(C[near], interpolation)
        return result

    def _central(self, N: FloatArray, V: FloatArray, T: FloatArray) -> FloatArray:
        return central_directions(self.center, N, V, T)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.brdf}: {len(self.layers)} layers {self.layout} {self.size}>"

    def save(self, path: str | Path) -> None:
        """Write a file; `Prefiltered.load` reads it.

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """
        from shrm.prefiltered.file import save  # a map's save is the file's

        save((self,), path)


class _OneShape(PrefilteredMap):
    """One layer for all views."""

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        return np.ones((len(views), 1))

    @classmethod
    def prefilter(
        cls: type[S],
        env: Environment,
        brdf: BRDF,
        *,
        integrator: Integrator = "hierarchical",
        error: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> S:
        """Prefilter an environment for a lobe of one shape.

        Parameters
        ----------
        env : Environment
        brdf : BRDF
            Of one radial lobe, about the class's center.
        integrator, error, size, layout
            As in `shrm.prefiltered.prefilter`.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        return cls._made(
            one_lobe(brdf, cls.__name__, cls.kinds, cls.centers),
            Layers.checked(env, brdf, integrator, error, size, layout),
        )

    @classmethod
    def _made(cls: type[S], one: Material, how: Layers) -> S:
        return cls(radial_layers([one], how), one.name)


class Diffuse(_OneShape):
    """Miller's: what a matt surface reflects [KVHS00 section 4]."""

    keeps = "(n)"
    assumes = "a diffuse surface"
    kinds, centers = ("radial",), ("normal",)


class Phong(_OneShape):
    """Miller's and Heidrich's: a lobe of one shape about the reflection [KVHS00 section 4]."""

    keeps = "(r_v)"
    assumes = "a lobe of one shape, symmetric about the reflection"
    kinds, centers = ("radial",), ("reflection",)


class _Slices(PrefilteredMap):
    """Layers at equal steps of theta_o, linear between them."""

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        K = len(self.layers)
        place = np.clip(theta_o / largest_angle(self.center) * (K - 1), 0.0, K - 1)
        return np.maximum(1.0 - np.abs(place[:, None] - np.arange(K)), 0.0)

    @classmethod
    def prefilter(
        cls: type[D],
        env: Environment,
        brdf: BRDF,
        *,
        slices: int = SLICES,
        integrator: Integrator = "hierarchical",
        error: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> D:
        """Prefilter an environment for a lobe that is symmetric about its center for every view, or made so.

        Parameters
        ----------
        env : Environment
        brdf : BRDF
            Of one lobe: about the tangent for `Anisotropic`, else isotropic, or zonal about the reflection or
            the normal.
        slices : int
            Layers, 2 to 341, at equal steps of theta_o: 5.6 degrees by default. Linear look-ups between them
            want several to the width of the lobe in theta_o.
        integrator, error, size, layout
            As in `shrm.prefiltered.prefilter`.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        return cls._made(
            one_lobe(brdf, cls.__name__, cls.kinds, cls.centers),
            Layers.checked(env, brdf, integrator, error, size, layout),
            slices,
        )

    @classmethod
    def _made(cls: type[D], one: Material, how: Layers, slices: int) -> D:
        return cls(sliced_layers(symmetric(one.lobes[0]), one.name, how, slices), one.name)


class KautzMcCool3D(_Slices):
    """Kautz and McCool's of three dimensions: a lobe symmetric about the reflection for every view [KM00]."""

    keeps = "(r_v, n.r_v)"
    assumes = "a lobe symmetric about the reflection; other isotropic lobes lose their azimuth about it"
    kinds, centers = ("isotropic", "zonal"), ("reflection", "normal")


class Anisotropic(_Slices):
    """Of lobes about the tangent that depend on two angles, such as Banks' [KVHS00 section 5.3]."""

    keeps = "(t, v.t)"
    assumes = "no self-shadowing: light from below the surface is reflected too"
    kinds, centers = ("zonal",), ("tangent",)


@dataclass(frozen=True, eq=False, repr=False)
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
    kinds, centers = ("isotropic", "zonal"), ("reflection", "normal")

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """See `PrefilteredMap.shares`."""
        theta_v = theta_o * (np.pi / 2 / largest_angle(self.center))
        of_layers = np.stack([factor_at(factor, theta_v) for factor in self.factors], axis=1)
        return np.asarray(np.broadcast_to(of_layers, (*of_layers.shape[:2], 3)))

    @classmethod
    def prefilter(
        cls,
        env: Environment,
        brdf: BRDF,
        *,
        lobes: int = 1,
        integrator: Integrator = "hierarchical",
        error: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> KautzMcCool2D:
        """Prefilter an environment for products of shapes and factors that come nearest to a lobe.

        Parameters
        ----------
        env : Environment
        brdf : BRDF
            Of one lobe: isotropic, or zonal about the reflection or the normal.
        lobes : int
            How many products of a shape and a factor are summed, 1 to 8.
        integrator, error, size, layout
            As in `shrm.prefiltered.prefilter`.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        how = Layers.checked(env, brdf, integrator, error, size, layout)
        one = one_lobe(brdf, cls.__name__, cls.kinds, cls.centers)
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
    kinds, centers = ("isotropic",), ()

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
    def prefilter(
        cls,
        env: Environment,
        brdf: BRDF,
        *,
        integrator: Integrator = "hierarchical",
        error: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> Cabral:
        """Prefilter an environment for a material of one isotropic lobe; see `Diffuse.prefilter`."""
        return cls._made(
            one_lobe(brdf, cls.__name__, cls.kinds, cls.centers),
            Layers.checked(env, brdf, integrator, error, size, layout),
        )

    @classmethod
    def fitted(
        cls, maps: npt.ArrayLike, center: Center = "reflection", name: str = "twelve pictures"
    ) -> Cabral:
        """Return them from pictures.

        Parameters
        ----------
        maps : (12, H, 2 H, 3) array_like
            Lat-long maps over the central direction, H even, in the order of `icosahedron`.
        center : {"reflection", "normal", "tangent"}
            The central direction by which they are looked up.
        name : str
            What the material is called.

        Raises
        ------
        TypeError, ValueError
            If the maps have another shape.
        """
        pixels = lat_long_pictures(maps, len(icosahedron()))
        one_of("center", center, ("reflection", "normal", "tangent"))
        rings = np.ascontiguousarray(pixels.transpose(0, 1, 3, 2)[:, :, None], np.float32)
        gamma = gamma_table(center)
        return cls(tuple(Layer(center, gamma, "latlong", layer) for layer in rings), name)

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
