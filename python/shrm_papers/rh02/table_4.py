"""[RH02] table 4: a Phong lobe prefiltered by direct integration and in frequency space.

The paper compares one implementation of each. Here direct integration comes in two forms: (a) the paper's
kind, where every texel within the lobe's width is visited for every pixel, its angle and the lobe found
anew; and (b) the best there is, which finds them once for each row of a lat-long map and slides them along
it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from shrm import brdf
from shrm.arrays import Float32Array
from shrm.environment import Environment
from shrm.frequency.analysis import analyse
from shrm.frequency.prefilter import prefilter
from shrm.frequency.relight import Prefilter
from shrm.integrate.angular import AngularReflection, prefilter_angular

from shrm_papers import single_thread
from shrm_papers.errors import relative_rms_on_sphere
from shrm_papers.exponents import fit
from shrm_papers.plotting import COLORS, measured_line, panels, papers_line, plain_log
from shrm_papers.result import Cell, Result, Settings
from shrm_papers.rh02 import flops
from shrm_papers.rh02.peak import flops_per_second

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "rh02-table-4"

Call = Callable[[], object]

EPSILON = 0.05
"""Fraction of the lobe's integral that direct integration leaves out [RH02 section 7.4]."""

VIEW = (0.0, 0.0, 1.0)
"""Any view: a radial lobe's map is the same for all."""

REPEATS = 40
"""Calls to one measured time, of work that takes less than a millisecond."""

PAPER = {
    8: (67.28, 0.081),
    16: (38.03, 0.114),
    32: (21.80, 0.159),
    64: (11.94, 0.227),
    128: (7.17, 0.328),
    256: (3.55, 0.461),
    512: (2.28, 0.686),
}
"""[RH02] table 4, by the exponent s: seconds in angular and in frequency space, at 1.4 GHz."""

BEYOND = (1024, 2048, 4096)
"""Exponents past the paper's, towards s*, where both sides cost the same."""


def make(settings: Settings) -> Result:
    """Measure both sides for every exponent."""
    measured = single_thread.measured(__name__, settings)
    rows = [row_of(row, measured["size"], measured["peak"]) for row in measured["rows"]]
    return Result(
        NAME,
        f"Time to prefilter with Phong's lobe, by integration and in frequency space, {settings.env_name}",
        tuple(rows[0]),
        [list(row.values()) for row in rows],
        notes(measured),
        picture(measured["rows"]),
    )


def row_of(row: dict[str, Any], size: int, peak: float) -> dict[str, Cell]:
    """Return the cells of a row by their headings, from what was measured."""
    s, (a, b, frequency, papers, one_shot) = row["s"], row["seconds"]
    angular_paper, frequency_paper = PAPER.get(s, (None, None))
    ratio_paper = angular_paper and frequency_paper and round(angular_paper / frequency_paper, 1)
    flops_a, flops_b = (flops.angular_flops(size, s, EPSILON, symmetry) for symmetry in (False, True))
    return {
        "s": s,
        "angular (a), ms": 1e3 * a,
        "angular (b), ms": 1e3 * b,
        "F": row["F"],
        "frequency, ms": 1e3 * frequency,
        "(a) / frequency": a / frequency,
        "(b) / frequency": b / frequency,
        "angular, s [RH02]": angular_paper,
        "frequency, s [RH02]": frequency_paper,
        "ratio [RH02]": ratio_paper,
        "error, angular": row["angular error"],
        "error, angular rescaled": row["rescaled error"],
        "error, frequency": row["frequency error"],
        "F = 1 + sqrt(6 s) [RH02]": row["paper's F"],
        "error there": row["paper's error"],
        "ms there": 1e3 * papers,
        "frequency in one shot, ms": 1e3 * one_shot,
        "of peak, (a)": flops_a / a / peak,
        "of peak, (b)": flops_b / b / peak,
        "of peak, frequency": flops.frequency_flops(size, row["F"]) / frequency / peak,
    }


# ---- What is measured


def measure(env: Environment, quick: bool) -> dict[str, Any]:
    """Return the orders, errors and median seconds of every exponent, the size, and the machine's peak."""
    size = 32 if quick else 128
    exponents = (8, 32) if quick else (*PAPER, *BEYOND)
    rounds = 3 if quick else 9
    light = env.resized((size, 2 * size))
    rows: list[dict[str, Any]] = []
    calls: list[tuple[Call, int]] = []
    for s in exponents:
        rows.append(compared(light, s))
        calls += timed(light, s, rows[-1]["F"], rows[-1]["paper's F"], rounds)
    # All take turns, so that what disturbs one disturbs all.
    seconds = single_thread.processor_seconds([repeated(*call) for call in calls], rounds)
    each = np.median(seconds, axis=0) / [times for _, times in calls]
    for row, of_row in zip(rows, each.reshape(len(rows), -1), strict=True):
        row["seconds"] = of_row.tolist()
    return {"rows": rows, "size": size, "peak": flops_per_second()}


def compared(light: Environment, s: int) -> dict[str, Any]:
    """Return the orders and errors for one exponent."""
    exact = converged(light, s)
    forms = [integrated(light, s, symmetry) for symmetry in (False, True)]
    angular = min(relative_rms_on_sphere(form, exact) for form in forms)
    rescaled = min(relative_rms_on_sphere(form / np.float32(1 - EPSILON), exact) for form in forms)

    def error(F: int) -> float:
        return relative_rms_on_sphere(in_frequency(light, s, F), exact)

    # The smallest F that is no worse than integration.
    F = 0
    while (frequency := error(F)) > min(angular, rescaled):
        F += 1
    papers_F = round(1 + float(np.sqrt(6 * s)))  # [RH02] section 7.4
    return {
        "s": s,
        "F": F,
        "angular error": angular,
        "rescaled error": rescaled,
        "frequency error": frequency,
        "paper's F": papers_F,
        "paper's error": error(papers_F),
    }


def timed(light: Environment, s: int, F: int, papers_F: int, rounds: int) -> list[tuple[Call, int]]:
    """Return the calls to time, each with its number to one measured time.

    Angular (a) and (b); the maps of F and of the paper's F; F with nothing kept from before.
    """
    return [
        (integration(light, s, False, rounds), 1),
        (integration(light, s, True, rounds), 1),
        (relighting(light, s, F), REPEATS),
        (relighting(light, s, papers_F), REPEATS),
        (lambda: in_one_shot(light, s, F), 1),
    ]


def repeated(call: Call, times: int) -> Call:
    """Return a call that makes another `times` times."""

    def again() -> None:
        for _ in range(times):
            call()

    return again


def integration(light: Environment, s: int, symmetry: bool, rounds: int) -> Call:
    """Time direct integration, its tables made before."""
    # A radial lobe's map is kept once it is made: each round, and the one that does not count, has its own.
    fresh = [lobe(light, s, symmetry) for _ in range(rounds + 1)]
    return lambda: fresh.pop().at_view(VIEW)


def relighting(light: Environment, s: int, F: int) -> Call:
    """Time light to coefficients to the map, all tables and memory made before."""
    plan = Prefilter(light, brdf.Phong(s), orders=(F, 0), size=len(light.pixels))
    out = np.empty(light.pixels.shape, dtype=np.float32)
    return lambda: plan.update(light).at_view(VIEW, out)


def in_one_shot(light: Environment, s: int, F: int) -> object:
    """Make the map from light and material, with nothing kept from before."""
    analyse.cache_clear()
    return in_frequency(Environment(light.pixels), s, F)


# ---- Maps, (H, 2 H, 3)


def lobe(light: Environment, s: int, symmetry: bool) -> AngularReflection:
    """Integrate the part of the lobe that [RH02] section 7.4 keeps, one node to a texel."""
    return prefilter_angular(
        light, brdf.Phong(s), cutoff=EPSILON, size=len(light.pixels), subsamples=1, symmetry=symmetry
    )


def integrated(light: Environment, s: int, symmetry: bool) -> Float32Array:
    """Return the map by direct integration."""
    return lobe(light, s, symmetry).at_view(VIEW)


def in_frequency(light: Environment, s: int, F: int) -> Float32Array:
    """Return the map by a series to degree F."""
    rm = prefilter(light, brdf.Phong(s), orders=(F, 0), size=len(light.pixels))
    return rm.at_view(VIEW)


def converged(light: Environment, s: int) -> Float32Array:
    """Return the map of the same piecewise constant light, exact to rounding.

    rho_l falls as exp(-l^2 / 2s) [RH02 section 6.3], which is 1e-8 at l = 6 sqrt(s); for small s, where the
    lobe's edge shows, as a power.
    """
    return in_frequency(light, s, 40 + int(6 * np.sqrt(s)))


# ---- What the numbers mean


def crossings(
    s: Sequence[float], angular: Sequence[float], frequency: Sequence[float]
) -> tuple[float, float]:
    """Return s* where both cost the same: of lines of the theory's slopes, and of freely fitted ones.

    The theory's are 1/s in angular space [RH02 eq. 10] and sqrt(s) in frequency space [RH02 eq. 9].
    """
    by_theory = fit(s, frequency, 0.5).crossing(fit(s, angular, -1.0))
    return by_theory, fit(s, frequency).crossing(fit(s, angular))


def measured_crossing(
    s: Sequence[float], angular: Sequence[float], frequency: Sequence[float]
) -> float | None:
    """Return the first s* between two measured ones, along lines in log-log; None if there is none."""
    log_s, log_ratio = np.log(s), np.log(angular) - np.log(frequency)
    for k in range(len(log_s) - 1):
        if log_ratio[k] > 0 >= log_ratio[k + 1]:
            share = log_ratio[k] / (log_ratio[k] - log_ratio[k + 1])
            return float(np.exp(log_s[k] + share * (log_s[k + 1] - log_s[k])))
    return None


def notes(measured: dict[str, Any]) -> list[str]:
    """Return what the numbers mean."""
    rows, size = measured["rows"], measured["size"]
    return [
        f"Light and maps are {2 * size} x {size} lat-long, RGB; the paper's are 128 x 128. Times are"
        " processor time of one thread, the median of rounds in which all calls take turns; tables and memory"
        " are made before. Frequency: light to coefficients to radiance, `Prefilter.update` and `at_view`,"
        f" {REPEATS} times to a measurement. In one shot: `prefilter` with the analysis of the material,"
        " nothing kept.",
        f"Angular: one node for each texel within the lobe's width W, which leaves {EPSILON:.0%} of its"
        " integral out [RH02 section 7.4, appendix D]. (a) is the paper's kind: the angle and the lobe are"
        " evaluated for every pair of a pixel and a texel. (b) is the best we can write: they are evaluated"
        " once for each row of the map, and the weights slide along it, since a lat-long grid is the same"
        " from all its columns. Light or maps on cubes have no such symmetry.",
        "Errors are relative RMS over the sphere against the converged map of the same light, each texel of"
        " which is constant: a series far beyond where Phong's coefficients vanish. Rescaled: over"
        f" {1 - EPSILON:g}, so that the lobe that is kept has the integral of the whole.",
        "F is the smallest at which the frequency side's error is no larger than the angular side's, rescaled"
        " or not. The paper's own F, rounded, is for 1% of the lobe's energy; its error and time are beside.",
        "Fractions of peak count two flops for a multiply-add:"
        f" {flops.FLOPS_OF_WEIGHT + flops.FLOPS_OF_SUM} for each sample of (a), the angle, a"
        f" cubic and three channels; {flops.FLOPS_OF_SUM} for each of (b), and"
        f" {flops.FLOPS_OF_WEIGHT} for each weight; in frequency space the products of the two"
        " transforms, phi folded to a quarter. The peak is that of a float32 matrix product of BLAS in the"
        f" same process, {measured['peak'] / 1e9:.0f} Gflop/s.",
        measured_crossings_note(rows),
        fitted_crossings_note([row for row in rows if row["s"] in PAPER], size),
    ]


def measured_crossings_note(rows: Sequence[dict[str, Any]]) -> str:
    """Say at which s* the measured times of both sides meet."""
    s = [row["s"] for row in rows]
    a, b, frequency, at_papers_F = ([row["seconds"][k] for row in rows] for k in range(4))

    def star(angular: Sequence[float], frequency: Sequence[float]) -> str:
        crossing = measured_crossing(s, angular, frequency)
        return f"beyond {s[-1]}" if crossing is None else f"{crossing:.0f}"

    return (
        "s*, where both sides cost the same, is measured between the rows, some of which go past the paper's:"
        f" (a) {star(a, frequency)}, (b) {star(b, frequency)} at equal errors; {star(a, at_papers_F)} and"
        f" {star(b, at_papers_F)} at the paper's F."
        " Where lobes are narrower than texels, one node for each is no longer accurate, and a small F does"
        " as well."
    )


def fitted_crossings_note(rows: Sequence[dict[str, Any]], size: int) -> str:
    """Say at which s* lines through the times of the paper's exponents meet."""
    s = [row["s"] for row in rows]
    a, b, frequency = ([row["seconds"][k] for row in rows] for k in range(3))
    papers = zip(*(PAPER[exponent] for exponent in s), strict=True)
    lines = [crossings(s, *times) for times in ((a, frequency), (b, frequency), tuple(papers))]
    (line_a, free_a), (line_b, free_b), (line_paper, free_paper) = lines
    laws = [fit(s, times).exponent for times in (a, b, frequency)]
    return (
        "s* of lines through the times of the paper's exponents: of the slopes of eq. 9, sqrt(s), and 10,"
        f" 1/s, {line_a:.0f} for (a), {line_b:.0f} for (b) and {line_paper:.0f} for the paper's times; of"
        f" free slopes {free_a:.0f}, {free_b:.0f} and {free_paper:.0f}. The free slopes are {laws[0]:.2f},"
        f" {laws[1]:.2f} and, in frequency space, {laws[2]:.2f}; where they are flatter than the theory's,"
        " for work that s does not change, the theory's lines meet before the times do. Its own"
        f" s* = S_L^(4/3), constants left out, is {(2 * size**2) ** (2 / 3):.0f} for S_L^2 = {2 * size} x"
        f" {size} texels, and 645 for 128 x 128 [RH02 section 6.3]."
    )


def picture(rows: Sequence[dict[str, Any]]) -> Figure:
    """Draw times against s, ours in ms, the paper's in s, dotted the theory's slopes; ratios at the right."""
    figure, (times, ratios) = panels(1, 2, 13.0, 5.8)
    s = np.array([row["s"] for row in rows], dtype=np.float64)
    a, b, frequency = (np.array([row["seconds"][k] for row in rows]) for k in range(3))
    s_paper = np.array([exponent for exponent in s if exponent in PAPER])
    angular_paper, frequency_paper = np.array([PAPER[exponent] for exponent in s_paper]).T

    # Times
    for index, (label, seconds, slope) in enumerate(
        (("angular (a)", a, -1.0), ("angular (b)", b, -1.0), ("frequency", frequency, 0.5))
    ):
        measured_line(times, index, label, s, 1e3 * seconds)
        line = fit(s_paper, seconds[: len(s_paper)], slope)
        times.plot(s_paper, 1e3 * line.at(s_paper), ":", color=COLORS[index], linewidth=1.4, alpha=0.8)
    papers_line(times, 0, "angular, s [RH02]", s_paper, angular_paper)
    papers_line(times, 2, "frequency, s [RH02]", s_paper, frequency_paper)
    times.set(ylabel="milliseconds of one thread; [RH02] in seconds; dotted: slopes of theory")

    # Ratios
    for index, (label, ratio) in enumerate(
        (("(a) / frequency", a / frequency), ("(b) / frequency", b / frequency))
    ):
        measured_line(ratios, index, label, s, ratio)
    papers_line(ratios, 2, "[RH02]", s_paper, angular_paper / frequency_paper)
    ratios.axhline(1, color="0.4", linewidth=1.0)
    ratios.set(ylabel="angular time over frequency time")
    for panel in (times, ratios):
        panel.set(xscale="log", yscale="log", xlabel="Phong exponent s")
        plain_log(panel.xaxis, base=2)
        plain_log(panel.yaxis, subs=(1, 2, 5) if panel is times else (1, 3))
        panel.legend(fontsize=9, frameon=False)
    return figure
