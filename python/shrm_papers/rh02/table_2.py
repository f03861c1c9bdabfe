"""[RH02] table 2: representations of the reflected light compared in bytes, error and time.

Where the paper says yes or no, here is what was measured, for one material and one environment.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from shrm import brdf
from shrm.arrays import Float32Array, FloatArray
from shrm.environment import Environment
from shrm.frequency import orders
from shrm.frequency.analysis import analyse
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.integrate.angular import AngularReflection, integrate, prefilter_angular
from shrm.prefiltered.explicit import icosahedral_maps, reflection_maps, three_dimensional_texture

from shrm_papers import single_thread
from shrm_papers.errors import relative_rms
from shrm_papers.plotting import COLORS, MARKS, panels, plain_log
from shrm_papers.result import Cell, Result, Settings
from shrm_papers.rh02 import light_fields

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "rh02-table-2"

Built = TypeVar("Built")
Form = TypeVar("Form", bound=light_fields.LightField)

EPSILON = 0.03
"""Fraction of the BRDF's energy that F and P may leave out [RH02 section 7.1]."""

CODES = 256
"""Entries of the code book of the quantised table: one byte per texel."""

LOOK_UPS = 100_000
"""Look-ups that are timed together."""

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
    measured = single_thread.measured(__name__, settings)
    rows = measured["rows"]
    return Result(
        NAME,
        f"Representations of the reflected light, {measured['material']} under {settings.env_name}",
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
        notes(measured),
        picture(rows),
    )


def notes(measured: dict[str, Any]) -> list[str]:
    """Return notes on the meaning of the numbers."""
    F, P = measured["orders"]
    return [
        f"(F, P) = ({F}, {P}) leave out {EPSILON:.0%} of the BRDF's energy, about the reflection. Maps have"
        f" about S^2 texels with S = {measured['S/F']} F, square ones; explicit sets T x T views with"
        f" T = {measured['T/P']} P [RH02 section 5.2 has 10 F and 10 P]. All is RGB in float32.",
        f"The light is reduced to {measured['light']} texels, so that it can be integrated. Errors are"
        f" against direct integration over {measured['frames']} seeded frames, R and V uniform on the sphere"
        " and the same for all.",
        "Times are processor time of one thread. Look-ups are bilinear in numpy but for the series, which"
        " the C++ core sums, and the last row, which is `ReflectionMap.radiance` in C++ with cubic look-ups"
        " and whose building includes the choice of its size. Building in frequency space includes the"
        " analysis of light and material.",
        "Tabular, integrated: one map at a time in angular space, lobes cut at 0.1% of their integral, which"
        f" is itself off by {measured['integration']:.2%} over the same frames;"
        " compressed and factored forms are made from it, and their times include it. The twelve maps are"
        " those of [CON99], weighted as V's flat barycentric coordinates; the 3D texture is that of [KM00],"
        " the azimuthal mean of the reflected light, made from a SHRM of order"
        f" {measured['texture orders']}.",
        f"Compressed: vector quantisation to {CODES} distributions over the views, each texel with its own"
        " gain. Factored: the singular vectors of the table, as many terms as the SHRM has maps.",
        'The paper has one line for all tabular forms. "*" there: straightforward, but only once the dense'
        " 4D light field is known.",
    ]


# ---- What is measured


@dataclass(frozen=True, eq=False)
class Case:
    """The light, material and sizes that all representations share.

    Attributes
    ----------
    light : Environment
        The light, reduced so that it can be integrated.
    material, about_R : BRDF
        The material about its lobe's center, and about the reflection.
    F, P : int
        Orders that leave out `EPSILON` of the BRDF's energy about the reflection.
    S_per_F, T_per_P : int
        S / F, where maps have S^2 texels, and T / P, where explicit sets have T x T views.
    quick : bool
        True for fewer texels, frames and rounds.
    """

    light: Environment
    material: brdf.BRDF
    about_R: brdf.BRDF
    F: int
    P: int
    S_per_F: int
    T_per_P: int
    quick: bool

    @classmethod
    def chosen(cls, env: Environment, quick: bool) -> Case:
        """Choose the orders, and sizes by them [RH02 section 5.2]."""
        light = env.resized((32, 64)) if quick else env.resized((64, 128))
        material = brdf.Microfacet(0.4 if quick else 0.2)
        about_R = material.recentered("reflection")
        chosen = orders.choose(None, about_R, tolerance=EPSILON, criterion="brdf")
        return cls(light, material, about_R, chosen.F, chosen.P, *((5, 3) if quick else (10, 10)), quick)

    @property
    def H(self) -> int:
        """Rows of maps: H x 2 H texels are about S^2."""
        return 2 * round(self.S_per_F * self.F / math.sqrt(2) / 2)

    @property
    def T(self) -> int:
        """Rows and columns of the grid of views."""
        return 2 * round(self.T_per_P * self.P / 2)

    @property
    def texels(self) -> str:
        """The size of a map, for the table."""
        return f"{self.H} x {2 * self.H}"

    @property
    def fresh_light(self) -> Environment:
        """The light without kept coefficients, so that times include their computation."""
        return Environment(self.light.pixels)

    def shrm(self, orders: tuple[int, int], size: int) -> ReflectionMap:
        """Prefilter the light about the reflection."""
        return prefilter(self.fresh_light, self.about_R, orders=orders, size=size)


class Comparison:
    """Representations that are built, judged and gathered as rows of the table.

    Parameters
    ----------
    R, V : (n, 3) float64
        Frames at which errors are measured.
    exact : (n, 3)
        The radiance there by direct integration.

    Attributes
    ----------
    rows : list
        Rows of method, representation, size, MB, error, and seconds of building.
    look_ups : list of callables
        The look-ups of each row that are to be timed.
    """

    def __init__(self, R: FloatArray, V: FloatArray, exact: FloatArray) -> None:
        self._R, self._V, self._exact = R, V, exact
        self._many = random_frames(LOOK_UPS)
        self.rows: list[list[Cell]] = []
        self.look_ups: list[Callable[[], object]] = []

    def add(
        self, method: str, name: str, size: str, build: Callable[[], Form], seconds_before: float = 0.0
    ) -> tuple[Form, float]:
        """Build a representation; return it with the seconds of building, those before it included."""
        form, seconds = built(build)
        seconds += seconds_before
        error = relative_rms(form.radiance(self._R, self._V), self._exact)
        self.rows.append([method, name, size, form.bytes / 1e6, error, seconds])
        R, V, _ = self._many
        self.look_ups.append(lambda: form.radiance(R, V))
        return form, seconds

    def add_reflection_map(self, case: Case, N: FloatArray) -> None:
        """Prefilter about the lobe's center and judge `ReflectionMap.radiance`, which takes normals N."""
        rm, seconds = built(lambda: prefilter(case.fresh_light, case.material, orders=(case.F, case.P)))
        maps = rm.parts[0].maps
        size = f"{len(maps)} maps of {maps.shape[1]} x {maps.shape[2]}"
        error = relative_rms(rm.radiance(N, self._V), self._exact)
        self.rows.append(["SHRM", "about the lobe, this package's", size, maps.nbytes / 1e6, error, seconds])
        _, many_V, many_N = self._many
        self.look_ups.append(lambda: rm.radiance(many_N, many_V))


def measure(env: Environment, quick: bool) -> dict[str, Any]:
    """Return the rows without the paper's columns, and what they were made with."""
    case = Case.chosen(env, quick)
    frames = 400 if quick else 4000
    R, V, N = random_frames(frames)
    exact = integrate(case.light, case.about_R, N, V, subsamples=3)

    # One node a texel is not enough: at grazing views lobes are narrower than texels.
    angular = prefilter_angular(case.light, case.about_R, cutoff=1e-3, size=case.H, subsamples=2)
    comparison = Comparison(R, V, exact)
    table, seconds = add_explicit(comparison, case, angular)
    add_compressed(comparison, case, table.maps, seconds)
    add_harmonics(comparison, case)
    comparison.add_reflection_map(case, N)

    # All take turns, so that what disturbs one disturbs all.
    times = single_thread.processor_seconds(comparison.look_ups, 3 if quick else 9)
    for row, median in zip(comparison.rows, np.median(times, axis=0), strict=True):
        row.append(1e3 * float(median))
    return {
        "rows": comparison.rows,
        "material": case.material.name,
        "orders": (case.F, case.P),
        "S/F": case.S_per_F,
        "T/P": case.T_per_P,
        "light": f"{case.light.pixels.shape[1]} x {case.light.pixels.shape[0]}",
        "frames": frames,
        "integration": relative_rms(angular.radiance(N, V), exact),
        "texture orders": "F = {}, P = {}".format(*texture_orders(case)),
    }


def add_explicit(
    comparison: Comparison, case: Case, angular: AngularReflection
) -> tuple[light_fields.Tabular, float]:
    """Add the tabular forms; return the set for a grid of views with the seconds of its integration."""

    def tabulated() -> light_fields.Tabular:
        return light_fields.Tabular(reflection_maps(angular, case.T))

    def twelve() -> light_fields.Icosahedral:
        return light_fields.Icosahedral(icosahedral_maps(angular))

    def texture() -> light_fields.Texture3D:
        rm = case.shrm(texture_orders(case), case.H)
        return light_fields.Texture3D(three_dimensional_texture(rm, case.T))

    T, texels = case.T, case.texels
    table = comparison.add("Tabular", "explicit maps, integrated", f"{T} x {T} maps of {texels}", tabulated)
    comparison.add("Tabular", "icosahedral set", f"12 maps of {texels}", twelve)
    comparison.add("Tabular", "3D texture", f"{T} layers of {texels}", texture)
    return table


def add_compressed(comparison: Comparison, case: Case, table: Float32Array, seconds: float) -> None:
    """Add the forms that are made from the table of all views, which took `seconds`."""
    comparison.add(
        "Compressed",
        "vector quantisation",
        f"{case.texels} codes of {CODES}",
        lambda: light_fields.quantised(table, CODES, rounds=3 if case.quick else 8),
        seconds,
    )
    terms = (case.P + 1) ** 2
    comparison.add(
        "Factored",
        "singular vectors",
        f"{terms} terms, {case.texels} and {case.T} x {case.T}",
        lambda: light_fields.factored(table, terms),
        seconds,
    )


def add_harmonics(comparison: Comparison, case: Case) -> None:
    """Add the forms in frequency space, about the reflection."""
    F, P = case.F, case.P

    def coefficients() -> light_fields.Coefficients:
        (part,) = case.shrm((F, P), 2).expanded_parts()
        return light_fields.Coefficients(part.coefficients.astype(np.float32))

    def maps() -> light_fields.HarmonicMaps:
        (part,) = case.shrm((F, P), case.H).parts
        return light_fields.HarmonicMaps(np.ascontiguousarray(part.maps.transpose(1, 2, 0, 3)))

    terms = (P + 1) ** 2
    comparison.add("Coefficients", "harmonics of R and V", f"{(F + P + 1) ** 2} x {terms}", coefficients)
    comparison.add("SHRM", "about the reflection", f"{terms} maps of {case.texels}", maps)


def texture_orders(case: Case) -> tuple[int, int]:
    """Return the orders of the SHRM that the 3D texture is made from: more than it can show."""
    return (case.F if case.quick else 2 * case.F), 8


def built(build: Callable[[], Built]) -> tuple[Built, float]:
    """Build a form; return it with its processor time in seconds, the material's analysis included."""
    analyse.cache_clear()
    start = time.process_time()
    form = build()
    return form, time.process_time() - start


def random_frames(n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return reflected views, views and normals, (n, 3) each: R and V independent, uniform on the sphere.

    That is the measure of predicted errors, cos^2(theta_v) uniform: the angle between R and V is 2 theta_v.
    """
    R, V = np.random.default_rng(2).normal(size=(2, n, 3))
    R /= np.linalg.norm(R, axis=1, keepdims=True)
    V /= np.linalg.norm(V, axis=1, keepdims=True)
    N = R + V
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    return R, V, N


# ---- How it is shown


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
