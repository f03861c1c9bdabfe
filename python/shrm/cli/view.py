"""View spheres, a mesh or an object with transfer in a window, and change light, material and view.

Every --brdf adds an object to a row. Drag with the left button to orbit, with the right one to turn the
light; ? lists all keys. Environment maps, meshes, objects with transfer and saved windows can be dropped on
the window.

With an object from `shrm transfer` in place of the environment, --env is its light.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from shrm.cli import values
from shrm.cli.compatibility import TRANSFER_FILE, Rule, flags_given, require_compatible
from shrm.cli.options import (
    DAYLIGHT,
    ENVIRONMENT,
    MATERIAL,
    TECHNIQUES,
    add_environment_reading,
    add_extrapolate,
    add_orders,
    add_tangents,
    add_transfer_choice,
    add_up,
    add_viewer,
    material_text,
    parse_brdf,
)

if TYPE_CHECKING:
    from shrm.cli.options import Arguments
    from shrm.viewer.window.state import State

EXAMPLE = (
    "shrm view grace.hdr --brdf ggx:0.3,1.0/0.71/0.29 --mesh bunny.ply"
    "    or    shrm view bunny.shrt --env grace.hdr"
)

FILTERS = ("two-pass", "exact")
"""Names of `shrm.viewer.window.state.Filter`."""

FILTERED = "kautz-mccool-2d"
"""The technique whose maps the GPU can filter."""

RULES = {
    **dict.fromkeys(
        ("--brdf", "--mesh", "--up", "--tangents", "--tolerance", "--orders", "--technique"),
        Rule(excludes=(TRANSFER_FILE,)),
    ),
    **dict.fromkeys(("--variant", "--components", "--tents", "--window"), Rule(needs=(TRANSFER_FILE,))),
    "--env": Rule(excludes=("ENV",)),
    "--filter": Rule(
        excludes=(
            TRANSFER_FILE,
            *(f"--technique {name}" for name in ("shrm", *TECHNIQUES) if name != FILTERED),
        )
    ),
}
"""Options that need or exclude others."""

# ---- Options


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    command.add_argument(
        "path", metavar="ENV", nargs="?", help=f"{ENVIRONMENT}; or an object with transfer ({TRANSFER_FILE})"
    )
    light = command.add_argument_group("environment")
    light.add_argument("--env", metavar="ENV", help="environment map that lights an object with transfer")
    add_environment_reading(light)
    _add_objects(command.add_argument_group("objects"))
    _add_prefiltering(command.add_argument_group("prefiltering"))
    add_transfer_choice(command.add_argument_group("objects with transfer"))
    _add_window(command.add_argument_group("window"))


def _add_objects(group: Arguments) -> None:
    group.add_argument(
        "--brdf",
        action="append",
        metavar="BRDF",
        help=f"{MATERIAL}; repeat for a row of objects (default: gold)",
    )
    add_extrapolate(group)
    group.add_argument(
        "--mesh", metavar="FILE", help="mesh to draw: OBJ, PLY, STL, OFF, glTF (default: a sphere)"
    )
    add_up(group, default=None)
    add_tangents(group, default=None)


def _add_prefiltering(group: Arguments) -> None:
    add_orders(group, default="0.06")
    group.add_argument(
        "--technique",
        choices=("shrm", *TECHNIQUES),
        metavar="TECHNIQUE",
        help="class of maps: spherical harmonic reflection maps (shrm, default), or an earlier approximation:"
        f" {', '.join(TECHNIQUES)}",
    )
    group.add_argument(
        "--filter",
        choices=FILTERS,
        help=f"filter the maps of {FILTERED} on the GPU whenever the light changes: by two passes of a small"
        " kernel (two-pass), or by a sum over many taps (exact)",
    )


def _add_window(group: Arguments) -> None:
    add_viewer(group, default="distant")
    group.set_defaults(viewer=None)  # what is not given is as in --state
    group.add_argument(
        "--exposure", type=values.number, metavar="STOPS", help="exposure (default: automatic)"
    )
    group.add_argument(
        "--background",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="show the environment behind the objects (default)",
    )
    group.add_argument(
        "--state", metavar="FILE", help="saved window (.json) to start from; Ctrl+S saves to the same file"
    )
    group.add_argument(
        "--size",
        dest="shape",
        type=values.shape,
        default=(900, 1280),
        metavar="WxH",
        help="pixels of the window (default: 1280x900)",
    )


# ---- Work


def run(options: argparse.Namespace) -> None:
    """Open the window, and draw until it is closed."""
    from pathlib import Path

    first = state(options)
    if first.transfer is not None:  # a file that cannot be opened is refused before there is a window
        from shrm.cli.transfer_stage import open_transfer

        open_transfer(first.transfer, options, [options.variant])
    from shrm.viewer.window.app import Application

    application = Application(first, options.shape, state_file=options.state and Path(options.state))
    try:
        application.run()
    finally:
        application.close()


def state(options: argparse.Namespace) -> State:
    """Return the state that the window begins with: a saved one, overridden by the other options.

    Raises
    ------
    OSError, ValueError
        If the saved state cannot be read.
    argparse.ArgumentError
        If a text describes no material, or an option excludes or lacks another.
    """
    from dataclasses import replace
    from pathlib import Path

    from shrm.viewer.window.state import State

    transfer, environment = _files(options)
    saved = options.state is not None and Path(options.state).exists()
    first = State.load(options.state) if saved else State()

    # Other objects end the transfer of a saved state.
    replaced = options.brdf is not None or options.mesh is not None
    shows_transfer = transfer is not None or (first.transfer is not None and not replaced)
    require_compatible(_present(options, transfer, shows_transfer), RULES)

    changes = _changes(options, transfer, environment)
    if replaced:
        changes.update(eye=None, transfer=None)
    if transfer is not None:
        changes["eye"] = None
    if options.tolerance is not None:
        changes["orders"] = None
    if options.technique is not None:
        changes["filter"] = options.filter
    return replace(first, **changes)


def _files(options: argparse.Namespace) -> tuple[str | None, str | None]:
    """Return the paths of the object with transfer and of the environment; None where they are not given."""
    from shrm.render.transferred import is_transfer

    path = options.path
    if path not in (None, DAYLIGHT) and is_transfer(path):
        return path, options.env
    return None, options.env if path is None else path


def _present(options: argparse.Namespace, transfer: str | None, shows_transfer: bool) -> set[str]:
    """Return the arguments that are given, as `RULES` names them."""
    present = flags_given(options)
    if options.path is not None:
        present.add("ENV" if transfer is None else TRANSFER_FILE)

    # A saved object has transfer, too, which options may choose from; those of materials replace the object.
    if shows_transfer and transfer is None:
        present -= {"--variant", "--components", "--tents", "--window"}
    return present


def _changes(options: argparse.Namespace, transfer: str | None, environment: str | None) -> dict[str, Any]:
    """Return the fields of the state that options give, by name."""
    materials = None
    if options.brdf is not None:
        materials = tuple(material_text(options, text) for text in options.brdf)
        for text in materials:
            parse_brdf(text)
    fields = {
        "environment": environment if environment in (None, DAYLIGHT) else _absolute(environment),
        "layout": options.env_layout,
        "border": options.env_border,
        "repair": True if options.repair else None,
        "materials": materials,
        "selected": None if materials is None else 0,
        "mesh": None if options.mesh is None else _absolute(options.mesh),
        "exposure": options.exposure,
        "automatic": None if options.exposure is None else False,
        "transfer": None if transfer is None else _absolute(transfer),
        "technique": FILTERED if options.filter is not None else options.technique,
    }
    for name in (
        "up", "tangents", "tolerance", "orders", "filter", "viewer", "background", "variant", "components",
        "tents", "window",
    ):  # fmt: skip
        fields[name] = getattr(options, name)
    return {name: value for name, value in fields.items() if value is not None}


def _absolute(path: str) -> str:
    """Return a path that a saved window finds from any folder."""
    from pathlib import Path

    return str(Path(path).absolute())
