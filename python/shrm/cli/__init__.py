"""The command `shrm`: one module for each of its commands, which imports what it needs when it runs.

The exit status is 0 on success, 1 if the work failed, 2 if the command line is wrong, 130 on an interrupt. A
failure is one line on standard error that names the file or the argument and what is wrong with it.

values, compatibility -> options -> stage -> material_stage, transfer_stage -> the commands
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from shrm.cli import convert, demo, info, prefilter, render, reproduce, transfer, view
from shrm.cli.console import warnings_as_lines
from shrm.files import one_line
from shrm.version import __version__

COMMANDS = (demo, info, convert, prefilter, transfer, render, view, reproduce)


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> None:  # type: ignore[override]
        """Print what is wrong with the command line and exit with status 2."""
        self.exit(2, f"{self.prog}: error: {message} (see {self.prog} --help)\n")


def parser() -> Parser:
    """Return the parser of the whole command line."""
    top = Parser(
        prog="shrm",
        description="Frequency-space environment map rendering: spherical harmonic reflection maps.",
        epilog="example: shrm demo    then    shrm COMMAND --help",
    )
    top.add_argument("--version", action="version", version=f"shrm {__version__}")
    commands = top.add_subparsers(metavar="COMMAND", required=True, parser_class=Parser)
    for module in COMMANDS:
        name = module.__name__.rpartition(".")[2]
        summary, _, details = (module.__doc__ or "").partition("\n\n")
        command = commands.add_parser(
            name,
            help=summary.rstrip("."),
            description=f"{summary}\n\n{details}".strip(),
            epilog=f"example: {module.EXAMPLE}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(command)
        command.set_defaults(run=module.run, parser=command)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status (argparse exits by itself with 0 or 2)."""
    options = parser().parse_args(arguments)
    try:
        with warnings_as_lines():
            options.run(options)
    except argparse.ArgumentError as fault:  # found after the command line was parsed
        options.parser.error(one_line(fault))
    except (OSError, ValueError, RuntimeError, MemoryError) as fault:
        print(f"shrm: error: {one_line(fault)}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0
