"""An object with transfer, as `shrm render` draws it."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

from shrm.cli.console import progress
from shrm.cli.options import flag, read_environment

if TYPE_CHECKING:
    from shrm.render import Picture
    from shrm.viewer import Renderer

OF_MAPS = {"row": None, "mesh": None, "up": "y", "tangents": "axis", "method": "shrm"}
"""What an object with transfer has already or has no use for, with what these are if nobody gives them."""


def require_none_of_maps(options: argparse.Namespace) -> None:
    """Refuse options that an object with transfer cannot have.

    Raises
    ------
    argparse.ArgumentError
        If one is given.
    """
    for name, default in {**OF_MAPS, "tolerance": None, "orders": None}.items():
        if getattr(options, name) != default:
            said = f"--{options.row[0][0]}" if name == "row" else flag(name)
            raise argparse.ArgumentError(
                None, f"{said} cannot go with {options.transfer}, which has mesh and material"
            )


class TransferredStage:
    """An object with transfer, its light and the camera, as the options have them."""

    def __init__(self, options: argparse.Namespace) -> None:
        from shrm import image_io
        from shrm.render import TransferredMesh, row_camera, row_picture
        from shrm.render.transferred import load

        self.options = options
        with progress("Opening the object"):
            transfer = load(options.transfer)
        try:
            self.lighting = transfer.lighting(options.variant, K=options.components, M=options.tents)
        except ValueError as fault:
            raise argparse.ArgumentError(None, f"{options.transfer}: {fault}") from None
        if options.texture is not None and transfer.uv is None:
            raise ValueError(f"{options.transfer}: it has no texture coordinates for --texture")
        self.thing = TransferredMesh.placed(transfer, turn=options.turn)
        self.env = read_environment(options)
        self.texture = None if options.texture is None else image_io.read_image(options.texture).pixels
        extent: tuple[int, int] = options.size or row_picture(1, diameter=320)
        self.width, self.height = extent
        azimuth, elevation = options.view
        self.camera, _ = row_camera(1, self.width / self.height, azimuth, elevation, options.fov)

    def draw(self, degrees: float, report: Callable[[float], None] | None) -> Picture:
        """Draw it turned, as the turntable has it."""
        from shrm.render import Object, about_vertical, render, turned_camera

        options, thing, camera = self.options, self.thing, self.camera
        turn = options.light_turn or 0.0
        if options.turntable == "light":
            turn += degrees
        elif options.turntable == "camera":
            camera = turned_camera(camera, degrees)
        rotation = about_vertical(turn)
        light = thing.light(self.env.coefficients(thing.transfer.n - 1), rotation)
        seen = Object(thing.mesh, thing.lit(self.lighting, light, camera, options.viewer), self.texture)
        background = self.env if options.background else None
        if options.gpu:
            from shrm.viewer import Scene

            return self._renderer.render(Scene([seen], camera, background, options.viewer, rotation))
        if background is not None and turn % 360.0 != 0.0:
            background = background.rotated(rotation)
        return render(
            [seen],
            camera,
            self.width,
            self.height,
            background=background,
            viewer=options.viewer,
            samples=options.samples,
            progress=report,
        )

    @cached_property
    def _renderer(self) -> Renderer:
        from shrm.viewer import Renderer

        return Renderer((self.width, self.height), samples=self.options.samples)
