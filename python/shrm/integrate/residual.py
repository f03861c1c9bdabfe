"""The residual that reflection maps of small orders miss: the cores of sharp lobes, integrated or looked up.

A core (`shrm.lobes.split`) as wide as the texels of the light is integrated by descent in a pyramid of them
(`shrm.integrate.hierarchical`). The texels are areas of one radiance: they are cut for narrower cores, as
far as `LARGEST_CUT`. What is too narrow even then is split off once more and looked up, as in a mirror: the
light in the direction of the lobe's center times the directional albedo.

All is kept in arrays, so that it can be stored with the maps and used without the material.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import directional_albedo
from shrm.brdf.lobe import Center, IsotropicLobe, RadialLobe
from shrm.brdf.material import Material
from shrm.environment.lookup import environment_lookup
from shrm.integrate.angular_lobes import half_width
from shrm.integrate.descent_lobes import IsotropicDescent, RadialDescent
from shrm.integrate.sampled_frames import Frames
from shrm.integrate.saved_arrays import NamedArrays, angles, number, table
from shrm.integrate.tables import light_quadrature, view_at, view_nodes, view_place
from shrm.integrate.threshold import map_texels
from shrm.lobes.center import gamma_at, gamma_table
from shrm.lobes.directions import above_horizon, across, normals_at
from shrm.lobes.reflection import Layout, sum_by_name
from shrm.lobes.split import split
from shrm.validation import unit_vectors

CoreLobe = IsotropicLobe | RadialLobe

LARGEST_CUT = 2048
"""Most columns of a picture whose texels are cut for narrow cores: 25 MB, and its pyramid."""

CUT_TO, RESOLVED = 2.0, 1.0
"""Texels, which count as points, in the angle that holds half of a core: as many as texels are cut for, and
as many as there must be for it to be integrated."""

THRESHOLDS = (0.05, 0.0125, 0.003)
"""Thresholds of the descent, tried in turn. The first already has nodes small against the lobe."""


@dataclass(frozen=True, eq=False)
class LookUp:
    """A lobe that reflects as a mirror does.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal"}
        Direction in which the light is looked up.
    gamma : (257,) float64
        The angle between the mirrored direction and N over theta_v in [0, pi/2], radians.
    albedo : (97, channels) float64
        Directional albedo at the views of `lobe_tables.view_nodes`.
    """

    center: Center
    gamma: FloatArray
    albedo: FloatArray

    @classmethod
    def of(cls, lobe: CoreLobe) -> LookUp:
        """Tabulate a lobe."""
        if isinstance(lobe, RadialLobe):
            albedo = directional_albedo(Material((lobe,), "core"), [1.0]).repeat(len(view_nodes()), axis=0)
            return cls(lobe.center, gamma_table(lobe.center), albedo)
        rows = []
        for cos_v in np.cos(view_nodes()):
            wi, weight = light_quadrature(cos_v, 192)
            rho = lobe.transfer(wi, view_at(cos_v, len(wi)))
            rows.append(weight @ rho.reshape(len(wi), -1))
        return cls(lobe.center, gamma_table(lobe.center, lobe.transfer), np.array(rows))

    def to_arrays(self) -> NamedArrays:
        """Return what `from_arrays` takes, `center` apart."""
        return {"albedo": self.albedo, "mirror": self.gamma[None]}

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> LookUp:
        """Restore it from what `to_arrays` returned; KeyError or ValueError if that is damaged."""
        albedo = table(arrays, "albedo", (len(view_nodes()), None))
        if albedo.shape[1] not in (1, 3):
            raise ValueError(f"albedo of shape {albedo.shape}")
        return cls(center, angles(arrays, "mirror"), albedo)

    def radiance(self, pixels: Float32Array, n: FloatArray, v: FloatArray) -> FloatArray:
        """Return reflected radiance (n, 3); light is linear between the texels of a picture (H, W, 3)."""
        n, v = above_horizon(self.center, n, v)
        x, theta_v = across(n, v)
        gamma = gamma_at(self.gamma, theta_v)[:, None]
        place, nodes = view_place(np.cos(theta_v)), np.arange(len(self.albedo))
        albedo = np.stack([np.interp(place, nodes, channel) for channel in self.albedo.T], axis=1)
        return np.asarray(albedo * environment_lookup(pixels, np.cos(gamma) * n - np.sin(gamma) * x))


@dataclass(frozen=True, eq=False)
class Core:
    """The core of one lobe.

    Attributes
    ----------
    center, gamma
        Center of the map it belongs to, by which its own maps are indexed too, and the angle of that from N.
    descent : IsotropicDescent or RadialDescent
        The part of the core that the texels resolve.
    threshold : float
        Threshold of the descent.
    look_up : LookUp or None
        The part that is narrower than the texels.
    """

    center: Center
    gamma: FloatArray
    descent: IsotropicDescent | RadialDescent
    threshold: float
    look_up: LookUp | None

    def to_arrays(self) -> NamedArrays:
        """Return what `from_arrays` takes, the centers and the map's gamma apart."""
        look_up = {} if self.look_up is None else self.look_up.to_arrays()
        return {
            "threshold": np.asarray(self.threshold),
            "looked up": np.asarray(int(self.look_up is not None)),
            **self.descent.to_arrays(),
            **look_up,
        }

    @classmethod
    def from_arrays(cls, center: Center, gamma: FloatArray, own_center: Center, arrays: NamedArrays) -> Core:
        """Restore it from what `to_arrays` returned.

        Parameters
        ----------
        center, gamma
            Center of the map it belongs to, and the angle of that from N.
        own_center : {"lobe", "reflection", "normal"}
            Center of its descent.
        arrays : {name: array}
            Its arrays.

        Raises
        ------
        KeyError, ValueError
            If an array is missing or damaged.
        """
        kind = IsotropicDescent if "ratio" in arrays else RadialDescent
        descent = kind.from_arrays(own_center, arrays)
        look_up = LookUp.from_arrays(own_center, arrays) if number(arrays, "looked up") else None
        return cls(center, gamma, descent, number(arrays, "threshold"), look_up)


@dataclass(frozen=True, eq=False)
class Light:
    """A picture whose texels are cut into smaller ones of the same radiance, and its pyramid.

    Attributes
    ----------
    pixels : (H, W, 3) float32
        The light, lat-long.
    cut : int
        Parts along each side of a texel.
    """

    pixels: Float32Array
    cut: int

    @cached_property
    def picture(self) -> Float32Array:
        """The light with its texels cut: (cut H, cut W, 3)."""
        return np.ascontiguousarray(self.pixels.repeat(self.cut, axis=0).repeat(self.cut, axis=1))

    @cached_property
    def pyramid(self) -> _core.Pyramid:
        """The pyramid of `picture` that cores are integrated in."""
        return _core.Pyramid(self.picture)

    def __reduce__(self) -> tuple[type[Light], tuple[Float32Array, int]]:
        """Return what is pickled: the picture and the pyramid are made again."""
        return Light, (self.pixels, self.cut)


@dataclass(frozen=True, eq=False)
class Residual:
    """The cores of a material's lobes under one light.

    Attributes
    ----------
    light : Light
        The light.
    cores : tuple of (str, Core)
        The cores with the names that `shrm.ReflectionMap.maps_at_view` has for the maps they belong to.
    layout : {"latlong", "cube"}
        The grid of maps.
    size : int
        Rows of a lat-long map, or of a cube's face.
    rotation : (3, 3) float64
        The rotation of the light, L'(w) = L(R^T w).
    """

    light: Light
    cores: tuple[tuple[str, Core], ...]
    layout: Layout
    size: int
    rotation: FloatArray

    def radiance(self, normals: npt.ArrayLike, views: npt.ArrayLike) -> Float32Array:
        """Return what the cores reflect towards the eye.

        Parameters
        ----------
        normals : (n, 3) array_like
            Unit vectors.
        views : (n, 3) or (3,) array_like
            Unit vectors from the surface to the eye.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        n = unit_vectors("normals", normals)
        v = np.broadcast_to(unit_vectors("views", views, 1 if np.ndim(views) == 1 else len(n)), n.shape)
        radiance = np.zeros(n.shape, np.float32)
        for _, core in self.cores:
            radiance += self._of_core(core, n, v)
        return radiance

    def maps_at_view(self, view: npt.ArrayLike) -> dict[str, Float32Array]:
        """Return the cores' maps for a distant viewer, about the centers of the maps they belong to.

        Parameters
        ----------
        view : (3,) array_like
            Unit vector to the eye.

        Returns
        -------
        {name: (H, W, 3) or (6, N, N, 3) float32}
            Each texel is the radiance at its center.

        Raises
        ------
        TypeError, ValueError
            If view is not a unit vector.
        """
        shape, order, targets = map_texels(self.layout, self.size)
        v = np.ascontiguousarray(np.broadcast_to(unit_vectors("view", view, 1), targets.shape))

        def core_map(core: Core) -> Float32Array:
            pixels = np.empty(targets.shape, np.float32)
            pixels[order] = self._of_core(core, normals_at(core.center, core.gamma, targets, v), v)
            return pixels.reshape(shape)

        return sum_by_name((name for name, _ in self.cores), (core_map(core) for _, core in self.cores))

    def relit(self, pixels: Float32Array) -> Residual:
        """Return the same cores under another light (H, W, 3), not rotated."""
        return replace(self, light=Light(pixels, self.light.cut), rotation=np.eye(3))

    def rotated(self, R: FloatArray) -> Residual:
        """Return the same cores with the light rotated by R, in place of an earlier rotation."""
        return replace(self, rotation=R)

    def __repr__(self) -> str:
        names = ", ".join(name for name, _ in self.cores)
        H, W, _ = self.light.pixels.shape
        return f"<Residual: cores of {names} under {H} x {W} texels>"

    def _of_core(self, core: Core, n: FloatArray, v: FloatArray) -> Float32Array:
        # R^T n: the light stays as it was
        return _core_radiance(self.light, core, n @ self.rotation, v @ self.rotation)


def _core_radiance(light: Light, core: Core, n: FloatArray, v: FloatArray) -> Float32Array:
    """Return what a core reflects, (n, 3), for directions in the frame of the light."""
    # Queries whose reflections are neighbors descend together.
    order = _neighbors(2 * np.einsum("nc,nc->n", n, v)[:, None] * n - v)
    n, v = np.ascontiguousarray(n[order]), np.ascontiguousarray(v[order])

    radiance = np.empty(n.shape, np.float32)
    radiance[order] = core.descent.radiance(light.pyramid, n, v, n, core.threshold)[0]
    if core.look_up is not None:
        radiance[order] += core.look_up.radiance(light.picture, n, v).astype(np.float32)
    return radiance


def residual_for(
    pixels: Float32Array,
    cores: Sequence[tuple[str, CoreLobe, Center, FloatArray]],
    layout: Layout,
    size: int,
    allowed: float,
) -> tuple[Residual, float]:
    """Prepare the cores of a material's lobes.

    Parameters
    ----------
    pixels : (H, W, 3) float32
        The light.
    cores : sequence of (name, lobe, center, gamma)
        Lobes, with the name, the center and gamma of the map that each belongs to.
    layout, size
        Grid and size of the maps.
    allowed : float
        The mean square error that is allowed to all together, over frames of every orientation and
        cos^2(theta_v) uniform, channels summed.

    Returns
    -------
    Residual, and the mean square error, measured at a sample of frames.
    """
    # Texels, cut for the narrowest core
    H, W, _ = pixels.shape
    texel = max(np.pi / H, 2 * np.pi / W)
    narrowest = min(half_width(lobe) for _, lobe, _, _ in cores)
    cut = int(np.clip(np.ceil(CUT_TO * texel / narrowest), 1, max(LARGEST_CUT // max(H, W), 1)))
    light = Light(pixels, cut)
    chosen: list[tuple[str, Core]] = []
    error = 0.0
    for name, lobe, center, gamma in cores:
        # The part that the texels resolve, and a mirror for what is narrower
        resolved, narrow = _at_width(lobe, RESOLVED * texel / cut)
        descent = _descent(resolved)
        look_up = None if narrow is None else LookUp.of(narrow)

        # The first threshold that suffices, or the last that helps
        frames = Frames.of(pixels, lobe)
        tried: list[tuple[float, Core]] = []
        for threshold in THRESHOLDS:
            core = Core(center, gamma, descent, threshold, look_up)
            square = frames.error(_core_radiance(light, core, frames.normals, frames.views))
            tried.append((square, core))
            if square <= allowed / len(cores) or (len(tried) > 1 and square > 0.8 * tried[-2][0]):
                break
        square, core = min(tried, key=lambda trial: trial[0])
        error += square
        chosen.append((name, core))
    return Residual(light, tuple(chosen), layout, size, np.eye(3)), error


def _descent(lobe: CoreLobe) -> IsotropicDescent | RadialDescent:
    """Tabulate a core for descent."""
    if isinstance(lobe, IsotropicLobe):
        return IsotropicDescent.of_core(lobe)
    return RadialDescent.of(lobe.center, lobe.profile)


def _at_width(lobe: CoreLobe, width: float) -> tuple[CoreLobe, CoreLobe | None]:
    """Split off what makes a lobe narrower than an angle, with the least height that does."""
    if half_width(lobe) >= width:
        return lobe, None
    low, high = -12.0, 24.0  # logarithms of heights
    while high - low > 0.2:
        middle = 0.5 * (low + high)
        if half_width(split(lobe, float(np.exp(middle)))[0]) >= width:
            low = middle
        else:
            high = middle
    return split(lobe, float(np.exp(low)))


def _neighbors(directions: FloatArray) -> npt.NDArray[np.intp]:
    """Return an order of directions (n, 3) in which neighbors on the sphere follow each other.

    It runs to and fro along bands of equal z.
    """
    side = int(np.clip(np.sqrt(len(directions) / _core.HIERARCHICAL_BLOCK), 1, 512))
    band = np.clip((0.5 * (1 + directions[:, 2]) * side).astype(int), 0, side - 1)
    turn = (np.arctan2(directions[:, 1], directions[:, 0]) / (2 * np.pi) + 0.5) * side
    return np.lexsort((np.where(band % 2 == 0, turn, -turn), band))
