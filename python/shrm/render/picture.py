"""The renderer: first hits, reflected radiance, background.

Materials know no shadows and no interreflection; radiance at vertices has what was precomputed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt

from shrm.arrays import BoolArray, Float32Array, FloatArray
from shrm.environment.lookup import environment_lookup, texture_lookup
from shrm.render.camera import Camera, Vector, Viewer
from shrm.render.line_field import VERTICAL, orthogonalised, tangents_around
from shrm.render.mesh import Mesh
from shrm.render.shapes import Hits, Shape
from shrm.render.vertex_radiance import VertexRadiance
from shrm.transfer.precomputation import MeshLike
from shrm.validation import float32_array, one_of, picture_shape, real_array, require_instance, whole_number
from shrm.vectors import unit

RAYS_AT_ONCE = 1 << 17
"""Rays traced together: they bound the memory of a picture of any size to some tens of megabytes."""
MOST_SAMPLES = 64
"""Samples to a side of a pixel: as many as on the GPU."""

Shading = Literal["sample", "pixel"]
"""Whether materials are asked once for each ray, or once for each object in a pixel."""


class SupportsRadiance(Protocol):
    """A material as the renderer needs it: every `shrm.lobes.reflection.Reflection`, or your own."""

    def radiance(
        self,
        normals: Float32Array,
        views: Float32Array,
        tangents: Float32Array | None = None,
    ) -> Float32Array:
        """Return reflected radiance (n, 3); arguments are (n, 3) unit vectors, views from surface to eye."""
        ...


class Background(Protocol):
    """What is seen behind the objects: `shrm.Environment`."""

    @property
    def pixels(self) -> Float32Array:
        """Lat-long picture, (H, W, 3) float32."""
        ...


@dataclass(frozen=True, eq=False, init=False)
class Object:
    """A shape with its material.

    Parameters
    ----------
    shape : Shape or trimesh.Trimesh
        The latter becomes a `Mesh` (`Mesh.from_trimesh`); what draws it often does that once, beforehand.
    material : SupportsRadiance or VertexRadiance
        The latter on a mesh, with a row for each of its vertices.
    texture : (H, W, 3) array_like, optional
        Linear; multiplies the reflected light [RH02 sec. 3]. (u, v) = (0, 1) is its upper left corner.
    axis : 3 floats
        Tangents, which only materials centered on them use, run around this axis, unless the shape has a
        tangent field of its own (`Mesh.with_tangents`).

    Raises
    ------
    TypeError, ValueError
        If the shape is none, the texture is no picture or the axis no direction, or if radiance is given at
        vertices and the shape is no mesh or has another number of them.
    """

    shape: Shape
    material: SupportsRadiance | VertexRadiance
    texture: Float32Array | None
    axis: Vector

    def __init__(
        self,
        shape: Shape | MeshLike,
        material: SupportsRadiance | VertexRadiance,
        texture: npt.ArrayLike | None = None,
        axis: Vector = VERTICAL,
    ) -> None:
        drawn = shape if hasattr(shape, "intersect") else Mesh.from_trimesh(shape)
        if isinstance(material, VertexRadiance):
            require_instance("shape", drawn, Mesh, what="a Mesh where radiance is given at vertices")
            assert isinstance(drawn, Mesh)
            material.require_vertices(len(drawn.vertices))
        elif not hasattr(material, "radiance"):
            raise TypeError(
                f"material must have radiance(normals, views, tangents), got {type(material).__name__}"
            )
        if texture is not None:
            texture = float32_array("texture", texture, ("H", "W", 3), empty=False)
        real_array("axis", axis, (3,))
        for name, value in (("shape", drawn), ("material", material), ("texture", texture), ("axis", axis)):
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        """Say shape and material, and whether there is a texture."""
        texture = "" if self.texture is None else ", texture {} x {}".format(*self.texture.shape)
        return f"<Object: {self.shape!r}, {self.material!r}{texture}>"


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

    def __repr__(self) -> str:
        """Say rows and columns, and how much of the picture objects cover."""
        H, W = self.coverage.shape
        return f"<Picture: {H} x {W} pixels, {self.coverage.mean():.0%} covered>"


def render(
    objects: Sequence[Object],
    camera: Camera,
    shape: tuple[int, int],
    *,
    background: Background | None = None,
    viewer: Viewer = "near",
    samples: int = 2,
    shading: Shading = "sample",
    progress: Callable[[float], None] | None = None,
) -> Picture:
    """Render objects lit through their prefiltered materials.

    Parameters
    ----------
    objects : sequence of Object
    camera : Camera
    shape : (H, W)
        Rows and columns of the picture in pixels.
    background : Background, optional
        Environment to show behind the objects; black without one.
    viewer : {"near", "distant"}
        Whether each pixel has its own view vector or all have the camera's.
    samples : int
        samples x samples rays per pixel, averaged; at most 64.
    shading : {"sample", "pixel"}
        Whether materials are asked once for each ray, or once for each object in a pixel, at the mean
        normal: right where shapes and reflections are smooth over a pixel, and samples^2 times faster.
    progress : callable, optional
        Called with the part of the work that is done, up to 1.

    Returns
    -------
    Picture

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    # What is given is checked here, and trusted below.
    for index, obj in enumerate(objects):
        require_instance(f"objects[{index}]", obj, Object)
    require_instance("camera", camera, Camera)
    H, W = picture_shape("shape", shape)
    samples = whole_number("samples", samples, 1, MOST_SAMPLES)
    one_of("viewer", viewer, get_args(Viewer))
    one_of("shading", shading, get_args(Shading))

    # Bands of rows, so that memory does not grow with the picture.
    radiance = np.empty((H, W, 3), np.float32)
    coverage = np.empty((H, W), np.float32)
    band = max(1, RAYS_AT_ONCE // (W * samples**2))
    for top in range(0, H, band):
        bottom = min(top + band, H)
        rows = (np.arange(top * samples, bottom * samples) + 0.5) / samples
        columns = (np.arange(W * samples) + 0.5) / samples
        grid = np.meshgrid(columns, rows)
        origins, directions = camera.rays(grid[0].ravel(), grid[1].ravel(), (H, W))

        # Rays that share a point ask a material once.
        by_sample = (bottom - top, samples, W, samples)
        points = np.arange(len(directions))
        if shading == "pixel":
            pixels = np.arange((bottom - top) * W).reshape(bottom - top, 1, W, 1)
            points = np.broadcast_to(pixels, by_sample).ravel()
        views = np.broadcast_to(-camera.forward, directions.shape) if viewer == "distant" else -directions

        colors, covered = _trace(objects, origins, directions, views, points, background)
        radiance[top:bottom] = colors.reshape(*by_sample, 3).mean(axis=(1, 3))
        coverage[top:bottom] = covered.reshape(by_sample).mean(axis=(1, 3))
        if progress is not None:
            progress(bottom / H)
    return Picture(radiance, coverage)


def _trace(
    objects: Sequence[Object],
    origins: FloatArray,
    directions: FloatArray,
    views: FloatArray,
    points: npt.NDArray[np.intp],
    background: Background | None,
) -> tuple[Float32Array, BoolArray]:
    """Return the radiance (n, 3) along rays, and whether they hit an object (n,).

    Rays of the same point that hit the same object share one evaluation of its material.
    """
    # The object that each ray meets first, -1 for none.
    all_hits = [obj.shape.intersect(origins, directions) for obj in objects]
    nearest = np.full(len(directions), np.inf)
    first = np.full(len(directions), -1)
    for index, hits in enumerate(all_hits):
        closer = hits.distances < nearest
        nearest[closer], first[closer] = hits.distances[closer], index

    radiance = np.zeros((len(directions), 3), np.float32)
    missed = first < 0
    if background is not None and missed.any():
        radiance[missed] = environment_lookup(background.pixels, directions[missed])

    for index, (obj, hits) in enumerate(zip(objects, all_hits, strict=True)):
        seen = np.flatnonzero(first == index)
        if len(seen):
            if isinstance(obj.material, VertexRadiance):
                reflected = _interpolated(obj.material, hits, seen)
            else:
                reflected = _reflected(obj, obj.material, hits, seen, views, points)
            if obj.texture is not None:
                reflected = reflected * texture_lookup(obj.texture, hits.uv[seen])
            radiance[seen] = reflected
    return radiance, ~missed


def _reflected(
    obj: Object,
    material: SupportsRadiance,
    hits: Hits,
    seen: npt.NDArray[np.intp],
    views: FloatArray,
    points: npt.NDArray[np.intp],
) -> Float32Array:
    """Return the reflected radiance (k, 3) of rays that see an object; those of the same point ask once."""
    # Means over the rays of each point: of normals and views, then of tangents, whose signs mean nothing.
    _, a_ray, point = np.unique(points[seen], return_index=True, return_inverse=True)
    normals, toward_eye = (unit(_sums(x[seen], point, len(a_ray))) for x in (hits.normals, views))
    if hits.tangents is None:
        tangents = tangents_around(obj.axis, normals)
    else:
        lines = _same_sign(hits.tangents[seen], hits.tangents[seen[a_ray]][point])
        means = _sums(lines, point, len(a_ray)) / np.bincount(point)[:, None]
        tangents = orthogonalised(means, normals, obj.axis)
    return material.radiance(_single(normals), _single(toward_eye), tangents=_single(tangents))[point]


def _interpolated(material: VertexRadiance, hits: Hits, seen: npt.NDArray[np.intp]) -> Float32Array:
    """Return the radiance (k, 3) of the rays that see an object, from its vertices."""
    assert hits.corners is not None  # the shape is a mesh
    assert hits.weights is not None
    return material.at(hits.corners[seen], hits.weights[seen])


def _sums(vectors: FloatArray, group: npt.NDArray[np.intp], groups: int) -> FloatArray:
    """Return the sums (groups, 3) of the vectors of each group."""
    return np.stack([np.bincount(group, vectors[:, k], groups) for k in range(3)], axis=1)


def _same_sign(tangents: FloatArray, others: FloatArray) -> FloatArray:
    """Return tangents (n, 3), whose sign means nothing, with that of others (n, 3)."""
    opposite = np.einsum("nk,nk->n", tangents, others) < 0.0
    return np.where(opposite[:, None], -tangents, tangents)


def _single(vectors: FloatArray) -> Float32Array:
    """Return vectors in single precision and C order, as materials take them."""
    return np.ascontiguousarray(vectors, np.float32)
