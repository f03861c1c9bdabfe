"""[KVHS00] figure 6: an anisotropic pot by the Banks model, and slices of its map of three dimensions."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from shrm import brdf
from shrm.arrays import Float32Array
from shrm.integrate.angular import prefilter_angular
from shrm.prefiltered import Anisotropic
from shrm.render import Camera, Mesh, Object, Picture, SupportsRadiance, automatic_exposure, display, render

from shrm_papers.grid_meshes import pot
from shrm_papers.result import Result, Settings
from shrm_papers.spheres import common_exposure, picture_error, show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "kvhs00-figure-6"

SHARPNESS = 0.99
"""The exponent s of the model."""

REFLECTED = 0.011
"""Factor of the model with which about as much light is reflected as comes in."""

TOLERANCE = 0.003
"""Relative RMS error that layers are prefiltered to."""

ANGLES = (44.0, 39.0, 35.0)
"""Degrees between v and t of the paper's slices."""

SLICES, ROWS, LIGHT = 181, 64, 128
"""Layers, their rows, and rows of the light."""

PICTURE = (320, 420)
"""Rows and columns of a picture."""

JUDGED = (64, 84)
"""Rows and columns of the pictures that are integrated for their errors."""

CAMERAS = (
    Camera((3.4, 1.2, 1.5), (0.0, 0.0, 0.1), fov=33.0),
    Camera((1.0, -3.4, 0.9), (0.0, 0.0, 0.1), fov=33.0),
)
COLUMNS = ("s", "slices", "map", "prefiltering, s", "error of the pictures")


def make(settings: Settings) -> Result:
    """Prefilter, draw the pot twice, and show the paper's slices."""
    # The layers
    slices, rows, light = (19, 16, 32) if settings.quick else (SLICES, ROWS, LIGHT)
    env = settings.env.resized((light, 2 * light))
    material = REFLECTED * brdf.Banks(SHARPNESS)
    start = time.perf_counter()
    maps = Anisotropic.prefilter(
        env, material, slices=slices, size=rows, tolerance=0.05 if settings.quick else TOLERANCE
    )
    seconds = time.perf_counter() - start

    # The pot, and its errors
    pot = Object(_mesh(settings), maps)
    shape, samples = ((45, 60), 1) if settings.quick else (PICTURE, 2)
    pictures = [render([pot], camera, shape, background=settings.env, samples=samples) for camera in CAMERAS]
    places = np.radians(ANGLES) / np.pi * (slices - 1)
    error = _error(pot, prefilter_angular(env, material, subsamples=1), settings.quick)
    return Result(
        NAME,
        f"A brushed pot by Banks' model, {settings.env_name}",
        COLUMNS,
        [[SHARPNESS, slices, f"{2 * rows} x {rows}", seconds, error]],
        _notes(settings, light),
        _draw(pictures, [maps.maps[round(float(place))] for place in places]),
    )


def _error(pot: Object, exact: SupportsRadiance, quick: bool) -> float:
    """Return the relative RMS error of both pictures together, by fewer pixels of each."""
    shape = (9, 12) if quick else JUDGED
    errors = [
        picture_error(
            render([pot], camera, shape, samples=1),
            render([Object(pot.shape, exact)], camera, shape, samples=1),
        )
        for camera in CAMERAS
    ]
    return float(np.sqrt(np.mean(np.square(errors))))


def _mesh(settings: Settings) -> Mesh:
    return pot().placed(radius=0.95) if settings.mesh is None else Mesh.read(settings.mesh).placed(radius=1.3)


def _notes(settings: Settings, light: int) -> list[str]:
    return [
        "Tangents run around the vertical. Layers are at equal steps of the angle between v and t, made "
        f"hierarchically from {2 * light} x {light} texels to an error of {TOLERANCE:.1%}; the model is "
        f"multiplied by {REFLECTED}, so that the pot is as bright as its background.",
        "The error is relative RMS against direct integration of the same light at some of the pixels of "
        "both pictures.",
        "The slices are lat-long, the paper's dual paraboloids. Self-shadowing is left out, as there.",
        *(["[KVHS00] shows a teapot: give one with --mesh."] if settings.mesh is None else []),
    ]


def _draw(pictures: Sequence[Picture], slices: Sequence[Float32Array]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    grid = figure.add_gridspec(2, 6, height_ratios=(2.2, 1.0))
    exposure = common_exposure(pictures)
    for k, picture in enumerate(pictures):
        show(figure.add_subplot(grid[0, 3 * k : 3 * k + 3]), picture, exposure)
    covered = np.ones((len(slices), *slices[0].shape[:2]), np.float32)
    stops = automatic_exposure(np.stack(slices), covered)
    for k, (pixels, angle) in enumerate(zip(slices, ANGLES, strict=True)):
        panel = figure.add_subplot(grid[1, 2 * k : 2 * k + 2])
        panel.imshow(display(pixels, stops), interpolation="lanczos")
        panel.set(xticks=[], yticks=[])
        panel.set_title(f"angle of v and t = {angle:g}°", fontsize=9)
    return figure
