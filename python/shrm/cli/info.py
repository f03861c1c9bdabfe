"""Describe an environment map, a material, a reflection map or an object with transfer.

An environment: its size, range and mean radiance, and how its energy is spread over the degrees of spherical
harmonics. A result of prefiltering: its material, maps and error. An object with transfer: its material, what
its file holds and how accurate it is. A material: its lobes, its albedo and the orders it needs; if it was
measured, how far it is from reciprocal, whether it reflects more than it receives, and where there are no
data. With --plot, a figure of the material: its lobes, its spectrum, what orders capture of it, and a sphere
lit by the environment.
"""

from __future__ import annotations

import argparse
import io
from pathlib import Path
from typing import TYPE_CHECKING

from shrm.cli import values
from shrm.cli.console import progress
from shrm.cli.descriptions import (
    environment_lines,
    material_lines,
    result_lines,
    transfer_lines,
)
from shrm.cli.options import (
    DAYLIGHT,
    MATERIAL,
    add_environment,
    add_extrapolate,
    material_text,
    parse_brdf,
    read_environment,
)

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.environment import Environment

EXAMPLE = "shrm info grace.hdr    or    shrm info --brdf krylon_blue.brdf --plot krylon.png"

DPI = 110
"""Dots per inch of the figure."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(
        command,
        required=False,
        alternatives="; or a file of measurements, a result of prefiltering, an object with transfer",
    )
    command.add_argument("--brdf", metavar="BRDF", help=MATERIAL)
    add_extrapolate(command)
    command.add_argument(
        "--plot",
        type=values.file_name(".png"),
        metavar="FILE",
        help="file to write a figure of the material to, .png",
    )


def run(options: argparse.Namespace) -> None:
    """Print what the files hold, and draw the figure."""
    # An environment's file may turn out to be a material's.
    if options.env is not None and _is_measured(options.env):
        if options.brdf is not None:
            raise argparse.ArgumentError(
                None, f"argument --brdf: not allowed with argument {options.env}, a material itself"
            )
        options.env, options.brdf = None, options.env
    if options.env is None and options.brdf is None:
        raise argparse.ArgumentError(None, "one of the arguments ENV --brdf is required")
    if options.plot is not None and options.brdf is None:
        raise argparse.ArgumentError(None, "argument --plot: only allowed with argument --brdf")

    env = None if options.env is None else _describe_file(options)
    if options.brdf is not None:
        brdf = parse_brdf(material_text(options, options.brdf))
        with progress("Analyzing the material"):
            lines = material_lines(brdf)
        print(brdf.name, *lines, sep="\n")
        if options.plot is not None:
            _plot(options.plot, brdf, env, DAYLIGHT if env is None else Path(options.env).stem)


def _describe_file(options: argparse.Namespace) -> Environment | None:
    """Print what a file holds; return it if it is an environment."""
    from shrm.render.transferred import is_transfer
    from shrm.result_files import load

    env = None
    if _is_result(options.env):
        with progress("Reading the result"):
            lines = result_lines(load(options.env))
    elif is_transfer(options.env):
        lines = transfer_lines(options.env)
    else:
        with progress("Reading the environment"):
            env = read_environment(options)
            lines = environment_lines(env)
    print(options.env, *lines, sep="\n")
    return env


def _is_measured(path: str) -> bool:
    """Tell whether a file is one of measurements."""
    from shrm.brdf import measured

    try:
        return measured.recognised(Path(path.partition(":sample=")[0])) is not None
    except OSError:
        return False  # reading it as an environment says what is wrong


def _is_result(path: str) -> bool:
    """Tell whether a file is a saved result of prefiltering."""
    from shrm.image_io import ImageError
    from shrm.result_files import kind_of

    if Path(path).suffix.lower() != ".exr":
        return False
    try:
        return kind_of(path) is not None
    except ImageError:
        return False  # reading it as an environment says what is wrong


def _plot(path: Path, brdf: BRDF, env: Environment | None, env_name: str) -> None:
    """Write the figure of a material, under daylight if there is no environment."""
    from shrm.environment import Environment
    from shrm.files import write_bytes
    from shrm.render.material_figure import material_figure
    from shrm.render.row import SUN_AZIMUTH

    with progress("Drawing the material"):
        light = Environment.daylight(sun_azimuth=SUN_AZIMUTH) if env is None else env
        content = io.BytesIO()
        material_figure(brdf, light, env_name).savefig(content, format="png", dpi=DPI)
        write_bytes(path, content.getvalue())
    print(path)
