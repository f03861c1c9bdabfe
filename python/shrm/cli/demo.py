"""Render a row of spheres, from diffuse to near-mirror, and compare it with direct integration.

Writes the pictures, their difference and the reflection maps to a folder, and prints orders, predicted error,
measured error and time of each material. Needs no file.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from shrm.cli import values
from shrm.cli.console import progress

EXAMPLE = "shrm demo -o demo"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    command.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("demo"),
        metavar="DIR",
        help="folder to write (default: demo)",
    )
    command.add_argument(
        "--size", type=values.count, default=144, metavar="N", help="pixels across a sphere (default: 144)"
    )


def run(options: argparse.Namespace) -> None:
    """Write the folder and print the table."""
    from shrm.cli.demonstration import make_demo

    with progress("Prefiltering and drawing") as report:
        rows = make_demo(options.output, options.size, report)

    print(f"{'':8}{'material':39}{'F':>3}{'P':>3}{'predicted':>10}{'measured':>9}{'ms':>6}")
    for row in rows:
        print(
            f"{row.name:8}{row.material:39}{row.F:3}{row.P:3}"
            f"{row.predicted:10.2%}{row.measured:9.2%}{row.milliseconds:6.0f}"
        )
    print(f"{options.output}: spheres.png, integrated.png, difference.png, difference-x16.png and the maps")
