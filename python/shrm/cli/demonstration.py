"""The demonstration: one row of spheres by frequency space, by integration, and their difference."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import parse
from shrm.environment import Environment
from shrm.frequency.prefilter import prefilter
from shrm.image_io import draw_text, write_image
from shrm.integrate.angular import prefilter_angular
from shrm.render import (
    Camera,
    Object,
    Picture,
    Sphere,
    SupportsRadiance,
    automatic_exposure,
    display,
    render,
    row_camera,
    row_shape,
)
from shrm.render.camera import Vector
from shrm.vectors import unit

MATERIALS = {
    "matt": "lambert:.75/.72/.68",
    "clay": ".8/.38/.25*microfacet:.4",
    "thread": ".5/.25/.13*kajiya-kay:16,mirror",
    "plastic": "lambert:.02/.08/.36+.07*microfacet:.2",
    "gold": "ggx:.4,1/.71/.29",
    "steel": "ggx:.1,.62/.6/.58",
}
"""Materials by name, from Lambert to near-mirror, as texts that `shrm.brdf.parse` reads."""

TOLERANCE = 0.03
"""Relative RMS error of the reflected radiance that is asked for."""

AMPLIFIED = 16
"""Factor of the difference in the fourth picture."""

SUN_AZIMUTH, SUN_ELEVATION = 128.0, 38.0
"""Degrees: over the left shoulder of the camera, which looks along +x."""

TURBIDITY = 2.0
"""Haze of the sky: very clear, so that the sun is sharp."""

GROUND = (0.32, 0.23, 0.14)
"""Albedo of the ground, R, G, B."""

ROWS = 48
"""Rows of the light, so few that direct integration takes seconds; the background is finer."""

FRAMES = 1600
"""Random frames (N, V) over which the error is measured."""


@dataclass(frozen=True)
class Result:
    """One line of the table: a material, its orders, its errors (relative RMS) and its time."""

    name: str
    material: str
    F: int
    P: int
    predicted: float
    measured: float
    milliseconds: float


def make_demo(
    folder: Path, diameter: int = 144, progress: Callable[[float], None] | None = None
) -> list[Result]:
    """Write the pictures and the maps of the demonstration.

    Parameters
    ----------
    folder : path
        Folder for spheres.png, integrated.png, difference.png, difference-x16.png and one reflection map
        (.exr) for each material; it is made if it does not exist.
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
    report = progress or (lambda share: None)
    env = daylight(ROWS)

    # Each material by both methods
    frequency: list[SupportsRadiance] = []
    integrated: list[SupportsRadiance] = []
    results = []
    for index, (name, text) in enumerate(MATERIALS.items()):
        brdf = parse(text)
        start = time.perf_counter()
        rm = prefilter(env, brdf, tolerance=TOLERANCE)
        milliseconds = 1e3 * (time.perf_counter() - start)
        rm.save(folder / f"{name}.exr")
        reference = prefilter_angular(env, brdf, cutoff=1e-3)
        measured = relative_rms(rm, reference, about_tangent=brdf.frame == "tangent")
        results.append(Result(name, text, rm.F, rm.P, rm.error, measured, milliseconds))
        frequency.append(rm)
        integrated.append(reference)
        report(0.4 * (index + 1) / len(MATERIALS))

    # The rows of spheres, and their difference
    sky = daylight(512)
    spheres = draw(frequency, sky, diameter, lambda share: report(0.4 + 0.1 * share))
    exact = draw(integrated, sky, diameter, lambda share: report(0.5 + 0.5 * share))
    exposure = automatic_exposure(exact.radiance, exact.coverage)
    difference = np.abs(spheres.radiance - exact.radiance)

    # The pictures with their captions
    orders = [f"F = {row.F}, P = {row.P}" for row in results]
    errors = [f"{row.measured:.1%}" for row in results]
    for file, light, captions in (
        ("spheres", spheres.radiance, orders),
        ("integrated", exact.radiance, ["integrated"] * len(results)),
        ("difference", difference, errors),
        (f"difference-x{AMPLIFIED}", AMPLIFIED * difference, [f"{text}, x {AMPLIFIED}" for text in errors]),
    ):
        write_image(folder / f"{file}.png", labelled(display(light, exposure), captions, diameter))
    return results


def daylight(rows: int) -> Environment:
    """Return the demonstration's light."""
    return Environment.daylight(
        sun_elevation=SUN_ELEVATION, sun_azimuth=SUN_AZIMUTH, turbidity=TURBIDITY, albedo=GROUND, size=rows
    )


def draw(
    materials: list[SupportsRadiance], sky: Environment, diameter: int, progress: Callable[[float], None]
) -> Picture:
    """Draw spheres of the materials in a row, the sky behind them."""
    shape, camera, centers = row_of(len(materials), diameter)
    objects = [Object(Sphere(center), material) for center, material in zip(centers, materials, strict=True)]
    return render(objects, camera, shape, background=sky, samples=3, shading="pixel", progress=progress)


def row_of(count: int, diameter: int) -> tuple[tuple[int, int], Camera, list[Vector]]:
    """Return the shape (H, W) of the picture, the camera, and the spheres' centers.

    There is room for captions below; the camera looks up, so that the ground behind them ends there.
    """
    H, W = row_shape(count, diameter)
    H += round(0.4 * diameter)
    return (H, W), *row_camera(count, W / H, elevation=-3.0, fov=36.0)


def labelled(pixels: npt.NDArray[np.uint8], captions: list[str], diameter: int) -> npt.NDArray[np.uint8]:
    """Write each material's name and a caption below its sphere."""
    shape, camera, centers = row_of(len(captions), diameter)
    columns = camera.project(centers, shape)[0]
    size = diameter // 10
    for name, caption, column in zip(MATERIALS, captions, columns, strict=True):
        pixels = draw_text(pixels, name, round(column), shape[0] - 2 * size, size)
        pixels = draw_text(pixels, caption, round(column), shape[0] - 3 * size // 4, size - size // 5)
    return pixels


def relative_rms(a: SupportsRadiance, b: SupportsRadiance, about_tangent: bool) -> float:
    """Return the relative RMS difference of a from b over random frames.

    The measure is the one that predicted errors use: R uniform on the sphere and cos^2 of the view's
    angle to N uniform; about the tangent, T and V uniform and independent. Under a sun, a few frames hold
    most of the light: those that reflect the sun and those that graze. They are drawn more often, and
    weighted by the measure over the density that they are drawn with.
    """
    rng = np.random.default_rng(1)
    around = unit(rng.normal(size=(FRAMES, 3)))
    if about_tangent:
        tangents = unit(rng.normal(size=(FRAMES, 3)))
        views, weights = around, np.ones(FRAMES)
        normals = unit(views - np.sum(views * tangents, axis=1, keepdims=True) * tangents)
    else:
        # cos^2 = t^4, t uniform: the measure d(cos^2) is 4 t^3 dt.
        t = (rng.permutation(FRAMES) + rng.uniform(size=FRAMES)) / FRAMES
        cosine = t[:, None] ** 2
        reflections, weights = directions_near_the_sun(rng)
        weights *= 4.0 * t**3
        tangents = unit(np.cross(reflections, around))
        sideways = np.cross(tangents, reflections)
        normals = cosine * reflections + np.sqrt(1.0 - cosine**2) * sideways
        views = 2.0 * cosine * normals - reflections
    light = [
        x.radiance(single(normals), single(views), tangents=single(tangents)).astype(float) for x in (a, b)
    ]
    difference = weights @ np.sum((light[0] - light[1]) ** 2, axis=1)
    return float(np.sqrt(difference / (weights @ np.sum(light[1] ** 2, axis=1))))


def directions_near_the_sun(
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors (FRAMES, 3), half uniform, half within 30 degrees of the sun, and their weights."""
    elevation, azimuth = np.radians([SUN_ELEVATION, SUN_AZIMUTH])
    across = np.cos(elevation)
    sun = np.array([across * np.cos(azimuth), across * np.sin(azimuth), np.sin(elevation)])
    rim = np.cos(np.radians(30.0))
    lowest = np.where(np.arange(FRAMES) % 2, rim, -1.0)
    cosine = lowest + (1.0 - lowest) * rng.uniform(size=FRAMES)
    sideways = unit(np.cross(sun, unit(rng.normal(size=(FRAMES, 3)))))
    directions = cosine[:, None] * sun + np.sqrt(1.0 - cosine**2)[:, None] * sideways

    # Uniform is 1/2 per unit of the cosine; the mixture is 1/4, and 1 / (2 (1 - rim)) more in the cap.
    density = 0.25 + np.where(cosine >= rim, 0.5 / (1.0 - rim), 0.0)
    return directions, 0.5 / density


def single(vectors: FloatArray) -> Float32Array:
    """Return vectors as contiguous float32."""
    return np.ascontiguousarray(vectors, np.float32)
