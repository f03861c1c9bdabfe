"""[LK03] table 1: frames per second of all methods, shadowed and not, and what it does not print: errors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from shrm_papers.index import threads
from shrm_papers.lk03.transfer_methods import TENTS, Judged, compare
from shrm_papers.lk03.transfer_reference import VERTICES, VIEWS
from shrm_papers.lk03.transfer_subject import Subject, note, subject
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
"""[LK03 table 1], by the method: frames per second of the bird, shadowed, and of the head, which is not."""

COMPRESSION = {"11 x 11 tents, PCA, K = 10": 285, "11 x 11 tents, PCA, K = 25": 114}
"""[LK03 table 1]: how many times smaller than without PCA."""

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
    this = subject(settings)
    found = compare(this, settings.quick)
    return Result(
        NAME,
        f"Ways to light an object with transfer, {this.name}",
        COLUMNS,
        table(found),
        _notes(this, found),
        _draw(found),
    )


def table(found: Sequence[Judged]) -> list[list[Cell]]:
    """Return a row for each method and kind of shadows, the paper's figures beside ours."""
    whole = {one.shadowed: one.bytes for one in found if one.method == f"{TENTS} x {TENTS} tents"}
    rows: list[list[Cell]] = []
    for one in found:
        theirs = PAPER.get(one.method)
        smaller = whole[one.shadowed] / one.bytes if "PCA" in one.method else None
        rows.append(
            [
                one.method,
                "yes" if one.shadowed else "no",
                one.K,
                1 / one.seconds,
                None if theirs is None else theirs[not one.shadowed],
                one.bytes / 1e6,
                smaller,
                COMPRESSION.get(one.method),
                one.snr,
                one.published,
            ]
        )
    return rows


def _notes(this: Subject, found: Sequence[Judged]) -> list[str]:
    glossy, phong = found[0].material, found[-1].material
    return [
        note(this),
        f"Lighting only, as in [LK03]: {threads()} threads here, a Pentium 4 at 2.26 GHz and 50000 vertices "
        "there; its bird was shadowed and its head was not. Light of order 5, three colors; eye and light "
        "move between frames. Median wall times, of the best of three bursts.",
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


def _draw(found: Sequence[Judged]) -> Figure:
    figure, axes = panels(1, 2, 11.0, 4.6)
    widest = 20 * max(1 / one.seconds for one in found)  # with room for what stands beside a bar
    for panel, shadowed in zip(axes, (True, False), strict=True):
        these = [one for one in found if one.shadowed == shadowed]
        at = np.arange(len(these))[::-1]
        speeds = [1 / one.seconds for one in these]
        panel.barh(at, speeds, 0.62, color=COLORS[0], label="shrm")
        theirs = [
            (PAPER[one.method][not shadowed], y)
            for y, one in zip(at, these, strict=True)
            if one.method in PAPER
        ]
        panel.plot(*zip(*theirs, strict=True), "D", color=COLORS[3], label="[LK03]", linestyle="")
        for y, speed, one in zip(at, speeds, these, strict=True):
            panel.text(1.15 * speed, y, f"{one.snr:.1f} dB", va="center", fontsize=8)
        panel.set(xscale="log", xlabel="frames per second", xlim=(1.0, widest))
        panel.set_yticks(at, [one.method for one in these], fontsize=8)
        panel.set_title("self-shadowing" if shadowed else "no shadows", fontsize=10)
        panel.tick_params(axis="x", labelsize=8)
        panel.grid(False, axis="y")
        plain_log(panel.xaxis)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, fontsize=8, loc="outside lower center", ncols=2)
    return figure
