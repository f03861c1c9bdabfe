"""Draw spheres, a mesh, or an object with transfer, lit by an environment.

Every --brdf, and every --map that `shrm prefilter` saved, adds an object to a row. A .png is
multiplied by 2^exposure, clipped at white and encoded by the sRGB curve; an .exr is linear. With
--gpu OpenGL draws the same picture, with or without a display.

Materials and maps know no shadows and no interreflection. An object whose transfer `shrm transfer`
has precomputed does, and has its material already; every --variant adds one to a row.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from shrm.cli.console import progress
from shrm.cli.options import (
    MATERIAL,
    TECHNIQUES,
    add_environment,
    add_extrapolate,
    add_orders,
    add_output,
    add_residual,
    add_tangents,
    add_transfer,
    add_viewer,
    degrees,
    extent,
    flag,
    material_text,
    number,
    of_transfer,
    orders,
    parse_brdf,
    positive,
    read_mesh,
    view,
    whole,
)
from shrm.cli.stage import GPU_MAP_SIZE, Stage

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.frequency.reflection_map import ReflectionMap
    from shrm.frequency.relight import Prefilter
    from shrm.prefiltered import Prefiltered
    from shrm.render import Camera, Object, Reflection
from shrm.arrays import FloatArray

EXAMPLE = "shrm render --env grace.hdr --brdf lambert:0.8 --brdf ggx:0.1 --mesh bunny.ply -o bunnies.png"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add = command.add_argument
    add(
        "transfer",
        metavar="FILE",
        nargs="?",
        help="object with transfer (.shrt), in place of --brdf and --map",
    )
    add_environment(command, flag=True, layout_flags=("--layout", "--env-layout"))
    add(
        "--brdf",
        dest="row",
        action="append",
        type=lambda text: ("brdf", text),
        metavar="B",
        help=f"{MATERIAL}; repeat for a row of objects",
    )
    add_extrapolate(command)
    add(
        "--map",
        dest="row",
        action="append",
        type=lambda text: ("map", text),
        metavar="FILE",
        help="reflection map (.exr) saved by `shrm prefilter`, in place of a material; repeat for a row of"
        " objects (--env is then only what is seen behind them)",
    )
    add_orders(command)
    command.set_defaults(tolerance=None)  # by the method
    add_residual(command)
    add(
        "--max-orders",
        type=orders,
        metavar="F,P",
        help="the largest orders that the tolerance may take, such as 16,4",
    )
    add(
        "--method",
        choices=("shrm", *INTEGRATED, *TECHNIQUES),
        default="shrm",
        metavar="M",
        help="how to prefilter: in frequency space (shrm, the default); pixel by pixel, over all the light"
        " (angular) or in a pyramid of it (hierarchical); or by an earlier technique, an approximation: "
        f"{', '.join(TECHNIQUES)}. The tolerance of the last two kinds is 0.01 unless it is given",
    )
    add_transfer(command, row=True)
    add(
        "--light-turn",
        type=number,
        metavar="DEG",
        help="turn the light of an object with transfer about the vertical",
    )
    add("--mesh", metavar="FILE", help="mesh to draw (default: a sphere)")
    add("--turn", type=number, default=0.0, metavar="DEG", help="turn the mesh about the vertical")
    add("--up", choices=("y", "z"), default="y", help="the mesh file's upward axis (default y)")
    add_tangents(command, default="axis")
    add("--texture", metavar="FILE", help="picture that multiplies the reflected light, by the mesh's UV")
    add("--size", type=extent, metavar="WxH", help="pixels (default: 384 rows, as wide as it needs)")
    add(
        "--view",
        type=view,
        default=(0.0, 10.0),
        metavar="AZ,EL",
        help="where the camera looks: azimuth (0: along +x, the middle of the map; 90: +y, left of it)"
        " and how many degrees it looks down (default 0,10; --view=-30,10 for negative ones)",
    )
    add(
        "--fov",
        type=degrees,
        default=30.0,
        metavar="DEG",
        help="field of view of the wider side (default 30)",
    )
    add("--zoom", type=positive, default=1.0, metavar="Z", help="enlarge what is in the middle, Z times")
    add_viewer(command, default="near")
    add("--gpu", action="store_true", help="draw with OpenGL; needs no display")
    add(
        "--turntable",
        nargs="?",
        const="light",
        choices=("light", "camera"),
        help="turn the light (default) or the camera once round the vertical, in --frames numbered pictures",
    )
    add("--frames", type=whole, metavar="N", help="pictures of a turntable (default 120)")
    add("--background", action=argparse.BooleanOptionalAction, default=True, help="show the environment")
    add("--exposure", type=number, metavar="STOPS", help="for .png (default: from the picture)")
    add("--samples", type=whole, default=3, metavar="N", help="NxN rays per pixel (default 3)")
    add_output(command, ".png", ".exr")


def run(options: argparse.Namespace) -> None:
    """Prefilter each material, draw, write."""
    if options.frames is not None and options.turntable is None:
        raise argparse.ArgumentError(None, "--frames is for a --turntable")
    if options.transfer is not None:
        from shrm.cli.transferred import TransferredStage, require_none_of_maps

        require_none_of_maps(options)
        write(TransferredStage(options), options)
        return
    if options.row is None:
        raise argparse.ArgumentError(None, "needs a --brdf, a --map or an object with transfer")
    if of_transfer(options) is not None:
        raise argparse.ArgumentError(None, f"{of_transfer(options)} is for an object with transfer")
    if options.gpu and options.method in INTEGRATED:
        raise argparse.ArgumentError(
            None, f"--gpu draws reflection maps: it cannot go with --method {options.method}"
        )
    if options.method != "shrm" and options.orders is not None:
        raise argparse.ArgumentError(None, f"--orders are for --method shrm, not {options.method}")
    if options.max_orders is not None and options.orders is not None:
        raise argparse.ArgumentError(None, "argument --max-orders: not allowed with argument --orders")
    for name in ("residual", "max_orders"):
        if options.method != "shrm" and getattr(options, name) is not None:
            raise argparse.ArgumentError(None, f"{flag(name)} is for --method shrm, not {options.method}")
    if options.gpu and options.residual is not None:
        raise argparse.ArgumentError(None, "--gpu draws reflection maps alone: it cannot go with --residual")
    if options.method == "angular" and options.tolerance is not None:
        raise argparse.ArgumentError(None, "--method angular leaves nothing out: it takes no --tolerance")
    if options.turntable == "light" and (
        options.method != "shrm" or any(kind == "map" for kind, _ in options.row)
    ):
        raise argparse.ArgumentError(
            None,
            "a --turntable of the light turns reflection maps that it makes: it needs a --brdf for each, and"
            " --method shrm",
        )
    row = [
        saved(text) if kind == "map" else parse_brdf(material_text(options, text))
        for kind, text in options.row
    ]
    write(MaterialStage(row, options), options)


def write(stage: Stage, options: argparse.Namespace) -> None:
    """Draw a picture, or all of a turntable, into files."""
    from shrm.render import numbered, write_picture

    frames = 1 if options.turntable is None else options.frames or FRAMES
    exposure, first = options.exposure, options.output
    with progress("Drawing" if frames == 1 else f"Drawing {frames} pictures") as report:
        for frame in range(frames):
            picture = stage.draw(360.0 * frame / frames, report if frames == 1 else None)
            path = options.output if frames == 1 else numbered(options.output, frame, frames)
            used = write_picture(path, picture, exposure, alpha=not options.background)
            if frame == 0:  # all have the exposure of the first
                first, exposure = path, used
            report((frame + 1) / frames)
    said = "linear" if exposure is None else f"exposure {exposure:+.2f}"
    names = str(first) if frames == 1 else f"{first} to {path.name}"
    print(f"{names}: {stage.width} x {stage.height}, {said}")


class MaterialStage(Stage):
    """Objects in a row, their light and the camera, as the options have them."""

    def __init__(self, row: list[BRDF | ReflectionMap | Prefiltered], options: argparse.Namespace) -> None:
        from shrm.render import Sphere

        super().__init__(options, len(row))
        mesh = None
        if options.mesh is not None:
            mesh = read_mesh(options)
        self.shapes = [
            Sphere(center) if mesh is None else mesh.placed(center, turn=options.turn)
            for center in self.centers
        ]
        self.materials = [self._prefiltered(material) for material in row]

    def _prefiltered(self, material: BRDF | ReflectionMap | Prefiltered) -> Prefilter | Reflection:
        """Prefilter by the method that the options name, so that the light can be turned if it is to be."""
        from shrm.brdf import BRDF
        from shrm.frequency.orders import F_MAX, P_MAX
        from shrm.frequency.prefilter import prefilter
        from shrm.frequency.relight import Prefilter
        from shrm.integrate.angular import prefilter_angular
        from shrm.integrate.hierarchical import prefilter_hierarchical
        from shrm.prefiltered import prefilter as prefilter_explicit

        if not isinstance(material, BRDF):
            return material
        options = self.options
        with progress(f"Prefiltering with {material.name}"):
            if options.method == "angular":
                return prefilter_angular(self.env, material)
            error = options.tolerance or INTEGRATION_ERROR
            if options.method == "hierarchical":
                return prefilter_hierarchical(self.env, material, error=error)
            if options.method != "shrm":
                return prefilter_explicit(
                    self.env,
                    material,
                    options.method,
                    error=error,
                    layout="cube" if options.gpu else "latlong",
                    size=GPU_MAP_SIZE if options.gpu else None,
                )
            F_max, P_max = options.max_orders or (F_MAX, P_MAX)
            make = Prefilter if options.turntable == "light" else prefilter
            return make(
                self.env,
                material,
                tolerance=options.tolerance or SHRM_ERROR,
                orders=options.orders,
                F_max=F_max,
                P_max=P_max,
                residual=options.residual,
                layout="cube" if options.gpu else "latlong",
                size=GPU_MAP_SIZE if options.gpu else None,
            )

    def objects(self, rotation: FloatArray, camera: Camera) -> list[Object]:
        """Return them; those of one light alone cannot be turned."""
        from shrm.frequency.relight import Prefilter
        from shrm.render import Object

        maps = [
            material.update(rotation=rotation) if isinstance(material, Prefilter) else material
            for material in self.materials
        ]
        return [Object(shape, each, self.texture) for shape, each in zip(self.shapes, maps, strict=True)]


INTEGRATED = ("angular", "hierarchical")
"""Methods that have no maps: each pixel is integrated."""

SHRM_ERROR, INTEGRATION_ERROR = 0.05, 0.01
"""Tolerances unless given, in frequency space and by the other methods."""

FRAMES = 120
"""Pictures of a turntable."""


def saved(path: str) -> ReflectionMap | Prefiltered:
    """Read maps that `shrm prefilter` wrote."""
    from shrm import image_io
    from shrm.frequency.reflection_map import ReflectionMap
    from shrm.prefiltered import Prefiltered

    first = image_io.read_parts(path)[0].metadata
    return Prefiltered.load(path) if "shrm:prefiltered" in first else ReflectionMap.load(path)
