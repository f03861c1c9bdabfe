"""[RH02] figure 7: what the order P of the view does for the microfacet model of eq. 11, sigma = .2.

Two views of a sphere, by series of F = 30 and P = 0..3 about the reflection, and exactly, by integration for
each pixel. The first view has the brightest light reflected at 30 degrees from the normal; the second at 75,
near grazing. A further row has the lobe center instead of the reflection.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from shrm.arrays import FloatArray
from shrm.brdf import Microfacet
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.environment.layouts import convert
from shrm.frequency.light_power import LightPower
from shrm.frequency.orders import error_of
from shrm.frequency.prefilter import prefilter
from shrm.integrate.angular import prefilter_angular
from shrm.render import Picture

from shrm_papers.result import Result, Settings
from shrm_papers.spheres import (
    View,
    brightest,
    caption,
    common_exposure,
    difference,
    picture_error,
    show,
    sphere,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "rh02-figure-7"
SIGMA = 0.2
F = 30
ORDERS = (0, 1, 2, 3)
INCIDENCE = {"light at 30°": 30.0, "at 75°, grazing": 75.0}
"""Degrees between the normal and the brightest light where it is reflected, by the view's label."""

CENTERS: Mapping[Center, str] = {"reflection": "R", "lobe": "the lobe"}


Row = tuple[str, Center, int, float, float, float, str | None]


@dataclass(frozen=True)
class Pictures:
    """The pictures of one view: the exact one, and those of each center and P."""

    exact: Picture
    series: dict[tuple[Center, int], Picture]


def make(settings: Settings) -> Result:
    """Draw the sphere for every view, center and P, and compare."""
    # The lobe is 20 degrees wide: 64 rows of the light suffice for it, and are what both ways get.
    env = Environment(convert(settings.env.pixels, "latlong", "latlong", 32 if settings.quick else 64))
    pixels = 32 if settings.quick else 144
    brdf = Microfacet(SIGMA)
    exact = prefilter_angular(env, brdf)
    series = {
        (center, P): prefilter(env, brdf, orders=(F, P), center=center, size=64)
        for center in CENTERS
        for P in ORDERS
    }

    # Pictures of both views
    sun = brightest(env)
    views = {name: view_reflecting(sun, degrees) for name, degrees in INCIDENCE.items()}
    pictures = {
        name: Pictures(
            sphere(exact, view, pixels),
            {key: sphere(rm, view, pixels) for key, rm in series.items()},
        )
        for name, view in views.items()
    }

    # Errors, and whether eps bounds their squares
    captured = {key: 1 - brdf_error(*key) for key in series}
    rows = _rows(pictures, captured)
    errors_about_R = [(error, eps) for _, center, _, error, _, eps, _ in rows if center == "reflection"]
    bounded = sum(error**2 <= eps for error, eps in errors_about_R)
    return Result(
        NAME,
        f"Microfacet model, sigma = {SIGMA:g}, F = {F}: images for P = 0..3, {settings.env_name}",
        ["view", "center", "P", "relative RMS error", "its square", "BRDF error eps", "eps [RH02]"],
        [list(row) for row in rows],
        [
            "Relative RMS error over the pixels of the sphere, colors pooled; eps is the fraction of the "
            "BRDF's energy that F and P leave out. [RH02] states eps < .03 at P = 2.",
            "Exact pictures are integrals over the whole hemisphere for each pixel, from the same light of "
            f"{len(env.pixels)} rows. All pictures have one exposure; differences are not amplified.",
            "[RH02] takes eps as a conservative estimate of the fraction of reflected energy that is lost, "
            f"the square: about R it is one in {bounded} of these {len(errors_about_R)} pictures. Near "
            "grazing single views can lose more: eps is a mean over all.",
            "The lobe center in place of the reflection is not in the paper.",
        ],
        _draw(pictures, captured),
    )


def brdf_error(center: Center, P: int) -> float:
    """Return the fraction of the BRDF's energy that (F, P) leaves out."""
    brdf = Microfacet(SIGMA).recentered(center)
    return error_of(brdf, [(F, P)], LightPower.natural(F), "brdf").error


def view_reflecting(light: FloatArray, incidence: float) -> View:
    """Return the view at 2 incidence degrees from a light, to its side: N in between reflects it there."""
    side = np.cross((0.0, 0.0, 1.0), light)
    side = side / np.linalg.norm(side) if np.linalg.norm(side) > 1e-6 else np.array([1.0, 0.0, 0.0])
    upwards = np.cross(light, side)
    away = np.cos(_TILT) * side + np.sin(_TILT) * upwards
    angle = np.radians(2 * incidence)
    x, y, z = np.cos(angle) * light + np.sin(angle) * away
    return float(x), float(y), float(z)


_TILT = np.radians(20.0)
"""Angle by which the view's side is turned upwards: lights are above, and viewers not to be far below."""


def _rows(pictures: dict[str, Pictures], captured: dict[tuple[Center, int], float]) -> list[Row]:
    rows: list[Row] = []
    for name, view in pictures.items():
        for (center, P), picture in view.series.items():
            error = picture_error(picture, view.exact)
            stated = "< .03" if (center, P) == ("reflection", 2) else None
            rows.append((name, center, P, error, error**2, 1 - captured[center, P], stated))
    return rows


def _draw(pictures: dict[str, Pictures], captured: dict[tuple[Center, int], float]) -> Figure:
    from matplotlib.figure import Figure

    cell, label, title, gap = 1.5, 0.5, 0.5, 0.1  # inches
    rows = 1 + len(CENTERS)
    width = label + cell * (len(ORDERS) + 1)
    height = title + len(pictures) * (rows * cell + gap)
    figure = Figure(figsize=(width, height))
    exposure = common_exposure([view.exact for view in pictures.values()])

    def place(picture: Picture, block: int, row: int, column: int) -> Axes:
        x, y = label + cell * column, height - title - block * gap - cell * (rows * block + row + 1)
        axes = figure.add_axes((x / width, y / height, cell / width, cell / height))
        show(axes, picture, exposure)
        return axes

    for k, (name, view) in enumerate(pictures.items()):
        for P in ORDERS:
            axes = place(view.series["reflection", P], k, 0, P)
            if k == 0:
                axes.set_title(f"P = {P}\n{captured['reflection', P]:.1%} of the BRDF", fontsize=9)
            if P == 0:
                axes.set_ylabel(f"{name}\nabout R", fontsize=9)
            for row, center in enumerate(CENTERS, start=1):
                picture = view.series[center, P]
                axes = place(difference(picture, view.exact), k, row, P)
                error = picture_error(picture, view.exact)
                caption(axes, f"{error:.0%}" if error >= 0.1 else f"{error:.1%}")
                if P == 0:
                    axes.set_ylabel(f"difference\nabout {CENTERS[center]}", fontsize=9)
        axes = place(view.exact, k, 0, len(ORDERS))
        if k == 0:
            axes.set_title("exact", fontsize=9)
    return figure
