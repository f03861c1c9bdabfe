"""Precompute how an object shadows and lights itself, for any light around it.

The mesh and its material become one file, for `shrm render` and `shrm view`. What takes long is kept in
FILE.work until it is finished: the same command goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import errno
import os
import time
from typing import TYPE_CHECKING

from shrm.arrays import FloatArray
from shrm.cli.console import stages
from shrm.cli.options import (
    add_extrapolate,
    add_output,
    add_tangents,
    material_text,
    number,
    parse_brdf,
    read_mesh,
    whole,
)

if TYPE_CHECKING:
    from shrm.render import Mesh
    from shrm.transfer import Path as Way
    from shrm.transfer import RadianceTransfer

EXAMPLE = "shrm transfer armadillo.obj --brdf ashikhmin-shirley:nu=40,nv=10 -o armadillo.shrt"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add = command.add_argument
    add("mesh", metavar="MESH", help="OBJ, PLY, STL, OFF or glTF")
    add("--up", choices=("y", "z"), default="y", help="the mesh's upward axis (default y)")
    add(
        "--brdf",
        action="append",
        required=True,
        metavar="B",
        help="material, such as ashikhmin-shirley:nu=40,nv=10, or a file of measurements; twice with --mask",
    )
    add_extrapolate(command)
    add(
        "--mask",
        metavar="FILE",
        help="picture over the mesh's texture coordinates: white has the second --brdf",
    )
    add_tangents(command, default="axis")
    add("--order", type=whole, default=5, metavar="N", help="of the light: degrees 0 to N - 1 (default 5)")
    add("--directions", type=whole, default=4096, metavar="D", help="rays over a sphere (default 4096)")
    add(
        "--bounces",
        type=whole,
        metavar="B",
        help="diffuse reflections between its parts (default: none)",
    )
    add("--albedo", type=number, metavar="A", help="of these bounces, 0 to 1 (default: the material's)")
    add("--no-shadows", action="store_true", help="light reaches every vertex")
    add(
        "--accuracy",
        type=number,
        default=24.0,
        metavar="DB",
        help="relative SNR of outgoing radiance in dB that tents, and again components, keep (default 24)",
    )
    add("--tents", type=whole, metavar="M", help="M x M tents in all (default: from the accuracy)")
    add(
        "--path",
        type=path,
        metavar="P",
        help="expansions between rays and tents: direct, S (inner order), S,M (and order of the view) or"
        " published (default: from the accuracy)",
    )
    add("--components", type=whole, metavar="K", help="principal components (default: from the accuracy)")
    add(
        "--clusters",
        type=whole,
        metavar="Q",
        help="of vertices, with K components each (default 1; K then 3)",
    )
    add("--uncompressed", action="store_true", help="keep the matrices as well")
    add_output(command, ".shrt")


def run(options: argparse.Namespace) -> None:
    """Read the mesh, compute, save."""
    from shrm.transfer import precompute
    from shrm.transfer.precompute import remove_work

    materials = [parse_brdf(material_text(options, text)) for text in options.brdf]
    if (len(materials) == 2) != (options.mask is not None) or len(materials) > 2:
        raise argparse.ArgumentError(None, "argument --mask: goes with two --brdf, and two --brdf with it")
    if options.no_shadows and options.bounces is not None:
        raise argparse.ArgumentError(None, "argument --bounces: not allowed with argument --no-shadows")
    if options.albedo is not None and options.bounces is None:
        raise argparse.ArgumentError(None, "argument --albedo: is that of --bounces, and needs them")
    if options.output.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(options.output))
    work = options.output.with_name(options.output.name + ".work")
    start = time.perf_counter()
    with stages() as progress:
        progress("reading the mesh", 0, 1)
        mesh = read_mesh(options)
        made = precompute(
            mesh,
            materials if options.mask else materials[0],
            shares=_shares(options.mask, mesh) if options.mask else None,
            tangents=mesh.vertex_tangents,
            n=options.order,
            directions=options.directions,
            variants=_variants(options),
            bounces=options.bounces or 1,
            albedo=options.albedo,
            accuracy=options.accuracy,
            M=options.tents,
            path=_way(options.path, options.order),
            K=options.components,
            clusters=options.clusters,
            matrices=options.uncompressed,
            work=work,
            progress=progress,
        )
        made.save(options.output)
    remove_work(work)
    print(f"{options.output}: {described(made)}, {time.perf_counter() - start:.0f} s")


def described(made: RadianceTransfer) -> str:
    """An object with transfer in one line."""
    snr = made.report.get("SNR of matrices")
    accuracy = "exact" if snr is None else f"{snr:.1f} dB"
    variants = ", ".join(f"{name} {_kept(made, name)}" for name in made.variants)
    return f"{len(made.vertices)} vertices, {made.material}, {made.M} x {made.M} tents {accuracy}; {variants}"


def _kept(made: RadianceTransfer, name: str) -> str:
    said = made.report.get("compression", {}).get(name, {})
    if made.variants[name].weights is None:
        return "uncompressed"
    snr = said.get("SNR")
    return f"K = {made.variants[name].K}" + ("" if snr is None else f" {snr:.1f} dB")


def _variants(options: argparse.Namespace) -> list[str]:
    names = ["unshadowed"]
    if not options.no_shadows:
        names.append("shadowed")
    if options.bounces is not None:
        names.append("interreflected")
    return names


def _shares(mask: str, mesh: Mesh) -> FloatArray:
    """The shares (V, 2) of two materials at the vertices, from the mean of a picture's channels."""
    import numpy as np

    from shrm import image_io

    colors = mesh.texture_at_vertices(image_io.read_image(mask).pixels)
    second = np.clip(colors[:, :3].mean(axis=1, dtype=np.float64), 0, 1)
    return np.stack([1 - second, second], axis=1)


def path(text: str) -> tuple[int, ...] | str:
    """Read direct, published, S or S,M."""
    parts = text.split(",")
    if text in ("direct", "published"):
        return text
    if len(parts) > 2 or not all(part.isascii() and part.isdigit() and int(part) > 0 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r}, but it needs direct, published, S or S,M, such as 8,8")
    return tuple(int(part) for part in parts)


def _way(said: tuple[int, ...] | str | None, n: int) -> Way | None:
    from shrm.transfer import Path, published

    if said is None:
        return None
    if isinstance(said, str):
        return published(n) if said == "published" else Path()
    return Path(said[0], said[1] if len(said) > 1 else None)
