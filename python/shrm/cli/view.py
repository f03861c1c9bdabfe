"""Look at spheres or a mesh in a window, and change light, material and view while looking.

Every --brdf adds an object to a row. Drag with the left button to orbit, with the right one to turn
the light; ? lists all keys. Pictures, meshes, objects with transfer and saved windows can be dropped
on the window.

An object whose transfer `shrm transfer` has precomputed, in place of the environment, shadows and
lights itself under a light that turns; --env is its light then.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from shrm.cli.options import (
    MATERIAL,
    add_environment,
    add_extrapolate,
    add_orders,
    add_tangents,
    add_transfer,
    add_viewer,
    extent,
    flag,
    material_text,
    number,
    of_transfer,
    parse_brdf,
)
from shrm.cli.transferred import opened

if TYPE_CHECKING:
    from shrm.viewer.window.state import State

EXAMPLE = (
    "shrm view grace.hdr --brdf ggx:0.3,1.0/0.71/0.29 --mesh bunny.ply"
    "    or    shrm view bunny.shrt --env grace.hdr"
)


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add = command.add_argument
    add_environment(
        command, optional=True, layout_flags=("--layout",), or_else="; or an object with transfer (.shrt)"
    )
    add("--env", dest="light", metavar="ENV", help="environment map that lights an object with transfer")
    add_transfer(command)
    add(
        "--brdf",
        dest="materials",
        action="append",
        metavar="B",
        help=f"{MATERIAL}; repeat for a row of objects (default: gold)",
    )
    add_extrapolate(command)
    add("--mesh", metavar="FILE", help="mesh to draw (default: a sphere)")
    add("--up", choices=("y", "z"), help="the mesh file's upward axis (default y)")
    add_tangents(command, default=None)
    add_orders(command, default=0.06)
    add_viewer(command, default="distant")
    command.set_defaults(tolerance=None, viewer=None)  # what is not given is as in --state
    add(
        "--method",
        choices=("shrm", "kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral", "hardware"),
        help="what the maps hold of the view: all that the orders do (default), round lobes, one round lobe,"
        " a Phong lobe, 12 views; or one round lobe filtered by the GPU",
    )
    add("--exposure", type=number, metavar="STOPS", help="(default: from the picture)")
    add(
        "--background",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="show the environment (default)",
    )
    add("--state", metavar="FILE", help="a saved window (.json) to go on from; Ctrl+S saves to it")
    add("--size", type=extent, default=(1280, 900), metavar="WxH", help="of the window (default 1280x900)")


def run(options: argparse.Namespace) -> None:
    """Open the window, and draw until it is closed."""
    from pathlib import Path

    first = state(options)
    if first.transfer is not None:  # what is wrong with it is said without a window
        opened(first.transfer, options, [options.variant])
    from shrm.viewer.window.app import Application

    application = Application(first, *options.size, state_file=options.state and Path(options.state))
    try:
        application.run()
    finally:
        application.close()


def state(options: argparse.Namespace) -> State:
    """Return what the window begins with: a saved one, with what the command line says otherwise."""
    from dataclasses import replace
    from pathlib import Path

    from shrm.viewer.window.state import State

    saved = options.state is not None and Path(options.state).exists()
    first = State.load(options.state) if saved else State()
    materials = [material_text(options, text) for text in options.materials or ()]
    for text in materials:
        parse_brdf(text)
    transfer, environment = files(options)
    given = {
        "environment": environment if environment in (None, "daylight") else absolute(environment),
        "layout": options.env_layout,
        "repair": True if options.repair else None,
        "materials": None if options.materials is None else tuple(materials),
        "mesh": None if options.mesh is None else absolute(options.mesh),
        "up": options.up,
        "tangents": options.tangents,
        "tolerance": options.tolerance,
        "orders": options.orders,
        "method": options.method,
        "viewer": options.viewer,
        "background": options.background,
        "exposure": options.exposure,
        "automatic": None if options.exposure is None else False,
        "selected": None if options.materials is None else 0,
        "transfer": None if transfer is None else absolute(transfer),
        "variant": options.variant,
        "components": options.components,
        "tents": options.tents,
        "window": options.window,
    }
    changes = {name: value for name, value in given.items() if value is not None}
    if options.materials is not None or options.mesh is not None:  # other objects are fitted anew
        changes.update(eye=None, transfer=None)
    if transfer is not None:
        changes["eye"] = None
    if options.tolerance is not None:
        changes["orders"] = None
    shown = replace(first, **changes)
    if shown.transfer is None and of_transfer(options) is not None:
        raise argparse.ArgumentError(None, f"{of_transfer(options)} is for an object with transfer")
    return shown


def files(options: argparse.Namespace) -> tuple[str | None, str | None]:
    """Return the paths of the object with transfer and of the environment, as far as they are given.

    Raises
    ------
    argparse.ArgumentError
        If there is an environment too many, or what an object with transfer has already.
    """
    from shrm.render.transferred import is_transfer

    path = options.env
    if path in (None, "daylight") or not is_transfer(path):
        if path is not None and options.light is not None:
            raise argparse.ArgumentError(None, "ENV and --env are two environments: one can be shown")
        return None, options.light if path is None else path
    names = {"materials": "--brdf", **{name: flag(name) for name in OF_MAPS}}
    for name, said in names.items():
        if getattr(options, name) is not None:
            raise argparse.ArgumentError(None, f"{said} cannot go with {path}, which has mesh and material")
    return path, options.light


OF_MAPS = ("mesh", "up", "tangents", "tolerance", "orders", "method")
"""What an object with transfer has already, or has no use for."""


def absolute(path: str) -> str:
    """Return a path that a saved window finds from any folder."""
    from pathlib import Path

    return str(Path(path).absolute())
