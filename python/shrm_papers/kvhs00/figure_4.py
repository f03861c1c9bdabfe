"""[KVHS00] figure 4: one environment filtered in every way, exponent 100, in maps of 128 x 256 texels."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from shrm import brdf
from shrm.arrays import Float32Array, FloatArray
from shrm.environment import Environment
from shrm.environment.paraboloid import face_directions
from shrm.integrate.angular import prefilter_angular
from shrm.integrate.hierarchical import prefilter_hierarchical
from shrm.render import automatic_exposure, display, environment_lookup
from shrm.render.tonemap import LUMINANCE
from shrm.viewer import HardwarePrefilter
from shrm.viewer.gpu.hardware_prefilter import Filter

from shrm_papers.errors import relative_rms
from shrm_papers.kvhs00.opengl import context_or_note, frame_seconds
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "kvhs00-figure-4"
EXPONENT = 100

SIZE, BORDER = 128, 16
"""Texels of a face and of its border."""

TAPS = 128
"""Samples of the exact filter for each texel."""

BRIGHTEST = 0.2
"""Upper end of the picture's scale of errors, relative to the mean luminance."""

HARDWARE: tuple[tuple[str, Filter], ...] = (
    ("hardware, two passes", "two-pass"),
    ("hardware, one pass", "one-pass"),
    (f"hardware, exact, {TAPS} taps", "exact"),
)


@dataclass(frozen=True)
class Filtered:
    """A map of both faces, (2, side, side, 3), and the seconds it took; None where nothing was filtered."""

    pixels: Float32Array
    seconds: float | None


def make(settings: Settings) -> Result:
    """Filter in every way that there is here, and compare with the sum over all texels."""
    size, border = (32, 4) if settings.quick else (SIZE, BORDER)
    light = settings.env.resized((size, 2 * size))
    looks = face_directions(size, border)
    maps, about = _maps(light, looks, size, border)
    exact = maps["classic"].pixels

    # Only the discs are looked up. A texel's solid angle is as (1 + |z|)^2.
    z = looks[..., 2] * np.array([1.0, -1.0])[:, None, None]
    weight = np.where(z >= 0, (1 + z) ** 2, 0.0)[..., None]
    rows: list[list[Cell]] = []
    for name, filtered in maps.items():
        error = relative_rms(filtered.pixels, exact, weight)
        milliseconds = None if filtered.seconds is None else 1e3 * filtered.seconds
        rows.append([name, milliseconds, None if name == "classic" else error])

    return Result(
        NAME,
        f"Filters compared at exponent {EXPONENT}, {settings.env_name}",
        ["filter", "ms", "relative RMS error"],
        rows,
        [
            f"Maps of two faces of {size} texels with a border of {border}; errors are over the discs, by "
            "solid angle, against the classic filter: the sum over all texels of a lat-long picture of "
            f"{2 * size} x {size}.",
            "The classic and the hierarchical filter (to an error of 1%) run on the processor, all threads; "
            "the hardware's times are of its filters alone, without the unfiltered map. Wall times.",
            "No border is dark, as those of [KVHS00] are: kernels that reach beyond it meet its outermost "
            "texels again.",
            f"OpenGL: {about}." if HARDWARE[0][0] in maps else about,
        ],
        _draw({name: filtered.pixels for name, filtered in maps.items()}, exact, weight),
    )


def _maps(light: Environment, looks: FloatArray, size: int, border: int) -> tuple[dict[str, Filtered], str]:
    """Return maps by the filter's name, and the driver, or why there is none."""
    # On the processor
    material, targets = brdf.Phong(EXPONENT), looks.reshape(-1, 3)
    descent = prefilter_hierarchical(light, material, tolerance=0.01)
    integral = prefilter_angular(light, material, subsamples=1)
    maps = {
        "unfiltered": Filtered(environment_lookup(light.pixels, targets).reshape(looks.shape), None),
        "classic": _timed(lambda: integral.radiance(targets, targets), looks.shape),
        "hierarchical": _timed(lambda: descent.radiance(targets, targets), looks.shape),
    }

    # By OpenGL
    context, about = context_or_note()
    if context is None:
        return maps, about
    for name, filter in HARDWARE:
        with HardwarePrefilter(
            material, size=size, border=border, filter=filter, taps=TAPS, context=context
        ) as prefilter:
            prefilter.update(light)
            (seconds,) = frame_seconds(context, [prefilter.apply_filter], 5)
            maps["unfiltered"] = Filtered(prefilter.unfiltered(), None)
            maps[name] = Filtered(prefilter.maps().maps[0].pixels, seconds)
    context.release()
    return maps, about


def _timed(call: Callable[[], Float32Array], shape: tuple[int, ...]) -> Filtered:
    """Return the map that a call makes, of a shape, and the seconds it took."""
    start = time.perf_counter()
    pixels = call()
    return Filtered(pixels.reshape(shape), time.perf_counter() - start)


def _draw(maps: dict[str, Float32Array], exact: Float32Array, weight: FloatArray) -> Figure:
    from matplotlib.figure import Figure

    inside = weight[..., 0] > 0
    exposure = automatic_exposure(exact[inside][None], np.ones((1, int(inside.sum())), np.float32))
    mean = float((weight[..., 0] * (exact @ LUMINANCE)).sum() / weight.sum())
    figure = Figure(figsize=(1.75 * len(maps) + 0.9, 7.4), layout="constrained")
    axes = figure.subplots(2, len(maps), squeeze=False)
    for (name, pixels), (above, below) in zip(maps.items(), axes.T, strict=True):
        above.imshow(display(np.concatenate(list(pixels)), exposure), interpolation="nearest")
        above.set_title(name.replace(", ", ",\n", 1), fontsize=9)
        below.set_visible(name != "classic")
        error = np.abs((pixels - exact) @ LUMINANCE) / mean
        image = below.imshow(100 * np.concatenate(list(error)), cmap="magma", vmin=0, vmax=100 * BRIGHTEST)
        for panel in (above, below):
            panel.set(xticks=[], yticks=[])
            panel.spines[:].set_visible(False)
    axes[0, 0].set_ylabel("map", fontsize=9)
    axes[1, 0].set_ylabel("error of luminance", fontsize=9)
    bar = figure.colorbar(image, ax=axes[1, :], extend="max", pad=0.01, aspect=30)
    bar.set_label("% of the mean", fontsize=9)
    return figure
