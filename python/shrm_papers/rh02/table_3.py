"""[RH02] table 3: what prefiltering costs against resolutions S, orders F and P, views T and width W.

Where the paper has the order of growth, here are exponents fitted to measured times: processor time of one
thread, the measure of work that other programs disturb least.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from shrm.arrays import FloatArray

from shrm_papers import single_thread
from shrm_papers.exponents import PowerLaw, fit
from shrm_papers.plotting import COLORS, MARKS, panels, plain_log
from shrm_papers.result import Cell, Result, Settings
from shrm_papers.rh02 import prefiltering_costs
from shrm_papers.rh02.prefiltering_costs import EPSILON, Cost

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "rh02-table-3"


@dataclass(frozen=True)
class Measured:
    """A cost with its median times and their fit.

    Attributes
    ----------
    cost : Cost
        A cost without its calls, which stayed in the process that made them.
    seconds : (sizes,) float64
        Median over the rounds.
    spread : float
        The largest ratio of a size's median to its fastest round: near 1 where nothing disturbed.
    law : PowerLaw
        The fit to the medians.
    """

    cost: Cost
    seconds: FloatArray
    spread: float
    law: PowerLaw


def make(settings: Settings) -> Result:
    """Time every cost of the table and fit its exponents."""
    costs = []
    for attributes in single_thread.measured(prefiltering_costs.__name__, settings):
        rounds = np.array(attributes.pop("seconds"))
        cost = Cost(**attributes, calls=())
        seconds = np.median(rounds, axis=0)
        spread = float((seconds / rounds.min(axis=0)).max())
        costs.append(Measured(cost, seconds, spread, fit(cost.sizes, seconds)))
    rows = [row_of(measured) for measured in costs]
    return Result(
        NAME,
        "Exponents of the cost of prefiltering, measured against the theory's",
        tuple(rows[0]),
        [list(row.values()) for row in rows],
        notes(),
        picture(costs),
    )


def row_of(measured: Measured) -> dict[str, Cell]:
    """Return the cells of a row by their headings."""
    cost, law = measured.cost, measured.law
    return {
        "type": cost.kind,
        "cost [RH02]": cost.theory,
        "what is timed": cost.stage,
        "against": cost.against,
        "from": cost.sizes[0],
        "to": cost.sizes[-1],
        "fixed": cost.fixed,
        "ms, first": 1e3 * float(measured.seconds[0]),
        "ms, last": 1e3 * float(measured.seconds[-1]),
        "median / fastest": round(measured.spread, 2),
        "exponent": round(law.exponent, 3),
        "standard error": round(law.deviation, 3),
        "exponent [RH02]": cost.expected,
    }


PANELS: Mapping[str, tuple[str, set[str]]] = {
    "resolution S, frequency space": ("frequency", {"S", "S_L", "S_B"}),
    "order F": ("frequency", {"F"}),
    "order P + 1": ("frequency", {"P + 1"}),
    "resolution S, angular space": ("angular", {"S_L", "S_B"}),
    "width W of the lobe": ("angular", {"W"}),
    "views T of T x T": ("", {"T"}),
}
"""Panels of the picture: the space, "" for both, and the sizes that grow."""


def picture(measured: Sequence[Measured]) -> Figure:
    """Draw times over sizes: marks are measured, lines fitted, dashes the theory's slopes."""
    figure, axes = panels(2, 3, 13.5, 10.0)
    for panel, (title, (space, variables)) in zip(axes, PANELS.items(), strict=True):
        costs = [m for m in measured if m.cost.against in variables and m.cost.kind.endswith(space)]
        for index, cost in enumerate(costs):
            draw(panel, cost, index, name_variable=len(variables) > 1)
        panel.set(xscale="log", yscale="log", xlabel=title, ylabel="milliseconds of one thread")
        if variables == {"W"}:
            plain_log(panel.xaxis, subs=(1, 2, 5))
        else:
            plain_log(panel.xaxis, base=4 if len(variables) > 1 else 2)
        plain_log(panel.yaxis, subs=(1, 2, 5))
        # Above the panel, where it hides nothing.
        panel.legend(loc="lower left", bbox_to_anchor=(0, 1), fontsize=8, frameon=False)
    figure.suptitle("Cost of prefiltering: marks measured, lines fitted; dashed and in brackets: [RH02]")
    return figure


def draw(panel: Axes, measured: Measured, index: int, name_variable: bool) -> None:
    """Draw the times of one cost, their fit, and the theory's slope through its middle."""
    cost, law = measured.cost, measured.law
    x = np.array(cost.sizes, dtype=np.float64)
    name = f"{cost.kind.split(',')[0].removesuffix(' BRDF')} {cost.stage}"
    if name_variable:
        name += f", {cost.against}"
    color = COLORS[index]
    panel.plot(x, 1e3 * measured.seconds, MARKS[index], color=color, markersize=5)
    label = f"{name}: {law.exponent:.2f} ({cost.expected:g})"
    panel.plot(
        x, 1e3 * law.at(x), "-", color=color, linewidth=1.4, marker=MARKS[index], markevery=[], label=label
    )
    middle = np.exp(np.log(x).mean())
    theory = law.at(middle) * (x / middle) ** cost.expected
    panel.plot(x, 1e3 * theory, "--", color=color, linewidth=1.0, alpha=0.7)


def notes() -> list[str]:
    """Return what the numbers mean."""
    return [
        "Each exponent is the least-squares slope of log time over log size. Times are processor time of one"
        " thread, so that they count work: wall times with threads snap to the system's time slices where"
        " anything else runs. The time of a size is the median of rounds over all sizes; its largest ratio to"
        " the fastest round says how much was disturbed, the standard error how straight the line is.",
        "Maps have S rows and 2 S columns, RGB. S_L is the light's, S_B the maps'. P and T count as P + 1 and"
        " T, T x T being the views of an explicit set.",
        "An exponent below the theory's says that, over this range, part of the work grows more slowly than"
        " the leading term that the theory counts. Where the standard error is above .1 the points bend, and"
        " one exponent describes them badly.",
        "1D against F: reading the texels, separating their channels and folding the circle cost the same"
        " for every F, as much as some 30 degrees; and orders are summed in whole vectors, 16 to a fold. The"
        " product itself grows as F. Against S: calls and tables of F alone are in every time.",
        "SHRM: the product for the coefficients of the maps, F^2 P^2, is in every time whatever S_B. Against"
        " F, the maps' degree is F + P, and unfolding and storing cost the same for every F.",
        "3D explicit maps: the sum over p is taken once for each theta of the view, then that over q, as the"
        " paper's conversion does. New memory for the maps costs the same for every P, the sums over p grow"
        " as T, and T = 10 [RH02 section 7.4] is small enough for their P^2 to show beside P.",
        f"Angular: every pixel integrated by itself over the lobe but for {EPSILON:.0%} of it, one node a"
        " texel; W is varied by Phong's exponent [RH02 appendix D]. Half vectors are found once for a view"
        " where their table fits a cache, else for every pair.",
    ]
