"""Table 3 of [RH02]: what prefiltering costs against resolutions S, orders F and P, views T and width W.

Where the paper has the order of growth, here are exponents fitted to measured times: processor time of one
thread, the measure of work that other programs disturb least.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
from shrm import brdf, sh
from shrm.arrays import Float32Array, FloatArray
from shrm.environment import Environment, layouts
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.relight import Prefilter
from shrm.integrate.angular import AngularReflection, prefilter_angular
from shrm.prefiltered import explicit

from shrm_papers import single_thread
from shrm_papers.exponents import PowerLaw, fit
from shrm_papers.plotting import COLORS, MARKS, panels, plain_log
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "rh02-table-3"

Call = Callable[[], object]

MATERIAL = brdf.Microfacet(0.2).recentered("reflection")
EPSILON = 0.05  # of the lobe that angular integration leaves out, as in [RH02] section 7.4


@dataclass(frozen=True)
class Cost:
    """One growth to be measured.

    Attributes
    ----------
    kind : str
        The row of the paper's table and the space.
    theory : str
        The cost there.
    stage : str
        What is timed.
    against : str
        What grows.
    fixed : str
        What does not.
    expected : float
        The exponent of the theory.
    sizes : sequence of float
        Values of what grows.
    calls : sequence of callables
        The work for each.
    """

    kind: str
    theory: str
    stage: str
    against: str
    fixed: str
    expected: float
    sizes: Sequence[float]
    calls: Sequence[Call]


@dataclass(frozen=True)
class Measured:
    """A cost with its median times and their fit.

    Attributes
    ----------
    cost : Cost
        Without its calls.
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
    for found in single_thread.measured(__name__, settings):
        rounds = np.array(found.pop("seconds"))
        cost = Cost(**found, calls=())
        seconds = np.median(rounds, axis=0)
        spread = float((seconds / rounds.min(axis=0)).max())
        costs.append(Measured(cost, seconds, spread, fit(cost.sizes, seconds)))
    return Result(
        NAME,
        "exponents of the cost of prefiltering, measured against the theory's",
        (
            "type",
            "cost [RH02]",
            "what is timed",
            "against",
            "from",
            "to",
            "fixed",
            "ms, first",
            "ms, last",
            "median / fastest",
            "exponent",
            "standard error",
            "exponent [RH02]",
        ),
        [row_of(each) for each in costs],
        notes(),
        picture(costs),
    )


def measure(env: Environment, quick: bool) -> list[dict[str, Any]]:
    """Return every cost's description with its times, (rounds, sizes) seconds."""
    found = []
    for costs in (radial_costs, map_costs, explicit_costs, angular_costs):
        for cost in costs(env, quick):
            description = {
                part.name: getattr(cost, part.name) for part in fields(cost) if part.name != "calls"
            }
            seconds = single_thread.processor_seconds(cost.calls, 2 if quick else 9)
            found.append({**description, "seconds": seconds.tolist()})
    return found


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


# ---- What is timed. Each returns work to be called again and again; what is not timed is done before.


def analysis(pixels: Float32Array, F: int) -> Call:
    """Light to L_lm [RH02 section 6.1]."""
    return lambda: sh.analysis(pixels, F)


def synthesis(coefficients: FloatArray, S: int) -> Call:
    """B_lm to the one map of a radial BRDF."""
    return lambda: sh.synthesis(coefficients, S, 2 * S)


def both(pixels: Float32Array, F: int) -> Call:
    """Light to the map of a radial BRDF; the product between is F^2 and left out."""
    S = len(pixels)
    return lambda: sh.synthesis(sh.analysis(pixels, F), S, 2 * S)


def maps(env: Environment, F: int, P: int, S: int) -> Call:
    """L_lm and rho_lpq to the SHRM: both, and tables of the orders and sizes alone, are kept."""
    relit = Prefilter(env, MATERIAL, orders=(F, P), size=S)
    return lambda: relit.update()


def explicit_maps(rm: ReflectionMap, T: int) -> Call:
    """A SHRM to T x T reflection maps [RH02 eq. 12]."""
    return lambda: explicit.reflection_maps(rm, T)


def integration(angular: AngularReflection, S: int, views: FloatArray) -> Call:
    """Reflection maps of S x 2 S pixels over R, one for each view (n, 3), every pixel integrated."""
    R = np.tile(layouts.directions("latlong", S, 2 * S).reshape(-1, 3), (len(views), 1))
    V = np.repeat(views, 2 * S * S, axis=0)
    N = R + V
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    return lambda: angular.radiance(N, V)


# ---- The table's rows


def light_of(env: Environment, S: int) -> Float32Array:
    """Return the environment's low degrees as S x 2 S samples."""
    return sh.synthesis(env.coefficients(15), S, 2 * S)


def radial_costs(env: Environment, quick: bool) -> list[Cost]:
    """1D BRDF in frequency space: F_B S_B^2."""
    sizes = [128, 181, 256, 362] if quick else [256, 362, 512, 724, 1024, 1448]
    degrees = [12, 24, 48] if quick else [12, 18, 27, 40, 60, 90, 120]
    F, S = 30, (128 if quick else 512)
    pictures = {size: light_of(env, size) for size in {*sizes, S}}
    light = env.coefficients(max(degrees))

    def cost(stage: str, against: str, expected: float, calls: Sequence[Call]) -> Cost:
        fixed = f"S = {S}" if against == "F" else f"F = {F}"
        swept = degrees if against == "F" else sizes
        return Cost("1D BRDF, frequency", "F_B S_B^2", stage, against, fixed, expected, swept, calls)

    return [
        cost("analysis", "S_L", 2, [analysis(pictures[size], F) for size in sizes]),
        cost("synthesis", "S_B", 2, [synthesis(light[: (F + 1) ** 2], size) for size in sizes]),
        cost("both", "S", 2, [both(pictures[size], F) for size in sizes]),
        cost("analysis", "F", 1, [analysis(pictures[S], degree) for degree in degrees]),
        cost("synthesis", "F", 1, [synthesis(light[: (degree + 1) ** 2], S) for degree in degrees]),
        cost("both", "F", 1, [both(pictures[S], degree) for degree in degrees]),
    ]


def map_costs(env: Environment, quick: bool) -> list[Cost]:
    """SHRM: F_B P_B^2 S_B^2."""
    sizes = [64, 90, 128] if quick else [128, 182, 256, 362, 512]
    degrees = [12, 24, 48] if quick else [12, 17, 24, 34, 48, 68]
    orders = [1, 3, 7] if quick else [1, 2, 3, 5, 8, 11]
    F, P, S = 30, 3, 128

    def cost(against: str, expected: float, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "F_B P_B^2 S_B^2", "product and maps"
        return Cost("SHRM, frequency", theory, stage, against, fixed, expected, swept, calls)

    return [
        cost("S_B", 2, f"F = {F}, P = {P}", sizes, [maps(env, F, P, size) for size in sizes]),
        cost("F", 1, f"P = {P}, S = {S}", degrees, [maps(env, degree, P, S) for degree in degrees]),
        cost("P + 1", 2, f"F = {F}, S = {S}", [p + 1 for p in orders], [maps(env, F, p, S) for p in orders]),
    ]


def explicit_costs(env: Environment, quick: bool) -> list[Cost]:
    """3D BRDF in frequency space: P_B T_B^2 S_B^2."""
    sizes = [32, 64, 90] if quick else [64, 90, 128, 182, 256]
    orders = [1, 3, 7] if quick else [1, 2, 3, 5, 8, 11]
    counts = [2, 4, 6] if quick else [3, 4, 6, 8, 11, 16]
    F, P, S, T = 12, 3, 64, 4
    T_B = 10  # as the paper has it; fewer views share less of the sum over p

    def rm(P: int, S: int) -> ReflectionMap:
        return prefilter(env, MATERIAL, orders=(F, P), size=S)

    def cost(against: str, expected: float, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "P_B T_B^2 S_B^2", "T x T maps from the SHRM"
        return Cost("3D BRDF, frequency", theory, stage, against, fixed, expected, swept, calls)

    return [
        cost("T", 2, f"P = {P}, S = {S}", counts, [explicit_maps(rm(P, S), count) for count in counts]),
        cost("S_B", 2, f"P = {P}, T = {T}", sizes, [explicit_maps(rm(P, size), T) for size in sizes]),
        cost(
            "P + 1",
            1,
            f"S = {S}, T = {T_B}",
            [p + 1 for p in orders],
            [explicit_maps(rm(p, S), T_B) for p in orders],
        ),
    ]


def angular_costs(env: Environment, quick: bool) -> list[Cost]:
    """Both kinds in angular space: W S_L^2 S_B^2, and T_B^2 times that."""
    light_sizes = [32, 64, 90] if quick else [256, 362, 512, 724, 1024]
    sizes = [4, 8, 12] if quick else [4, 6, 8, 12, 16]
    exponents = [8, 32, 128] if quick else [8, 16, 32, 64, 128, 256]
    counts = [1, 2, 3] if quick else [1, 2, 3, 4]
    S_L, S_B, s = (64, 8, 32) if quick else (512, 8, 32)
    above = np.array([[0.0, 0.0, 1.0]])

    def lobe(material: brdf.BRDF, light_size: int) -> AngularReflection:
        light = Environment(light_of(env, light_size))
        return prefilter_angular(light, material, tolerance=EPSILON, subsamples=1)

    def one(s: float, light_size: int, size: int) -> Call:
        return integration(lobe(brdf.Phong(s), light_size), size, above)

    def radial(against: str, expected: float, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "W S_L^2 S_B^2", "integration"
        return Cost("1D BRDF, angular", theory, stage, against, fixed, expected, swept, calls)

    def general(against: str, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "W S_L^2 T_B^2 S_B^2", "integration"
        return Cost("3D BRDF, angular", theory, stage, against, fixed, 2, swept, calls)

    widths = [0.5 * (1 - EPSILON ** (1 / (s + 1))) for s in exponents]  # [RH02] appendix D
    facets = {size: lobe(MATERIAL, size) for size in {*light_sizes, S_L}}
    views = {count: explicit.grid_views(count).reshape(-1, 3) for count in counts}
    return [
        radial("S_L", 2, f"s = {s}, S_B = {S_B}", light_sizes, [one(s, size, S_B) for size in light_sizes]),
        radial("S_B", 2, f"s = {s}, S_L = {S_L}", sizes, [one(s, S_L, size) for size in sizes]),
        radial("W", 1, f"S_L = {S_L}, S_B = {S_B}", widths, [one(s, S_L, S_B) for s in exponents]),
        general(
            "S_L",
            f"sigma = .2, S_B = {S_B}, T = 1",
            light_sizes,
            [integration(facets[size], S_B, above) for size in light_sizes],
        ),
        general(
            "S_B",
            f"sigma = .2, S_L = {S_L}, T = 1",
            sizes,
            [integration(facets[S_L], size, above) for size in sizes],
        ),
        general(
            "T",
            f"sigma = .2, S_L = {S_L}, S_B = {S_B}",
            counts,
            [integration(facets[S_L], S_B, views[count]) for count in counts],
        ),
    ]


# ---- How it is shown


def row_of(measured: Measured) -> list[Cell]:
    """Return the table's row."""
    cost, law = measured.cost, measured.law
    return [
        cost.kind,
        cost.theory,
        cost.stage,
        cost.against,
        cost.sizes[0],
        cost.sizes[-1],
        cost.fixed,
        1e3 * float(measured.seconds[0]),
        1e3 * float(measured.seconds[-1]),
        round(measured.spread, 2),
        round(law.exponent, 3),
        round(law.deviation, 3),
        cost.expected,
    ]


PANELS = {
    "resolution S, frequency space": ("frequency", {"S", "S_L", "S_B"}),
    "order F": ("frequency", {"F"}),
    "order P + 1": ("frequency", {"P + 1"}),
    "resolution S, angular space": ("angular", {"S_L", "S_B"}),
    "width W of the lobe": ("angular", {"W"}),
    "views T of T x T": ("", {"T"}),
}


def picture(measured: Sequence[Measured]) -> Figure:
    """Draw times over sizes: marks are measured, lines fitted, dashes the theory's slopes."""
    figure, axes = panels(2, 3, 13.5, 10.0)
    for panel, (title, (space, variables)) in zip(axes, PANELS.items(), strict=True):
        shown = [m for m in measured if m.cost.against in variables and m.cost.kind.endswith(space)]
        for index, each in enumerate(shown):
            draw(panel, each, index, name_variable=len(variables) > 1)
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
    """Draw one cost."""
    cost, law = measured.cost, measured.law
    x = np.array(cost.sizes, dtype=np.float64)
    what = f"{cost.kind.split(',')[0].removesuffix(' BRDF')} {cost.stage}"
    if name_variable:
        what += f", {cost.against}"
    color = COLORS[index]
    panel.plot(x, 1e3 * measured.seconds, MARKS[index], color=color, markersize=5)
    label = f"{what}: {law.exponent:.2f} ({cost.expected:g})"
    panel.plot(
        x, 1e3 * law.at(x), "-", color=color, linewidth=1.4, marker=MARKS[index], markevery=[], label=label
    )
    middle = np.exp(np.log(x).mean())
    theory = law.at(middle) * (x / middle) ** cost.expected
    panel.plot(x, 1e3 * theory, "--", color=color, linewidth=1.0, alpha=0.7)
