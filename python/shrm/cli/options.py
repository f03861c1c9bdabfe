"""Arguments that several commands take, and how their text is read."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from shrm.cli.console import interrupts_afterwards

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.environment import Environment
    from shrm.render import Mesh

DAYLIGHT_AZIMUTH = 130.0  # the sun stands over the left shoulder of a camera that looks along +x

LAYOUTS = (
    "latlong",
    "openexr-latlong",
    "vertical-cross",
    "horizontal-cross",
    "strip",
    "faces",
    "openexr-cube",
    "angular",
    "mirror-ball",
    "dual-paraboloid",
    "octahedral",
)


def add_environment(
    command: argparse.ArgumentParser,
    *,
    flag: bool = False,
    optional: bool = False,
    layout_flags: tuple[str, ...],
    or_else: str = "",
) -> None:
    """Add the environment, as an argument of its own or as --env, and how it is read.

    `or_else` says what else that argument may be.
    """
    what = f"environment map (.hdr, .exr, .png, ...), or 'daylight'{or_else}"
    if flag:
        command.add_argument("--env", metavar="ENV", default="daylight", help=f"{what} (default)")
    else:
        command.add_argument("env", metavar="ENV", nargs="?" if optional else None, help=what)
    command.add_argument(
        *layout_flags,
        dest="env_layout",
        choices=LAYOUTS,
        metavar="L",
        help=f"layout of the file, if it is not the one recognised: {', '.join(LAYOUTS)}",
    )
    command.add_argument(
        "--repair", action="store_true", help="replace texels that are not finite by neighbours"
    )


def read_environment(options: argparse.Namespace) -> Environment:
    """Read what `add_environment` asked for."""
    from shrm.environment import Environment

    if options.env == "daylight":
        return Environment.daylight(sun_azimuth=DAYLIGHT_AZIMUTH)
    border = getattr(options, "env_border", 0)
    return Environment.read(options.env, layout=options.env_layout, repair=options.repair, border=border)


def read_mesh(options: argparse.Namespace) -> Mesh:
    """Read --mesh, or MESH, with the tangents of `add_tangents`."""
    from shrm.render import Mesh

    with interrupts_afterwards():  # trimesh goes on without whatever part of it was being imported
        mesh = Mesh.read(options.mesh, up=options.up)
    return mesh.with_tangents(options.tangents)


def add_orders(command: argparse.ArgumentParser, default: float = 0.05) -> None:
    """Add --tolerance, by default `default`, or --orders."""
    either = command.add_mutually_exclusive_group()
    either.add_argument(
        "--tolerance",
        type=tolerance,
        default=default,
        metavar="T",
        help=f"relative RMS error of the reflected light that chooses the orders (default {default:g})",
    )
    either.add_argument("--orders", type=orders, metavar="F,P", help="the orders themselves, such as 30,4")


def add_residual(command: argparse.ArgumentParser) -> None:
    """Add --residual."""
    command.add_argument(
        "--residual",
        choices=("auto",),
        help="auto: what the orders cannot hold of a sharp lobe is split off, and integrated or looked up"
        " (default: no)",
    )


TANGENTS = {
    "axis": "around the vertical",
    "uv": "along u of the mesh's texture coordinates",
    "principal": "along its larger curvature",
}


TECHNIQUES = ("kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral")
"""Those of `shrm.prefiltered`."""


def add_tangents(command: argparse.ArgumentParser, default: str | None) -> None:
    """Add --tangents."""
    command.add_argument(
        "--tangents",
        choices=tuple(TANGENTS),
        default=default,
        help="how tangents run on a mesh, for materials that have a direction: "
        + ", ".join(f"{name}: {what}" for name, what in TANGENTS.items())
        + " (default axis)",
    )


VIEWERS = {
    "near": "each pixel has its own view vector",
    "distant": "one view vector for the whole picture",
}


def add_viewer(command: argparse.ArgumentParser, default: str) -> None:
    """Add --near and --distant, one of which is the default."""
    either = command.add_mutually_exclusive_group()
    for name, what in VIEWERS.items():
        either.add_argument(
            f"--{name}",
            dest="viewer",
            action="store_const",
            const=name,
            default=default,
            help=f"{what} (default)" if name == default else what,
        )


VARIANTS = ("unshadowed", "shadowed", "interreflected")
"""Those of `shrm.transfer`."""


def add_transfer(command: argparse.ArgumentParser, *, row: bool = False) -> None:
    """Add what is used of an object with transfer; in a row it may be several variants."""
    add = command.add_argument
    add(
        "--variant",
        choices=VARIANTS,
        action="append" if row else "store",
        help="of an object with transfer: without shadows, with them, or with light between its parts too"
        f" (default: the most complete that it has){'; repeat for a row of them' if row else ''}",
    )
    add("--components", type=whole, metavar="K", help="components of its transfer to use (default: all)")
    add("--tents", type=tents, metavar="M", help="tents to a side, in place of more (default: all)")
    add(
        "--window",
        choices=("hann", "lanczos"),
        help="damp the high degrees of its light against ringing (default: no)",
    )


def of_transfer(options: argparse.Namespace) -> str | None:
    """Return the first option given that is for objects with transfer alone."""
    names = ("variant", "components", "tents", "window", "light_turn")
    return next((flag(name) for name in names if getattr(options, name, None) is not None), None)


def flag(name: str) -> str:
    """Return an option's name on the command line."""
    return f"--{name.replace('_', '-')}"


def add_output(command: argparse.ArgumentParser, *suffixes: str) -> None:
    """Add --output, whose name ends in one of the suffixes."""
    known = " or ".join([", ".join(suffixes[:-1]), suffixes[-1]] if len(suffixes) > 1 else suffixes)

    def file(text: str) -> Path:
        if Path(text).suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"{text!r}, but it needs a name that ends in {known}")
        return Path(text)

    command.add_argument("-o", "--output", type=file, required=True, metavar="FILE", help=f"{known} to write")


MATERIAL = "a material, such as microfacet:0.2 or merl-sgd:brass, or a file of measurements"
"""What --brdf takes."""


def add_extrapolate(command: argparse.ArgumentParser) -> None:
    """Add --extrapolate."""
    command.add_argument(
        "--extrapolate",
        choices=("nearest", "zero"),
        default="nearest",
        help="what files of measurements have at grazing angles, and wherever they have no data: the nearest"
        " value (default), or nothing",
    )


def material_text(options: argparse.Namespace, text: str) -> str:
    """Return a material's text, its files of measurements filled as the options say."""
    from shrm import brdf

    return text if options.extrapolate == "nearest" else brdf.filled(text, options.extrapolate)


def parse_brdf(text: str) -> BRDF:
    """Read a material's text; a wrong one is a fault of the command line.

    Raises
    ------
    argparse.ArgumentError
        If the text does not describe a material.
    MeasurementError
        If it names a file of measurements that is none, or damaged.
    """
    from shrm import brdf

    try:
        return brdf.parse(text)
    except brdf.MeasurementError:
        raise
    except ValueError as fault:
        raise argparse.ArgumentError(None, f"argument --brdf: {fault}") from None


def tolerance(text: str) -> float:
    """0 < T < 1."""
    return _between(text, 0.0, 1.0, "a number between 0 and 1")


def degrees(text: str) -> float:
    """An opening angle, 0 < angle < 180."""
    return _between(text, 0.0, 180.0, "an angle between 0 and 180 degrees")


def _between(text: str, low: float, high: float, needs: str) -> float:
    value = _number(text, needs)
    if not low < value < high:
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs {needs}")
    return value


def positive(text: str) -> float:
    """A finite number above 0."""
    return _between(text, 0.0, math.inf, "a number above 0")


def number(text: str) -> float:
    """A finite number."""
    return _number(text, "a number")


def _number(text: str, needs: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs {needs}")
    return value


def whole(text: str, least: int = 1) -> int:
    """A whole number of at least 1, or so many."""
    if not (text.isascii() and text.isdigit()) or int(text) < least:
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs a whole number of at least {least}")
    return int(text)


def tents(text: str) -> int:
    """Tents to a side."""
    return whole(text, 2)


def orders(text: str) -> tuple[int, int]:
    """Read F,P."""
    parts = text.split(",")
    if len(parts) != 2 or not all(part.isascii() and part.isdigit() for part in parts):
        raise argparse.ArgumentTypeError(
            f"{text!r}, but it needs F,P: two whole numbers from 0, such as 30,4"
        )
    return int(parts[0]), int(parts[1])


def extent(text: str) -> tuple[int, int]:
    """Read WxH."""
    parts = text.lower().split("x")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs WxH, such as 1280x720")
    return whole(parts[0]), whole(parts[1])


def view(text: str) -> tuple[float, float]:
    """Read AZIMUTH,ELEVATION."""
    needs = "AZIMUTH,ELEVATION in degrees, the elevation from -90 to 90, such as 30,10"
    parts = text.split(",")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs {needs}")
    azimuth, elevation = (_number(part, needs) for part in parts)
    if abs(elevation) > 90.0:
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs {needs}")
    return azimuth, elevation
