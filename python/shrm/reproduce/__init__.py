"""The tables and figures of [RH02], [KVHS00] and [LK03], made again with the papers' own figures beside them.

Each module of this package makes one result: `NAME`, and `make(settings) -> Result`.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
[KVHS00] J. Kautz, P.-P. Vazquez, W. Heidrich, H.-P. Seidel. A Unified Approach to Prefiltered Environment
    Maps. Eurographics Workshop on Rendering 2000.
[LK03] J. Lehtinen, J. Kautz. Matrix Radiance Transfer. I3D 2003.
"""

from __future__ import annotations

from importlib import import_module

from shrm.reproduce.result import Result, Settings

__all__ = ["MODULES", "Result", "Settings", "make", "names"]

MODULES = (
    "table_2",
    "table_3",
    "table_4",
    "table_5",
    "figure_1",
    "figure_5",
    "figure_6",
    "figure_7",
    "figure_8",
    "figure_9",
    "figure_10",
    "kautz_table_1",
    "kautz_table_2",
    "kautz_figure_3",
    "kautz_figure_4",
    "kautz_figure_5",
    "kautz_figure_6",
    "lk_table_1",
    "lk_figure_2",
    "lk_figure_3",
    "lk_figure_4",
    "lk_figure_5",
)
"""In the papers' order. A module is imported when its result is made: plots are slow to load."""


def names() -> tuple[str, ...]:
    """Return the results' names, such as "table-4", in the papers' order."""
    return tuple(module.replace("_", "-") for module in MODULES)


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
    module = import_module(f"shrm.reproduce.{MODULES[names().index(name)]}")
    result: Result = module.make(settings)
    return result
