"""The renderer: first hits, reflected radiance, background.

Materials know no shadows and no interreflection; radiance at vertices has what was precomputed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt

from shrm.arrays import BoolArray, Float32Array, FloatArray
from shrm.environment.lookup import environment_lookup, texture_lookup
from shrm.render.camera import Camera, Vector
from shrm.render.line_field import VERTICAL, orthogonalised, tangents_around
from shrm.render.mesh import Mesh
from shrm.render.shapes import Hits, Shape
from shrm.render.vertex_radiance import VertexRadiance
from shrm.vectors import unit

RAYS_AT_ONCE = 1 << 17  # bounds the memory of a picture of any size


class Reflection(Protocol):
    """A prefiltered material: `shrm.ReflectionMap`, the results of the integrators, or your own."""

    def radiance(
        self,
        normals: Float32Array,
        views: Float32Array,
        tangents: Float32Array | None = None,
    ) -> Float32Array:
        """Reflected radiance (n, 3); all arguments (n, 3) unit vectors, views from surface to eye."""
        ...


class Lighting(Protocol):
    """What is seen behind the objects: `shrm.Environment`."""

    @property
    def pixels(self) -> Float32Array:
        """Lat-long picture, (H, W, 3) float32."""
        ...


@dataclass(frozen=True, eq=False)
class Object:
    """A shape with its material.

    Parameters
    ----------
    shape : Shape
    material : Reflection or VertexRadiance
        The latter on a `Mesh`, with a row for each of its vertices.
    texture : (H, W, 3) float32, optional
        Linear; multiplies the reflected light [RH02 sec. 3]. (u, v) = (0, 1) is its upper left corner.
    axis : 3 floats
        Tangents, which only materials centered on them use, run around this axis, unless the shape has a
        tangent field of its own (`Mesh.with_tangents`).

    Raises
    ------
    TypeError, ValueError
        If radiance is given at vertices, and the shape is no mesh or has another number of them.
    """

    shape: Shape
    material: Reflection | VertexRadiance
    texture: Float32Array | None = None
    axis: Vector = VERTICAL

    def __post_init__(self) -> None:
        if isinstance(self.material, VertexRadiance):
            if not isinstance(self.shape, Mesh):
                raise TypeError(f"radiance at vertices needs a Mesh, got {type(self.shape).__name__}")
            self.material.require_vertices(len(self.shape.vertices))


@dataclass(frozen=True, eq=False)
class Picture:
    """A rendered picture.

    Attributes
    ----------
    radiance : (H, W, 3) float32
        Linear. Without a background, multiplied by the coverage.
    coverage : (H, W) float32
        The part of each pixel that objects cover.
    """

    radiance: Float32Array
    coverage: Float32Array


def render(
    objects: Sequence[Object],
    camera: Camera,
    width: int,
    height: int,
    *,
    background: Lighting | None = None,
    viewer: Literal["near", "distant"] = "near",
    samples: int = 2,
    shading: Literal["sample", "pixel"] = "sample",
    progress: Callable[[float], None] | None = None,
) -> Picture:
    """Render objects lit through their prefiltered materials.

    Parameters
    ----------
    objects : sequence of Object
    camera : Camera
    width, height : int
        Extent of the picture in pixels.
    background : Lighting, optional
        Environment to show behind the objects; black without one.
    viewer : "near" or "distant"
        Whether each pixel has its own view vector or all have the camera's.
    samples : int
        samples x samples rays per pixel, averaged.
    shading : "sample" or "pixel"
        Whether materials are asked once for each ray, or once for each object in a pixel, at the mean
        normal: right where shapes and reflections are smooth over a pixel, and samples^2 times faster.
    progress : callable, optional
        Called with the part of the work that is done, up to 1.

    Raises
    ------
    ValueError
        If width, height or samples is not positive, or viewer or shading is another word.
    """
    for name, value in (("width", width), ("height", height), ("samples", samples)):
        if value < 1:
            raise ValueError(f"{name} is {value}, but needs to be at least 1")
    for name, word, words in (
        ("viewer", viewer, ("near", "distant")),
        ("shading", shading, ("sample", "pixel")),
    ):
        if word not in words:
            raise ValueError(f"{name} is {word!r}, but needs to be {words[0]!r} or {words[1]!r}")

    radiance = np.empty((height, width, 3), np.float32)
    coverage = np.empty((height, width), np.float32)
    band = max(1, RAYS_AT_ONCE // (width * samples**2))
    for top in range(0, height, band):
        bottom = min(top + band, height)
        rows = (np.arange(top * samples, bottom * samples) + 0.5) / samples
        columns = (np.arange(width * samples) + 0.5) / samples
        grid = np.meshgrid(columns, rows)
        origins, directions = camera.rays(grid[0].ravel(), grid[1].ravel(), width, height)
        shape = (bottom - top, samples, width, samples)
        points = np.arange(len(directions))  # where materials are asked
        if shading == "pixel":
            pixels = np.arange((bottom - top) * width).reshape(bottom - top, 1, width, 1)
            points = np.broadcast_to(pixels, shape).ravel()
        views = np.broadcast_to(-camera.forward, directions.shape) if viewer == "distant" else -directions
        colors, covered = _trace(objects, origins, directions, views, points, background)
        radiance[top:bottom] = colors.reshape(*shape, 3).mean(axis=(1, 3))
        coverage[top:bottom] = covered.reshape(shape).mean(axis=(1, 3))
        if progress is not None:
            progress(bottom / height)
    return Picture(radiance, coverage)


def _trace(
    objects: Sequence[Object],
    origins: FloatArray,
    directions: FloatArray,
    views: FloatArray,
    points: npt.NDArray[np.intp],
    background: Lighting | None,
) -> tuple[Float32Array, BoolArray]:
    """Radiance (n, 3) along rays, and whether they hit an object (n,).

    Rays of the same point that hit the same object share one evaluation of its material.
    """
    all_hits = [thing.shape.intersect(origins, directions) for thing in objects]
    nearest = np.full(len(directions), np.inf)
    first = np.full(len(directions), -1)
    for index, hits in enumerate(all_hits):
        closer = hits.distances < nearest
        nearest[closer], first[closer] = hits.distances[closer], index

    radiance = np.zeros((len(directions), 3), np.float32)
    missed = first < 0
    if background is not None and missed.any():
        radiance[missed] = environment_lookup(background.pixels, directions[missed])
    for index, (thing, hits) in enumerate(zip(objects, all_hits, strict=True)):
        seen = np.flatnonzero(first == index)
        if len(seen):
            if isinstance(thing.material, VertexRadiance):
                reflected = _interpolated(thing.material, hits, seen)
            else:
                reflected = _reflected(thing, thing.material, hits, seen, views, points)
            if thing.texture is not None:
                reflected = reflected * texture_lookup(thing.texture, hits.uv[seen])
            radiance[seen] = reflected
    return radiance, ~missed


def _reflected(
    thing: Object,
    material: Reflection,
    hits: Hits,
    seen: npt.NDArray[np.intp],
    views: FloatArray,
    points: npt.NDArray[np.intp],
) -> Float32Array:
    """Reflected radiance (k, 3) of the rays that see an object; those of the same point ask once."""
    _, some, point = np.unique(points[seen], return_index=True, return_inverse=True)
    normals, toward_eye = (unit(_sums(x[seen], point, len(some))) for x in (hits.normals, views))
    if hits.tangents is None:
        tangents = tangents_around(thing.axis, normals)
    else:
        lines = _same_sign(hits.tangents[seen], hits.tangents[seen[some]][point])
        means = _sums(lines, point, len(some)) / np.bincount(point)[:, None]
        tangents = orthogonalised(means, normals, thing.axis)
    return material.radiance(_single(normals), _single(toward_eye), tangents=_single(tangents))[point]


def _interpolated(material: VertexRadiance, hits: Hits, seen: npt.NDArray[np.intp]) -> Float32Array:
    """Radiance (k, 3) of the rays that see an object, from its vertices."""
    assert hits.corners is not None  # the shape is a mesh
    assert hits.weights is not None
    return material.at(hits.corners[seen], hits.weights[seen])


def _sums(vectors: FloatArray, group: npt.NDArray[np.intp], groups: int) -> FloatArray:
    """Sums (groups, 3) of the vectors of each group."""
    return np.stack([np.bincount(group, vectors[:, k], groups) for k in range(3)], axis=1)


def _same_sign(tangents: FloatArray, others: FloatArray) -> FloatArray:
    """Tangents (n, 3), whose sign means nothing, with that of others (n, 3)."""
    opposite = np.einsum("nk,nk->n", tangents, others) < 0.0
    return np.where(opposite[:, None], -tangents, tangents)


def _single(vectors: FloatArray) -> Float32Array:
    return np.ascontiguousarray(vectors, np.float32)
