"""Cabral's prefiltered maps: reflection maps for twelve views, blended for others [CON99]."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.brdf import Material
from shrm.brdf.lobe import Center
from shrm.lobes.center import gamma_at, gamma_table
from shrm.lobes.directions import across
from shrm.prefiltered.explicit import lat_long_pictures
from shrm.prefiltered.icosahedron import VERTICES, weights
from shrm.prefiltered.layers import Integration, Layer, icosahedral_layers
from shrm.prefiltered.prefiltered_map import PrefilteredMap
from shrm.validation import one_of


class Cabral(PrefilteredMap):
    """Cabral's map of four dimensions: layers for twelve views, blended for others [CON99].

    [CON99] has maps over normals, warped along R to the new view; maps over R need no warp
    [RH02 section 3.1]. All of a lobe is kept at the twelve views.
    """

    keeps = "(v, n), v at twelve places"
    assumes = "a distant viewer; highlights that move little between the views of an icosahedron"
    kinds, centers_held = ("isotropic",), ()
    layer_counts = (VERTICES, VERTICES)

    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """Return barycentric weights of the views; see `PrefilteredMap.shares`."""
        return weights(views)

    def central_directions(self, N: FloatArray, V: FloatArray, T: FloatArray) -> FloatArray:
        """Return C for normals, views and tangents, (n, 3) each; about the lobe by the table of gamma."""
        if self.center != "lobe":
            return super().central_directions(N, V, T)
        x, theta_v = across(N, V)
        gamma = gamma_at(self.layers[0].gamma, theta_v)[:, None]
        return np.asarray(np.cos(gamma) * N - np.sin(gamma) * x)

    @classmethod
    def integrated(cls, material: Material, integration: Integration, **options: Any) -> Cabral:
        """Integrate the layers; there are no options."""
        return cls(icosahedral_layers(material, integration), material.name, integration.tolerance)

    @classmethod
    def fitted(
        cls, maps: npt.ArrayLike, center: Center = "reflection", name: str = "twelve pictures"
    ) -> Cabral:
        """Return the map of twelve pictures.

        Parameters
        ----------
        maps : (12, H, 2 H, 3) array_like
            Lat-long maps over the central direction, H even, for the views of `icosahedron` in its order.
        center : {"reflection", "normal", "tangent"}
            The central direction by which they are looked up.
        name : str
            The material's name.

        Raises
        ------
        TypeError, ValueError
            If the maps have another shape.
        """
        pixels = lat_long_pictures(maps, VERTICES)
        one_of("center", center, ("reflection", "normal", "tangent"))
        rings = np.ascontiguousarray(pixels.transpose(0, 1, 3, 2)[:, :, None], np.float32)
        gamma = gamma_table(center)
        return cls(tuple(Layer(center, gamma, "latlong", layer) for layer in rings), name)
