"""Reproduce the tables and figures of the papers, with the papers' own numbers beside ours.

Writes NAME.csv, NAME.md and NAME.png for each, and index.md, which lists them. Needs no file, except that
rh02-figure-1 and the measured materials of rh02-figure-8 need --data.
"""

from __future__ import annotations

import argparse
import errno
import time
from pathlib import Path

from shrm.cli import values
from shrm.cli.console import progress
from shrm.cli.options import add_environment_option, read_environment

EXAMPLE = "shrm reproduce rh02-table-4 rh02-figure-6 --env grace.hdr -o reproduced"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    from shrm_papers import RESULTS

    names = ", ".join(RESULTS)

    def name(text: str) -> str:
        if text not in RESULTS:
            raise values.refusal(text, f"one of {names}")
        return text

    command.add_argument(
        "names", nargs="*", type=name, metavar="NAME", help=f"result to make: {names} (default: all)"
    )
    add_environment_option(command)
    command.add_argument(
        "--data",
        type=Path,
        metavar="DIR",
        help="folder of data: measured materials in brdf/ for rh02-figure-8; for rh02-figure-1 also krylon"
        " and golden_yellow there, the maps grace, stpeters, uffizi and rnl in env/, and armadillo in mesh/",
    )
    command.add_argument(
        "--fits",
        type=Path,
        metavar="DIR",
        help="folder of published fits to measured materials, in place of those that come with shrm",
    )
    command.add_argument(
        "--mesh",
        type=Path,
        metavar="FILE",
        help="mesh for rh02-figure-1, kvhs00-figure-6 (such as a teapot) and all results of lk03",
    )
    command.add_argument(
        "--quick", action="store_true", help="fewer rows and samples, to check that everything runs"
    )
    command.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("reproduced"),
        metavar="DIR",
        help="folder to write (default: reproduced)",
    )


def run(options: argparse.Namespace) -> None:
    """Make each result, write it, then the index of all."""
    from shrm_papers import RESULTS, Settings, make
    from shrm_papers.index import write_index

    for folder in (options.data, options.fits):
        if folder is not None and not folder.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, "is not a folder", str(folder))

    # The light, and the other settings
    with progress("Reading the environment"):
        env = read_environment(options)
    if not env.pixels.any():
        raise ValueError(f"{options.env}: every texel is black, and nothing reflects no light")
    settings = Settings(env, Path(options.env).stem, options.fits, options.mesh, options.quick, options.data)

    # The results in the papers' order, each written at once
    results = []
    for name in RESULTS:
        if options.names and name not in options.names:
            continue
        start = time.perf_counter()
        with progress(f"Making {name}"):
            result = make(name, settings)
            result.write(options.output)
        print(f"{name:15} {result.title}, {time.perf_counter() - start:.1f} s", flush=True)
        results.append(result)
    print(write_index(options.output, settings, results))
