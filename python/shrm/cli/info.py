"""Say what an environment map or a material holds.

An environment: its size, its range, its mean radiance, and how its energy is spread over the
degrees of spherical harmonics. A material: its lobes and the orders that it needs.
"""

from __future__ import annotations

import argparse

from shrm.cli.options import add_environment

EXAMPLE = "shrm info grace.hdr    or    shrm info --brdf ggx:0.1"

DEGREES = 60  # of the spectrum that is looked at


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_environment(command, "env", layout_flags=("--layout", "--env-layout"))
    command.add_argument("--brdf", metavar="B", help="a material instead, such as microfacet:0.2")


def run(options: argparse.Namespace) -> None:
    """Print what is asked for."""
    print()
