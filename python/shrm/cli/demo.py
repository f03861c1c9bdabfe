"""Draw a row of spheres, from matt to mirror, and judge it by direct integration.

Leaves a folder with the pictures, their difference and the reflection maps, and prints a table:
orders, predicted error, measured error and time for each material. Needs no file.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from shrm.cli.console import progress
from shrm.cli.options import whole

EXAMPLE = "shrm demo -o demo"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    command.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("demo"),
        metavar="DIR",
        help="folder to write (default demo)",
    )
    command.add_argument(
        "--size", type=whole, default=128, metavar="N", help="pixels across a sphere (default 128)"
    )


def run(options: argparse.Namespace) -> None:
    """Make the folder and print the table."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    from shrm.demo import make_demo

    with progress("Prefiltering and drawing") as report:
        rows = make_demo(options.output, options.size, report)

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("sphere")
    table.add_column("material", no_wrap=True)
    for title in ("F", "P", "predicted", "measured", "ms"):
        table.add_column(title, justify="right")
    for row in rows:
        table.add_row(
            row.name,
            row.material,
            str(row.F),
            str(row.P),
            f"{row.predicted:.2%}",
            f"{row.measured:.2%}",
            f"{row.milliseconds:.0f}",
        )
    Console().print(table)
    print(f"{options.output}: spheres.png, integrated.png, difference.png, difference-x16.png and the maps")
