"""[KVHS00] section 5.1, the table: Phong's lobe by brute force and by hierarchical descent."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from shrm import brdf
from shrm.arrays import FloatArray
from shrm.environment import Environment
from shrm.integrate.angular import prefilter_angular
from shrm.integrate.hierarchical import prefilter_hierarchical

from shrm_papers import single_thread
from shrm_papers.errors import relative_rms_on_sphere
from shrm_papers.exponents import fit
from shrm_papers.plotting import measured_line, panels, papers_line, plain_log
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "kvhs00-table-1"

PAPER = {10: (413, 98), 50: (442, 83), 100: (474, 61), 250: (545, 55), 500: (552, 39)}
"""[KVHS00] section 5.1: seconds by brute force and hierarchically, at 350 MHz, by the exponent."""

ERROR = 0.01
"""Relative RMS error that the descent's threshold is found for."""

WIDTH_LEFT_OUT = 0.05
"""Fraction of the lobe's integral beyond its width W [RH02 section 7.4]."""

ROWS = 128
"""Rows of the light and of the maps, 128 x 256."""

SOURCES = (64, 128, 256, 512)
"""Rows of lights for maps of one size."""

FLOOR = 1e-9
"""Added to the lobe everywhere, so that brute force leaves no texel out."""

SHARPEST = 50
"""The largest exponent for brute force, whose time does not depend on it: sharper tables leave registers."""

VIEW = (0.0, 0.0, 1.0)
"""Any view: a radial lobe's map is the same for all."""

COLUMNS = (
    "exponent",
    "brute force, ms",
    "hierarchical, ms",
    "with its pyramid, ms",
    "speed up",
    "with its pyramid",
    "speed up [KVHS00]",
    "within W, ms",
    "speed up against that",
    "error",
    "error within W",
    "lobe evaluations for a texel",
)


def everywhere(exponent: float) -> brdf.Material:
    """Return Phong's lobe plus a little everywhere, so that its support is the sphere.

    Its profile is (s + 1) / 2 pi (cos^s + `FLOOR`).
    """

    def profile(cosine: FloatArray) -> FloatArray:
        return np.asarray((exponent + 1) / (2 * np.pi) * (np.maximum(cosine, 0) ** exponent + FLOOR))

    return brdf.Material((brdf.RadialLobe("reflection", profile),), "phong everywhere")


def make(settings: Settings) -> Result:
    """Time both, and integration within the width, for each exponent."""
    measured = single_thread.measured(__name__, settings)
    rows: list[list[Cell]] = []
    for s, (brute, within, descent, pyramid, error, cut, evaluations) in measured["rows"]:
        slow, fast = PAPER[s]
        times = [brute, descent, pyramid, brute / descent, brute / pyramid, slow / fast]
        rows.append([s, *times, within, within / descent, error, cut, evaluations])
    return Result(
        NAME,
        f"Phong's lobe by brute force over all texels and hierarchically, {settings.env_name}",
        COLUMNS,
        rows,
        _notes(measured["texels"], measured["seconds"]),
        _draw(rows),
    )


def measure(env: Environment, quick: bool) -> dict[str, Any]:
    """Return times, errors and evaluations by exponent, and seconds by source texels."""
    H = 16 if quick else ROWS
    rounds = 1 if quick else 5
    light = env.resized((H, 2 * H))
    rows = [(s, _measure_exponent(light, s, H, rounds)) for s in ((10, 500) if quick else PAPER)]
    sources = (16, 32) if quick else SOURCES
    calls = [_with_pyramid(env.resized((n, 2 * n)), brdf.Phong(50), H) for n in sources]
    seconds = np.median(single_thread.processor_seconds(calls, rounds), axis=0)
    return {"rows": rows, "texels": [2 * n * n for n in sources], "seconds": seconds.tolist()}


def _with_pyramid(light: Environment, lobe: brdf.BRDF, size: int) -> Callable[[], Any]:
    descent = prefilter_hierarchical(light, lobe, tolerance=ERROR, size=size)

    def call() -> Any:
        descent.update(light)
        return descent.at_view(VIEW)

    return call


def _measure_exponent(light: Environment, s: int, H: int, rounds: int) -> list[float]:
    """Return milliseconds of four ways, the errors of two, and lobe evaluations for a texel."""
    lobe = brdf.Phong(s)
    descent = prefilter_hierarchical(light, lobe, tolerance=ERROR, size=H)

    def integrated(material: Any, tolerance: float) -> Any:
        return prefilter_angular(light, material, cutoff=tolerance, size=H, subsamples=1, symmetry=False)

    def integration(material: Any, tolerance: float) -> Callable[[], Any]:
        # A map is kept once it is made: each round has its own, its tables made before.
        fresh = [integrated(material, tolerance) for _ in range(rounds + 1)]
        return lambda: fresh.pop().at_view(VIEW)

    # Times: brute force, within W, the descent without and with its pyramid
    calls = [
        integration(everywhere(min(s, SHARPEST)), 0.0),
        integration(lobe, WIDTH_LEFT_OUT),
        lambda: descent.at_view(VIEW),
        _with_pyramid(light, lobe, H),
    ]
    seconds = np.median(single_thread.processor_seconds(calls, rounds), axis=0)

    # Errors
    exact = integrated(lobe, 0.0).at_view(VIEW)
    within_W = integrated(lobe, WIDTH_LEFT_OUT).at_view(VIEW) / (1 - WIDTH_LEFT_OUT)
    return [
        *(float(1e3 * x) for x in seconds),
        relative_rms_on_sphere(descent.at_view(VIEW), exact),
        relative_rms_on_sphere(within_W, exact),
        descent.evaluations,
    ]


def _notes(texels: list[int], seconds: list[float]) -> list[str]:
    law = fit(texels, seconds)
    return [
        f"Light and maps are {2 * ROWS} x {ROWS} lat-long, RGB; the paper's are dual paraboloids of as many "
        "texels. Times are processor time of one thread, medians of rounds in which all take turns.",
        "Brute force: every texel for every texel, angle and lobe found for each pair, one node a texel, in "
        f"the core's widest vectors; for s beyond {SHARPEST}, whose table would not stay in registers, the "
        f"time of s = {SHARPEST}: it does not depend on s. Within W: the same for texels within the width "
        f"that holds all but {WIDTH_LEFT_OUT:.0%} of the lobe, rescaled in its error.",
        f"Hierarchical: descent at the threshold that was found for an error of {ERROR:.0%}. Finding "
        "it, from a sample of the map, takes several times as long and is not counted; a new light keeps it.",
        "Errors are relative RMS over the sphere against brute force. The paper compares by eye, at a "
        "threshold of .001 of the lobe alone; here the light of a node counts too.",
        f"Against the number of source texels, {texels[0]} to {texels[-1]}, for the same maps and s = 50, "
        f"with the pyramid, whose making grows with them: {1e3 * seconds[0]:.3g} to {1e3 * seconds[-1]:.3g} "
        f"ms, exponent {law.exponent:.2f} +- {law.deviation:.2f}.",
    ]


def _draw(rows: list[list[Cell]]) -> Figure:
    figure, (panel,) = panels(1, 1, 6.4, 4.0)
    table = np.array(rows, dtype=float)
    measured_line(panel, 0, "descent", table[:, 0], table[:, 4])
    measured_line(panel, 1, "descent and pyramid", table[:, 0], table[:, 5])
    papers_line(panel, 0, "[KVHS00]", table[:, 0], table[:, 6])
    measured_line(panel, 2, "descent, against integration within W", table[:, 0], table[:, 8])
    panel.set(xscale="log", yscale="log", xlabel="Phong exponent s", ylabel="speed up")
    plain_log(panel.xaxis, subs=(1.0, 2.0, 5.0))
    plain_log(panel.yaxis, subs=(1.0, 2.0, 5.0))
    panel.legend(frameon=False, fontsize=8)
    return figure
