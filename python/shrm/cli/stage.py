"""The stage of `shrm render`: the light, the camera, and the turntable that turns them."""

from __future__ import annotations

import argparse
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

from shrm.cli.options import read_environment

if TYPE_CHECKING:
    from shrm.arrays import FloatArray
    from shrm.render import Camera, Object, Picture
    from shrm.viewer import Renderer

GPU_MAP_SIZE = 128
"""Edge of a cube map's face in texels: bilinear look-ups, as the GPU's, need finer maps than cubic ones."""


DIAMETER = 320
"""Diameter of an object in the picture by default, pixels."""

FRAMES = 120
"""Default of --frames, the pictures of a turntable."""


class Stage(ABC):
    """Light and camera for a row of objects, as the options of `shrm render` have them.

    Attributes
    ----------
    options : argparse.Namespace
        The options of the command.
    env : Environment
        The light before it is turned.
    texture : (H, W, 3) float32 or None
        The texture that multiplies the reflected light.
    shape : (H, W)
        Rows and columns of the pictures.
    camera : Camera
        The camera before it is turned.
    centers : list of 3 floats
        Positions of the objects, in their radii.
    """

    def __init__(self, options: argparse.Namespace, count: int) -> None:
        from shrm import image_io
        from shrm.render import row_camera, row_shape

        self.options = options
        self.env = read_environment(options)
        self.texture = None if options.texture is None else image_io.read_image(options.texture).pixels
        self.shape: tuple[int, int] = options.shape or row_shape(count, diameter=DIAMETER)
        azimuth, elevation = options.view
        camera, self.centers = row_camera(
            count, self.shape[1] / self.shape[0], azimuth, elevation, options.fov
        )
        self.camera = camera.zoomed(options.zoom)

    @property
    def frames(self) -> int:
        """Number of pictures: one, or those of a turntable."""
        return 1 if self.options.turntable is None else self.options.frames or FRAMES

    @abstractmethod
    def objects(self, rotation: FloatArray, camera: Camera) -> list[Object]:
        """Return the objects under light that is turned by a rotation (3, 3)."""

    def draw(self, degrees: float, report: Callable[[float], None] | None) -> Picture:
        """Draw with the light or the camera turned by an angle, as the turntable has it.

        `report`, if given, is called with the share of the picture that is drawn, 0 to 1.
        """
        from shrm.render import about_vertical, render, turned_camera

        # The turntable
        options, camera, turn = self.options, self.camera, self.options.light_turn or 0.0
        if options.turntable == "light":
            turn += degrees
        elif options.turntable == "camera":
            camera = turned_camera(camera, degrees)
        rotation = about_vertical(turn)

        # The picture, by OpenGL or on the CPU
        objects = self.objects(rotation, camera)
        background = self.env if options.background else None
        if options.gpu:
            from shrm.viewer import Scene

            return self._renderer.render(Scene(objects, camera, background, options.viewer, rotation))
        if background is not None and turn % 360.0 != 0.0:
            background = background.rotated(rotation)
        return render(
            objects,
            camera,
            self.shape,
            background=background,
            viewer=options.viewer,
            samples=options.samples,
            progress=report,
        )

    @cached_property
    def _renderer(self) -> Renderer:
        """The renderer on the GPU, made when the first picture is drawn."""
        from shrm.viewer import Renderer

        return Renderer(self.shape, samples=self.options.samples, map_size=GPU_MAP_SIZE)
