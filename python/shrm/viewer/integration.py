"""The same picture by direct integration, coarse first: the judge of the maps.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm import brdf
from shrm.environment import Environment
from shrm.reference import AngularReflection, prefilter_angular
from shrm.render.camera import Camera, FloatArray
from shrm.render.picture import Object, Picture, render
from shrm.render.shapes import Shape
from shrm.viewer.scene import Viewer
from shrm.viewer.state import Rows
from shrm.viewer.worker import StaleError

Directions = npt.NDArray[np.float32]

ROWS = 128  # of the light that is integrated: every pixel visits all of its texels
COARSENESS = (16, 8, 4, 2, 1)  # screen pixels across one that is integrated
AT_ONCE = 256  # points between two questions whether they are still wanted


@dataclass(frozen=True)
class Question:
    """A picture to be integrated.

    Attributes
    ----------
    environment : Environment
    light : 3 x 3 floats
        How it is turned, see `State`.
    materials : tuple of str
    shapes : tuple of shapes
        One for each material.
    camera : Camera
    viewer : {"near", "distant"}
    width, height : int
        Extent of the window's picture in pixels.
    """

    environment: Environment
    light: Rows
    materials: tuple[str, ...]
    shapes: tuple[Shape, ...]
    camera: Camera
    viewer: Viewer
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class Integrated:
    """A picture that was integrated, at a part of the window's resolution.

    Attributes
    ----------
    question : Question
    picture : Picture
        Objects alone, multiplied by their coverage.
    coarseness : int
        Screen pixels across one of its pixels; 1 is the last.
    """

    question: Question
    picture: Picture
    coarseness: int


class Integration:
    """Answers questions in one thread, and keeps the light that was made ready."""

    def __init__(self) -> None:
        self._source: Environment | None = None
        self._light: Environment | None = None

    def __call__(self, question: Question, stale: Callable[[], bool]) -> Iterator[Integrated]:
        """Yield the picture, ever finer [RH02 eq. 10].

        Raises
        ------
        StaleError
            If there is a newer question.
        """
        if question.environment is not self._source:
            H = question.environment.pixels.shape[0]
            coarse = question.environment.resized(ROWS, 2 * ROWS) if H > ROWS else question.environment
            self._source, self._light = question.environment, coarse
        assert self._light is not None
        objects = []
        for text, shape in zip(question.materials, question.shapes, strict=True):
            reflection = prefilter_angular(self._light, brdf.parse(text), tolerance=0.002)
            objects.append(Object(shape, _Turned(reflection, np.asarray(question.light, np.float64), stale)))
        for coarseness in COARSENESS:
            extent = (max(1, side // coarseness) for side in (question.width, question.height))
            picture = render(objects, question.camera, *extent, viewer=question.viewer, samples=1)
            yield Integrated(question, picture, coarseness)


class _Turned:
    """A material under a turned light: the frames are turned back instead. Stops when it is not wanted."""

    def __init__(self, reflection: AngularReflection, R: FloatArray, stale: Callable[[], bool]) -> None:
        self._reflection, self._stale = reflection, stale
        self._light_from_world = R.T

    def radiance(
        self, normals: Directions, views: Directions, tangents: Directions | None = None
    ) -> Directions:
        """Reflected radiance (n, 3)."""
        radiance = np.empty(normals.shape, np.float32)
        for first in range(0, len(normals), AT_ONCE):
            if self._stale():
                raise StaleError
            some = slice(first, first + AT_ONCE)
            radiance[some] = self._reflection.radiance(
                self._back(normals[some]),
                self._back(views[some]),
                None if tangents is None else self._back(tangents[some]),
            )
        return radiance

    def _back(self, directions: Directions) -> FloatArray:
        turned = directions.astype(np.float64) @ self._light_from_world.T
        return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True))
