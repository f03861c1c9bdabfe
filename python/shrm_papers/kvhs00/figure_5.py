"""[KVHS00] figure 5: a glossy torus in two environments, filtered by the hardware for every frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from shrm import brdf
from shrm.environment import Environment
from shrm.integrate.angular import prefilter_angular
from shrm.render import Camera, Object, Picture, render
from shrm.viewer import Context, HardwarePrefilter, Renderer, Scene

from shrm_papers.errors import relative_rms
from shrm_papers.grid_meshes import torus
from shrm_papers.kvhs00.opengl import context_or_note, frame_seconds
from shrm_papers.result import Cell, Result, Settings
from shrm_papers.spheres import common_exposure, show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "kvhs00-figure-5"
EXPONENTS = (50, 500)

SIZE, BORDER = 512, 64
"""Texels of a face and of its border."""

PICTURE, SAMPLES = 384, 3
"""Pixels across a picture, and samples along each side of a pixel."""

CAMERA = Camera((3.2, 1.6, 0.5), fov=52.0)

TILT = 60.0
"""Degrees: the torus stands, and shows the camera its hole."""

COLUMNS = ("environment", "exponent", "filter, ms", "frames/s", "relative RMS error")
DAYLIGHT = "daylight at noon"


def make(settings: Settings) -> Result:
    """Draw the torus with two exponents in two environments."""
    context, about = context_or_note()
    title = f"A torus filtered for every frame, {settings.env_name} and {DAYLIGHT}"
    if context is None:
        rows: list[list[Cell]] = [["not drawn", s, None, None, None] for s in EXPONENTS]
        return Result(NAME, title, COLUMNS, rows, [about])
    noon = Environment.daylight(sun_elevation=55.0, sun_azimuth=-70.0, size=32 if settings.quick else 512)
    rows, pictures = _measure(context, {settings.env_name: settings.env, DAYLIGHT: noon}, settings.quick)
    context.release()
    return Result(
        NAME,
        title,
        COLUMNS,
        rows,
        [
            f"Two passes, faces of {SIZE} texels with a border of {BORDER}; a frame is filtered, then drawn: "
            f"{PICTURE} x {PICTURE} pixels, one sample, where the figure has {SAMPLES} x {SAMPLES}."
            + (" (Quick: all smaller.)" if settings.quick else ""),
            "Errors are of the torus' pixels against direct integration of the light for each of them.",
            "Where the sun is reflected, the few texels of the shrunk map show.",
            f"OpenGL: {about}. [KVHS00] says interactive rates, on an SGI O2.",
        ],
        _draw(list(pictures), pictures),
    )


def _measure(
    context: Context, lights: dict[str, Environment], quick: bool
) -> tuple[list[list[Cell]], dict[str, list[Picture]]]:
    """Return the rows of the table, and pictures by the light's name."""
    pixels, samples, size = (32, 1, 64) if quick else (PICTURE, SAMPLES, SIZE)
    renderer = Renderer((pixels, pixels), samples=samples, context=context)
    gl, extent = context.gl, (pixels, pixels)
    target = gl.framebuffer([gl.texture(extent, 4, dtype="f4")], gl.depth_renderbuffer(extent))
    shape = torus(tilt=TILT)
    rows: list[list[Cell]] = []
    pictures: dict[str, list[Picture]] = {name: [] for name in lights}

    for name, light in lights.items():
        for s in EXPONENTS:
            with HardwarePrefilter(
                brdf.Phong(s), size=size, border=size // 8, filter="two-pass", context=context
            ) as prefilter:
                prefilter.update(light)
                scene = Scene([Object(shape, prefilter)], CAMERA, light)

                def frame(prefilter: HardwarePrefilter = prefilter, scene: Scene = scene) -> None:
                    prefilter.apply_filter()
                    renderer.draw(scene, target)

                calls = [prefilter.apply_filter, frame]
                filtering, drawing = frame_seconds(context, calls, 1 if quick else 5)
                picture = renderer.render(scene)
            pictures[name].append(picture)
            rows.append([name, s, 1e3 * filtering, 1.0 / drawing, _error(picture, scene, light, s)])
    renderer.release()
    return rows, pictures


def _error(picture: Picture, scene: Scene, light: Environment, s: int) -> float:
    """Return the relative RMS error where the torus fills a pixel, by one sample for each pixel."""
    exact = prefilter_angular(light, brdf.Phong(s))
    integrated = render([Object(scene.objects[0].shape, exact)], CAMERA, picture.coverage.shape, samples=1)
    filled = (picture.coverage == 1) & (integrated.coverage == 1)
    return relative_rms(picture.radiance[filled], integrated.radiance[filled])


def _draw(names: Sequence[str], pictures: dict[str, list[Picture]]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.6, 6.8), layout="constrained")
    axes = figure.subplots(len(names), len(EXPONENTS), squeeze=False)
    for row, name in zip(axes, names, strict=True):
        exposure = common_exposure(pictures[name])
        for panel, s, picture in zip(row, EXPONENTS, pictures[name], strict=True):
            show(panel, picture, exposure)
            if name == names[0]:
                panel.set_title(f"s = {s}", fontsize=10)
        row[0].set_ylabel(name, fontsize=10)
    return figure
