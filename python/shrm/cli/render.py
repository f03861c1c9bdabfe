"""Render spheres, a mesh, or an object with precomputed transfer, lit by an environment map.

Every --brdf, and every --map that was saved, adds an object to a row. A .png is scaled by
2^exposure, clipped and encoded as sRGB; an .exr holds linear radiance. With --gpu OpenGL draws the same
picture, with or without a display.

Prefiltered materials ignore shadows and interreflection. An object from `shrm transfer` has them, and its own
material; every --variant adds one to a row.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from shrm.cli import values
from shrm.cli.compatibility import TRANSFER_FILE, Rule, flags_given, require_compatible
from shrm.cli.console import progress
from shrm.cli.options import (
    MATERIAL,
    TECHNIQUES,
    add_environment_option,
    add_extrapolate,
    add_max_orders,
    add_orders,
    add_output,
    add_residual,
    add_tangents,
    add_transfer_choice,
    add_up,
    add_viewer,
    material_text,
    parse_brdf,
)
from shrm.cli.stage import FRAMES

if TYPE_CHECKING:
    from shrm.cli.options import Arguments
    from shrm.cli.stage import Stage
    from shrm.result_files import Result

EXAMPLE = "shrm render --env grace.hdr --brdf lambert:0.8 --brdf ggx:0.1 --mesh bunny.ply -o bunnies.png"

METHODS = ("frequency", "angular", "hierarchical", "auto")

_NO_MAPS = ("--method angular", "--method hierarchical", "--method auto")
"""Methods that integrate each pixel, or may do so."""

RULES = {
    **dict.fromkeys(
        ("--brdf", "--map", "--mesh", "--up", "--tangents", "--technique"), Rule(excludes=(TRANSFER_FILE,))
    ),
    "--method": Rule(excludes=(TRANSFER_FILE, "--technique")),
    "--tolerance": Rule(excludes=(TRANSFER_FILE, "--method angular")),
    "--orders": Rule(excludes=(TRANSFER_FILE, "--technique", *_NO_MAPS)),
    "--max-orders": Rule(
        excludes=(TRANSFER_FILE, "--orders", "--technique", "--method angular", "--method hierarchical")
    ),
    "--residual": Rule(excludes=(TRANSFER_FILE, "--technique", "--gpu", *_NO_MAPS)),
    "--gpu": Rule(excludes=_NO_MAPS),
    "--turntable light": Rule(excludes=("--map", "--technique", *_NO_MAPS)),
    "--frames": Rule(needs=("--turntable",)),
    **dict.fromkeys(
        ("--variant", "--components", "--tents", "--window", "--light-turn"), Rule(needs=(TRANSFER_FILE,))
    ),
}
"""Options that need or exclude others."""

# ---- Options


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    command.add_argument(
        "transfer",
        metavar=TRANSFER_FILE,
        nargs="?",
        help="object with transfer, from `shrm transfer`, in place of --brdf and --map",
    )
    add_environment_option(command.add_argument_group("environment"))
    _add_materials(command.add_argument_group("materials"))
    _add_prefiltering(command.add_argument_group("prefiltering"))
    _add_mesh(command.add_argument_group("shape"))
    _add_transfer(command.add_argument_group("objects with transfer"))
    _add_camera(command.add_argument_group("camera"))
    _add_picture(command.add_argument_group("picture"))


def _add_materials(group: Arguments) -> None:
    group.add_argument(
        "--brdf",
        dest="row",
        action="append",
        type=lambda text: ("brdf", text),
        metavar="BRDF",
        help=f"{MATERIAL}; repeat for a row of objects",
    )
    group.add_argument(
        "--map",
        dest="row",
        action="append",
        type=lambda text: ("map", text),
        metavar="FILE",
        help="result saved by `shrm prefilter` or in Python (.exr), in place of a material; repeat for a row"
        " of objects (--env is then the background only)",
    )
    add_extrapolate(group)


def _add_prefiltering(group: Arguments) -> None:
    add_orders(group, default="0.05; 0.01 with --method hierarchical or an earlier --technique")
    add_max_orders(group)
    add_residual(group)
    group.add_argument(
        "--method",
        choices=METHODS,
        default="frequency",
        help="computation of the reflected radiance: by reflection maps in frequency space (frequency,"
        " default), by integration over the light for each pixel (angular), by integration over a pyramid of"
        " the light (hierarchical), or by the method that is predicted to cost least (auto)",
    )
    group.add_argument(
        "--technique",
        choices=("shrm", *TECHNIQUES),
        default="shrm",
        metavar="TECHNIQUE",
        help="class of maps: spherical harmonic reflection maps (shrm, default), or an earlier approximation:"
        f" {', '.join(TECHNIQUES)}",
    )


def _add_mesh(group: Arguments) -> None:
    group.add_argument(
        "--mesh", metavar="FILE", help="mesh to draw: OBJ, PLY, STL, OFF, glTF (default: a sphere)"
    )
    group.add_argument(
        "--turn", type=values.number, default=0.0, metavar="DEG", help="turn the mesh about the vertical"
    )
    add_up(group)
    add_tangents(group)
    group.add_argument(
        "--texture",
        metavar="FILE",
        help="texture that multiplies the reflected light",
    )


def _add_transfer(group: Arguments) -> None:
    add_transfer_choice(group, row=True)
    group.add_argument(
        "--light-turn", type=values.number, metavar="DEG", help="turn the light about the vertical"
    )


def _add_camera(group: Arguments) -> None:
    group.add_argument(
        "--view",
        type=values.view,
        default=(0.0, 10.0),
        metavar="AZ,EL",
        help="viewing direction in degrees: azimuth (0 along +x, the middle of the map; 90 along +y, left of"
        " it) and how far down the camera looks (default: 0,10; --view=-30,10 for negative azimuths)",
    )
    group.add_argument(
        "--fov",
        type=values.field_of_view,
        default=30.0,
        metavar="DEG",
        help="field of view across the wider side (default: 30)",
    )
    group.add_argument(
        "--zoom",
        type=values.positive,
        default=1.0,
        metavar="Z",
        help="magnify the middle of the picture Z times",
    )
    add_viewer(group, default="near")
    group.add_argument(
        "--turntable",
        nargs="?",
        const="light",
        choices=("light", "camera"),
        help="turn the light (default) or the camera once about the vertical, in numbered pictures",
    )
    group.add_argument(
        "--frames", type=values.count, metavar="N", help=f"pictures of a turntable (default: {FRAMES})"
    )


def _add_picture(group: Arguments) -> None:
    group.add_argument(
        "--size",
        dest="shape",
        type=values.shape,
        metavar="WxH",
        help="pixels (default: 416 rows, as wide as the row needs)",
    )
    group.add_argument(
        "--samples", type=values.count, default=3, metavar="N", help="N x N samples per pixel (default: 3)"
    )
    group.add_argument("--gpu", action="store_true", help="draw with OpenGL; needs no display")
    group.add_argument(
        "--background",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="show the environment behind the objects (default), or write their coverage as alpha",
    )
    group.add_argument(
        "--exposure", type=values.number, metavar="STOPS", help="exposure of a .png (default: automatic)"
    )
    add_output(group, ".png", ".exr")


# ---- Work


def run(options: argparse.Namespace) -> None:
    """Prefilter each material, draw, write."""
    present = flags_given(options) | {f"--{kind}" for kind, _ in options.row or ()}
    if options.transfer is not None:
        present.add(TRANSFER_FILE)
    require_compatible(present, RULES)
    if options.transfer is not None:
        from shrm.cli.transfer_stage import TransferStage

        _write(TransferStage(options), options)
        return
    if options.row is None:
        raise argparse.ArgumentError(None, f"one of the arguments {TRANSFER_FILE} --brdf --map is required")
    from shrm.cli.material_stage import MaterialStage

    # Materials and saved maps, in the order of the command line
    row = [
        _saved(text, options.gpu) if kind == "map" else parse_brdf(material_text(options, text))
        for kind, text in options.row
    ]
    _write(MaterialStage(row, options), options)


def _saved(path: str, gpu: bool) -> Result:
    """Read a result of prefiltering; what integrates every point has no maps for the GPU to look up."""
    from shrm.integrate.angular import AngularReflection
    from shrm.integrate.hierarchical import HierarchicalReflection
    from shrm.result_files import load

    result = load(path)
    if gpu and isinstance(result, AngularReflection | HierarchicalReflection):
        raise argparse.ArgumentError(
            None, f"argument --gpu: not allowed with {path}, an integrator's result, which only the CPU draws"
        )
    return result


def _write(stage: Stage, options: argparse.Namespace) -> None:
    """Draw a picture, or all of a turntable, into files."""
    from shrm.render import numbered, write_picture

    frames = stage.frames
    paths = [options.output if frames == 1 else numbered(options.output, k, frames) for k in range(frames)]
    exposure = options.exposure
    with progress("Rendering" if frames == 1 else f"Rendering {frames} pictures") as report:
        for frame, path in enumerate(paths):
            picture = stage.draw(360.0 * frame / frames, report if frames == 1 else None)
            written_exposure = write_picture(path, picture, exposure, alpha=not options.background)
            if frame == 0:  # all have the exposure of the first
                exposure = written_exposure
            report((frame + 1) / frames)
    names = str(paths[0]) if frames == 1 else f"{paths[0]} to {paths[-1].name}"
    encoding = "linear" if exposure is None else f"exposure {exposure:+.2f}"
    print(f"{names}: {stage.shape[1]} x {stage.shape[0]}, {encoding}")
