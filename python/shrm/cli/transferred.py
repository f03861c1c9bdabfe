"""An object with transfer, as the commands open and draw it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from shrm.cli.console import progress
from shrm.cli.options import flag
from shrm.cli.stage import Stage

if TYPE_CHECKING:
    from shrm.arrays import FloatArray
    from shrm.render import Camera, Object
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
    for name, default in {
        **OF_MAPS,
        **dict.fromkeys(("tolerance", "orders", "residual", "max_orders")),
    }.items():
        if getattr(options, name) != default:
            said = f"--{options.row[0][0]}" if name == "row" else flag(name)
            raise argparse.ArgumentError(
                None, f"{said} cannot go with {options.transfer}, which has mesh and material"
            )


def opened(
    path: str, options: argparse.Namespace, variants: Sequence[str | None]
) -> tuple[RadianceTransfer, list[Lighting]]:
    """Open an object with transfer, and choose of its variants what the options say; None: the default one.

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
            lit = [transfer.lighting(one, K=options.components, M=options.tents) for one in variants]
        except ValueError as fault:
            raise argparse.ArgumentError(None, f"{path}: {fault}") from None
    return transfer, lit


class TransferredStage(Stage):
    """Variants of an object with transfer in a row, their light and the camera, as the options have them."""

    def __init__(self, options: argparse.Namespace) -> None:
        from shrm.render import TransferredMesh

        transfer, self.lighting = opened(options.transfer, options, options.variant or [None])
        if options.texture is not None and transfer.uv is None:
            raise ValueError(f"{options.transfer}: it has no texture coordinates for --texture")
        super().__init__(options, len(self.lighting))
        self.row = [TransferredMesh.placed(transfer, center, turn=options.turn) for center in self.centers]

    def objects(self, rotation: FloatArray, camera: Camera) -> list[Object]:
        """Return them, lit for the camera."""
        from shrm.render import Object

        coefficients = self.env.coefficients(self.row[0].transfer.n - 1)
        light = self.row[0].light(coefficients, rotation, self.options.window)
        return [
            Object(thing.mesh, thing.lit(lighting, light, camera, self.options.viewer), self.texture)
            for thing, lighting in zip(self.row, self.lighting, strict=True)
        ]
