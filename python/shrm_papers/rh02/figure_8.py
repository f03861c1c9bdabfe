"""[RH02] figure 8: the fraction of a BRDF's energy that F = 30 and P = 0..5 hold, for many materials.

The paper has the 61 materials of CUReT. Here are the published fits to the MERL database and to single
measured materials (`fits`), a folder's files of measurements, and the built-in models: about the reflection,
diffuse and glossy parts together [RH02 footnote 6], and about the lobe center. Energy that no P holds at
F = 30 is too sharp for that F.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from shrm.brdf import BRDF, GGX, Beckmann, Lambert, Microfacet, load
from shrm.brdf.lobe import Center
from shrm.brdf.parse import SUFFIXES
from shrm.threads import thread_count

from shrm_papers.result import Cell, Result, Settings
from shrm_papers.rh02 import fits
from shrm_papers.rh02.brdf_accuracy import CENTERS, GRAZING, ORDERS, WIDE, Accuracy, F, measure
from shrm_papers.rh02.merl_classes import CLASSES, class_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "rh02-figure-8"
BUILT_IN = "built-in models"
FILES = "files of measurements"

QUICK = 60
"""Step through the materials of a source in a quick run."""

NAMED = 30
"""Most materials of a source that are drawn with their names."""

Sources = Mapping[str, Mapping[str, Sequence[Accuracy]]]
"""Materials by source and class."""


def make(settings: Settings) -> Result:
    """Analyse every material about both centers."""
    # Every material of files, fits and models, in parallel
    files = measured(settings.data)
    sources = {
        **({FILES: files} if files else {}),
        **fits.read(settings.fits),
        BUILT_IN: models(),
    }
    step = QUICK if settings.quick else 1
    with ThreadPoolExecutor(thread_count()) as pool:
        accuracies = {
            source: grouped(pool.map(measure, list(brdfs)[::step], list(brdfs.values())[::step]))
            for source, brdfs in sources.items()
        }

    return Result(
        NAME,
        f"Fraction of the BRDF's energy that F = {F} and P hold",
        [
            "source",
            "class",
            "material",
            *(f"P = {P}, about {text}" for text in CENTERS.values() for P in ORDERS),
            "every P",
            "half-energy angle, degrees",
            *(f"views to {GRAZING:g} degrees, about {text}" for text in CENTERS.values()),
        ],
        [
            _row(source, name, material)
            for source, classes in accuracies.items()
            for name, materials in classes.items()
            for material in materials
        ],
        [*_NOTES, *exceptions(accuracies), *([] if files else [_WITHOUT_FILES])],
        _draw(accuracies),
        summary=(_COUNTED, [*_counts(accuracies), _PAPER]),
    )


_NOTES = (
    "[RH02], 61 materials of CUReT: over 90% at P = 5 in 56; eps < .05 at P = 3 in most cases.",
    "'Every P' is what F = 30 can hold at all: what is missing from it is F's doing, the rest is P's. Many "
    "of MERL's materials are near-mirrors: that F <= 30 suffices is true of rough ones, as CUReT's are.",
    "The energy is that of the squared BRDF with its cosine, colors pooled, in which peaks weigh heavily. "
    "Fits hold much of it at grazing views, where nothing was measured: how finely views are sampled there "
    "moves accuracies by about .01.",
    "The half-energy angle is that about the lobe center within which half of this energy lies, all views "
    "pooled; lobes of Lambert's model have 37 degrees.",
)
_WITHOUT_FILES = "Files of measurements are read from the folder brdf of --data."
_COUNTED = (
    "materials",
    "class",
    "number",
    *(f"over 90% about {text}" for text in CENTERS.values()),
    f"half-energy angle over {WIDE:g} degrees",
    *(f"of these over 90% about {text}" for text in CENTERS.values()),
)
_PAPER: Sequence[Cell] = ("CUReT [RH02]", "all", 61, 56, None, None, None, None)


def models() -> dict[str, BRDF]:
    """Return built-in models, from matt to glossy, by name."""
    return {
        "Lambert": Lambert(1.0),
        **{f"microfacet {sigma:g}": Microfacet(sigma) for sigma in (0.1, 0.2, 0.3, 0.4, 0.5)},
        **{f"Beckmann {alpha:g}": Beckmann(alpha) for alpha in (0.1, 0.2, 0.3, 0.5)},
        **{f"GGX {alpha:g}": GGX(alpha) for alpha in (0.1, 0.2, 0.3, 0.5, 0.8)},
        **{f"Lambert + GGX {alpha:g}": Lambert(0.5) + GGX(alpha, 0.04) for alpha in (0.1, 0.2, 0.3, 0.5)},
    }


def measured(folder: Path | None) -> dict[str, BRDF]:
    """Return the materials of all files of measurements in a folder's `brdf`, by name.

    Raises
    ------
    OSError, ValueError
        If there is no such folder, or a file in it that cannot be read.
    """
    if folder is None:
        return {}
    paths = sorted(path for path in (folder / "brdf").iterdir() if path.suffix.lower() in SUFFIXES)
    return {brdf.name: brdf for brdf in map(load, paths)}


def grouped(materials: Iterable[Accuracy]) -> dict[str, list[Accuracy]]:
    """Return materials by class in the order of `CLASSES`, in each from the least accurate to the most."""
    classes: dict[str, list[Accuracy]] = {name: [] for name in (*CLASSES, "")}
    for material in sorted(materials, key=lambda material: material.by_order["reflection"][-1]):
        classes[class_of(material.name)].append(material)
    return {name: many for name, many in classes.items() if many}


def _row(source: str, name: str, material: Accuracy) -> list[Cell]:
    numbers = [float(x) for center in CENTERS for x in material.by_order[center]]
    below = [material.below_grazing[center] for center in CENTERS]
    return [source, name, material.name, *numbers, material.every_order, material.half, *below]


def _counts(sources: Sources) -> list[list[Cell]]:
    """Return the paper's count for each source and class."""
    rows: list[list[Cell]] = []
    for source, classes in sources.items():
        all_materials = [material for many in classes.values() for material in many]
        parts = classes if len(classes) > 1 else {}
        for name, materials in {**parts, "all": all_materials}.items():
            wide = [material for material in materials if material.wide]
            reached = [_reaching(materials, center) for center in CENTERS]
            of_wide = [_reaching(wide, center) for center in CENTERS]
            rows.append([source, name, len(materials), *reached, len(wide), *of_wide])
    return rows


def _reaching(materials: Sequence[Accuracy], center: Center) -> int:
    return sum(material.reaches(center) for material in materials)


def exceptions(sources: Sources) -> list[str]:
    """Return notes on wide lobes that miss 90% about a center, and on where the missing energy is."""
    missing = [
        (source, material)
        for source, classes in sources.items()
        for many in classes.values()
        for material in many
        if material.wide and not all(material.reaches(center) for center in CENTERS)
    ]
    if not missing:
        return []
    least = min(max(material.below_grazing.values()) for _, material in missing)
    lines = [
        f"Of the materials with a half-energy angle over {WIDE:g} degrees {len(missing)} miss 90% about R "
        "or about the lobe. What they miss is at grazing views: to "
        f"{GRAZING:g} degrees the same F and P hold {least:.0%} or more about one of both. Beyond, a narrow "
        "and bright lobe takes the place of the wide one, as near-mirrors have it:"
    ]
    for source, material in missing:
        about = ", ".join(f"{material.by_order[c][-1]:.3f} about {text}" for c, text in CENTERS.items())
        below = ", ".join(f"{material.below_grazing[c]:.3f}" for c in CENTERS)
        lines.append(
            f"{material.name} ({source}): {about}, to {GRAZING:g} degrees {below}; half-energy angle "
            f"{material.half:.0f} degrees, of views beyond {GRAZING:g} alone {material.half_grazing:.1f}; "
            f"degrees above {F} hold {1 - material.every_order:.3f}."
        )
    return lines


def _draw(sources: Sources) -> Figure:
    """Draw a row of panels for each source, as high as its materials need."""
    from matplotlib.figure import Figure

    counts = {source: sum(map(len, classes.values())) for source, classes in sources.items()}
    heights = [
        (0.16 if count <= NAMED else 0.055) * (count + GAP * len(sources[source]))
        for source, count in counts.items()
    ]
    figure = Figure(figsize=(9.0, sum(heights) + 0.3 * len(heights) + 1.2), layout="constrained")
    grid = figure.subplots(len(sources), 2, sharex=True, squeeze=False, height_ratios=heights)
    for row, (source, classes) in zip(grid, sources.items(), strict=True):
        for axes, center in zip(row, CENTERS, strict=True):
            _panel(axes, classes, center)
        _names(row[0], classes, single=counts[source] <= NAMED)
        row[1].set_yticks([])
        counted = "" if counts[source] <= NAMED else ", over 90% about R at P = 5"
        row[0].set_title(f"{source}: {counts[source]}{counted}", fontsize=9, loc="left")
    for axes, text in zip(grid[-1], CENTERS.values(), strict=True):
        axes.set_xlabel(f"accuracy about {text}, F = {F}")
    legend = grid[0, 0].get_legend_handles_labels()
    figure.legend(*legend, loc="outside upper center", ncols=len(ORDERS) + 1, frameon=False, fontsize=9)
    return figure


GAP = 2
"""Empty rows between classes."""


def _rows(classes: Mapping[str, Sequence[Accuracy]]) -> list[range]:
    """Return the rows of the materials of each class, from the top."""
    starts = np.cumsum([0, *(len(many) + GAP for many in classes.values())]).tolist()
    return [range(start, start + len(many)) for start, many in zip(starts, classes.values(), strict=False)]


def _names(axes: Axes, classes: Mapping[str, Sequence[Accuracy]], single: bool) -> None:
    """Name each material, or each class with the number of its materials that reach 90%."""
    rows = _rows(classes)
    if single:
        ticks = [y for span in rows for y in span]
        axes.set_yticks(ticks, [material.name for many in classes.values() for material in many], fontsize=7)
        return
    labels = [f"{name}\n{_reaching(many, 'reflection')} of {len(many)}" for name, many in classes.items()]
    axes.set_yticks([(span[0] + span[-1]) / 2 for span in rows], labels, fontsize=7)


def _panel(axes: Axes, classes: Mapping[str, Sequence[Accuracy]], center: Center) -> None:
    """Draw each material in its row, its marks from light to dark with P [RH02 fig. 8]."""
    rows = _rows(classes)
    y = [row for span in rows for row in span]
    materials = [material for many in classes.values() for material in many]
    for P, marker in zip(ORDERS, "DDDDDo", strict=True):
        shade = str(0.82 * (1 - P / ORDERS[-1]))
        x = [material.by_order[center][P] for material in materials]
        axes.plot(x, y, marker, color=shade, markersize=3, label=f"P = {P}")

    # What F holds at all, the paper's 90%, and lines between classes
    limit = [material.every_order for material in materials]
    axes.plot(limit, y, "|", color="#d95f02", markersize=4.5, label="every P")
    axes.axvline(0.9, color="0.6", linewidth=0.6, zorder=0)
    for span in rows[1:]:
        axes.axhline(span[0] - (GAP + 1) / 2, color="0.85", linewidth=0.6, zorder=0)
    axes.set(xlim=(0, 1.01), ylim=(rows[-1][-1] + 1, -1), xticks=np.linspace(0, 1, 11))
    axes.tick_params(axis="x", labelsize=8)
    axes.tick_params(axis="y", length=0)
    axes.spines[["top", "right"]].set_visible(False)
