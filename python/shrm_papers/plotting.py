"""The look of graphs: measured values as filled marks, the papers' as open ones on dashed lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

COLORS = ("#0b6fb8", "#d1495b", "#2e8b57", "#e08e0b", "#7b4fa3", "#5b6770", "#17a2a2", "#a0522d")
"""Colors that, together with `MARKS`, are told apart in print and by the color-blind."""

MARKS = ("o", "s", "^", "D", "v", "P", "X", "p")


def panels(rows: int, columns: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """Return a figure of width x height inches and its axes, row by row, without pyplot's global state."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False).flat)
    for panel in axes:
        panel.grid(True, which="major", color="0.88", linewidth=0.8)
        panel.set_axisbelow(True)
        panel.spines[["top", "right"]].set_visible(False)
    return figure, axes


def plain_log(axis: Axis, base: float = 10.0, subs: Sequence[float] = (1.0,), percent: bool = False) -> None:
    """Mark a logarithmic axis at powers of the base, times `subs`, with plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axis.set_major_locator(LogLocator(base=base, subs=subs, numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda x, _: f"{100 * x:.3g}%" if percent else f"{x:.6g}"))
    axis.set_minor_locator(NullLocator())


def measured_line(panel: Axes, index: int, label: str, x: npt.ArrayLike, y: npt.ArrayLike) -> None:
    """Draw measured values: filled marks, joined."""
    panel.plot(
        x, y, MARKS[index], color=COLORS[index], linestyle="-", linewidth=1.6, markersize=6, label=label
    )


def papers_line(panel: Axes, index: int, label: str, x: npt.ArrayLike, y: npt.ArrayLike) -> None:
    """Draw a paper's values: open marks, joined by dashes."""
    panel.plot(
        x,
        y,
        MARKS[index],
        color=COLORS[index],
        linestyle="--",
        linewidth=1.2,
        markersize=6,
        markerfacecolor="none",
        label=label,
    )
