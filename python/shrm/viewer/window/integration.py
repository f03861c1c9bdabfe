"""The same picture by direct integration, coarse first: the judge of maps and of transfer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from shrm import brdf, sh
from shrm.arrays import Float32Array, FloatArray
from shrm.environment import Environment
from shrm.frequency.request import Window
from shrm.integrate.angular import integrate, prefilter_angular
from shrm.render.camera import Camera, Viewer
from shrm.render.picture import Object, Picture, SupportsRadiance, render
from shrm.render.shapes import Shape
from shrm.render.transferred import low_degrees
from shrm.viewer.window.state import Rows
from shrm.viewer.window.worker import StaleError

ROWS = 128
"""Most rows of the light that is integrated: every pixel visits all of its texels."""
SMOOTH_ROWS = 32
"""Rows of light of a low order, which has no detail."""
COARSENESS = (16, 8, 4, 2, 1)
"""Screen pixels across a pixel that is integrated, pass by pass."""
AT_ONCE = 256
"""Points that are integrated before asking whether the picture is still wanted."""


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
    shape : (H, W)
        Rows and columns of the window's picture in pixels.
    n : int, optional
        Order of the light: its degrees 0 to n - 1 alone are integrated, all of it without one.
    window : {"hann", "lanczos"}, optional
        On these degrees.
    """

    environment: Environment
    light: Rows
    materials: tuple[str, ...]
    shapes: tuple[Shape, ...]
    camera: Camera
    viewer: Viewer
    shape: tuple[int, int]
    n: int | None = None
    window: Window | None = None


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
        self._light: tuple[tuple[Environment, int | None, Window | None], Environment] | None = None

    def __call__(self, question: Question, stale: Callable[[], bool]) -> Iterator[Integrated]:
        """Yield the picture, ever finer [RH02 eq. 10].

        Raises
        ------
        StaleError
            If there is a newer question.
        """
        key = question.environment, question.n, question.window
        if self._light is None or self._light[0] != key:
            self._light = key, _coarse(*key)
        light = self._light[1]
        objects = []
        for text, shape in zip(question.materials, question.shapes, strict=True):
            reflection = _integral(light, brdf.parse(text))
            objects.append(Object(shape, _Turned(reflection, np.asarray(question.light, np.float64), stale)))
        for coarseness in COARSENESS:
            H, W = (max(1, side // coarseness) for side in question.shape)
            picture = render(objects, question.camera, (H, W), viewer=question.viewer, samples=1)
            yield Integrated(question, picture, coarseness)


def _coarse(environment: Environment, n: int | None, window: Window | None) -> Environment:
    """Return the light with as many texels as every pixel can visit."""
    if n is not None:
        low = low_degrees(environment.coefficients(n - 1), n, window)
        return Environment(sh.synthesis(low, (SMOOTH_ROWS, 2 * SMOOTH_ROWS)).astype(np.float32))
    H = environment.pixels.shape[0]
    return environment.resized((ROWS, 2 * ROWS)) if H > ROWS else environment


def _integral(light: Environment, material: brdf.BRDF) -> SupportsRadiance:
    """Return what integrates a material: from tables of its lobes, or plainly where one is anisotropic."""
    if any(lobe.kind == "anisotropic" for lobe in material.lobes):
        return _PlainSum(light, material)
    return prefilter_angular(light, material, cutoff=0.002)


class _PlainSum:
    """A material whose value is found anew for every texel."""

    def __init__(self, light: Environment, material: brdf.BRDF) -> None:
        self._light, self._material = light, material

    def radiance(
        self, normals: Float32Array, views: Float32Array, tangents: Float32Array | None = None
    ) -> Float32Array:
        """Reflected radiance (n, 3)."""
        return integrate(self._light, self._material, normals, views, tangents).astype(np.float32)


class _Turned:
    """A material under a turned light: the frames are turned back instead. Stops when it is not wanted."""

    def __init__(self, reflection: SupportsRadiance, R: FloatArray, stale: Callable[[], bool]) -> None:
        self._reflection, self._stale = reflection, stale
        self._light_from_world = R.T

    def radiance(
        self, normals: Float32Array, views: Float32Array, tangents: Float32Array | None = None
    ) -> Float32Array:
        """Reflected radiance (n, 3)."""
        radiance = np.empty(normals.shape, np.float32)
        for first in range(0, len(normals), AT_ONCE):
            if self._stale():
                raise StaleError
            block = slice(first, first + AT_ONCE)
            radiance[block] = self._reflection.radiance(
                self._back(normals[block]),
                self._back(views[block]),
                None if tangents is None else self._back(tangents[block]),
            )
        return radiance

    def _back(self, directions: Float32Array) -> Float32Array:
        turned = directions.astype(np.float64) @ self._light_from_world.T
        return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True), np.float32)
