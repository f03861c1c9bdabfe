"""Draw spheres or a mesh, made of one or several materials and lit by an environment.

Every --brdf, and every --map that `shrm prefilter` saved, adds an object to a row. A .png is
multiplied by 2^exposure, clipped at white and encoded by the sRGB curve; an .exr is linear. There
are no shadows and no interreflection.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from shrm.cli.console import progress
from shrm.cli.options import (
    add_environment,
    add_orders,
    add_output,
    degrees,
    extent,
    number,
    parse_brdf,
    read_environment,
    view,
    whole,
)

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.environment import Environment
    from shrm.reflection_map import ReflectionMap
    from shrm.render import Reflection

EXAMPLE = "shrm render --env grace.hdr --brdf lambert:0.8 --brdf ggx:0.1 --mesh bunny.ply -o bunnies.png"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add = command.add_argument
    add_environment(command, flag=True, layout_flags=("--layout", "--env-layout"))
    add(
        "--brdf",
        dest="row",
        action="append",
        type=lambda text: ("brdf", text),
        metavar="B",
        help="material; repeat for a row of objects",
    )
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
    add("--method", choices=("shrm", "angular"), default="shrm", help="how to prefilter (default shrm)")
    add("--mesh", metavar="FILE", help="mesh to draw (default: a sphere)")
    add("--turn", type=number, default=0.0, metavar="DEG", help="turn the mesh about the vertical")
    add("--up", choices=("y", "z"), default="y", help="the mesh file's upward axis (default y)")
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
    viewer = command.add_mutually_exclusive_group()
    viewer.add_argument(
        "--near",
        dest="viewer",
        action="store_const",
        const="near",
        default="near",
        help="each pixel has its own view vector (default)",
    )
    viewer.add_argument(
        "--distant",
        dest="viewer",
        action="store_const",
        const="distant",
        help="one view vector for the whole picture",
    )
    add("--background", action=argparse.BooleanOptionalAction, default=True, help="show the environment")
    add("--exposure", type=number, metavar="STOPS", help="for .png (default: from the picture)")
    add("--samples", type=whole, default=3, metavar="N", help="NxN rays per pixel (default 3)")
    add_output(command, ".png", ".exr")


def run(options: argparse.Namespace) -> None:
    """Prefilter each material, draw, write."""
    from shrm import image_io
    from shrm.brdf import BRDF
    from shrm.render import Mesh, Object, Sphere, render, row_camera, row_picture, write_picture

    if options.row is None:
        raise argparse.ArgumentError(None, "needs a --brdf or a --map")
    row = [saved(text) if kind == "map" else parse_brdf(text) for kind, text in options.row]
    env = read_environment(options)
    mesh = None if options.mesh is None else Mesh.read(options.mesh, up=options.up)
    texture = None if options.texture is None else image_io.read_image(options.texture).pixels

    width, height = options.size or row_picture(len(row), diameter=320)
    azimuth, elevation = options.view
    camera, centers = row_camera(len(row), width / height, azimuth, elevation, options.fov)
    objects = []
    for material, center in zip(row, centers, strict=True):
        reflection = prefiltered(env, material, options) if isinstance(material, BRDF) else material
        shape = Sphere(center) if mesh is None else mesh.placed(center, turn=options.turn)
        objects.append(Object(shape, reflection, texture))

    with progress("Drawing") as report:
        picture = render(
            objects,
            camera,
            width,
            height,
            background=env if options.background else None,
            viewer=options.viewer,
            samples=options.samples,
            progress=report,
        )
    exposure = write_picture(options.output, picture, options.exposure, alpha=not options.background)
    said = "linear" if exposure is None else f"exposure {exposure:+.2f}"
    print(f"{options.output}: {width} x {height}, {said}")


def saved(path: str) -> ReflectionMap:
    """Read a reflection map that `shrm prefilter` wrote."""
    from shrm.reflection_map import ReflectionMap

    return ReflectionMap.load(path)


def prefiltered(env: Environment, brdf: BRDF, options: argparse.Namespace) -> Reflection:
    """Prefilter by the method that the options name."""
    with progress(f"Prefiltering with {brdf.name}"):
        if options.method == "angular":
            from shrm.reference import prefilter_angular

            return prefilter_angular(env, brdf)
        from shrm.prefiltering import prefilter

        return prefilter(env, brdf, tolerance=options.tolerance, orders=options.orders)
