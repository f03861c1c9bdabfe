"""Look at spheres or a mesh in a window, and change light, material and view while looking.

Every --brdf adds an object to a row. Drag with the left button to orbit, with the right one to turn
the light; ? lists all keys. Pictures, meshes and saved windows can be dropped on the window.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from shrm.cli.options import (
    add_environment,
    add_orders,
    add_tangents,
    add_viewer,
    extent,
    number,
    parse_brdf,
)

if TYPE_CHECKING:
    from shrm.viewer.state import State

EXAMPLE = "shrm view grace.hdr --brdf ggx:0.3,1.0/0.71/0.29 --mesh bunny.ply"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add = command.add_argument
    add_environment(command, optional=True, layout_flags=("--layout",))
    add(
        "--brdf",
        dest="materials",
        action="append",
        metavar="B",
        help="material; repeat for a row of objects (default: gold)",
    )
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
    from shrm.viewer.app import Application

    application = Application(first, *options.size, state_file=options.state and Path(options.state))
    try:
        application.run()
    finally:
        application.close()


def state(options: argparse.Namespace) -> State:
    """Return what the window begins with: a saved one, with what the command line says otherwise."""
    from dataclasses import replace
    from pathlib import Path

    from shrm.viewer.state import State

    saved = options.state is not None and Path(options.state).exists()
    first = State.load(options.state) if saved else State()
    for text in options.materials or ():
        parse_brdf(text)
    given = {
        "environment": options.env if options.env in (None, "daylight") else absolute(options.env),
        "layout": options.env_layout,
        "repair": True if options.repair else None,
        "materials": None if options.materials is None else tuple(options.materials),
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
    }
    changes = {name: value for name, value in given.items() if value is not None}
    if options.materials is not None or options.mesh is not None:  # other objects are fitted anew
        changes["eye"] = None
    if options.tolerance is not None:
        changes["orders"] = None
    return replace(first, **changes)


def absolute(path: str) -> str:
    """Return a path that a saved window finds from any folder."""
    from pathlib import Path

    return str(Path(path).absolute())
