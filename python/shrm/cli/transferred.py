"""An object with transfer, as the commands open and draw it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from shrm.cli.console import progress
from shrm.cli.options import flag
from shrm.cli.stage import Stage

if TYPE_CHECKING:
    from shrm.render import Camera, Object
    from shrm.render.camera import FloatArray
    from shrm.transfer.lighting import Lighting
    from shrm.transfer.object import RadianceTransfer

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


def opened(path: str, options: argparse.Namespace) -> tuple[RadianceTransfer, Lighting]:
    """Open an object with transfer, and choose of it what the options say.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read.
    argparse.ArgumentError
        If it has no such variant, or not as many components or tents.
    """
    from shrm.transfer.object import RadianceTransfer

    with progress("Opening the object"):
        transfer = RadianceTransfer.load(path)
        try:
            lighting = transfer.lighting(options.variant, K=options.components, M=options.tents)
        except ValueError as fault:
            raise argparse.ArgumentError(None, f"{path}: {fault}") from None
    return transfer, lighting


class TransferredStage(Stage):
    """An object with transfer, its light and the camera, as the options have them."""

    def __init__(self, options: argparse.Namespace) -> None:
        from shrm.render import TransferredMesh

        transfer, self.lighting = opened(options.transfer, options)
        if options.texture is not None and transfer.uv is None:
            raise ValueError(f"{options.transfer}: it has no texture coordinates for --texture")
        super().__init__(options, 1)
        self.thing = TransferredMesh.placed(transfer, turn=options.turn)

    def objects(self, rotation: FloatArray, camera: Camera) -> list[Object]:
        """Return it, lit for the camera."""
        from shrm.render import Object

        coefficients = self.env.coefficients(self.thing.transfer.n - 1)
        light = self.thing.light(coefficients, rotation, self.options.window)
        lit = self.thing.lit(self.lighting, light, camera, self.options.viewer)
        return [Object(self.thing.mesh, lit, self.texture)]
