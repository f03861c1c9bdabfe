"""Precompute how an object shadows and lights itself, for any light around it.

Mesh and material become one file for `shrm render` and `shrm view`. Finished stages are kept in FILE.work
until the file is written: the same command continues where it was interrupted.
"""

from __future__ import annotations

import argparse
import errno
import os
import pathlib
import time
from typing import TYPE_CHECKING

from shrm.cli import values
from shrm.cli.compatibility import Rule, flags_given, require_compatible
from shrm.cli.console import stages
from shrm.cli.options import (
    MATERIAL,
    VARIANTS,
    add_extrapolate,
    add_output,
    add_tangents,
    add_up,
    material_text,
    parse_brdf,
    read_mesh,
)

if TYPE_CHECKING:
    from shrm.arrays import FloatArray
    from shrm.brdf import BRDF
    from shrm.cli.options import Arguments
    from shrm.render import Mesh
    from shrm.transfer import RadianceTransfer, Route

EXAMPLE = "shrm transfer armadillo.obj --brdf ashikhmin-shirley:nu=40,nv=10 -o armadillo.shrt"

RULES = dict.fromkeys(("--bounces", "--albedo"), Rule(needs=("--variant interreflected",)))
"""Options that need or exclude others."""

PRECOMPUTED = ("unshadowed", "shadowed")
"""Default of --variant."""

# ---- Options


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    command.add_argument("mesh", metavar="MESH", help="mesh: OBJ, PLY, STL, OFF, glTF")
    add_up(command)
    add_tangents(command)
    _add_materials(command.add_argument_group("materials"))
    _add_light(command.add_argument_group("light"))
    _add_compression(command.add_argument_group("compression"))
    add_output(command, ".shrt")


def _add_materials(group: Arguments) -> None:
    group.add_argument(
        "--brdf",
        action="append",
        required=True,
        metavar="BRDF",
        help=f"{MATERIAL}; twice with --mask",
    )
    add_extrapolate(group)
    group.add_argument(
        "--mask",
        metavar="FILE",
        help="picture over the texture coordinates that blends two materials: the first --brdf where it is"
        " black, the second where it is white",
    )


def _add_light(group: Arguments) -> None:
    group.add_argument(
        "--order",
        type=values.count,
        default=5,
        metavar="N",
        help="order of the light, degrees 0 to N - 1 (default: 5)",
    )
    group.add_argument(
        "--directions",
        type=values.count,
        default=4096,
        metavar="D",
        help="directions over the sphere in which rays are cast from each vertex (default: 4096)",
    )
    group.add_argument(
        "--variant",
        choices=VARIANTS,
        action="append",
        help="transfer without shadows, with shadows, or with interreflection; repeat for several (default:"
        f" {' and '.join(PRECOMPUTED)})",
    )
    group.add_argument(
        "--bounces",
        type=values.count,
        metavar="B",
        help="diffuse reflections between parts of the object, for --variant interreflected (default: 1)",
    )
    group.add_argument(
        "--albedo",
        type=values.number,
        metavar="A",
        help="albedo of these reflections, 0 to 1 (default: that of the material)",
    )


def _add_compression(group: Arguments) -> None:
    group.add_argument(
        "--accuracy",
        type=values.number,
        default=24.0,
        metavar="DB",
        help="least signal-to-noise ratio of the outgoing radiance, in dB, for the tents and again for the"
        " components (default: 24)",
    )
    group.add_argument(
        "--tents",
        type=values.tents,
        metavar="M",
        help="resolution of the outgoing light, M x M tents (default: from the accuracy)",
    )
    group.add_argument(
        "--route",
        type=route,
        metavar="ROUTE",
        help="expansions between rays and tents: direct, S (inner order), S,M (and order of the view) or"
        " published (default: from the accuracy)",
    )
    group.add_argument(
        "--components",
        type=values.count,
        metavar="K",
        help="principal components of the matrices (default: from the accuracy)",
    )
    group.add_argument(
        "--clusters",
        type=values.count,
        metavar="Q",
        help="clusters of vertices, each with its own K components, 3 unless given (default: 1)",
    )
    group.add_argument("--matrices", action="store_true", help="keep the uncompressed matrices as well")


def route(text: str) -> tuple[int, ...] | str:
    """Read "direct", "published", S or S,M."""
    parts = text.split(",")
    if text in ("direct", "published"):
        return text
    if len(parts) > 2 or not all(part.isascii() and part.isdigit() and int(part) > 0 for part in parts):
        raise values.refusal(text, "direct, published, S or S,M, such as 8,8")
    return tuple(int(part) for part in parts)


# ---- Work


def run(options: argparse.Namespace) -> None:
    """Read the mesh, precompute, save."""
    from shrm.transfer.precomputation import remove_work

    materials = _materials(options)
    require_compatible(flags_given(options), RULES)
    if options.output.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(options.output))
    work = options.output.with_name(options.output.name + ".work")
    start = time.perf_counter()
    transfer = _precomputed(options, materials, work)
    transfer.save(options.output)
    remove_work(work)
    print(f"{options.output}: {summary(transfer)}, {time.perf_counter() - start:.0f} s")


def _materials(options: argparse.Namespace) -> list[BRDF]:
    """Return the materials of the options: one, or two with a mask between them."""
    materials = [parse_brdf(material_text(options, text)) for text in options.brdf]
    if len(materials) != (1 if options.mask is None else 2):
        times = "once" if options.mask is None else "twice with argument --mask"
        raise argparse.ArgumentError(
            None, f"argument --brdf: must be given {times}, got {len(materials)} (--mask blends two)"
        )
    return materials


def _precomputed(options: argparse.Namespace, materials: list[BRDF], work: pathlib.Path) -> RadianceTransfer:
    """Precompute the transfer; finished stages stay in the folder `work`."""
    from shrm.transfer import precompute

    with stages() as progress:
        progress("reading the mesh", 0, 1)
        mesh = read_mesh(options)
        return precompute(
            mesh,
            materials if options.mask else materials[0],
            shares=_shares(options.mask, mesh) if options.mask else None,
            tangents=mesh.vertex_tangents,
            order=options.order,
            directions=options.directions,
            variants=options.variant or PRECOMPUTED,
            bounces=options.bounces,
            albedo=options.albedo,
            accuracy=options.accuracy,
            tents=options.tents,
            route=_route(options.route, options.order),
            components=options.components,
            clusters=options.clusters,
            matrices=options.matrices,
            work=work,
            progress=progress,
        )


def _shares(mask: str, mesh: Mesh) -> FloatArray:
    """Return the shares (V, 2) of two materials at the vertices, from the mean of a picture's channels."""
    import numpy as np

    from shrm import image_io

    colors = mesh.texture_at_vertices(image_io.read_image(mask).pixels)
    second = np.clip(colors[:, :3].mean(axis=1, dtype=np.float64), 0, 1)
    return np.stack([1 - second, second], axis=1)


def _route(orders: tuple[int, ...] | str | None, n: int) -> Route | None:
    """Return the route that the text of --route names, for light of order n."""
    from shrm.transfer import Route, published

    if orders is None:
        return None
    if isinstance(orders, str):
        return published(n) if orders == "published" else Route()
    return Route(orders[0], orders[1] if len(orders) > 1 else None)


def summary(transfer: RadianceTransfer) -> str:
    """Describe an object with transfer in one line."""
    snr = transfer.report.get("SNR of matrices")
    accuracy = "exact" if snr is None else f"{snr:.1f} dB"
    variants = ", ".join(f"{name} {_compression(transfer, name)}" for name in transfer.variants)
    return (
        f"{len(transfer.vertices)} vertices, {transfer.material},"
        f" {transfer.M} x {transfer.M} tents {accuracy}; {variants}"
    )


def _compression(transfer: RadianceTransfer, name: str) -> str:
    """Describe how a variant is compressed."""
    if transfer.variants[name].weights is None:
        return "uncompressed"
    snr = transfer.report.get("compression", {}).get(name, {}).get("SNR")
    return f"K = {transfer.variants[name].K}" + ("" if snr is None else f" {snr:.1f} dB")
