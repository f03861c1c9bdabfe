"""[LK03] table 1: frames per second of all methods, shadowed and not, and their errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from shrm.threads import thread_count

from shrm_papers.lk03.methods import TENTS, Judged, compare
from shrm_papers.lk03.reference import VERTICES, VIEWS
from shrm_papers.lk03.subject import Subject, note, subject_of
from shrm_papers.plotting import COLORS, panels, plain_log
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "lk03-table-1"

PAPER = {
    "Kautz et al. 2002": (1.6, 2.9),
    "7 x 7 tents": (9.3, 9.7),
    "11 x 11 tents": (8.7, 8.7),
    "11 x 11 tents, PCA, K = 10": (28.9, 26.6),
    "11 x 11 tents, PCA, K = 25": (17.1, 17.6),
}
"""[LK03 table 1], by method: frames per second of the bird, with shadows, and of the head, without."""

COMPRESSION = {"11 x 11 tents, PCA, K = 10": 285, "11 x 11 tents, PCA, K = 25": 114}
"""[LK03 table 1]: the compression of methods with PCA."""

COLUMNS = (
    "method",
    "self-shadowing",
    "K",
    "frames/s",
    "frames/s [LK03]",
    "MB",
    "compression",
    "compression [LK03]",
    "SNR, dB",
    "SNR by the published path, dB",
)


def make(settings: Settings) -> Result:
    """Time and judge all methods."""
    subject = subject_of(settings)
    judged = compare(subject, settings.quick)
    return Result(
        NAME,
        f"Ways to light an object with transfer, {subject.name}",
        COLUMNS,
        table(judged),
        _notes(subject, judged),
        _draw(judged),
    )


def table(judged: Sequence[Judged]) -> list[list[Cell]]:
    """Return a row for each method and kind of shadows, the paper's numbers beside ours."""
    full = {way.shadowed: way.bytes for way in judged if way.method == f"{TENTS} x {TENTS} tents"}
    rows: list[list[Cell]] = []
    for way in judged:
        papers = PAPER.get(way.method)
        compression = full[way.shadowed] / way.bytes if "PCA" in way.method else None
        rows.append(
            [
                way.method,
                "yes" if way.shadowed else "no",
                way.K,
                1 / way.seconds,
                None if papers is None else papers[not way.shadowed],
                way.bytes / 1e6,
                compression,
                COMPRESSION.get(way.method),
                way.snr,
                way.published,
            ]
        )
    return rows


def _notes(subject: Subject, judged: Sequence[Judged]) -> list[str]:
    glossy, phong = judged[0].material, judged[-1].material
    return [
        note(subject),
        f"Lighting only, as in [LK03]: {thread_count()} threads here, a Pentium 4 at 2.26 GHz and 50000 "
        "vertices there; its bird was shadowed and its head was not. Light of order 5, three colors; eye and "
        "light move between frames. Median wall times, of the best of three bursts.",
        f"The material is {glossy}, for the matt row Lambert's, for the convolution {phong}.",
        f"SNR: radiance from {VERTICES} vertices towards viewers in {VIEWS} directions, over the error "
        "against the sum over the same rays with neither tents nor harmonics in between, for white light of "
        "order 5. The published path has transferred radiance to order 5 and views to order 8, even, with a "
        "window above degree 5 [LK03 section 7]; ours goes from rays to tents straight. Kautz et al. and the "
        "convolution know no other way than by transferred radiance of order 5.",
        "Megabytes are those of what was precomputed, without vertices and frames: float32, weights of "
        "components half floats, which makes the compression twice the paper's. Where nothing shadows, T is "
        "the identity and is not stored.",
        "PCA to an accuracy takes the smallest K that reaches it against the uncompressed matrices.",
    ]


def _draw(judged: Sequence[Judged]) -> Figure:
    figure, axes = panels(1, 2, 11.0, 4.6)
    fastest = 20 * max(1 / way.seconds for way in judged)  # with room for the text beside a bar
    for panel, shadowed in zip(axes, (True, False), strict=True):
        # A bar for each method, a mark where the paper has it, and the error beside
        ways = [way for way in judged if way.shadowed == shadowed]
        y = np.arange(len(ways))[::-1]
        speeds = [1 / way.seconds for way in ways]
        panel.barh(y, speeds, 0.62, color=COLORS[0], label="shrm")
        papers = [
            (PAPER[way.method][not shadowed], place)
            for place, way in zip(y, ways, strict=True)
            if way.method in PAPER
        ]
        panel.plot(*zip(*papers, strict=True), "D", color=COLORS[3], label="[LK03]", linestyle="")
        for place, speed, way in zip(y, speeds, ways, strict=True):
            error = f"{way.snr:.1f} dB" if np.isfinite(way.snr) else "exact"
            panel.text(1.15 * speed, place, error, va="center", fontsize=8)

        panel.set(xscale="log", xlabel="frames per second", xlim=(1.0, fastest))
        panel.set_yticks(y, [way.method for way in ways], fontsize=8)
        panel.set_title("self-shadowing" if shadowed else "no shadows", fontsize=10)
        panel.tick_params(axis="x", labelsize=8)
        panel.grid(False, axis="y")
        plain_log(panel.xaxis)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize=8, loc="outside lower center", ncols=2)
    return figure
