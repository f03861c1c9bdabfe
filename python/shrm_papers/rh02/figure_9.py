"""[RH02] figure 9: a fabric by SHRM, and without azimuth, as Kautz and McCool have it.

Their single lobe is an arbitrary function u(theta_i, theta_o) about the reflection [KM00], which is what the
terms q = 0 of the local form make up [RH02 footnote 7]. The paper's fabric is CUReT's velvet, which cannot be
had: here is a published fit to a fabric of the MERL database, or, where a folder of fits lacks it, a model of
velvet.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from shrm.brdf import BRDF
from shrm.brdf.lobe import Center
from shrm.frequency.prefilter import prefilter
from shrm.integrate.angular import prefilter_angular
from shrm.prefiltered.explicit import without_azimuth

from shrm_papers.comparison import COLUMNS, Block, Frames, Judged, Representation, Truth, draw_blocks
from shrm_papers.result import Result, Settings
from shrm_papers.rh02 import fits
from shrm_papers.rh02.velvet import velvet
from shrm_papers.spheres import brightest, view_turned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "rh02-figure-9"
F = 24
ORDERS = range(6)

EVERY_VIEW = 12
"""The order P that stands for an arbitrary function of theta_o."""

CENTERS: Mapping[Center, str] = {"reflection": "R", "lobe": "the lobe"}

AZIMUTH, ELEVATION = 75.0, 12.0
"""The viewer's direction: degrees from the brightest light, and above the horizon."""

ROWS = 64
"""Rows of the light that is prefiltered and integrated; fabrics are broad lobes."""

FIT = ("MERL, fits of Bagher et al. 2012", "red-fabric")
"""Source and name of the fabric."""

Series = Mapping[tuple[Center, bool], Mapping[int, Judged]]
"""Judged maps by center and whether they have azimuth, and by P."""


def make(settings: Settings) -> Result:
    """Draw the fabric in every representation, and compare with the integral."""
    quick = settings.quick
    rows, size, pixels, samples = (12, 16, 16, 100) if quick else (ROWS, 64, 192, 4000)
    orders = (0, 2) if quick else ORDERS
    env = settings.env.resized((rows, 2 * rows))
    brdf = fabric(settings)
    view = view_turned(brightest(env), AZIMUTH, ELEVATION)
    truth = Truth(prefilter_angular(env, brdf), view, pixels, Frames.drawn(samples))

    def judged(center: Center, P: int, azimuth: bool) -> Judged:
        rm = prefilter(env, brdf, orders=(F, P), center=center, size=size)
        if not azimuth:
            rm = without_azimuth(rm)
        (part,) = rm.parts
        name = f"SHRM, P = {P}" if azimuth else f"q = 0 only, P = {P}"
        return truth.judge(Representation(name, CENTERS[center], part.rings.shape[1], part.rings.nbytes, rm))

    series: Series = {
        (center, azimuth): {P: judged(center, P, azimuth) for P in orders}
        for azimuth in (True, False)
        for center in CENTERS
    }
    texture = judged("reflection", orders[-1] if quick else EVERY_VIEW, azimuth=False)
    return Result(
        NAME,
        f"{brdf.name}: SHRM and Kautz and McCool's 2D approximation, {settings.env_name}",
        COLUMNS,
        [*(judged.cells for by_P in series.values() for judged in by_P.values()), texture.cells],
        _notes(brdf, series),
        _draw(brdf.name, truth, series, texture),
    )


def _notes(brdf: BRDF, series: Series) -> list[str]:
    material = "a model of velvet [AP07]" if brdf.name == "velvet" else f"{FIT[1]} ({FIT[0]})"
    lost = {center: f"{list(series[center, False].values())[-1].frames_error:.0%}" for center in CENTERS}
    return [
        f"In place of CUReT's velvet: {material}, diffuse and glossy parts together [RH02 footnote 6].",
        "Kautz and McCool's single lobe is u(theta_i, theta_o), any function of both angles about R: q = 0 "
        f"in the local SHRM [RH02 footnote 7]; P = {EVERY_VIEW} stands for any function of theta_o.",
        f"What q = 0 cannot hold, whatever P: {lost['reflection']} about R, {lost['lobe']} about the center "
        "of the lobe's energy, which is not in the paper.",
        f"F = {F}; the correct picture is an integral over the same light, of {ROWS} rows. Errors are "
        "relative RMS, colors pooled; random frames have N and V of any direction. [RH02] gives no "
        "numbers. MB are of float32 RGB.",
    ]


def fabric(settings: Settings) -> BRDF:
    """Return the fit `FIT` if there is one, else a model of velvet."""
    source, name = FIT
    fit = fits.read(settings.fits).get(source, {}).get(name)
    return velvet(0.4, (0.3, 0.02, 0.05), (0.08, 0.003, 0.008)) if fit is None else fit


def _draw(name: str, truth: Truth, series: Series, texture: Judged) -> Figure:
    P = max(series["lobe", True])
    columns = [
        (f"SHRM about the lobe\nP = {P}", series["lobe", True][P]),
        (f"SHRM about R [RH02]\nP = {P}", series["reflection", True][P]),
        ("Kautz and McCool\nq = 0, any $\\theta_o$", texture),
    ]
    beside = 3.7  # inches, for the graph
    figure = draw_blocks([Block(name, truth, columns)], beside)
    width, height = figure.get_size_inches()
    left, bottom, right, top = width - beside + 0.8, 0.5, width - 0.15, height - 0.6
    extent = (left / width, bottom / height, (right - left) / width, (top - bottom) / height)
    _draw_errors(figure.add_axes(extent, yscale="log"), series)
    return figure


def _draw_errors(axes: Axes, series: Series) -> None:
    """Draw errors over random frames against P."""
    for (center, azimuth), by_P in series.items():
        axes.plot(
            list(by_P),
            [judged.frames_error for judged in by_P.values()],
            color={"reflection": "#d95f02", "lobe": "#1b9e77"}[center],
            linestyle="-" if azimuth else "--",
            marker="o" if azimuth else "s",
            markersize=4,
            label=f"{'SHRM' if azimuth else 'q = 0'}, about {CENTERS[center]}",
        )
    axes.set(xlabel="P", xticks=list(series["lobe", True]), ylabel="relative RMS error, random frames")
    lowest, highest = axes.get_ylim()
    ticks = [x for x in (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5) if lowest <= x <= highest]
    axes.set_yticks(ticks, [f"{x:.1%}" if x < 0.01 else f"{x:.0%}" for x in ticks])
    axes.minorticks_off()
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", linewidth=0.6)
    axes.legend(
        frameon=False,
        fontsize=7,
        handlelength=3,
        columnspacing=1.0,
        ncols=2,
        loc="lower center",
        bbox_to_anchor=(0.45, 1.0),
    )
