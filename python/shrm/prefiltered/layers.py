"""The layers of prefiltered maps: how they are integrated, and their grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF, Material
from shrm.brdf.lobe import Center, Lobe, refuse_anisotropic
from shrm.environment import Environment
from shrm.frequency.prefilter import prefilter as prefilter_in_frequency
from shrm.frequency.rings import Interpolation, Rings, ring_directions
from shrm.integrate.angular import DEFAULT_SIZE, prefilter_angular
from shrm.integrate.angular_lobes import across, bisector
from shrm.integrate.hierarchical import prefilter_hierarchical
from shrm.lobes.center import gamma_table
from shrm.lobes.reflection import Layout
from shrm.validation import fraction, one_of, whole_number

Integrator = Literal["frequency", "angular", "hierarchical"]

MOST_SLICES = 341
"""Three channels each, of the 1024 that a part of a file may have."""

P_MAX = 16
"""Largest order of the view in frequency space."""


class Reflects(Protocol):
    """What integrators return."""

    def radiance(self, normals: Any, views: Any, tangents: Any = None) -> Float32Array:
        """Reflected radiance (n, 3)."""


class Layer(Rings):
    """A map of radiance over the central direction C: rings (H, 1, 3, W)."""

    def radiance(self, C: FloatArray, interpolation: Interpolation = "cubic") -> Float32Array:
        """Return the radiance at central directions (n, 3), from look-ups; (n, 3)."""
        # a map of P = 0 is multiplied by Y_00 = 1 / sqrt(4 pi)
        return self.look_up(C, C, False, interpolation) * np.float32(np.sqrt(4.0 * np.pi))

    def __repr__(self) -> str:
        return f"<Layer about the {self.center}: {self.layout} {self.size}>"


@dataclass(frozen=True, eq=False)
class Layers:
    """How maps are integrated, and their grid."""

    env: Environment
    integrator: Integrator
    error: float
    size: int
    layout: Layout

    @classmethod
    def checked(
        cls,
        env: Environment,
        brdf: BRDF,
        integrator: Integrator = "hierarchical",
        error: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> Layers:
        """At the door of every `prefilter`."""
        if not isinstance(env, Environment):
            raise TypeError(f"env must be an Environment, got {type(env).__name__}")
        require_material(brdf)
        one_of("integrator", integrator, get_args(Integrator))
        one_of("layout", layout, get_args(Layout))
        if fraction("error", error) == 0:
            raise ValueError(f"error must be above 0 and below 1, got {error!r}")
        edge = DEFAULT_SIZE[layout] if size is None else whole_number("size", size, 2, 8192)
        return cls(env, integrator, error, edge, layout)

    def integrated(self, one: Material) -> Reflects:
        """What reflects the environment under a material."""
        if self.integrator == "frequency":
            return prefilter_in_frequency(self.env, one, tolerance=self.error, P_max=P_MAX)
        if self.integrator == "angular":
            return prefilter_angular(self.env, one, tolerance=self.error)
        return prefilter_hierarchical(self.env, one, tolerance=self.error, size=self.size, layout=self.layout)

    def layer(
        self, center: Center, radiance: Callable[[FloatArray], Float32Array], gamma: FloatArray
    ) -> Layer:
        """Return a map over C of radiance(C), borders of faces included."""
        C = ring_directions(self.size, self.layout)
        pixels = radiance(np.ascontiguousarray(C.reshape(-1, 3))).reshape(C.shape)
        rings = np.ascontiguousarray(pixels.transpose(0, 2, 1)[:, None], np.float32)
        return Layer(center, gamma, self.layout, rings)


def require_material(brdf: BRDF) -> None:
    """Raise TypeError unless it is one."""
    if not isinstance(brdf, BRDF):
        raise TypeError(f"brdf must be a material of shrm.brdf, got {type(brdf).__name__}")


def one_lobe(brdf: BRDF, name: str, kinds: tuple[str, ...], centers: tuple[Center, ...]) -> Material:
    """Return a material of one lobe that a class of this name holds."""
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


def radial_layers(materials: Sequence[Material], how: Layers) -> tuple[Layer, ...]:
    """One layer for each material of one radial lobe."""
    layers = []
    for one in materials:
        center = one.lobes[0].center
        reflection = how.integrated(one)
        # For N = V = C, both R and N are C.
        layers.append(how.layer(center, lambda C, of=reflection: of.radiance(C, C), gamma_table(center)))  # type: ignore[misc]
    return tuple(layers)


def sliced_layers(lobe: Lobe, name: str, how: Layers, slices: int) -> tuple[Layer, ...]:
    """Layers of a zonal lobe at equal steps of the angle between C and V."""
    K = whole_number("slices", slices, 2, MOST_SLICES)
    reflection = how.integrated(Material((lobe,), name))

    def at(theta_o: float) -> Callable[[FloatArray], Float32Array]:
        def radiance(C: FloatArray) -> Float32Array:
            aside, _ = across(C, C)
            V = np.cos(theta_o) * C + np.sin(theta_o) * aside
            return reflection.radiance(bisector(C, V) if lobe.center == "reflection" else C, V, C)

        return radiance

    angles = np.linspace(0.0, largest_angle(lobe.center), K)
    return tuple(how.layer(lobe.center, at(float(angle)), gamma_table(lobe.center)) for angle in angles)


def largest_angle(center: Center) -> float:
    """The largest angle between C and V."""
    return np.pi / 2 if center == "normal" else np.pi
