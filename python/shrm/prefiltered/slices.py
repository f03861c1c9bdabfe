"""Prefiltered maps of three dimensions: layers at equal steps of an angle, linear in between."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import BRDF, Material
from shrm.environment import Environment
from shrm.lobes.factored import symmetric
from shrm.lobes.reflection import Layout
from shrm.prefiltered.file import LARGEST
from shrm.prefiltered.layers import Integration, Method, largest_angle, sliced_layers
from shrm.prefiltered.prefiltered_map import PrefilteredMap

Sliced = TypeVar("Sliced", bound="SlicedMap")

SLICES = 33
"""Layers by default, 5.6 degrees of theta_o apart where it goes to 180."""


class SlicedMap(PrefilteredMap):
    """Layers at equal steps of theta_o, linear between them."""

    layer_counts = (2, LARGEST)

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """Return the weights of linear interpolation; see `PrefilteredMap.shares`."""
        K = len(self.layers)
        place = np.clip(theta_o / largest_angle(self.center) * (K - 1), 0.0, K - 1)
        return np.maximum(1.0 - np.abs(place[:, None] - np.arange(K)), 0.0)

    @classmethod
    def prefilter(
        cls: type[Sliced],
        env: Environment,
        brdf: BRDF,
        *,
        slices: int = SLICES,
        method: Method = "hierarchical",
        tolerance: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> Sliced:
        """Prefilter an environment for a lobe that is symmetric about its center for every view, or made so.

        Parameters
        ----------
        slices : int
            Layers, 2 to 341, at equal steps of theta_o. Linear look-ups between them want several to the
            width of the lobe in theta_o.
        env, brdf, method, tolerance, size, layout
            As in `PrefilteredMap.prefilter`.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        integration = Integration.requested(env, method, tolerance, size, layout)
        return cls.integrated(cls.held(brdf), integration, slices=slices)

    @classmethod
    def integrated(
        cls: type[Sliced],
        material: Material,
        integration: Integration,
        *,
        slices: int = SLICES,
        **options: Any,
    ) -> Sliced:
        """Integrate the layers of the lobe, made symmetric."""
        layers = sliced_layers(symmetric(material.lobes[0]), material.name, integration, slices)
        return cls(layers, material.name, integration.tolerance)


class KautzMcCool3D(SlicedMap):
    """Kautz and McCool's map of three dimensions: a lobe symmetric about R for every view [KM00]."""

    keeps = "(r_v, n.r_v)"
    assumes = "a lobe symmetric about the reflection; other isotropic lobes lose their azimuth about it"
    kinds, centers_held = ("isotropic", "zonal"), ("reflection", "normal")


class Anisotropic(SlicedMap):
    """A map of lobes about the tangent that depend on two angles, such as Banks' [KVHS00 section 5.3]."""

    keeps = "(t, v.t)"
    assumes = "no self-shadowing: light from below the surface is reflected too"
    kinds, centers_held = ("zonal",), ("tangent",)
