"""[RH02] figure 1: an armadillo of five materials in the light of four places, drawn from SHRMs.

Light, object and measured materials are files of a folder (`Settings.data`). The paper's orange and velvet
are CUReT's, which cannot be had: measurements of other materials, and fits to them, stand in for both.
"""

from __future__ import annotations

import errno
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from shrm.arrays import FloatArray
from shrm.brdf import BRDF, KajiyaKay, Microfacet, fits, load
from shrm.environment import Environment
from shrm.frequency.orders import ToleranceWarning
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.integrate.angular import prefilter_angular
from shrm.render import Camera, Mesh, Object, Placement, SupportsRadiance, about_vertical, display, render

from shrm_papers.comparison import Frames
from shrm_papers.errors import relative_rms
from shrm_papers.grid_meshes import knot
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "rh02-figure-1"

TOLERANCE = 0.03
"""Relative RMS of the reflected radiance that orders are chosen for."""

LIGHT = 256
"""Rows of the light that is prefiltered and integrated."""

PANEL = (500, 400)
"""Width and height of a panel in pixels."""

RAYS = 4
"""Rays along each side of a pixel."""

JUDGED = 4000
"""Points of each panel that are integrated."""

DISTANCE = 3.75
"""Distance of the camera from the center of an object between -1 and 1."""

FILLED = 0.97
"""Fraction of a panel that the object fills, across or upright."""


@dataclass(frozen=True)
class Panel:
    """One armadillo.

    Attributes
    ----------
    paper : str
        The paper's material.
    name : str
        The material of this panel.
    measured : str
        Who measured it.
    model : BRDF
        The material; where a file has it, a stand-in for use without a folder.
    file : str
        Part of the name of a file of measurements; empty without one.
    place, light : str
        Where the light was photographed, and part of the name of its file.
    look, turn : float
        Degrees: the camera's azimuth, and how far the object is turned from facing it.
    bright : float
        The 98th percentile of the object's strongest color as displayed; 1 is the display's limit.
    """

    paper: str
    name: str
    measured: str
    model: BRDF
    file: str
    place: str
    light: str
    look: float
    turn: float
    bright: float


MODEL, FIT = "a model", "MERL, fit of Bagher et al."
GRACE, PETER, UFFIZI, GROVE = (
    ("Grace Cathedral", "grace"),
    ("St. Peter's Basilica", "stpeters"),
    ("Uffizi gallery", "uffizi"),
    ("Eucalyptus grove", "rnl"),
)
PAINTED = fits.fit("merl-sgd", "blue-metallic-paint"), fits.fit("merl-sgd", "orange-paint")
WOVEN, BRUSHED = fits.fit("merl-sgd", "red-fabric"), (0.06, 0.5, 0.22) * KajiyaKay(32)

PANELS = (
    Panel("microfacet BRDF", "microfacet", MODEL, Microfacet(0.15), "", *GRACE, 135.0, 36.0, 1.0),
    Panel("krylon blue", "krylon blue", "Cornell", PAINTED[0], "krylon", *UFFIZI, 180.0, -26.0, 1.0),
    Panel("orange, CUReT", "golden yellow", "RGL", PAINTED[1], "golden_yellow", *PETER, 0.0, 36.0, 1.1),
    Panel("velvet, CUReT", "red fabric", FIT, WOVEN, "", *GRACE, -140.0, -26.0, 0.8),
    Panel("anisotropic BRDF", "Kajiya-Kay", MODEL, BRUSHED, "", *GROVE, 180.0, 36.0, 0.65),
)
COLUMNS = (
    "material [RH02]",
    "material",
    "measured by",
    "light",
    "F",
    "P",
    "predicted error",
    "measured, picture",
    "measured, N and V of any direction",
    "prefiltering, ms",
)


def make(settings: Settings) -> Result:
    """Prefilter, draw and judge each panel."""
    shape = object_shown(settings)
    pictures: list[npt.NDArray[np.uint8]] = []
    rows: list[list[Cell]] = []
    for panel in PANELS:
        # Orders are chosen by the predicted error, which the table has.
        env, brdf = _light(settings, panel), _material(settings, panel)
        height = 32 if settings.quick else LIGHT
        light = env.resized((height, 2 * height))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ToleranceWarning)
            rm = prefilter(light, brdf, tolerance=TOLERANCE)

        # The picture, and errors against integration of the same light.
        camera, mesh = framed(shape, panel)
        pictures.append(_picture(Object(mesh, rm), camera, env, panel.bright, settings.quick))
        exact, count = prefilter_angular(light, brdf), 100 if settings.quick else JUDGED
        judged = (visible_frames(mesh, camera, count), np.ones(count)), random_frames(rm, count)
        errors = [relative_error(rm, exact, frames, weights) for frames, weights in judged]

        stands_in = bool(panel.file) and settings.data is None
        rows.append(
            [
                panel.paper,
                brdf.name if stands_in else panel.name,
                FIT if stands_in else panel.measured,
                settings.env_name if settings.data is None else panel.place,
                *(rm.F, rm.P, rm.error, *errors, _milliseconds(light, brdf, rm)),
            ]
        )
    return Result(
        NAME,
        "An object of five materials in the light of four places",
        COLUMNS,
        rows,
        _notes(settings),
        _draw(pictures, [f"{row[1]}\n{row[3]}" for row in rows]),
    )


def _notes(settings: Settings) -> list[str]:
    lines = [
        "Panels from left to right. Krylon blue is the paper's, as Cornell measured it; the paper has it as "
        "McCool et al. rebuilt it from the same measurements.",
        "CUReT's measurements cannot be had. In place of its orange stands golden yellow, which RGL measured "
        "(Dupuy and Jakob 2018); in place of its velvet a red fabric of MERL, by the fit of Bagher et al. "
        "2012.",
        "Models: equation 11 of [RH02] with sigma = .15; Kajiya and Kay's with exponent 32 [RH02 sec. 7.1], "
        "tinted, about the direction of larger curvature. The paper does not say what it took, nor which "
        "light is in which panel.",
        f"F and P are chosen for a predicted error of {TOLERANCE:.0%}, F <= 120 and P <= 8. Errors are "
        "relative RMS, colors pooled; measured ones against integration of the same light, of "
        f"{LIGHT} rows, at {JUDGED} points that are seen in the picture, and for as many N and V of any "
        "direction, which is what is predicted; of these half are chosen by their light, and weighted.",
        "Prefiltering is from the light to maps of these orders, the material analysed before, best of ten.",
        "Objects are shown linearly, each panel with its own exposure, and shadow nothing; backgrounds are "
        "tone-mapped, as in the paper. The light is Paul Debevec's, the armadillo Stanford's.",
    ]
    if settings.data is None:
        shape = "a knot in place of the armadillo" if settings.mesh is None else "the mesh that was given"
        lines.append(
            f"Without a folder (--data) all panels have one light, and {shape}; fits to MERL stand in for "
            "files of measurements."
        )
    return lines


# ---- Files of the folder


def _file(settings: Settings, folder: str, part: str) -> Path:
    """Return the first file of a folder of the data whose name contains a part."""
    assert settings.data is not None
    place = settings.data / folder
    paths = sorted(path for path in place.iterdir() if part in path.name.lower())
    if not paths:
        raise FileNotFoundError(
            errno.ENOENT, f"{NAME} needs a file with {part!r} in its name there", str(place)
        )
    return paths[0]


def _light(settings: Settings, panel: Panel) -> Environment:
    return settings.env if settings.data is None else Environment.read(_file(settings, "env", panel.light))


def _material(settings: Settings, panel: Panel) -> BRDF:
    if settings.data is None or not panel.file:
        return panel.model
    return load(_file(settings, "brdf", panel.file))


def object_shown(settings: Settings) -> Mesh:
    """Return the object with tangents, within a cube from -1 to 1."""
    if settings.mesh is not None:
        mesh = Mesh.read(settings.mesh)
    elif settings.data is not None:
        mesh = Mesh.read(_file(settings, "mesh", "armadillo"))
    else:
        mesh = knot(128, 24) if settings.quick else knot()
    return mesh.placed().with_tangents("principal")


# ---- Drawing and judging


def framed(shape: Mesh, panel: Panel) -> tuple[Camera, Mesh]:
    """Return a panel's camera and the object turned to it, such that it fills the picture."""
    # Across the view the object is moved to the middle of what it projects to.
    phi = np.radians(panel.look)
    away = DISTANCE * np.array([-np.cos(phi), -np.sin(phi), 0.0])
    camera = Camera((float(away[0]), float(away[1]), 0.0))
    height, width = PANEL
    mesh = shape.moved(Placement(about_vertical(panel.look + panel.turn), 1.0, np.zeros(3)))
    pixel = 2.0 * DISTANCE * np.tan(np.radians(camera.fov) / 2.0) / height
    x, y = (0.5 * (part.min() + part.max()) for part in camera.project(mesh.vertices, PANEL))
    right, up, _ = camera.axes
    aside = pixel * ((0.5 * width - x) * right + (y - 0.5 * height) * up)
    mesh = mesh.moved(Placement(np.eye(3), 1.0, aside))

    # The field of view is narrowed until the object fills the panel.
    columns, lines = camera.project(mesh.vertices, PANEL)
    return camera.zoomed(FILLED * min(width / np.ptp(columns), height / np.ptp(lines))), mesh


def _picture(
    shown: Object, camera: Camera, env: Environment, bright: float, quick: bool
) -> npt.NDArray[np.uint8]:
    """Draw a panel, (H, W, 3).

    Rays are clipped to the display's range before they are averaged, which makes edges beside highlights
    smooth.
    """
    # The object
    height, width = (extent // 8 for extent in PANEL) if quick else PANEL
    rays = 1 if quick else RAYS
    drawn = render([shown], camera, (rays * height, rays * width), samples=1)
    strongest = drawn.radiance[drawn.coverage > 0].max(axis=1)
    clipped = np.clip(drawn.radiance * (bright / np.percentile(strongest, 98.0)), 0.0, 1.0)

    # The background, by Reinhard's curve for each color: half the limit at one and a half times the mean
    behind = render([], camera, (height, width), background=env, samples=rays).radiance
    behind = behind / (behind + 1.5 * behind.mean())

    # Both, pixel by pixel
    shape = (height, rays, width, rays, -1)
    linear = clipped.reshape(shape).mean(axis=(1, 3))
    linear += (1 - drawn.coverage.reshape(shape).mean(axis=(1, 3))) * behind
    return display(linear.astype(np.float32))


def visible_frames(mesh: Mesh, camera: Camera, count: int) -> Frames:
    """Return frames at points of an object that a camera sees, uniform in its picture."""
    rng = np.random.default_rng(20020721)
    height, width = PANEL
    batches: list[FloatArray] = []  # (3, n, 3) each: N, V and T
    while sum(batch.shape[1] for batch in batches) < count:
        columns, lines = rng.uniform(0, (width, height), (count, 2)).T
        origins, directions = camera.rays(columns, lines, PANEL)
        hits = mesh.intersect(origins, directions)
        assert hits.tangents is not None  # the mesh has a field of its own
        hit = np.isfinite(hits.distances)
        batches.append(np.stack([hits.normals, -directions, hits.tangents])[:, hit])
    return Frames(*np.concatenate(batches, axis=1)[:, :count])


def random_frames(rm: SupportsRadiance, count: int) -> tuple[Frames, FloatArray]:
    """Return frames of any direction, half of them chosen by their squared radiance, and weights (n,).

    Few of `Frames.drawn` see a small light at grazing angles, but these have much of the energy and error.
    """
    many = Frames.drawn(16 * count)
    energy = np.sum(many.radiance(rm) ** 2, axis=1)
    chance = 0.5 / len(energy) + 0.5 * energy / energy.sum()
    chosen = np.random.default_rng(20020722).choice(len(energy), count, p=chance)
    frames = Frames(many.normals[chosen], many.views[chosen], many.tangents[chosen])
    return frames, 1 / (len(energy) * chance[chosen])


def relative_error(
    rm: SupportsRadiance, exact: SupportsRadiance, frames: Frames, weights: FloatArray
) -> float:
    """Return the relative RMS error of a map over frames with weights (n,), colors pooled."""
    return relative_rms(frames.radiance(rm), frames.radiance(exact), weights[:, None])


def _milliseconds(light: Environment, brdf: BRDF, rm: ReflectionMap) -> float:
    """Return the best of ten times from the light to the maps, the material analysed before."""
    times = []
    for _ in range(10):
        fresh = Environment(light.pixels)  # without coefficients that were kept
        start = time.perf_counter()
        prefilter(fresh, brdf, orders=(rm.F, rm.P), size=rm.parts[0].size)
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


def _draw(pictures: Sequence[npt.NDArray[np.uint8]], captions: Sequence[str]) -> Figure:
    """Lay panels side by side, their captions below; the smaller panels of quick runs are enlarged."""
    from matplotlib.figure import Figure

    dpi, gap, below = 150, 6, 64  # pixels: between panels, and for captions
    height, width = PANEL
    full_width, full_height = len(pictures) * (width + gap) - gap, height + below
    figure = Figure(figsize=(full_width / dpi, full_height / dpi), dpi=dpi)
    for k, (picture, text) in enumerate(zip(pictures, captions, strict=True)):
        left = k * (width + gap) / full_width
        axes = figure.add_axes((left, below / full_height, width / full_width, height / full_height))
        axes.imshow(picture, interpolation="none", aspect="auto")
        axes.set_axis_off()
        middle = left + 0.5 * width / full_width
        figure.text(middle, 0.5 * below / full_height, text, fontsize=10, ha="center", va="center")
    return figure
