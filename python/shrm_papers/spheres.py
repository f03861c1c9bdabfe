"""Spheres for figures: drawn one by one, from anywhere, and shown in the axes of a figure."""

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
    Reflection,
    Sphere,
    automatic_exposure,
    display,
    render,
)
from shrm.render.tonemap import LUMINANCE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

View = tuple[float, float, float]


def sphere(material: Reflection, view: View, pixels: int, samples: int = 2) -> Picture:
    """Draw a unit sphere that a distant viewer in the direction `view` sees, filling the picture."""
    distant = tuple(4.0 * x for x in view)
    camera = Camera((distant[0], distant[1], distant[2]), height=2.04)
    ball = Object(Sphere((0.0, 0.0, 0.0)), material)
    return render([ball], camera, pixels, pixels, viewer="distant", samples=samples, shading="pixel")


def brightest(env: Environment, F: int = 8) -> FloatArray:
    """Direction of the brightest light, a unit vector (3,), when the environment is seen to degree F."""
    pixels = sh.synthesis(env.coefficients(F), 8 * F, 16 * F) @ LUMINANCE
    row, column = np.unravel_index(np.argmax(pixels), pixels.shape)
    return np.asarray(layouts.directions("latlong", *pixels.shape)[row, column])


def view_turned(direction: FloatArray, azimuth: float, elevation: float) -> View:
    """Direction at an azimuth from that of another and an elevation above the horizon, in degrees."""
    phi = np.arctan2(direction[1], direction[0]) + np.radians(azimuth)
    up = np.radians(elevation)
    return float(np.cos(up) * np.cos(phi)), float(np.cos(up) * np.sin(phi)), float(np.sin(up))


def common_exposure(pictures: Sequence[Picture]) -> float:
    """Stops for pictures that are compared, from all of them together."""
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
    """Write small in the lower right corner."""
    axes.text(0.97, 0.03, text, transform=axes.transAxes, color="0.75", fontsize=7, ha="right")


def difference(a: Picture, b: Picture) -> Picture:
    """Take the absolute difference, pixel by pixel."""
    return Picture(np.abs(a.radiance - b.radiance), b.coverage)


def relative_rms(a: Picture, b: Picture) -> float:
    """Relative RMS difference of a from b over what the sphere covers, channels pooled."""
    wanted = b.radiance.astype(np.float64)
    return float(np.sqrt(np.sum((a.radiance - wanted) ** 2) / np.sum(wanted**2)))
