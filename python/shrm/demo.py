"""The demonstration: one row of spheres by frequency space, by integration, and their difference."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from shrm.brdf import parse
from shrm.environment import Environment
from shrm.image_io import draw_text, write_image
from shrm.prefiltering import prefilter
from shrm.reference import prefilter_angular
from shrm.render import (
    Camera,
    Object,
    Picture,
    Reflection,
    Sphere,
    automatic_exposure,
    display,
    render,
    row_camera,
    row_picture,
)
from shrm.render.camera import Vector

MATERIALS = {
    "matt": "lambert:0.75/0.72/0.68",
    "clay": "0.80/0.45/0.32*microfacet:0.5",
    "plastic": "lambert:0.03/0.1/0.4+ggx:0.35,0.05",
    "thread": "0.30/0.16/0.09*kajiya-kay:16",
    "gold": "ggx:0.35,1.0/0.71/0.29",
    "copper": "ggx:0.2,0.95/0.64/0.54",
    "steel": "ggx:0.1,0.62/0.60/0.58",
}
"""From Lambert to near-mirror, in the words of `shrm.brdf.parse`."""

AMPLIFIED = 16
SUN_AZIMUTH = 130.0  # over the left shoulder of the camera, which looks along +x
ROWS = 64  # of the light, so that direct integration takes seconds; the background is finer
FRAMES = 2000  # random frames (N, V) that the measured error is taken over


@dataclass(frozen=True)
class Result:
    """One line of the table."""

    name: str
    material: str
    F: int
    P: int
    predicted: float
    measured: float
    milliseconds: float


def make_demo(
    folder: Path, diameter: int = 128, progress: Callable[[float], None] | None = None
) -> list[Result]:
    """Write the pictures and the maps of the demonstration.

    Parameters
    ----------
    folder : path
        Made if it is not there: spheres.png, integrated.png, difference.png, difference-x16.png and
        one reflection map (.exr) for each material.
    diameter : int
        Pixels across a sphere.
    progress : callable, optional
        Called with the part of the work that is done, up to 1.

    Returns
    -------
    list of Result
        The errors are relative RMS of the reflected light over random frames, predicted and measured.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    say = progress or (lambda done: None)
    env = Environment.daylight(sun_azimuth=SUN_AZIMUTH, size=ROWS)

    frequency: list[Reflection] = []
    integrated: list[Reflection] = []
    results = []
    for index, (name, text) in enumerate(MATERIALS.items()):
        brdf = parse(text)
        start = time.perf_counter()
        rm = prefilter(env, brdf)
        milliseconds = 1e3 * (time.perf_counter() - start)
        rm.save(folder / f"{name}.exr")
        reference = prefilter_angular(env, brdf, tolerance=1e-3)
        measured = relative_rms(rm, reference, about_tangent=brdf.frame == "tangent")
        results.append(Result(name, text, rm.F, rm.P, rm.error, measured, milliseconds))
        frequency.append(rm)
        integrated.append(reference)
        say(0.4 * (index + 1) / len(MATERIALS))

    sky = Environment.daylight(sun_azimuth=SUN_AZIMUTH)
    spheres = draw(frequency, sky, diameter, lambda done: say(0.4 + 0.1 * done))
    judged = draw(integrated, sky, diameter, lambda done: say(0.5 + 0.5 * done))
    exposure = automatic_exposure(judged.radiance, judged.coverage)
    difference = np.abs(spheres.radiance - judged.radiance)
    orders = [f"{row.name}: F = {row.F}, P = {row.P}" for row in results]
    errors = [f"{row.name}: {row.measured:.1%}" for row in results]
    for file, light, captions in (
        ("spheres", spheres.radiance, orders),
        ("integrated", judged.radiance, list(MATERIALS)),
        ("difference", difference, errors),
        (f"difference-x{AMPLIFIED}", AMPLIFIED * difference, [f"{AMPLIFIED} x {text}" for text in errors]),
    ):
        write_image(folder / f"{file}.png", labelled(display(light, exposure), captions, diameter))
    return results


def draw(
    materials: list[Reflection], sky: Environment, diameter: int, progress: Callable[[float], None]
) -> Picture:
    """Draw spheres of the materials in a row, the sky behind them."""
    width, height, camera, centers = row_of(len(materials), diameter)
    objects = [Object(Sphere(center), material) for center, material in zip(centers, materials, strict=True)]
    return render(
        objects, camera, width, height, background=sky, samples=3, shading="pixel", progress=progress
    )


def row_of(count: int, diameter: int) -> tuple[int, int, Camera, list[Vector]]:
    """Width and height of the picture, the camera, and the spheres' centres."""
    width, height = row_picture(count, diameter)
    return width, height, *row_camera(count, width / height, elevation=0.5, fov=40.0)


def labelled(pixels: npt.NDArray[np.uint8], captions: list[str], diameter: int) -> npt.NDArray[np.uint8]:
    """Write a caption below each sphere of a row."""
    width, height, camera, centers = row_of(len(captions), diameter)
    size = diameter // 10
    for caption, column in zip(captions, camera.project(centers, width, height)[0], strict=True):
        pixels = draw_text(pixels, caption, round(column), height - size // 2, size)
    return pixels


def relative_rms(a: Reflection, b: Reflection, about_tangent: bool) -> float:
    """Relative RMS difference of a from b over random frames.

    The measure is the one that predicted errors use: N uniform on the sphere and cos^2 of the view's
    angle to it uniform; about the tangent, T and V uniform and independent.
    """
    rng = np.random.default_rng(1)
    axes, around = (unit(rng.normal(size=(FRAMES, 3))) for _ in range(2))
    sideways = unit(around - np.sum(around * axes, axis=1, keepdims=True) * axes)
    cosine = rng.uniform(-1.0, 1.0, FRAMES) if about_tangent else np.sqrt(rng.uniform(0.0, 1.0, FRAMES))
    views = cosine[:, None] * axes + np.sqrt(1.0 - cosine**2)[:, None] * sideways
    normals, tangents = (sideways, axes) if about_tangent else (axes, sideways)
    light = [
        x.radiance(single(normals), single(views), tangents=single(tangents)).astype(float) for x in (a, b)
    ]
    return float(np.sqrt(np.sum((light[0] - light[1]) ** 2) / np.sum(light[1] ** 2)))


def unit(vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Vectors of unit length."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def single(vectors: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """In float32, contiguous."""
    return np.ascontiguousarray(vectors, np.float32)
