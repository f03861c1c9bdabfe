"""The tables and figures of [RH02], [KVHS00] and [LK03], made again with the papers' own figures beside them.

Each module of this package makes one result: `NAME`, and `make(settings) -> Result`.
"""

from __future__ import annotations

from importlib import import_module

from shrm_papers.result import Result, Settings

__all__ = ["MODULES", "Result", "Settings", "make", "names"]

MODULES = (
    "rh02.table_2",
    "rh02.table_3",
    "rh02.table_4",
    "rh02.table_5",
    "rh02.figure_1",
    "rh02.figure_5",
    "rh02.figure_6",
    "rh02.figure_7",
    "rh02.figure_8",
    "rh02.figure_9",
    "rh02.figure_10",
    "kvhs00.table_1",
    "kvhs00.table_2",
    "kvhs00.figure_3",
    "kvhs00.figure_4",
    "kvhs00.figure_5",
    "kvhs00.figure_6",
    "lk03.table_1",
    "lk03.figure_2",
    "lk03.figure_3",
    "lk03.figure_4",
    "lk03.figure_5",
)
"""In the papers' order. A module is imported when its result is made: plots are slow to load."""


def names() -> tuple[str, ...]:
    """Return the results' names, such as "rh02-table-4", in the papers' order."""
    return tuple(module.replace("_", "-").replace(".", "-") for module in MODULES)


def make(name: str, settings: Settings) -> Result:
    """Make one result.

    Parameters
    ----------
    name : str
        One of `names`.
    settings : Settings
        What it is made from.

    Raises
    ------
    ValueError
        If there is no result of that name.
    """
    if name not in names():
        raise ValueError(f"name must be one of {', '.join(names())}, got {name!r}")
    module = import_module(f"shrm_papers.{MODULES[names().index(name)]}")
    result: Result = module.make(settings)
    return result
