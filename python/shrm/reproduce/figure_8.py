"""[RH02] figure 8: how much of a BRDF's energy F = 30 and P = 0..5 hold, for many materials.

The paper has the 61 materials of CUReT. Here are published fits to the MERL database and to single measured
materials (`fits`), if a folder of them is given, and the built-in models: about the reflection, diffuse and
glossy parts together [RH02 footnote 6], and about the lobe centre. What no P holds at F = 30 is too sharp for
that F.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from shrm.brdf import BRDF, GGX, Beckmann, Lambert, Microfacet
from shrm.brdf.lobe import Center, FloatArray
from shrm.brdf_analysis import analyse
from shrm.reproduce import fits
from shrm.reproduce.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "figure-8"
F = 30
ORDERS = range(6)
CENTERS: Mapping[Center, str] = {"reflection": "R", "lobe": "the lobe"}
BUILT_IN = "built-in models"
QUICK = 60
"""One material of so many is taken where it is to be quick."""
NAMED = 30
"""Materials of larger sources are drawn without their names."""


@dataclass(frozen=True)
class Accuracy:
    """One material.

    Attributes
    ----------
    name : str
    by_order : {centre: (6,) float64}
        Fraction of the energy that F and P = 0..5 hold.
    every_order : float
        What F holds with every P.
    """

    name: str
    by_order: Mapping[Center, FloatArray]
    every_order: float


def make(settings: Settings) -> Result:
    """Analyse every material about both centres."""
    sources = {BUILT_IN: models(), **(fits.read(settings.fits) if settings.fits is not None else {})}
    step = QUICK if settings.quick else 1
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = {
            source: list(pool.map(measure, list(brdfs)[::step], list(brdfs.values())[::step]))
            for source, brdfs in sources.items()
        }
    for materials in found.values():
        materials.sort(key=lambda material: material.by_order["reflection"][-1])
    return Result(
        NAME,
        f"Fraction of the BRDF's energy that F = {F} and P hold",
        [
            "source",
            "material",
            *(f"P = {P}, about {text}" for text in CENTERS.values() for P in ORDERS),
            "every P",
        ],
        [_row(source, material) for source, materials in found.items() for material in materials],
        [*_summary(found), *_NOTES, *([] if settings.fits is not None else [_WITHOUT_FITS])],
        _draw(found),
    )


_NOTES = (
    "[RH02], 61 materials of CUReT: over 90% at P = 5 in 56; eps < .05 at P = 3 in most cases.",
    "'Every P' is what F = 30 can hold at all: what is missing from it is F's doing, the rest is P's. Many "
    "of MERL's materials are near-mirrors: that F <= 30 suffices is true of rough ones, as CUReT's are.",
    "The energy is that of the squared BRDF with its cosine, colours pooled, in which peaks weigh heavily. "
    "Fits hold much of it at grazing views, where nothing was measured: how finely views are sampled there "
    "moves accuracies by about .01.",
)
_WITHOUT_FITS = (
    "Without a folder of fits only built-in models are shown. Fits are read from "
    f"{', '.join(fits.SOURCES)} there, JSON objects of materials; see shrm.reproduce.fits."
)


def models() -> dict[str, BRDF]:
    """Built-in models, from matt to glossy, by name."""
    return {
        "Lambert": Lambert(1.0),
        **{f"microfacet {sigma:g}": Microfacet(sigma) for sigma in (0.1, 0.2, 0.3, 0.4, 0.5)},
        **{f"Beckmann {alpha:g}": Beckmann(alpha) for alpha in (0.1, 0.2, 0.3, 0.5)},
        **{f"GGX {alpha:g}": GGX(alpha) for alpha in (0.1, 0.2, 0.3, 0.5, 0.8)},
        **{f"Lambert + GGX {alpha:g}": Lambert(0.5) + GGX(alpha, 0.04) for alpha in (0.1, 0.2, 0.3, 0.5)},
    }


def measure(name: str, brdf: BRDF) -> Accuracy:
    """Analyse one material about both centres."""
    by_order, every_order = {}, 0.0
    for center in CENTERS:
        (lobe,) = brdf.recentred(center, merge=True).lobes
        analysis = analyse(lobe, F, ORDERS[-1])
        whole = analysis.energy.sum()
        by_order[center] = np.array([analysis.captured(P).sum() / whole for P in ORDERS])
        every_order = float(analysis.degree_energy().sum() / whole)
    return Accuracy(name, by_order, every_order)


def _row(source: str, material: Accuracy) -> list[Cell]:
    numbers = [float(x) for center in CENTERS for x in material.by_order[center]]
    return [source, material.name, *numbers, material.every_order]


def _summary(found: Mapping[str, Sequence[Accuracy]]) -> list[str]:
    """The paper's two figures, for each source."""
    lines = []
    for source, materials in found.items():
        held = [material for material in materials if material.every_order > 0.95]
        for text, group in (("", materials), (" whose degrees to 30 hold over 95%", held)):
            lines.append(
                f"{source}, {len(group)} materials{text}: over 90% at P = 5 in {_above(group, 5, 0.9)}; "
                f"eps < .05 at P = 3 in {_above(group, 3, 0.95)}."
            )
    return lines


def _above(materials: Sequence[Accuracy], P: int, accuracy: float) -> str:
    """How many materials are above an accuracy about each centre."""
    counts = {
        text: sum(bool(material.by_order[center][P] > accuracy) for material in materials)
        for center, text in CENTERS.items()
    }
    return ", ".join(f"{count} about {text}" for text, count in counts.items())


def _draw(found: Mapping[str, Sequence[Accuracy]]) -> Figure:
    from matplotlib.figure import Figure

    heights = [
        (0.15 if len(materials) <= NAMED else 0.05) * (len(materials) + 1) for materials in found.values()
    ]
    figure = Figure(figsize=(9.0, sum(heights) + 0.3 * len(heights) + 1.2), layout="constrained")
    grid = figure.subplots(len(found), 2, sharex=True, squeeze=False, height_ratios=heights)
    for row, (source, materials) in zip(grid, found.items(), strict=True):
        for axes, center in zip(row, CENTERS, strict=True):
            _panel(axes, materials, center)
        names = [material.name for material in materials] if len(materials) <= NAMED else []
        row[0].set_yticks(range(len(names)), names, fontsize=7)
        row[1].set_yticks([])
        row[0].set_title(f"{source}: {len(materials)}", fontsize=9, loc="left")
    for axes, text in zip(grid[-1], CENTERS.values(), strict=True):
        axes.set_xlabel(f"accuracy about {text}, F = {F}")
    legend = grid[0, 0].get_legend_handles_labels()
    figure.legend(*legend, loc="outside upper center", ncols=len(ORDERS) + 1, frameon=False, fontsize=9)
    return figure


def _panel(axes: Axes, materials: Sequence[Accuracy], center: Center) -> None:
    """Each material in its row, its markers from light to dark with P [RH02 fig. 8]."""
    y = np.arange(len(materials))
    for P, marker in zip(ORDERS, "DDDDDo", strict=True):
        shade = str(0.82 * (1 - P / ORDERS[-1]))
        x = [material.by_order[center][P] for material in materials]
        axes.plot(x, y, marker, color=shade, markersize=3, label=f"P = {P}")
    limit = [material.every_order for material in materials]
    axes.plot(limit, y, "|", color="#d95f02", markersize=4.5, label="every P")
    axes.axvline(0.9, color="0.6", linewidth=0.6, zorder=0)
    axes.set(xlim=(0, 1.01), ylim=(-1, len(materials)), xticks=np.linspace(0, 1, 11))
    axes.tick_params(axis="x", labelsize=8)
    axes.tick_params(axis="y", length=0)
    axes.spines[["top", "right"]].set_visible(False)
