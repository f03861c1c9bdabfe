"""Table 2 of [RH02]: representations of the reflected light compared, in bytes, error and time.

Where the paper says yes or no, here is what was measured, for one material and one environment.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from shrm import brdf
from shrm.arrays import FloatArray
from shrm.environment import Environment
from shrm.frequency import orders
from shrm.frequency.analysis import analyse
from shrm.frequency.prefilter import prefilter
from shrm.integrate.angular import integrate, prefilter_angular
from shrm.prefiltered.explicit import icosahedral_maps, reflection_maps, three_dimensional_texture

from shrm_papers import representations, single_thread
from shrm_papers.plotting import COLORS, MARKS, panels, plain_log
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "rh02-table-2"


EPSILON = 0.03  # of the BRDF's energy, which chooses F and P as in [RH02] section 7.1
CODES = 256  # one byte for each texel
LOOK_UPS = 100_000

PAPER = {
    "Tabular": ("Yes", "No", "Yes", "No", "No"),
    "Compressed": ("No", "Yes", "Maybe", "*", "No"),
    "Factored": ("Yes", "Yes", "Yes", "*", "No"),
    "Coefficients": ("Yes", "Yes", "No", "Yes", "Yes"),
    "SHRM": ("Yes", "Yes", "Yes", "Yes", "Yes"),
}
"""[RH02] table 2: simple, compact, rendering, analysis, speed."""


def make(settings: Settings) -> Result:
    """Build every representation and measure it."""
    found = single_thread.measured(__name__, settings)
    rows = found["rows"]
    return Result(
        NAME,
        f"representations of the reflected light, {found['material']} under {settings.env_name}",
        (
            "method",
            "representation",
            "size",
            "MB",
            "relative RMS error",
            "built in, s",
            f"ms per {LOOK_UPS:,} look-ups",
            "simple [RH02]",
            "compact [RH02]",
            "rendering [RH02]",
            "analysis [RH02]",
            "speed [RH02]",
        ),
        [[*row, *PAPER[row[0]]] for row in rows],
        notes(found),
        picture(rows),
    )


def notes(found: dict[str, Any]) -> list[str]:
    """Return what the numbers mean."""
    F, P = found["orders"]
    return [
        f"(F, P) = ({F}, {P}) leave out {EPSILON:.0%} of the BRDF's energy, about the reflection. Maps have"
        f" about S^2 texels with S = {found['S/F']} F, square ones; explicit sets T x T views with"
        f" T = {found['T/P']} P [RH02 section 5.2 has 10 F and 10 P]. All is RGB in float32.",
        f"The light is reduced to {found['light']} texels, so that it can be integrated. Errors are against"
        f" direct integration over {found['frames']} seeded frames, R and V uniform on the sphere and the"
        " same for all.",
        "Times are processor time of one thread. Look-ups are bilinear in numpy but for the series, which"
        " the C++ core sums, and the last row, which is `ReflectionMap.radiance` in C++ with cubic look-ups"
        " and whose building includes the choice of its size. Building in frequency space includes the"
        " analysis of light and material.",
        "Tabular, integrated: one map at a time in angular space, lobes cut at 0.1% of their integral, which"
        f" is itself off by {found['integration']:.2%} over the same frames;"
        " compressed and factored forms are made from it, and their times include it. The twelve maps are"
        " those of [CON99], weighted as V's flat barycentric coordinates; the 3D texture is that of [KM00],"
        " the azimuthal mean of the reflected light, made from a SHRM of order"
        f" {found['texture orders']}.",
        f"Compressed: vector quantisation to {CODES} distributions over the views, each texel with its own"
        " gain. Factored: the singular vectors of the table, as many terms as the SHRM has maps.",
        'The paper has one line for all tabular forms. "*" there: straightforward, but only once the dense'
        " 4D light field is known.",
    ]


def measure(env: Environment, quick: bool) -> dict[str, Any]:
    """Return the rows without the paper's columns, and what they were made with."""
    reduced = env.resized(32, 64) if quick else env.resized(64, 128)
    material = brdf.Microfacet(0.4 if quick else 0.2)
    about_R = material.recentered("reflection")
    chosen = orders.choose(None, about_R, tolerance=EPSILON, criterion="brdf")
    F, P = chosen.F, chosen.P
    per_F, per_P = (5, 3) if quick else (10, 10)
    H = 2 * round(per_F * F / np.sqrt(2) / 2)  # H x 2 H texels are about S^2
    T = 2 * round(per_P * P / 2)
    frames = 400 if quick else 4000
    R, V, N = random_frames(frames)
    judge = integrate(reduced, about_R, N, V, subsamples=3)
    many = random_frames(LOOK_UPS)
    rows: list[list[Cell]] = []
    look_ups: list[Callable[[], object]] = []

    def compare(method: str, what: str, size: str, build: Callable[[], Any], before: float = 0.0) -> float:
        analyse.cache_clear()  # each pays for the analysis of its material
        start = time.process_time()
        form = build()
        built = before + time.process_time() - start
        rows.append([method, what, size, form.bytes / 1e6, relative_rms(form.radiance(R, V), judge), built])
        look_ups.append(lambda: form.radiance(*many[:2]))
        return built

    # One node a texel is not enough: at grazing views lobes are narrower than texels.
    angular = prefilter_angular(reduced, about_R, tolerance=1e-3, size=H, subsamples=2)
    integration = relative_rms(angular.radiance(N, V), judge)
    dense: list[representations.Tabular] = []

    def tabulated() -> representations.Tabular:
        dense.append(representations.Tabular(reflection_maps(angular, T)))
        return dense[0]

    def twelve() -> representations.Icosahedral:
        return representations.Icosahedral(icosahedral_maps(angular))

    wide = (F, 8) if quick else (2 * F, 8)

    def texture() -> representations.Texture3D:
        rm = prefilter(fresh(reduced), about_R, orders=wide, size=H)
        return representations.Texture3D(three_dimensional_texture(rm, T))

    def coefficients() -> representations.Coefficients:
        rm = prefilter(fresh(reduced), about_R, orders=(F, P), size=2)
        return representations.Coefficients(rm.expanded_parts()[0].coefficients.astype(np.float32))

    def shrm() -> representations.HarmonicMaps:
        rm = prefilter(fresh(reduced), about_R, orders=(F, P), size=H)
        return representations.HarmonicMaps(np.ascontiguousarray(rm.parts[0].maps.transpose(1, 2, 0, 3)))

    terms = (P + 1) ** 2
    texels = f"{H} x {2 * H}"
    built = compare("Tabular", "explicit maps, integrated", f"{T} x {T} maps of {texels}", tabulated)
    compare("Tabular", "icosahedral set", f"12 maps of {texels}", twelve)
    compare("Tabular", "3D texture", f"{T} layers of {texels}", texture)
    compare(
        "Compressed",
        "vector quantisation",
        f"{texels} codes of {CODES}",
        lambda: representations.quantised(dense[0].maps, CODES, rounds=3 if quick else 8),
        built,
    )
    compare(
        "Factored",
        "singular vectors",
        f"{terms} terms, {texels} and {T} x {T}",
        lambda: representations.factored(dense[0].maps, terms),
        built,
    )
    compare("Coefficients", "harmonics of R and V", f"{(F + P + 1) ** 2} x {terms}", coefficients)
    compare("SHRM", "about the reflection", f"{terms} maps of {texels}", shrm)

    analyse.cache_clear()
    start = time.process_time()
    rm = prefilter(fresh(reduced), material, orders=(F, P))
    built = time.process_time() - start
    maps = rm.parts[0].maps
    size = f"{terms} maps of {maps.shape[1]} x {maps.shape[2]}"
    error = relative_rms(rm.radiance(N, V), judge)
    rows.append(["SHRM", "about the lobe, this package's", size, maps.nbytes / 1e6, error, built])
    look_ups.append(lambda: rm.radiance(many[2], many[1]))

    # All in turn, so that what disturbs one disturbs all.
    seconds = np.median(single_thread.processor_seconds(look_ups, 3 if quick else 9), axis=0)
    for row, of_row in zip(rows, seconds, strict=True):
        row.append(1e3 * float(of_row))
    return {
        "rows": rows,
        "material": material.name,
        "orders": (F, P),
        "S/F": per_F,
        "T/P": per_P,
        "light": f"{reduced.pixels.shape[1]} x {reduced.pixels.shape[0]}",
        "frames": frames,
        "integration": integration,
        "texture orders": f"F = {wide[0]}, P = {wide[1]}",
    }


def fresh(env: Environment) -> Environment:
    """Return an environment that has kept no coefficients, so that the time includes them."""
    return Environment(env.pixels)


def random_frames(n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Reflected views, views and normals, (n, 3) each: R and V independent and uniform on the sphere.

    That is the measure of predicted errors, cos^2(theta_v) uniform: the angle between R and V is 2 theta_v.
    """
    R, V = np.random.default_rng(2).normal(size=(2, n, 3))
    R /= np.linalg.norm(R, axis=1, keepdims=True)
    V /= np.linalg.norm(V, axis=1, keepdims=True)
    N = R + V
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    return R, V, N


def relative_rms(found: npt.NDArray[Any], exact: FloatArray) -> float:
    """Relative root mean square difference, all channels pooled."""
    return float(np.sqrt(((found - exact) ** 2).sum() / (exact**2).sum()))


def picture(rows: list[list[Any]]) -> Figure:
    """Draw the error against the bytes, and against the time of look-ups."""
    figure, axes = panels(1, 2, 12.5, 5.6)
    for panel, column, label in (
        (axes[0], 3, "MB"),
        (axes[1], 6, f"ms per {LOOK_UPS:,} look-ups, one thread"),
    ):
        for index, row in enumerate(rows):
            panel.plot(
                row[column],
                row[4],
                MARKS[index],
                color=COLORS[index],
                markersize=9,
                linestyle="none",
                label=f"{row[0]}: {row[1]}",
            )
        panel.set(xscale="log", yscale="log", xlabel=label, ylabel="relative RMS error of the radiance")
        panel.margins(0.1)
        plain_log(panel.xaxis, subs=(1, 2, 5) if column == 6 else (1,))
        plain_log(panel.yaxis, subs=(1, 1.5, 2, 3, 4, 5, 7), percent=True)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=9, frameon=False)
    return figure
