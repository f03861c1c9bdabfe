"""[KVHS00] section 5.2, the table: frames per second when the hardware filters for every frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from shrm import brdf
from shrm.integrate.angular import prefilter_angular
from shrm.render import Camera, Object
from shrm.vectors import golden_spiral
from shrm.viewer import Context, HardwarePrefilter, Renderer, Scene
from shrm.viewer.gpu.hardware_prefilter import Filter
from shrm.viewer.gpu.paraboloid_kernels import TextureFilter, texture_filters

from shrm_papers.errors import relative_rms
from shrm_papers.grid_meshes import ball
from shrm_papers.kvhs00.opengl import context_or_note, frame_seconds
from shrm_papers.plotting import measured_line, panels, papers_line, plain_log
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "kvhs00-table-2"

Row = tuple[tuple[int, int], tuple[int, int], int, int]

PAPER: dict[int, Row] = {
    10: ((174, 32), (260, 64), 25, 33),
    50: ((78, 16), (136, 32), 20, 33),
    100: ((56, 8), (100, 16), 16, 25),
    250: ((36, 8), (66, 16), 16, 25),
    500: ((26, 4), (48, 8), 9, 11),
}
"""[KVHS00] section 5.2, by the exponent: size and shrink factor of the small and of the large filter, frames
per second of two passes and of one (SGI O2)."""

SIZE, BORDER = 512, 64
"""Texels of a face and of its border."""

CLAMP, LARGEST_KERNEL = 0.1, 7
"""Value of the lobe at a filter's rim relative to its peak, and most texels across a shrunk filter."""

TAPS = 128
"""Samples of the exact filter for each texel."""

PICTURE = 512
"""Pixels across the picture."""

DIRECTIONS = 4000
"""Directions at which errors are measured."""

ORDER: tuple[Filter, ...] = ("two-pass", "one-pass", "exact")

COLUMNS = (
    "exponent",
    "small filter",
    "small filter [KVHS00]",
    "large filter",
    "large filter [KVHS00]",
    "small shrink",
    "small shrink [KVHS00]",
    "large shrink",
    "large shrink [KVHS00]",
    "two passes, filter ms",
    "two passes, frames/s",
    "two passes, frames/s [KVHS00]",
    "one pass, filter ms",
    "one pass, frames/s",
    "one pass, frames/s [KVHS00]",
    "exact, filter ms",
    "exact, frames/s",
    "error, two passes",
    "error, one pass",
    "error, exact",
)


@dataclass(frozen=True)
class Speed:
    """The time and error of a filter.

    Attributes
    ----------
    filter, frame : float
        Seconds: the filter alone; filter and picture.
    error : float
        Relative RMS over the sphere.
    """

    filter: float
    frame: float
    error: float


def make(settings: Settings) -> Result:
    """Find the filters, and measure them where there is OpenGL."""
    # Times and errors by OpenGL
    exponents = (10, 500) if settings.quick else tuple(PAPER)
    context, about = context_or_note()
    measured: dict[int, dict[Filter, Speed]] = {}
    seconds = 0.0
    if context is not None:
        measured, seconds = _measure(context, settings, exponents)
        context.release()

    # A row for each exponent, ours beside the paper's
    rows: list[list[Cell]] = []
    for s in exponents:
        small, large, two_passes, one_pass = PAPER[s]
        ours = fitting_filters(s)
        row: list[Cell] = [s]
        for theirs, of_ours in (
            ((small[0], large[0]), [f.size for f in ours]),
            ((small[1], large[1]), [f.shrink for f in ours]),
        ):
            row += [x for pair in zip(of_ours, theirs, strict=True) for x in pair]
        speeds = [measured[s][filter] if measured else None for filter in ORDER]
        times: list[list[Cell]] = [
            [None, None] if speed is None else [1e3 * speed.filter, 1.0 / speed.frame] for speed in speeds
        ]
        row += [*times[0], two_passes, *times[1], one_pass, *times[2]]
        rows.append([*row, *(None if speed is None else speed.error for speed in speeds)])

    return Result(
        NAME,
        f"Filtering by OpenGL for every frame, {settings.env_name}",
        COLUMNS,
        rows,
        _notes(settings, about, seconds) if context is not None else [_SIZES, about],
        _draw(exponents, measured),
    )


def fitting_filters(exponent: int) -> tuple[TextureFilter, TextureFilter]:
    """Return the small and the large filter of an exponent."""
    return texture_filters(brdf.Phong(exponent).lobes[0].profile, SIZE, CLAMP, LARGEST_KERNEL)


def _measure(
    context: Context, settings: Settings, exponents: tuple[int, ...]
) -> tuple[dict[int, dict[Filter, Speed]], float]:
    """Return speeds by exponent and filter, and the seconds that making the unfiltered map takes."""
    # A sphere before the environment
    size, rounds = (64, 1) if settings.quick else (SIZE, 5)
    edge = PICTURE if not settings.quick else 64
    renderer, gl = Renderer((edge, edge), context=context), context.gl
    target = gl.framebuffer([gl.texture((edge, edge), 4, dtype="f4")], gl.depth_renderbuffer((edge, edge)))
    shape, camera = ball(), Camera((4.0, 2.0, 1.5), fov=32.0)
    count = DIRECTIONS // (10 if settings.quick else 1)
    directions = golden_spiral(1 - 2 * (np.arange(count) + 0.5) / count, start=0.5)

    measured: dict[int, dict[Filter, Speed]] = {}
    making = 0.0
    for s in exponents:
        exact = prefilter_angular(settings.env, brdf.Phong(s)).radiance(directions, directions)
        measured[s] = {}
        for filter in ORDER:
            with HardwarePrefilter(
                brdf.Phong(s), size=size, border=size // 8, filter=filter, taps=TAPS, context=context
            ) as prefilter:
                prefilter.update(settings.env)
                scene = Scene([Object(shape, prefilter)], camera, settings.env)

                def frame(prefilter: HardwarePrefilter = prefilter, scene: Scene = scene) -> None:
                    prefilter.apply_filter()
                    renderer.draw(scene, target)

                set_light = partial(prefilter.set_light, settings.env)
                calls: list[Callable[[], object]] = [prefilter.apply_filter, frame, set_light]
                filtering, drawing, making = frame_seconds(context, calls, 1 if filter == "exact" else rounds)
                error = relative_rms(prefilter.radiance(directions, directions), exact)
                measured[s][filter] = Speed(filtering, drawing, error)
    renderer.release()
    return measured, making


_SIZES = (
    "Filter sizes are 2 ceil(r), r_s = R tan(alpha/2) and r_l = R (1 - tan(pi/4 - alpha/2)) for the angle "
    f"alpha where the lobe falls to {CLAMP:g}. With R = {SIZE // 2} they are the paper's, and so is the "
    f"shrink factor, doubled until a filter is at most {LARGEST_KERNEL} texels across. R is half of the "
    "paper's 512 texels: its border of 64 is taken to lie beyond these, and faces are 640 texels. Within "
    "them R would be 192 and sizes three quarters as large."
)


def _notes(settings: Settings, driver: str, seconds: float) -> list[str]:
    size = "faces of 64 texels (quick)" if settings.quick else f"faces of {SIZE} texels, a border of {BORDER}"
    return [
        _SIZES,
        f"OpenGL: {driver}; {size}, float RGBA. [KVHS00] measured on an SGI O2, whose texels are clamped to "
        "[0, 1].",
        "Wall times, medians of rounds (of the exact filter one). A frame is filtered, then drawn: a sphere "
        f"of 2592 triangles before the environment, {PICTURE} x {PICTURE} pixels. As in the paper the "
        "unfiltered map and its mip-map are given; making them of the lat-long picture takes "
        f"{1e3 * seconds:.3g} ms.",
        f"The exact filter has {TAPS} taps. Errors are relative RMS over the sphere against direct "
        "integration. Those of one and two passes are what the clamp leaves out, and that a kernel of few "
        "shrunk texels, of one shape for a whole face, is not the lobe; those of the exact filter are the "
        "variance of few taps where small suns shine.",
    ]


def _draw(exponents: tuple[int, ...], measured: dict[int, dict[Filter, Speed]]) -> Figure:
    figure, axes = panels(1, 2 if measured else 1, 9.6 if measured else 5.2, 4.0)
    theirs = [PAPER[s] for s in exponents]
    for k, which in enumerate(("small", "large")):
        measured_line(axes[0], k, which, exponents, [fitting_filters(s)[k].size for s in exponents])
        papers_line(axes[0], k + 2, f"{which} [KVHS00]", exponents, [papers[:2][k][0] for papers in theirs])
    axes[0].set(ylabel="filter size, texels")
    if measured:
        for k, filter in enumerate(ORDER):
            speeds = [1.0 / measured[s][filter].frame for s in exponents]
            measured_line(axes[1], k, filter, exponents, speeds)
        for k, filter in enumerate(ORDER[:2]):
            papers_line(axes[1], k, f"{filter} [KVHS00]", exponents, [papers[2:][k] for papers in theirs])
        axes[1].set(ylabel="frames per second")
    for panel in axes:
        panel.set(xscale="log", yscale="log", xlabel="Phong exponent s")
        plain_log(panel.xaxis, subs=(1.0, 2.0, 5.0))
        plain_log(panel.yaxis, subs=(1.0, 2.0, 5.0))
        panel.legend(frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    return figure
