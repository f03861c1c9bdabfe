"""Prefilter an environment with a material: make a spherical harmonic reflection map.

The orders F and P are chosen so that the reflected light is within the tolerance, or given.
"""

from __future__ import annotations

import argparse
import time

from shrm.cli.console import progress
from shrm.cli.options import add_environment, add_orders, add_output, parse_brdf, read_environment, whole

EXAMPLE = "shrm prefilter grace.hdr --brdf ggx:alpha=0.2,f0=0.04 --tolerance 0.02 -o grace-ggx.exr"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(command, layout_flags=("--env-layout",))
    command.add_argument("--brdf", required=True, metavar="B", help="material, such as microfacet:0.2")
    add_orders(command)
    command.add_argument("--size", type=whole, metavar="N", help="rows of the map (default: from the orders)")
    command.add_argument(
        "--layout", choices=("latlong", "cube"), default="latlong", help="layout of the map (default latlong)"
    )
    add_output(command, ".exr")


def run(options: argparse.Namespace) -> None:
    """Read, prefilter, save."""
    from shrm.prefiltering import prefilter

    brdf = parse_brdf(options.brdf)
    with progress("Reading the environment"):
        env = read_environment(options)
    start = time.perf_counter()
    with progress(f"Prefiltering with {brdf.name}"):
        rm = prefilter(
            env,
            brdf,
            tolerance=options.tolerance,
            orders=options.orders,
            size=options.size,
            layout=options.layout,
        )
        seconds = time.perf_counter() - start
        rm.save(options.output)
    print(
        f"{options.output}: {brdf.name}, F = {rm.F}, P = {rm.P}, predicted error {rm.error:.2%},"
        f" {1e3 * seconds:.0f} ms"
    )
