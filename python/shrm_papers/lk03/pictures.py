"""Pictures of an object that is lit at its vertices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.render import Camera, Mesh, Object, Picture, VertexRadiance, render
from shrm.transfer.lighting import Lighting

from shrm_papers.lk03.subject import Subject, n
from shrm_papers.result import Settings
from shrm_papers.spheres import picture_error

AZIMUTH, ELEVATION, DISTANCE = 25.0, 20.0, 6.0
"""Degrees of the camera's direction, as in `shrm.render.row_camera`, and its distance."""

PICTURE, SAMPLES = 360, 2
"""Pixels across a picture, and samples along each side of a pixel."""

MARGIN, RAISED = 1.04, 0.08
"""The picture's extent, and how far the object is moved up for a line of text below, over the object's."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture and its relative RMS error, colors pooled; 0 for the correct one."""

    picture: Picture
    error: float = 0.0


class Stage:
    """An object, the light around it, and a camera.

    Parameters
    ----------
    subject : Subject
    settings : Settings

    Attributes
    ----------
    light : (n^2, 3) float64
    eye : (3,) float64
    """

    def __init__(self, subject: Subject, settings: Settings) -> None:
        self._mesh = subject.mesh
        self._camera = framed(self._mesh)
        self._pixels = 60 if settings.quick else PICTURE
        self.light = np.asarray(settings.env.coefficients(n - 1), np.float64)
        self.eye = np.asarray(self._camera.position)

    @cached_property
    def visible(self) -> IntArray:
        """Indices of the vertices of the faces that the camera's rays meet, ascending."""
        along = (np.arange(self._pixels * SAMPLES) + 0.5) / SAMPLES
        columns, rows = np.meshgrid(along, along)
        rays = self._camera.rays(columns.ravel(), rows.ravel(), (self._pixels, self._pixels))
        hits = self._mesh.intersect(*rays)
        assert hits.corners is not None
        return np.unique(hits.corners[np.isfinite(hits.distances)])

    def shot(self, radiance: Float32Array, truth: Shot | None = None) -> Shot:
        """Draw the object with radiance (V, 3) at its vertices; measure the error against another shot."""
        shaded = Object(self._mesh, VertexRadiance(radiance))
        picture = render([shaded], self._camera, (self._pixels, self._pixels), samples=SAMPLES)
        return Shot(picture, 0.0 if truth is None else picture_error(picture, truth.picture))

    def lit(self, lighting: Lighting, truth: Shot | None = None) -> Shot:
        """Light the object and draw it."""
        return self.shot(lighting.radiance(self.light, eye=self.eye), truth)


def framed(mesh: Mesh) -> Camera:
    """Return a camera whose square picture a mesh near the origin fills."""
    # The direction first, then where to look, then the field of view
    across, down = np.radians(AZIMUTH), np.radians(ELEVATION)
    forward = np.array([np.cos(across) * np.cos(down), np.sin(across) * np.cos(down), -np.sin(down)])
    position = -DISTANCE * forward
    camera = Camera(_vector(position))
    slopes = _slopes(camera, mesh)
    low, high = slopes.min(axis=0), slopes.max(axis=0)
    right, up = (low + high) / 2
    aim = np.array([right, up - RAISED * float((high - low).max()) / 2, 1.0])
    camera = Camera(_vector(position), _vector(position + aim @ camera.axes))
    reach = MARGIN * np.abs(_slopes(camera, mesh)).max()
    return Camera(camera.position, camera.target, fov=2 * float(np.degrees(np.arctan(reach))))


def _slopes(camera: Camera, mesh: Mesh) -> FloatArray:
    """Return where vertices appear, (V, 2): to the right and upwards, over their depth."""
    place = (mesh.vertices - np.asarray(camera.position)) @ camera.axes.T
    return np.asarray(place[:, :2] / place[:, 2:])


def _vector(v: FloatArray) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])
