"""Prefilter an environment with a material: make a spherical harmonic reflection map.

The orders F and P are chosen so that the reflected light is within the tolerance, or given. With --technique
the prefiltered maps of an earlier technique are made instead, by integration in a pyramid.
"""

from __future__ import annotations

import argparse
import time
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
    material_text,
    orders,
    parse_brdf,
    read_environment,
    whole,
)

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.environment import Environment

EXAMPLE = "shrm prefilter grace.hdr --brdf ggx:alpha=0.2,f0=0.04 --tolerance 0.02 -o grace-ggx.exr"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(command, layout_flags=("--env-layout",))
    command.add_argument("--brdf", required=True, metavar="B", help=MATERIAL)
    add_extrapolate(command)
    add_orders(command)
    add_residual(command)
    command.add_argument("--size", type=whole, metavar="N", help="rows of the map (default: from the orders)")
    command.add_argument(
        "--layout", choices=("latlong", "cube"), default="latlong", help="layout of the map (default latlong)"
    )
    command.add_argument(
        "--center",
        choices=("lobe", "reflection", "normal"),
        help="direction that lobes are expanded about: the lobe's mean, the reflected view (as in the paper),"
        " or the normal (default: what suits the material; lobes symmetric about their own center keep it)",
    )
    command.add_argument(
        "--criterion",
        choices=("light", "brdf", "minimum", "bound"),
        default="light",
        help="what the tolerance measures: the reflected light (default), the energy of the material that"
        " the orders leave out, the smaller of that and the energy of the environment, or an upper bound",
    )
    command.add_argument(
        "--max-orders",
        type=orders,
        metavar="F,P",
        help="the largest orders that the tolerance may take, such as 60,8",
    )
    command.add_argument(
        "--window", choices=("hann", "lanczos"), help="damp the high degrees against ringing (default: no)"
    )
    command.add_argument("--clamp", action="store_true", help="mark the map: negative light reads as zero")
    command.add_argument(
        "--technique",
        choices=TECHNIQUES,
        metavar="T",
        help=f"make explicit maps by an earlier technique: {', '.join(TECHNIQUES)} (lobes of one shape, and"
        " those about the tangent, are exact)",
    )
    add_output(command, ".exr")


def run(options: argparse.Namespace) -> None:
    """Read, prefilter, save."""
    from shrm.frequency.orders import F_MAX, P_MAX
    from shrm.frequency.prefilter import prefilter

    if options.max_orders is not None and options.orders is not None:
        raise argparse.ArgumentError(None, "argument --max-orders: not allowed with argument --orders")
    if options.residual is not None and (options.criterion != "light" or options.window is not None):
        raise argparse.ArgumentError(None, "argument --residual: is for --criterion light without a --window")
    brdf = parse_brdf(material_text(options, options.brdf))
    F_max, P_max = options.max_orders or (F_MAX, P_MAX)
    with progress("Reading the environment"):
        env = read_environment(options)
    if options.technique is not None:
        _explicit(options, env, brdf)
        return
    start = time.perf_counter()
    with progress(f"Prefiltering with {brdf.name}"):
        rm = prefilter(
            env,
            brdf,
            tolerance=options.tolerance,
            orders=options.orders,
            size=options.size,
            layout=options.layout,
            criterion=options.criterion,
            center=options.center,
            F_max=F_max,
            P_max=P_max,
            window=options.window,
            clamp=options.clamp,
            residual=options.residual,
        )
        seconds = time.perf_counter() - start
        rm.save(options.output)
    kept = "" if rm.residual is None else " and a residual"
    print(
        f"{options.output}: {brdf.name}, F = {rm.F}, P = {rm.P}{kept}, predicted error {rm.error:.2%},"
        f" {1e3 * seconds:.0f} ms"
    )


def _explicit(options: argparse.Namespace, env: Environment, brdf: BRDF) -> None:
    """Prefilter by an earlier technique, save."""
    from shrm.prefiltered import prefilter

    given = [name for name, usual in SHRM_ONLY.items() if getattr(options, name) != usual]
    if given:
        flag = f"--{given[0].replace('_', '-')}"
        raise argparse.ArgumentError(None, f"argument --technique: not allowed with argument {flag}")
    material = brdf if options.center is None else brdf.recentered(options.center)
    start = time.perf_counter()
    with progress(f"Prefiltering with {brdf.name}"):
        found = prefilter(
            env,
            material,
            options.technique,
            error=options.tolerance,
            size=options.size,
            layout=options.layout,
        )
        seconds = time.perf_counter() - start
        found.save(options.output)
    maps = " + ".join(f"{type(one).__name__} {one.keeps}" for one in found.lobes)
    print(f"{options.output}: {brdf.name}, {maps}, {1e3 * seconds:.0f} ms")


SHRM_ONLY = {
    "orders": None,
    "max_orders": None,
    "window": None,
    "clamp": False,
    "criterion": "light",
    "residual": None,
}
"""Arguments that go with frequency space alone, and what they are if they are not given."""
