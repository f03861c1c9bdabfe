"""[RH02] table 5: a microfacet lobe's T x T reflection maps by direct integration and from SHRMs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from shrm_papers import single_thread
from shrm_papers.plotting import measured_line, panels, papers_line, plain_log
from shrm_papers.result import Cell, Result, Settings
from shrm_papers.rh02 import flops, microfacet_maps
from shrm_papers.rh02.microfacet_maps import BRDF_EPSILON, EPSILON, PAPER, T

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "rh02-table-5"


def make(settings: Settings) -> Result:
    """Measure both sides for every roughness."""
    measured = single_thread.measured(microfacet_maps.__name__, settings)
    rows = [row_of(row, measured["size"], measured["peak"]) for row in measured["rows"]]
    return Result(
        NAME,
        f"Time of {T} x {T} reflection maps, microfacet, by integration and from SHRMs, {settings.env_name}",
        tuple(rows[0]),
        [list(row.values()) for row in rows],
        notes(measured),
        picture(measured["rows"]),
    )


def row_of(row: dict[str, Any], size: int, peak: float) -> dict[str, Cell]:
    """Return the cells of a row by their headings, from what was measured."""
    # Ours, the paper's, and the operations that ours take
    sigma = row["sigma"]
    a, b, shrm, frequency, papers_shrm, papers_frequency, one_shot = row["seconds"]
    F, P, angular_paper, map_paper, frequency_paper, shrm_paper = PAPER[sigma]
    flops_a, flops_b = (flops.half_angle_flops(row["samples"], tabulated) for tabulated in (False, True))
    flops_shrm = flops.shrm_flops(size, *row["orders"])
    flops_frequency = flops_shrm + T * T * flops.view_flops(size, row["orders"][1])

    return {
        "sigma": sigma,
        f"F, P for {BRDF_EPSILON:.0%}": "{}, {}".format(*row["by energy"]),
        "F, P [RH02]": f"{F}, {P}",
        "angular (a), s": T * T * a,
        "(a) per map, ms": 1e3 * a,
        "angular (b), s": T * T * b,
        "(b) per map, ms": 1e3 * b,
        "F, P": "{}, {}".format(*row["orders"]),
        "frequency, ms": 1e3 * frequency,
        "SHRM, ms": 1e3 * shrm,
        "(a) / frequency": T * T * a / frequency,
        "(b) / frequency": T * T * b / frequency,
        "(a) per map / SHRM": a / shrm,
        "(b) per map / SHRM": b / shrm,
        "angular, s [RH02]": angular_paper,
        "per map, s [RH02]": map_paper,
        "frequency, s [RH02]": frequency_paper,
        "SHRM, s [RH02]": shrm_paper,
        "angular / frequency [RH02]": round(angular_paper / frequency_paper, 1),
        "per map / SHRM [RH02]": round(map_paper / shrm_paper, 1),
        "error, angular": row["angular error"],
        "error, angular rescaled": row["rescaled error"],
        "error, frequency": row["frequency error"],
        f"error, F, P for {BRDF_EPSILON:.0%}": row["energy error"],
        "error at the paper's F, P": row["paper's error"],
        "frequency there, ms": 1e3 * papers_frequency,
        "SHRM there, ms": 1e3 * papers_shrm,
        "(a) / frequency there": T * T * a / papers_frequency,
        "(b) / frequency there": T * T * b / papers_frequency,
        "SHRM in one shot, ms": 1e3 * one_shot,
        "of peak, (a)": flops_a / a / peak,
        "of peak, (b)": flops_b / b / peak,
        "of peak, frequency": flops_frequency / frequency / peak,
        "of peak, SHRM": flops_shrm / shrm / peak,
    }


def notes(measured: dict[str, Any]) -> list[str]:
    """Return notes on the meaning of the numbers."""
    size, views = measured["size"], measured["views"]
    return [
        f"Light and maps are {2 * size} x {size} lat-long, RGB, the maps over the reflected view R; the"
        " paper's are 128 x 128. Times are processor time of one thread, the median of rounds in which all"
        " calls take turns; tables and memory are made before. In one shot: `prefilter` with the analysis of"
        " the material, nothing kept.",
        f"Angular times are measured on {views} maps, of every other ring of the {T} x {T} views; per map is"
        f" what was measured, and the time of all is {T * T} times that. One node for each texel within the"
        f" lobe's width, which leaves {EPSILON:.0%} of its integral out, as [RH02] section 7.4 has it for"
        " Phong. (a) finds half vector and lobe anew for every pair of a pixel and a texel; (b) finds the"
        " half vectors, which depend on light and view alone, once for each map. The lobe differs from pixel"
        " to pixel, so no symmetry of the grid is left to use for one view.",
        f"Frequency: light to the SHRM to {T * T} maps [RH02 eq. 12], each written over the one before. The"
        f" paper's orders leave out {BRDF_EPSILON:.0%} of the BRDF's energy, about the reflection; ours by"
        " that criterion are beside them. What this leaves out of the reflected light is more, above all"
        " under a sun: so the times are for F and P chosen by measured error, the smallest P, then the"
        " smallest F, whose error is no larger than the angular side's, rescaled or not. Times at the"
        " paper's F and P come after.",
        "Fractions of peak count two flops for a multiply-add: for each sample of (a)"
        f" {flops.FLOPS_OF_HALF_VECTOR} for the half vector, and for each of both forms"
        f" {flops.FLOPS_OF_HALF_ANGLE} for the lobe and {flops.FLOPS_OF_SUM} for three channels; in frequency"
        " space the products of the transforms, and a multiply-add for each map, texel and channel of a view."
        " What picks the lobe's cubics, mostly permutations, is not arithmetic and not counted. The peak is"
        " that of a float32 matrix product of BLAS in the same process,"
        f" {measured['peak'] / 1e9:.0f} Gflop/s.",
        f"Errors are relative RMS over {measured['texels']} texels of {T} maps, one of each ring, drawn as"
        " their solid angles, against integration of the whole lobe with 4 x 4 nodes to a texel. Rescaled:"
        " over"
        f" {1 - EPSILON:g}, so that the lobe that is kept has the integral of the whole.",
    ]


def picture(rows: Sequence[dict[str, Any]]) -> Figure:
    """Draw the times of all maps, ours in ms and the paper's in s, and ratios at the right."""
    figure, (times, ratios) = panels(1, 2, 13.0, 5.8)
    sigma = [row["sigma"] for row in rows]
    a, b, shrm, frequency = (np.array([row["seconds"][k] for row in rows]) for k in range(4))
    at_papers_orders = np.array([row["seconds"][5] for row in rows])
    papers = np.array([PAPER[roughness] for roughness in sigma]).T[2:]

    # Times
    for index, (label, seconds, paper) in enumerate(
        (
            ("angular (a), 100 maps", T * T * a, papers[0]),
            ("angular (b), 100 maps", T * T * b, None),
            ("frequency, 100 maps", frequency, papers[2]),
            ("SHRM", shrm, papers[3]),
        )
    ):
        measured_line(times, index, label, sigma, 1e3 * seconds)
        if paper is not None:
            papers_line(times, index, f"{label.replace(' (a)', '')}, s [RH02]", sigma, paper)
    times.set(ylabel="milliseconds of one thread; [RH02] in seconds")

    # Ratios
    for index, (label, ratio) in enumerate(
        (
            ("(a) / frequency, 100 maps", T * T * a / frequency),
            ("(b) / frequency, 100 maps", T * T * b / frequency),
            ("(a) of one map / SHRM", a / shrm),
            ("(a) / frequency, 100 maps, F and P of [RH02]", T * T * a / at_papers_orders),
        )
    ):
        measured_line(ratios, index, label, sigma, ratio)
    papers_line(ratios, 0, "100 maps [RH02]", sigma, papers[0] / papers[2])
    papers_line(ratios, 2, "one map / SHRM [RH02]", sigma, papers[1] / papers[3])
    ratios.set(ylabel="angular time over frequency time")

    for panel in (times, ratios):
        panel.set(yscale="log", xlabel="roughness sigma", xticks=sigma)
        plain_log(panel.yaxis, subs=(1, 3))
        panel.legend(fontsize=9, frameon=False, loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    return figure
