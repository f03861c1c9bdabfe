"""An object with transfer, as the commands open and draw it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from shrm.cli.console import progress
from shrm.cli.stage import Stage

if TYPE_CHECKING:
    from shrm.arrays import FloatArray
    from shrm.render import Camera, Object
    from shrm.transfer.lighting import Lighting
    from shrm.transfer.radiance_transfer import RadianceTransfer


def open_transfer(
    path: str, options: argparse.Namespace, variants: Sequence[str | None]
) -> tuple[RadianceTransfer, list[Lighting]]:
    """Open an object with transfer and choose the variants, components and tents that the options name.

    Parameters
    ----------
    path : str
        The object's file.
    options : argparse.Namespace
        The options of `shrm.cli.options.add_transfer_choice`.
    variants : sequence of str or None
        Names of variants; None is the most complete one that the object has.

    Returns
    -------
    transfer : RadianceTransfer
    lighting : list of Lighting
        One for each of the variants.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read.
    argparse.ArgumentError
        If the object has no such variant, or not as many components or tents.
    """
    from shrm.transfer.radiance_transfer import RadianceTransfer

    with progress("Opening the object"):
        transfer = RadianceTransfer.load(path)
        try:
            lighting = [
                transfer.lighting(name, components=options.components, tents=options.tents)
                for name in variants
            ]
        except ValueError as fault:
            raise argparse.ArgumentError(None, f"{path}: {fault}") from None
    return transfer, lighting


class TransferStage(Stage):
    """Variants of an object with transfer in a row, their light and the camera, as the options have them."""

    def __init__(self, options: argparse.Namespace) -> None:
        from shrm.render import TransferredMesh

        transfer, self._lighting = open_transfer(options.transfer, options, options.variant or [None])
        if options.texture is not None and transfer.uv is None:
            raise ValueError(f"{options.transfer}: it has no texture coordinates for --texture")
        super().__init__(options, len(self._lighting))
        self._row = [TransferredMesh.placed(transfer, center, turn=options.turn) for center in self.centers]

    def objects(self, rotation: FloatArray, camera: Camera) -> list[Object]:
        """Return the objects under light turned by a rotation (3, 3), lit for the camera."""
        from shrm.render import Object

        coefficients = self.env.coefficients(self._row[0].transfer.n - 1)
        light = self._row[0].light(coefficients, rotation, self.options.window)
        return [
            Object(placed.mesh, placed.lit(lighting, light, camera, self.options.viewer), self.texture)
            for placed, lighting in zip(self._row, self._lighting, strict=True)
        ]
