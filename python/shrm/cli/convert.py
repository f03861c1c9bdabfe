"""Convert an environment map to another layout or file format.

Every conversion is area-exact: the light of each texel stays where it is, small suns included. The format
follows from the suffix: .exr, .pfm and .tif hold float32, .hdr keeps each value to 0.4%.
"""

from __future__ import annotations

import argparse

from shrm.cli import values
from shrm.cli.console import progress
from shrm.cli.options import LAYOUTS, add_environment, add_output, read_environment

EXAMPLE = "shrm convert probe.hdr --layout vertical-cross -o cross.exr"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(command)
    command.add_argument(
        "--layout",
        choices=LAYOUTS,
        default="latlong",
        metavar="LAYOUT",
        help="layout to write, one of those of --env-layout (default: latlong)",
    )
    command.add_argument(
        "--size",
        type=values.count,
        metavar="N",
        help="rows of a lat-long or round picture, or of a cube's face (default: as fine as the input)",
    )
    command.add_argument(
        "--border",
        type=values.border,
        default=0,
        metavar="N",
        help="texels around each face of a dual paraboloid that is written (default: 0)",
    )
    add_output(command, ".exr", ".hdr", ".pfm", ".tif")


def run(options: argparse.Namespace) -> None:
    """Read, convert, write."""
    with progress("Converting"):
        env = read_environment(options)
        env.write(options.output, layout=options.layout, size=options.size, border=options.border)
    print(f"{options.output}: {options.layout}")
