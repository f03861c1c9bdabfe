"""The layers of prefiltered maps: radiance over the central direction, integrated by any method."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF, Material, require_brdf
from shrm.brdf.lobe import Center, Lobe, refuse_anisotropic
from shrm.environment import Environment, require_environment
from shrm.frequency.prefilter import prefilter as prefilter_in_frequency
from shrm.frequency.rings import Interpolation, Rings, ring_directions
from shrm.integrate.angular import prefilter_angular
from shrm.integrate.hierarchical import prefilter_hierarchical
from shrm.integrate.queries import DEFAULT_SIZE
from shrm.lobes.center import gamma_table
from shrm.lobes.directions import across, bisector, normals_of
from shrm.lobes.reflection import Layout, Reflection, map_layout
from shrm.prefiltered.icosahedron import icosahedron
from shrm.validation import one_of, positive, whole_number

Method = Literal["frequency", "angular", "hierarchical"]

MOST_SLICES = 341
"""Most layers: a part of a file has at most 1024 channels, of which a layer takes three."""

LARGEST_SIZE = 8192
"""Most rows of a lat-long map, or of a cube's face."""

P_MAX = 16
"""Largest order of the view where layers are made in frequency space: its maps themselves are not kept."""


class Layer(Rings):
    """A map of radiance over the central direction C: rings (H, 1, 3, W)."""

    def radiance(self, C: FloatArray, interpolation: Interpolation = "cubic") -> Float32Array:
        """Return the radiance at central directions (n, 3), from look-ups; (n, 3)."""
        # A map of P = 0 is multiplied by Y_00 = 1 / sqrt(4 pi).
        return self.look_up(C, C, False, interpolation) * np.float32(np.sqrt(4.0 * np.pi))

    @property
    def pixels(self) -> Float32Array:
        """The radiance, (H, W, 3), or (6, N, N, 3) for cubes: a view."""
        return np.asarray(self.maps[0])

    def __repr__(self) -> str:
        return f"<Layer about the {self.center}: {self.layout} {self.size}>"


@dataclass(frozen=True, eq=False)
class Integration:
    """The integration of an environment into layers: the method, its tolerance, and the grid.

    Attributes
    ----------
    env : Environment
        The light.
    method : {"frequency", "angular", "hierarchical"}
        The integrator.
    tolerance : float
        Relative RMS of the radiance under the lobe that the layers hold, in (0, 1).
    size : int
        Rows of a lat-long map, or the edge of a cube's face.
    layout : {"latlong", "cube"}
        The grid of the layers.

    Raises
    ------
    TypeError, ValueError
        If an attribute is not as described.
    """

    env: Environment
    method: Method
    tolerance: float
    size: int
    layout: Layout

    def __post_init__(self) -> None:
        require_environment(self.env)
        one_of("method", self.method, get_args(Method))
        one_of("layout", self.layout, get_args(Layout))
        positive("tolerance", self.tolerance, 1.0)
        whole_number("size", self.size, 2, LARGEST_SIZE)

    @classmethod
    def requested(
        cls, env: Environment, method: Method, tolerance: float, size: int | None, layout: Layout
    ) -> Integration:
        """Return what the arguments of a `prefilter` ask for, with the default size if there is none."""
        layout = map_layout(layout)
        return cls(env, method, tolerance, DEFAULT_SIZE[layout] if size is None else size, layout)

    def reflection(self, material: Material) -> Reflection:
        """Return the reflection of the environment under a material."""
        if self.method == "frequency":
            return prefilter_in_frequency(self.env, material, tolerance=self.tolerance, P_max=P_MAX)
        if self.method == "angular":
            return prefilter_angular(self.env, material, tolerance=self.tolerance)
        return prefilter_hierarchical(
            self.env, material, tolerance=self.tolerance, size=self.size, layout=self.layout
        )

    def layer(
        self, center: Center, radiance: Callable[[FloatArray], Float32Array], gamma: FloatArray
    ) -> Layer:
        """Return a map over C of radiance(C), borders of faces included."""
        C = ring_directions(self.size, self.layout)
        pixels = radiance(np.ascontiguousarray(C.reshape(-1, 3))).reshape(C.shape)
        rings = np.ascontiguousarray(pixels.transpose(0, 2, 1)[:, None], np.float32)
        return Layer(center, gamma, self.layout, rings)


def require_material(brdf: BRDF) -> None:
    """Raise TypeError if `brdf` is no material."""
    require_brdf(brdf)


def material_of_one_lobe(
    brdf: BRDF, name: str, kinds: tuple[str, ...], centers: tuple[Center, ...]
) -> Material:
    """Return a material of one lobe if a class of maps, called `name`, holds such lobes.

    Raises
    ------
    TypeError, ValueError
        If it is no material, has several lobes, or one of another kind or center.
    """
    require_material(brdf)
    if len(brdf.lobes) != 1:
        raise ValueError(
            f"{name} holds one lobe, and {brdf.name} has {len(brdf.lobes)}: use prefiltered.prefilter"
        )
    (lobe,) = brdf.lobes
    refuse_anisotropic(lobe)
    if lobe.kind not in kinds or not (lobe.kind == "isotropic" or lobe.center in centers):
        about = f" about the {' or the '.join(centers)}" if centers else ""
        raise ValueError(
            f"{name} holds a lobe that is {' or '.join(kinds)}{about}, and that of {brdf.name} is"
            f" {lobe.kind}, about the {lobe.center}"
        )
    return Material((lobe,), brdf.name)


# ---- Layers of each kind


def radial_layers(materials: Sequence[Material], integration: Integration) -> tuple[Layer, ...]:
    """Return one layer for each material of one radial lobe."""

    def layer(material: Material) -> Layer:
        reflection, center = integration.reflection(material), material.lobes[0].center
        # For N = V = C, both R and N are C.
        return integration.layer(center, lambda C: reflection.radiance(C, C), gamma_table(center))

    return tuple(map(layer, materials))


def sliced_layers(lobe: Lobe, name: str, integration: Integration, slices: int) -> tuple[Layer, ...]:
    """Return layers of a zonal lobe at equal steps of the angle theta_o between C and V."""
    count = whole_number("slices", slices, 2, MOST_SLICES)
    reflection = integration.reflection(Material((lobe,), name))

    def layer(theta_o: float) -> Layer:
        def radiance(C: FloatArray) -> Float32Array:
            aside, _ = across(C, C)
            V = np.cos(theta_o) * C + np.sin(theta_o) * aside
            return reflection.radiance(bisector(C, V) if lobe.center == "reflection" else C, V, C)

        return integration.layer(lobe.center, radiance, gamma_table(lobe.center))

    return tuple(layer(float(angle)) for angle in np.linspace(0.0, largest_angle(lobe.center), count))


def icosahedral_layers(material: Material, integration: Integration) -> tuple[Layer, ...]:
    """Return layers of an isotropic lobe for the twelve views of `icosahedron`."""
    lobe = material.lobes[0]
    reflection, gamma = integration.reflection(material), gamma_table(lobe.center, lobe.transfer)

    def layer(view: FloatArray) -> Layer:
        def radiance(C: FloatArray) -> Float32Array:
            V = np.ascontiguousarray(np.broadcast_to(view, C.shape))
            return reflection.radiance(normals_of(lobe.center, lobe.transfer, C, V), V)

        return integration.layer(lobe.center, radiance, gamma)

    return tuple(map(layer, icosahedron()))


def largest_angle(center: Center) -> float:
    """Return the largest angle between C and V, radians."""
    return np.pi / 2 if center == "normal" else np.pi
