"""Pictures of spheres: drawn one by one from any direction, compared, and shown in the axes of a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from shrm import sh
from shrm.arrays import FloatArray
from shrm.environment import Environment, layouts
from shrm.render import (
    Camera,
    Object,
    Picture,
    Sphere,
    SupportsRadiance,
    automatic_exposure,
    display,
    render,
)
from shrm.render.tonemap import LUMINANCE

from shrm_papers.errors import relative_rms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

View = tuple[float, float, float]
"""The direction towards the viewer, a unit vector."""

DISTANCE = 4.0
"""Distance of the camera from the unit sphere's center; any beyond 1 does, since its rays are parallel."""

HEIGHT = 2.04
"""Height of the picture in radii of the sphere, which leaves a margin of 2% around it."""


def sphere(material: SupportsRadiance, view: View, pixels: int, samples: int = 2) -> Picture:
    """Draw a unit sphere that a distant viewer in the direction `view` sees, filling the picture."""
    x, y, z = view
    camera = Camera((DISTANCE * x, DISTANCE * y, DISTANCE * z), height=HEIGHT)
    ball = Object(Sphere((0.0, 0.0, 0.0)), material)
    return render([ball], camera, (pixels, pixels), viewer="distant", samples=samples, shading="pixel")


def brightest(env: Environment, F: int = 8) -> FloatArray:
    """Return the direction of the brightest light, (3,), of the environment to degree F."""
    pixels = sh.synthesis(env.coefficients(F), (8 * F, 16 * F)) @ LUMINANCE
    row, column = np.unravel_index(np.argmax(pixels), pixels.shape)
    return np.asarray(layouts.directions("latlong", *pixels.shape)[row, column])


def view_turned(direction: FloatArray, azimuth: float, elevation: float) -> View:
    """Return the view at an azimuth from a direction's and an elevation above the horizon, in degrees."""
    phi = np.arctan2(direction[1], direction[0]) + np.radians(azimuth)
    up = np.radians(elevation)
    return float(np.cos(up) * np.cos(phi)), float(np.cos(up) * np.sin(phi)), float(np.sin(up))


def common_exposure(pictures: Sequence[Picture]) -> float:
    """Return one exposure in stops for pictures that are compared, from all of them together."""
    return automatic_exposure(
        np.concatenate([picture.radiance for picture in pictures]),
        np.concatenate([picture.coverage for picture in pictures]),
    )


def show(axes: Axes, picture: Picture, exposure: float) -> None:
    """Show a picture on black, without ticks or frame."""
    axes.imshow(display(picture.radiance, exposure), interpolation="lanczos")
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)


def caption(axes: Axes, text: str) -> None:
    """Write a small text in the lower right corner."""
    axes.text(0.97, 0.03, text, transform=axes.transAxes, color="0.75", fontsize=7, ha="right")


def difference(a: Picture, b: Picture) -> Picture:
    """Return the absolute difference of two pictures, pixel by pixel."""
    return Picture(np.abs(a.radiance - b.radiance), b.coverage)


def picture_error(picture: Picture, exact: Picture) -> float:
    """Return the relative RMS error of a picture over what its objects cover, colors pooled."""
    return relative_rms(picture.radiance, exact.radiance)
