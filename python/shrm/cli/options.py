"""Options that several commands have, and what they stand for: an environment, a material, a mesh."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from shrm.cli import values
from shrm.cli.console import interrupts_afterwards

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.environment import Environment
    from shrm.render import Mesh

    Arguments = argparse.ArgumentParser | argparse._ArgumentGroup
    """A command, or one of its groups of options: options are added to either."""

DAYLIGHT = "daylight"
"""Name of the analytic sky, which may stand in place of an environment map's file."""

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
"""The names in `shrm.environment.layouts`, repeated so that --help need not load it."""

TECHNIQUES = ("kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral")
"""Classes of maps beside "shrm", as `shrm.prefiltered.Technique` has them."""

ENVIRONMENT = f"environment map (.hdr, .exr, .png, ...) or '{DAYLIGHT}'"

MATERIAL = "material, such as ggx:0.3, microfacet:0.2 or merl-sgd:brass, or a file of measurements"

# ---- Environments


def add_environment(arguments: Arguments, *, required: bool = True, alternatives: str = "") -> None:
    """Add the environment as a positional argument, and the options for reading its file.

    `alternatives` is appended to its help: what else may stand in its place.
    """
    arguments.add_argument(
        "env", metavar="ENV", nargs=None if required else "?", help=f"{ENVIRONMENT}{alternatives}"
    )
    add_environment_reading(arguments)


def add_environment_option(arguments: Arguments) -> None:
    """Add the environment as --env, and the options for reading its file."""
    arguments.add_argument(
        "--env", metavar="ENV", default=DAYLIGHT, help=f"{ENVIRONMENT} (default: {DAYLIGHT})"
    )
    add_environment_reading(arguments)


def add_environment_reading(arguments: Arguments) -> None:
    """Add --env-layout, --env-border and --repair."""
    arguments.add_argument(
        "--env-layout",
        choices=LAYOUTS,
        metavar="LAYOUT",
        help="layout of the environment map's file (default: recognized from metadata and aspect ratio): "
        + ", ".join(LAYOUTS),
    )
    arguments.add_argument(
        "--env-border",
        type=values.border,
        metavar="N",
        help="texels around each face of a dual paraboloid in the environment map's file (default: what its"
        " metadata state, or none)",
    )
    arguments.add_argument(
        "--repair",
        action="store_true",
        help="replace texels that are NaN or infinite by their neighbors instead of refusing the file",
    )


def read_environment(options: argparse.Namespace) -> Environment:
    """Read the environment that the options name."""
    from shrm.environment import Environment
    from shrm.render.row import SUN_AZIMUTH

    if options.env == DAYLIGHT:
        return Environment.daylight(sun_azimuth=SUN_AZIMUTH)
    return Environment.read(
        options.env, layout=options.env_layout, repair=options.repair, border=options.env_border
    )


# ---- Materials


def add_extrapolate(arguments: Arguments) -> None:
    """Add --extrapolate."""
    arguments.add_argument(
        "--extrapolate",
        choices=("nearest", "zero"),
        default="nearest",
        help="values of measured materials where their file has none, such as at grazing angles:"
        " those of the nearest measurement (default), or zero",
    )


def material_text(options: argparse.Namespace, text: str) -> str:
    """Return a material's text with the extrapolation of the options."""
    from shrm import brdf

    return text if options.extrapolate == "nearest" else brdf.filled(text, options.extrapolate)


def parse_brdf(text: str) -> BRDF:
    """Return the material that a text describes.

    Raises
    ------
    argparse.ArgumentError
        If it describes none.
    MeasurementError
        If it names a file that does not hold measurements, or is damaged.
    """
    from shrm import brdf

    try:
        return brdf.parse(text)
    except brdf.MeasurementError:
        raise
    except ValueError as fault:
        raise argparse.ArgumentError(None, f"argument --brdf: {fault}") from None


# ---- Prefiltering


def add_orders(arguments: Arguments, default: str) -> None:
    """Add --tolerance, whose default is described, or else --orders."""
    either = arguments.add_mutually_exclusive_group()
    either.add_argument(
        "--tolerance",
        type=values.tolerance,
        metavar="T",
        help=f"largest error, the relative RMS of the reflected radiance (default: {default})",
    )
    either.add_argument(
        "--orders",
        type=values.orders,
        metavar="F,P",
        help="orders of the light and of the view, such as 30,4, in place of a tolerance",
    )


def add_max_orders(arguments: Arguments) -> None:
    """Add --max-orders."""
    arguments.add_argument(
        "--max-orders",
        type=values.orders,
        metavar="F,P",
        help="largest orders that a tolerance may lead to (default: 120,8)",
    )


def largest_orders(options: argparse.Namespace) -> tuple[int, int]:
    """Return the largest orders F, P that a tolerance may lead to."""
    from shrm.frequency.orders import F_MAX, P_MAX

    F, P = options.max_orders or (F_MAX, P_MAX)
    return F, P


def add_residual(arguments: Arguments) -> None:
    """Add --residual."""
    arguments.add_argument(
        "--residual",
        choices=("auto",),
        help="auto: split off the peak of lobes that are too sharp for the orders, and integrate it instead"
        " (default: off)",
    )


# ---- Meshes


TANGENTS = {
    "axis": "around the vertical",
    "uv": "along u of the texture coordinates",
    "principal": "along the larger curvature",
}


def add_up(arguments: Arguments, default: str | None = "y") -> None:
    """Add --up."""
    arguments.add_argument(
        "--up", choices=("y", "z"), default=default, help="upward axis of the mesh's file (default: y)"
    )


def add_tangents(arguments: Arguments, default: str | None = "axis") -> None:
    """Add --tangents."""
    arguments.add_argument(
        "--tangents",
        choices=tuple(TANGENTS),
        default=default,
        help="direction of the mesh's tangents, for materials that depend on it: "
        + ", ".join(f"{meaning} ({name})" for name, meaning in TANGENTS.items())
        + " (default: axis)",
    )


def read_mesh(options: argparse.Namespace) -> Mesh:
    """Read the mesh that the options name, with its tangents."""
    from shrm.render import Mesh

    with interrupts_afterwards():  # trimesh swallows an interrupt while it imports its parts
        mesh = Mesh.read(options.mesh, up=options.up)
    return mesh.with_tangents(options.tangents)


# ---- Objects with transfer


VARIANTS = ("unshadowed", "shadowed", "interreflected")
"""The names of `shrm.transfer`."""


def add_transfer_choice(arguments: Arguments, *, row: bool = False) -> None:
    """Add the options that choose a part of an object's transfer; in a row there may be several variants."""
    arguments.add_argument(
        "--variant",
        choices=VARIANTS,
        action="append" if row else "store",
        help="transfer without shadows, with shadows, or with interreflection (default: the most complete in"
        f" the file){'; repeat for a row of objects' if row else ''}",
    )
    arguments.add_argument(
        "--components", type=values.count, metavar="K", help="principal components to use (default: all)"
    )
    arguments.add_argument(
        "--tents",
        type=values.tents,
        metavar="M",
        help="resolution of the outgoing light, M x M tents (default: that of the file)",
    )
    arguments.add_argument(
        "--window",
        choices=("hann", "lanczos"),
        help="attenuate the high degrees of the light against ringing (default: off)",
    )


# ---- Pictures


VIEWERS = {
    "near": "one view vector for each pixel",
    "distant": "one view vector for the whole picture",
}


def add_viewer(arguments: Arguments, default: str) -> None:
    """Add --near and --distant, one of which is the default."""
    either = arguments.add_mutually_exclusive_group()
    for name, meaning in VIEWERS.items():
        either.add_argument(
            f"--{name}",
            dest="viewer",
            action="store_const",
            const=name,
            default=default,
            help=f"{meaning} (default)" if name == default else meaning,
        )


def add_output(arguments: Arguments, *suffixes: str) -> None:
    """Add --output, whose name ends in one of the suffixes."""
    arguments.add_argument(
        "-o",
        "--output",
        type=values.file_name(*suffixes),
        required=True,
        metavar="FILE",
        help=f"file to write, {values.alternatives(suffixes)}",
    )
