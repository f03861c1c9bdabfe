"""Pictures of an object that is lit at its vertices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.render import Camera, Mesh, Object, Picture, VertexRadiance, render
from shrm.transfer.lighting import Lighting

from shrm_papers.lk03.transfer_subject import Subject, n
from shrm_papers.result import Settings
from shrm_papers.spheres import relative_rms

AZIMUTH, ELEVATION, DISTANCE = 25.0, 20.0, 6.0  # where the camera looks, as in `shrm.render.row_camera`
PICTURE, SAMPLES = 360, 2
MARGIN, LOWERED = 1.04, 0.08  # of half the object's extent: below it there is room for a line of text


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture, and how far it is off another: relative RMS, colors pooled; 0 for the correct one."""

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
    def seen(self) -> IntArray:
        """The vertices of the faces that the camera's rays meet."""
        along = (np.arange(self._pixels * SAMPLES) + 0.5) / SAMPLES
        columns, rows = np.meshgrid(along, along)
        rays = self._camera.rays(columns.ravel(), rows.ravel(), self._pixels, self._pixels)
        hits = self._mesh.intersect(*rays)
        assert hits.corners is not None
        return np.unique(hits.corners[np.isfinite(hits.distances)])

    def shot(self, radiance: Float32Array, truth: Shot | None = None) -> Shot:
        """Take a picture of the object with this radiance (V, 3) of its vertices; judge it by another."""
        thing = Object(self._mesh, VertexRadiance(radiance))
        picture = render([thing], self._camera, self._pixels, self._pixels, samples=SAMPLES)
        return Shot(picture, 0.0 if truth is None else relative_rms(picture, truth.picture))

    def lit(self, lighting: Lighting, truth: Shot | None = None) -> Shot:
        """Light the object and take a picture."""
        return self.shot(lighting.radiance(self.light, eye=self.eye), truth)


def framed(mesh: Mesh) -> Camera:
    """Return a camera whose square picture a mesh near the origin fills."""
    across, down = np.radians(AZIMUTH), np.radians(ELEVATION)
    forward = np.array([np.cos(across) * np.cos(down), np.sin(across) * np.cos(down), -np.sin(down)])
    position = -DISTANCE * forward
    camera = Camera(_vector(position))
    slopes = _slopes(camera, mesh)
    low, high = slopes.min(axis=0), slopes.max(axis=0)
    right, up = (low + high) / 2
    aim = np.array([right, up - LOWERED * float((high - low).max()) / 2, 1.0])
    camera = Camera(_vector(position), _vector(position + aim @ camera.axes))
    reach = MARGIN * np.abs(_slopes(camera, mesh)).max()
    return Camera(camera.position, camera.target, fov=2 * float(np.degrees(np.arctan(reach))))


def _slopes(camera: Camera, mesh: Mesh) -> FloatArray:
    """Where vertices appear, (V, 2): to the right and upwards, over their depth."""
    place = (mesh.vertices - np.asarray(camera.position)) @ camera.axes.T
    return np.asarray(place[:, :2] / place[:, 2:])


def _vector(v: FloatArray) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])
