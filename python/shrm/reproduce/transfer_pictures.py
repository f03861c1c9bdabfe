"""Pictures of an object that is lit at its vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm.render import Object, Picture, VertexRadiance, render, row_camera
from shrm.reproduce.result import Settings
from shrm.reproduce.spheres import relative_rms
from shrm.reproduce.transfer_subject import Subject, n
from shrm.transfer.lighting import Lighting

Float32Array = npt.NDArray[np.float32]

AZIMUTH, ELEVATION = 25.0, 20.0
PICTURE = 360
FIELD = 27.0


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture, and how far it is off another: relative RMS, colours pooled; 0 for the correct one."""

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
        self._subject = subject
        self._camera, _ = row_camera(1, 1.0, AZIMUTH, ELEVATION, FIELD)
        self._pixels = 60 if settings.quick else PICTURE
        self.light = np.asarray(settings.env.coefficients(n - 1), np.float64)
        self.eye = np.asarray(self._camera.position)

    def shot(self, radiance: Float32Array, truth: Shot | None = None) -> Shot:
        """Take a picture of the object with this radiance (V, 3) of its vertices; judge it by another."""
        thing = Object(self._subject.mesh, VertexRadiance(radiance))
        picture = render([thing], self._camera, self._pixels, self._pixels)
        return Shot(picture, 0.0 if truth is None else relative_rms(picture, truth.picture))

    def lit(self, lighting: Lighting, truth: Shot | None = None) -> Shot:
        """Light the object and take a picture."""
        return self.shot(lighting.radiance(self.light, eye=self.eye), truth)
