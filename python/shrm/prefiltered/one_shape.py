"""Prefiltered maps of lobes that keep their shape for all views, one layer each, with factors or without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import BRDF, Material
from shrm.environment import Environment
from shrm.lobes.factored import FactoredLobe, factor_at, factored
from shrm.lobes.reflection import Layout
from shrm.prefiltered.file import LARGEST, SavedLobe
from shrm.prefiltered.layers import Integration, Method, largest_angle, radial_layers
from shrm.prefiltered.prefiltered_map import PrefilteredMap

Radial = TypeVar("Radial", bound="RadialMap")


class RadialMap(PrefilteredMap):
    """One layer for all views."""

    kinds = ("radial",)
    layer_counts = (1, 1)

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """Return ones; see `PrefilteredMap.shares`."""
        return np.ones((len(views), 1))

    @classmethod
    def integrated(cls: type[Radial], material: Material, integration: Integration, **options: Any) -> Radial:
        """Integrate the layer; there are no options."""
        return cls(radial_layers([material], integration), material.name, integration.tolerance)


class Diffuse(RadialMap):
    """Miller's map: the reflection of a matt surface [KVHS00 section 4]."""

    keeps = "(n)"
    assumes = "a diffuse surface"
    centers_held = ("normal",)


class Phong(RadialMap):
    """Miller's and Heidrich's map: a lobe of one shape about the reflection [KVHS00 section 4]."""

    keeps = "(r_v)"
    assumes = "a lobe of one shape, symmetric about the reflection"
    centers_held = ("reflection",)


@dataclass(frozen=True, eq=False, repr=False)
class KautzMcCool2D(PrefilteredMap):
    """Kautz and McCool's maps of two dimensions: lobes of one shape, times factors of the view [KM00].

    Attributes
    ----------
    layers, brdf, error
        As in `PrefilteredMap`.
    factors : (K, VIEWS, 1 or 3) float64
        The factor of each layer, uniform in theta_v over [0, pi/2].
    """

    factors: FloatArray = field(default_factory=lambda: np.ones((1, 2, 1)))

    keeps = "(r_v), F(n.r_v)"
    assumes = "a lobe symmetric about the reflection that keeps its shape"
    kinds, centers_held = ("isotropic", "zonal"), ("reflection", "normal")
    layer_counts = (1, LARGEST)

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """Return the factors at theta_v; see `PrefilteredMap.shares`."""
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
        method: Method = "hierarchical",
        tolerance: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> KautzMcCool2D:
        """Prefilter an environment for products of shapes and factors that come nearest to a lobe.

        Parameters
        ----------
        lobes : int
            Products of a shape and a factor that are summed, 1 to 8.
        env, brdf, method, tolerance, size, layout
            As in `PrefilteredMap.prefilter`.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        integration = Integration.requested(env, method, tolerance, size, layout)
        return cls.integrated(cls.held(brdf), integration, lobes=lobes)

    @classmethod
    def integrated(
        cls, material: Material, integration: Integration, *, lobes: int = 1, **options: Any
    ) -> KautzMcCool2D:
        """Integrate the layers of the products that come nearest to the lobe."""
        return cls.of_products(factored(material.lobes[0], lobes), material.name, integration)

    @classmethod
    def of_products(
        cls, products: Sequence[FactoredLobe], name: str, integration: Integration
    ) -> KautzMcCool2D:
        """Integrate the layers of given products of shapes and factors."""
        layers = radial_layers([Material((product.lobe,), name) for product in products], integration)
        return cls(layers, name, integration.tolerance, np.stack([product.factor for product in products]))

    def saved(self) -> SavedLobe:
        """Return what a file holds of the map, factors included."""
        return replace(super().saved(), factors=self.factors)

    @classmethod
    def from_saved(cls, saved: SavedLobe) -> KautzMcCool2D:
        """Return a map from what a file holds; ValueError if it is none."""
        if saved.factors is None:
            raise ValueError(f"no factors for {len(saved.layers)} layers")
        return replace(super().from_saved(saved), factors=saved.factors)
