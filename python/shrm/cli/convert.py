"""Convert an environment map to another layout or file format.

Every conversion is area-exact: the light of each texel stays where it is, small suns included.
The format follows the name: .exr, .pfm and .tif are float32, .hdr keeps each value to 0.4%.
"""

from __future__ import annotations

import argparse

from shrm.cli.console import progress
from shrm.cli.options import LAYOUTS, add_environment, add_output, read_environment, whole

EXAMPLE = "shrm convert probe.hdr --layout vertical-cross -o cross.exr"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(command, layout_flags=("--env-layout",))
    command.add_argument(
        "--layout", choices=LAYOUTS, default="latlong", metavar="L", help="layout to write (default latlong)"
    )
    command.add_argument("--size", type=whole, metavar="N", help="rows of the lat-long picture, or of a face")
    command.add_argument(
        "--border", type=whole, default=0, metavar="N", help="texels round each face of a dual paraboloid"
    )
    command.add_argument(
        "--env-border", type=whole, default=0, metavar="N", help="the same, of the file that is read"
    )
    add_output(command, ".exr", ".hdr", ".pfm", ".tif")


def run(options: argparse.Namespace) -> None:
    """Read, convert, write."""
    with progress("Converting"):
        env = read_environment(options)
        env.write(options.output, layout=options.layout, size=options.size, border=options.border)
    print(f"{options.output}: {options.layout}")
