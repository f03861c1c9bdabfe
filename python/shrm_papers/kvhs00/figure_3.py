"""[KVHS00] figure 3: the distortion of circles in a paraboloid map when they are projected to the sphere.

The paraboloid map is the stereographic projection: circles in it are circles on the sphere. But their centers
are not the projections of the centers, and so the distances from there to the border differ, most between the
points towards and away from the map's center.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from shrm.arrays import FloatArray

from shrm_papers.plotting import COLORS, measured_line, panels
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "kvhs00-figure-3"
RADII = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5)
DISTANCES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Radii of circles, and distances of their centers from the map's; the disc's radius is 1."""

LARGEST = 0.25
"""The largest distortion by [KVHS00] section 5.2."""

POINTS = 720
"""Points on each circle."""


def make(settings: Settings) -> Result:
    """Measure circles of all radii at all distances."""
    rows: list[list[Cell]] = [[r, *(round(deviation(r, d), 9) for d in DISTANCES)] for r in RADII]
    largest = max(deviation(r, d) for r in RADII for d in np.linspace(0, 1, 101))
    return Result(
        NAME,
        "Distortion of a circle projected from a paraboloid map back to the sphere",
        ["radius r", *(f"deviation at d = {d:g}" for d in DISTANCES)],
        rows,
        [
            "r = 1 is the radius of the map's disc, d the distance of the circle's center from the map's. "
            "Distances on the sphere, from the projection of the center to the border, are compared with the "
            "constant radius from which they deviate least; the largest deviation is given as a part of it.",
            f"Up to {largest:.0%} for r up to {max(RADII):g}, which is the large filter's at exponent 10; "
            f"[KVHS00] says {LARGEST:.0%}.",
            "About their own centers the projected circles do not deviate at all: the map is the "
            "stereographic projection, which maps circles to circles.",
        ],
        _draw(),
    )


def border(r: float, d: float) -> tuple[FloatArray, FloatArray]:
    """Return a circle's points about the projection of its center: angles (n,) and azimuths (n,)."""
    turn = 2 * np.pi * np.arange(POINTS) / POINTS
    points = _projected(d + r * np.cos(turn), r * np.sin(turn))
    center = _projected(np.array([d]), np.zeros(1))[0]
    outward = np.array([center[2], 0.0, -center[0]])  # away from the map's center
    along = points @ center
    a, b = points @ outward, points[:, 1]
    return np.arctan2(np.hypot(a, b), along), np.arctan2(b, a)


def deviation(r: float, d: float) -> float:
    """Return the largest relative deviation of a circle's distances from a constant radius."""
    angles, _ = border(r, d)
    return float((angles.max() - angles.min()) / (angles.max() + angles.min()))


def _projected(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the directions of points of the map, (n, 3)."""
    square = x**2 + y**2
    return np.stack([2 * x, 2 * y, 1 - square], axis=1) / (1 + square)[:, None]


def _draw() -> Figure:
    figure, (curves, circles) = panels(1, 2, 9.6, 4.4)
    d = np.linspace(0, 1, 11)
    for k, r in enumerate(RADII):
        measured_line(curves, k, f"r = {r:g}", d, [100 * deviation(r, x) for x in d])
    curves.axhline(100 * LARGEST, color="0.4", linestyle="--", linewidth=1.2)
    curves.annotate(
        "[KVHS00]: up to 25%", (0.0, 100 * LARGEST), (0, 4), textcoords="offset points", fontsize=8
    )
    curves.set(xlabel="distance d from the map's center", ylabel="deviation, %", ylim=(0, 28))
    curves.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(0.0, 0.88))
    _draw_circles(circles, 0.4)
    return figure


def _draw_circles(axes: Axes, r: float) -> None:
    """Draw circles of one radius as they lie on the sphere about the projections of their centers."""
    turn = np.linspace(0, 2 * np.pi, 200)
    for k, d in enumerate((0.0, 0.5, 1.0)):
        angle, azimuth = (np.append(x, x[0]) for x in border(r, d))
        x, y = np.degrees(angle) * np.cos(azimuth), np.degrees(angle) * np.sin(azimuth)
        axes.plot(x, y, color=COLORS[k], linewidth=1.8, label=f"d = {d:g}")
        middle = np.degrees(0.5 * (angle.max() + angle.min()))
        axes.plot(middle * np.cos(turn), middle * np.sin(turn), color=COLORS[k], linewidth=1.0, linestyle=":")
    axes.plot(0, 0, "+", color="0.2")
    axes.set(
        xlabel="degrees, outwards from the map's center", ylabel="degrees", aspect="equal", ylim=(-48, 62)
    )
    axes.set_title(f"r = {r:g}; dotted: the constant radius", fontsize=9)
    axes.legend(frameon=False, fontsize=8, loc="upper center", ncol=3)
