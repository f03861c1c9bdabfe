"""Checks of options that need or exclude each other: a table for each command, and one form of refusal.

An entry of a table is a flag (`--gpu`), a flag with one of its values (`--method angular`), or the name of a
positional argument (`FILE.shrt`). An option that has its default value counts as not given.
"""

from __future__ import annotations

import argparse
from collections.abc import Collection, Mapping
from typing import NamedTuple

TRANSFER_FILE = "FILE.shrt"
"""The positional argument of commands that draw an object with precomputed transfer."""


class Rule(NamedTuple):
    """Arguments that an option needs and that it excludes.

    Attributes
    ----------
    needs : tuple of str
        Arguments of which one must be given, too; none is needed if there are none.
    excludes : tuple of str
        Arguments that must not be given.
    """

    needs: tuple[str, ...] = ()
    excludes: tuple[str, ...] = ()


def flags_given(options: argparse.Namespace) -> set[str]:
    """Return the flags whose values are not the default, alone and with their value or each of several."""
    flags: set[str] = set()
    for name, value in vars(options).items():
        if value != options.parser.get_default(name):
            flag = f"--{name.replace('_', '-')}"
            flags |= {flag, *(f"{flag} {each}" for each in (value if isinstance(value, list) else [value]))}
    return flags


def require_compatible(present: Collection[str], rules: Mapping[str, Rule]) -> None:
    """Refuse arguments that do not go together.

    Raises
    ------
    argparse.ArgumentError
        If one is given that another excludes, or one is missing that another needs.
    """
    for option, rule in rules.items():
        if option not in present:
            continue
        for excluded in rule.excludes:
            if excluded in present:
                raise argparse.ArgumentError(None, f"argument {option}: not allowed with argument {excluded}")
        if rule.needs and not any(argument in present for argument in rule.needs):
            alternatives = " or ".join(rule.needs)
            raise argparse.ArgumentError(
                None, f"argument {option}: only allowed with argument {alternatives}"
            )
