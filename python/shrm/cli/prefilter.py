"""Prefilter an environment map with a material: compute a spherical harmonic reflection map.

The orders F and P are chosen so that the error of the reflected light stays within the tolerance, or given.
With --technique the maps of an earlier technique are computed instead, by integration in a pyramid.
"""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING

from shrm.cli import values
from shrm.cli.compatibility import Rule, flags_given, require_compatible
from shrm.cli.console import progress
from shrm.cli.options import (
    MATERIAL,
    TECHNIQUES,
    add_environment,
    add_extrapolate,
    add_max_orders,
    add_orders,
    add_output,
    add_residual,
    largest_orders,
    material_text,
    parse_brdf,
    read_environment,
)

if TYPE_CHECKING:
    from shrm.brdf import BRDF
    from shrm.cli.options import Arguments
    from shrm.environment import Environment
    from shrm.frequency.reflection_map import ReflectionMap
    from shrm.prefiltered import Prefiltered

EXAMPLE = "shrm prefilter grace.hdr --brdf ggx:alpha=0.2,f0=0.04 --tolerance 0.02 -o grace-ggx.exr"

TOLERANCE = 0.05
"""Default of --tolerance, the relative RMS error of the reflected radiance."""

RULES = {
    "--max-orders": Rule(excludes=("--orders",)),
    "--residual": Rule(excludes=("--criterion", "--window")),
    "--technique": Rule(
        excludes=("--orders", "--max-orders", "--criterion", "--window", "--clamp", "--residual")
    ),
}
"""Options that need or exclude others."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(command)
    command.add_argument("--brdf", required=True, metavar="BRDF", help=MATERIAL)
    add_extrapolate(command)
    _add_accuracy(command.add_argument_group("accuracy"))
    _add_maps(command.add_argument_group("maps"))


def _add_accuracy(group: Arguments) -> None:
    add_orders(group, default=f"{TOLERANCE:g}")
    add_max_orders(group)
    group.add_argument(
        "--criterion",
        choices=("light", "brdf", "minimum", "bound"),
        default="light",
        help="quantity that the tolerance limits: the error of the reflected light (light, default), the"
        " fraction of the material's energy beyond the orders (brdf), the smaller of the fractions of the"
        " material's and the environment's energy (minimum), or an upper bound on the error (bound)",
    )
    add_residual(group)


def _add_maps(group: Arguments) -> None:
    group.add_argument(
        "--technique",
        choices=("shrm", *TECHNIQUES),
        default="shrm",
        metavar="TECHNIQUE",
        help="class of maps: spherical harmonic reflection maps (shrm, default), or an earlier approximation:"
        f" {', '.join(TECHNIQUES)} (exact for lobes of one shape and lobes about the tangent)",
    )
    group.add_argument(
        "--layout",
        choices=("latlong", "cube", "strip"),
        default="latlong",
        help="layout of the maps: lat-long (default), or a cube (strip is the same)",
    )
    group.add_argument(
        "--size",
        type=values.count,
        metavar="N",
        help="rows of a lat-long map, or of a cube's face (default: from the orders)",
    )
    group.add_argument(
        "--center",
        choices=("lobe", "reflection", "normal"),
        help="direction that lobes are expanded about: the mean direction of the lobe, the reflected view as"
        " in [RH02], or the normal (default: the best for each lobe); lobes that are symmetric about a"
        " direction keep it",
    )
    group.add_argument(
        "--window",
        choices=("hann", "lanczos"),
        help="attenuate high degrees against ringing (default: off)",
    )
    group.add_argument("--clamp", action="store_true", help="clamp negative radiance to zero on look-up")
    add_output(group, ".exr")


def run(options: argparse.Namespace) -> None:
    """Read, prefilter, save."""
    require_compatible(flags_given(options), RULES)
    brdf = parse_brdf(material_text(options, options.brdf))
    with progress("Reading the environment"):
        env = read_environment(options)
    start = time.perf_counter()
    with progress(f"Prefiltering with {brdf.name}"):
        prefilter = _reflection_map if options.technique == "shrm" else _earlier_maps
        maps = prefilter(options, env, brdf)
        seconds = time.perf_counter() - start
        maps.save(options.output)
    print(f"{options.output}: {brdf.name}, {_summary(maps)}, {1e3 * seconds:.0f} ms")


def _reflection_map(options: argparse.Namespace, env: Environment, brdf: BRDF) -> ReflectionMap:
    """Prefilter in frequency space."""
    from shrm.frequency.prefilter import prefilter

    F_max, P_max = largest_orders(options)
    return prefilter(
        env,
        brdf,
        tolerance=options.tolerance or TOLERANCE,
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


def _earlier_maps(options: argparse.Namespace, env: Environment, brdf: BRDF) -> Prefiltered:
    """Prefilter by an earlier technique."""
    from shrm.prefiltered import prefilter

    return prefilter(
        env,
        brdf if options.center is None else brdf.recentered(options.center),
        technique=options.technique,
        tolerance=options.tolerance or TOLERANCE,
        size=options.size,
        layout=options.layout,
    )


def _summary(maps: ReflectionMap | Prefiltered) -> str:
    """Describe maps in a few words."""
    from shrm.frequency.reflection_map import ReflectionMap

    if isinstance(maps, ReflectionMap):
        residual = "" if maps.residual is None else " and a residual"
        return f"F = {maps.F}, P = {maps.P}{residual}, predicted error {maps.error:.2%}"
    return " + ".join(f"{type(lobe).__name__} {lobe.keeps}" for lobe in maps.lobes)
