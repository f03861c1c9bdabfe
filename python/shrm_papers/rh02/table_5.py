"""Table 5 of [RH02]: a microfacet lobe's T x T reflection maps by direct integration and from SHRMs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from shrm import brdf
from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.environment import Environment, layouts
from shrm.frequency import orders
from shrm.frequency.analysis import analyse
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.relight import Prefilter
from shrm.integrate.angular import AngularReflection, prefilter_angular
from shrm.integrate.angular_lobes import IsotropicIntegral
from shrm.prefiltered.explicit import grid_views

from shrm_papers import flops, single_thread
from shrm_papers.peak import flops_per_second
from shrm_papers.plotting import measured_line, panels, papers_line, plain_log
from shrm_papers.representations import root_areas
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "rh02-table-5"

Call = Callable[[], object]

EPSILON = 0.05  # of the lobe that direct integration leaves out, as in [RH02] section 7.4
BRDF_EPSILON = 0.03  # of the BRDF's energy that the paper's orders leave out
T = 10  # T x T maps
MOST_F, MOST_P = 64, 12

PAPER = {
    0.1: (24, 3, 923.0, 9.23, 2.70, 1.55),
    0.2: (12, 2, 2744.0, 27.44, 1.55, 0.72),
    0.3: (7, 2, 5731.0, 57.31, 1.49, 0.67),
    0.4: (5, 2, 9034.0, 90.34, 1.47, 0.65),
    0.5: (5, 2, 12580.0, 125.80, 1.45, 0.64),
}
"""[RH02] table 5, by sigma: F and P; seconds in angular space, of 100 maps and of one; seconds in frequency
space, of 100 maps and of the SHRM alone; at 1.4 GHz."""


def make(settings: Settings) -> Result:
    """Measure both sides for every roughness."""
    found = single_thread.measured(__name__, settings)
    rows = found["rows"]
    return Result(
        NAME,
        f"time of {T} x {T} reflection maps, microfacet, by integration and from SHRMs, {settings.env_name}",
        (
            "sigma",
            f"F, P for {BRDF_EPSILON:.0%}",
            "F, P [RH02]",
            "angular (a), s",
            "(a) per map, ms",
            "angular (b), s",
            "(b) per map, ms",
            "F, P",
            "frequency, ms",
            "SHRM, ms",
            "(a) / frequency",
            "(b) / frequency",
            "(a) per map / SHRM",
            "(b) per map / SHRM",
            "angular, s [RH02]",
            "per map, s [RH02]",
            "frequency, s [RH02]",
            "SHRM, s [RH02]",
            "angular / frequency [RH02]",
            "per map / SHRM [RH02]",
            "error, angular",
            "error, angular rescaled",
            "error, frequency",
            f"error, F, P for {BRDF_EPSILON:.0%}",
            "error at the paper's F, P",
            "frequency there, ms",
            "SHRM there, ms",
            "(a) / frequency there",
            "(b) / frequency there",
            "SHRM in one shot, ms",
            "of peak, (a)",
            "of peak, (b)",
            "of peak, frequency",
            "of peak, SHRM",
        ),
        [row_of(row, found["size"], found["peak"]) for row in rows],
        notes(found),
        picture(rows),
    )


def row_of(row: dict[str, Any], size: int, peak: float) -> list[Cell]:
    """Return a row of the table from what was measured."""
    sigma = row["sigma"]
    a, b, shrm, frequency, papers_shrm, papers_frequency, one_shot = row["seconds"]
    F, P, angular_paper, map_paper, frequency_paper, shrm_paper = PAPER[sigma]
    flops_a, flops_b = (flops.half_angle_flops(row["samples"], known) for known in (False, True))
    flops_shrm = flops.shrm_flops(size, *row["orders"])
    flops_frequency = flops_shrm + T * T * flops.view_flops(size, row["orders"][1])
    return [
        sigma,
        "{}, {}".format(*row["by energy"]),
        f"{F}, {P}",
        T * T * a,
        1e3 * a,
        T * T * b,
        1e3 * b,
        "{}, {}".format(*row["orders"]),
        1e3 * frequency,
        1e3 * shrm,
        T * T * a / frequency,
        T * T * b / frequency,
        a / shrm,
        b / shrm,
        angular_paper,
        map_paper,
        frequency_paper,
        shrm_paper,
        round(angular_paper / frequency_paper, 1),
        round(map_paper / shrm_paper, 1),
        row["angular error"],
        row["rescaled error"],
        row["frequency error"],
        row["energy error"],
        row["paper's error"],
        1e3 * papers_frequency,
        1e3 * papers_shrm,
        T * T * a / papers_frequency,
        T * T * b / papers_frequency,
        1e3 * one_shot,
        flops_a / a / peak,
        flops_b / b / peak,
        flops_frequency / frequency / peak,
        flops_shrm / shrm / peak,
    ]


def notes(found: dict[str, Any]) -> list[str]:
    """Return what the numbers mean."""
    size, views = found["size"], found["views"]
    return [
        f"Light and maps are {2 * size} x {size} lat-long, RGB, the maps over the reflected view R; the"
        " paper's are 128 x 128. Times are processor time of one thread, the median of rounds in which all"
        " calls take turns; tables and memory are made before. In one shot: `prefilter` with the analysis of"
        " the material, nothing kept.",
        f"Angular times are measured on {views} maps, of every other ring of the {T} x {T} views; per map is"
        f" what was measured, and the time of all is {T * T} times that. One node for each texel within the"
        f" lobe's width, which leaves {EPSILON:.0%} of its integral out, as [RH02] section 7.4 has it for"
        " Phong."
        " (a) finds half vector and lobe anew for every pair of a pixel and a texel; (b) finds the half"
        " vectors, which depend on light and view alone, once for each map. The lobe differs from pixel to"
        " pixel, so no symmetry of the grid is left to use for one view.",
        f"Frequency: light to the SHRM to {T * T} maps [RH02 eq. 12], each written over the one before. The"
        f" paper's orders leave out {BRDF_EPSILON:.0%} of the BRDF's energy, about the reflection; ours by"
        " that criterion are beside them. What this leaves out of the reflected light is more, above all"
        " under a sun: so the times are for F and P chosen by measured error, the smallest P, then the"
        " smallest F, whose error is no larger than the angular side's, rescaled or not. Times at the"
        " paper's F and P come after.",
        "Fractions of peak count two flops for a multiply-add: for each sample of (a)"
        f" {flops.FLOPS_OF_HALF_VECTOR} for the half vector, and for each of both forms"
        f" {flops.FLOPS_OF_HALF_ANGLE} for the lobe and {flops.FLOPS_OF_SUM} for three channels; in frequency"
        " space the products of the transforms, and a multiply-add for each map, texel and channel of a view."
        " What picks the lobe's cubics, mostly permutations, is not arithmetic and not counted. The peak is"
        f" that of a float32 matrix product of BLAS in the same process, {found['peak'] / 1e9:.0f} Gflop/s.",
        f"Errors are relative RMS over {found['frames']} texels of {T} maps, one of each ring, drawn as their"
        " solid angles, against integration of the whole lobe with 4 x 4 nodes to a texel. Rescaled: over"
        f" {1 - EPSILON:g}, so that the lobe that is kept has the integral of the whole.",
    ]


def picture(rows: Sequence[dict[str, Any]]) -> Figure:
    """Draw the times of all maps, ours in ms and the paper's in s, and the ratios beside."""
    figure, (times, ratios) = panels(1, 2, 13.0, 5.8)
    sigma = [row["sigma"] for row in rows]
    a, b, shrm, frequency = (np.array([row["seconds"][k] for row in rows]) for k in range(4))
    at_papers_orders = np.array([row["seconds"][5] for row in rows])
    papers = np.array([PAPER[each] for each in sigma]).T[2:]
    for index, (label, seconds, paper) in enumerate(
        (
            ("angular (a), 100 maps", T * T * a, papers[0]),
            ("angular (b), 100 maps", T * T * b, None),
            ("frequency, 100 maps", frequency, papers[2]),
            ("SHRM", shrm, papers[3]),
        )
    ):
        measured_line(times, index, label, sigma, 1e3 * seconds)
        if paper is not None:
            papers_line(times, index, f"{label.replace(' (a)', '')}, s [RH02]", sigma, paper)
    times.set(ylabel="milliseconds of one thread; [RH02] in seconds")
    for index, (label, ratio) in enumerate(
        (
            ("(a) / frequency, 100 maps", T * T * a / frequency),
            ("(b) / frequency, 100 maps", T * T * b / frequency),
            ("(a) of one map / SHRM", a / shrm),
            ("(a) / frequency, 100 maps, F and P of [RH02]", T * T * a / at_papers_orders),
        )
    ):
        measured_line(ratios, index, label, sigma, ratio)
    papers_line(ratios, 0, "100 maps [RH02]", sigma, papers[0] / papers[2])
    papers_line(ratios, 2, "one map / SHRM [RH02]", sigma, papers[1] / papers[3])
    ratios.set(ylabel="angular time over frequency time")
    for panel in (times, ratios):
        panel.set(yscale="log", xlabel="roughness sigma", xticks=sigma)
        plain_log(panel.yaxis, subs=(1, 3))
        panel.legend(fontsize=9, frameon=False, loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    return figure


# ---- What is measured


@dataclass(frozen=True)
class Frames:
    """Where maps are compared: texels of the maps of some of the T x T views.

    Attributes
    ----------
    views : (n, 3) float64
        One view from each ring of the grid of views.
    texels : (n, k) int
        Flat indices into each view's map, as probable as their solid angles.
    size : int
        Rows of the maps.
    """

    views: FloatArray
    texels: IntArray
    size: int

    @property
    def timed(self) -> FloatArray:
        """The views whose maps are timed in angular space."""
        return self.views[::2]

    def of_maps(self, maps: list[Float32Array]) -> FloatArray:
        """Radiance at the texels of the views' maps, (n k, 3)."""
        return np.concatenate(
            [of_view.reshape(-1, 3)[at] for of_view, at in zip(maps, self.texels, strict=True)]
        ).astype(np.float64)

    def integrated(self, angular: AngularReflection) -> FloatArray:
        """Radiance at the texels by direct integration, (n k, 3)."""
        R = layouts.directions("latlong", self.size, 2 * self.size).reshape(-1, 3)[self.texels.ravel()]
        V = np.repeat(self.views, self.texels.shape[1], axis=0)
        N = R + V
        return angular.radiance(N / np.linalg.norm(N, axis=1, keepdims=True), V).astype(np.float64)


def frames_of(size: int, count: int) -> Frames:
    """Choose the frames, `count` texels of each view's map."""
    of_view = np.arange(T)
    area = root_areas(size, 2 * size).astype(np.float64) ** 2
    texels = np.random.default_rng(5).choice(len(area), (T, count), p=area / area.sum())
    return Frames(grid_views(T)[of_view, 3 * of_view % T], texels, size)


def measure(env: Environment, quick: bool) -> dict[str, Any]:
    """Return for every sigma its orders, errors and median seconds."""
    size, count, rounds = (16, 40, 2) if quick else (128, 200, 3)
    sigmas = (0.3, 0.5) if quick else tuple(PAPER)
    light = env.resized(size, 2 * size)
    frames = frames_of(size, count)
    rows: list[dict[str, Any]] = []
    calls: list[Call] = []
    for sigma in sigmas:
        rows.append(compared(light, sigma, frames))
        calls += timed(light, sigma, rows[-1], frames)
    seconds = np.median(single_thread.processor_seconds(calls, rounds), axis=0)
    for row, of_row in zip(rows, seconds.reshape(len(rows), -1), strict=True):
        of_row[:2] /= len(frames.timed)  # of one map
        row["seconds"] = of_row.tolist()
        row["samples"] = samples(row["sigma"], frames)
    return {
        "rows": rows,
        "size": size,
        "views": len(frames.timed),
        "frames": frames.texels.size,
        "peak": flops_per_second(),
    }


def compared(light: Environment, sigma: float, frames: Frames) -> dict[str, Any]:
    """Return the orders and errors for one roughness."""
    exact = frames.integrated(angular_of(light, sigma, 0.0, subsamples=4))
    cut = angular_of(light, sigma, EPSILON, subsamples=1)
    angular = relative_rms(frames.integrated(cut), exact)
    rescaled = relative_rms(frames.integrated(cut) / (1 - EPSILON), exact)
    by_energy = orders.choose(None, material(sigma), tolerance=BRDF_EPSILON, criterion="brdf")
    F, P = enough(light, sigma, frames, exact, min(angular, rescaled))
    return {
        "sigma": sigma,
        "by energy": (by_energy.F, by_energy.P),
        "energy error": error_of(shrm_of(light, sigma, (by_energy.F, by_energy.P)), frames, exact),
        "paper's error": error_of(shrm_of(light, sigma, PAPER[sigma][:2]), frames, exact),
        "orders": (F, P),
        "angular error": angular,
        "rescaled error": rescaled,
        "frequency error": error_of(shrm_of(light, sigma, (F, P)), frames, exact),
    }


def enough(
    light: Environment, sigma: float, frames: Frames, exact: FloatArray, wanted: float
) -> tuple[int, int]:
    """Return the smallest P, then the smallest F, with an error that is wanted or less.

    RuntimeError if there are none up to the largest orders tried.
    """
    for P in range(MOST_P + 1):
        rm = shrm_of(light, sigma, (MOST_F, P))
        if error_of(rm, frames, exact) > wanted:
            continue
        F = 0
        while error_of(truncated(rm, F), frames, exact) > wanted:
            F += 1
        return F, P
    raise RuntimeError(f"sigma = {sigma}: no orders up to ({MOST_F}, {MOST_P}) have an error of {wanted:.3g}")


def truncated(rm: ReflectionMap, F: int) -> ReflectionMap:
    """Return a map of one lobe with fewer degrees."""
    (part,) = rm.expanded_parts()
    fewer = replace(part, light=part.light[: (F + 1) ** 2].copy(), rho=part.rho[: F + 1].copy())
    return replace(rm, parts=(fewer.resized(part.size, part.layout),))


def error_of(rm: ReflectionMap, frames: Frames, exact: FloatArray) -> float:
    """Relative RMS error of a SHRM's maps at the frames."""
    return relative_rms(frames.of_maps([rm.at_view(view) for view in frames.views]), exact)


def relative_rms(found: FloatArray, exact: FloatArray) -> float:
    """Relative root mean square difference, channels pooled."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


def timed(light: Environment, sigma: float, row: dict[str, Any], frames: Frames) -> list[Call]:
    """Return what is timed: maps in angular space; in frequency space SHRMs, and all their maps."""
    calls = [integration(light, sigma, frames, symmetry) for symmetry in (False, True)]
    for chosen in (row["orders"], PAPER[sigma][:2]):
        plan = Prefilter(light, material(sigma), orders=chosen, size=frames.size)
        calls += [relighting(plan, light), all_maps(plan, light)]
    return [*calls, lambda: in_one_shot(light, sigma, row["orders"])]


def integration(light: Environment, sigma: float, frames: Frames, symmetry: bool) -> Call:
    """One map for each view, half vectors found for each pixel or once for the view."""
    angular = angular_of(light, sigma, EPSILON, subsamples=1, symmetry=symmetry)
    return lambda: [angular.at_view(view) for view in frames.timed]


def samples(sigma: float, frames: Frames) -> float:
    """Texels that direct integration visits for one map, the mean over the views that are timed."""
    lobe = IsotropicIntegral("reflection", brdf.Microfacet(sigma).lobes[0].transfer, EPSILON, share=False)
    R = layouts.directions("latlong", frames.size, 2 * frames.size).reshape(-1, 3)
    each = []
    for view in frames.timed:
        V = np.tile(view, (len(R), 1))
        each.append(len(R) * flops.samples_in_caps(frames.size, *lobe.caps(lobe.normals(R, V), V)))
    return float(np.mean(each))


def relighting(plan: Prefilter, light: Environment) -> Call:
    """Light to the SHRM, all tables and memory made before."""
    return lambda: plan.update(light)


def all_maps(plan: Prefilter, light: Environment) -> Call:
    """Light to the SHRM to T x T maps [RH02 eq. 12], all in one place: kept, they would measure memory."""
    out = np.empty(light.pixels.shape, dtype=np.float32)
    views = grid_views(T).reshape(-1, 3)

    def make_maps() -> None:
        rm = plan.update(light)
        for view in views:
            rm.at_view(view, out)

    return make_maps


def in_one_shot(light: Environment, sigma: float, chosen: tuple[int, int]) -> ReflectionMap:
    """Light and material to the SHRM, with nothing kept from before."""
    analyse.cache_clear()
    return shrm_of(Environment(light.pixels), sigma, chosen)


# ---- The material, both ways


def material(sigma: float) -> brdf.BRDF:
    """[RH02] eq. 11, its maps about the reflection as the paper has them."""
    return brdf.Microfacet(sigma).recentered("reflection")


def angular_of(
    light: Environment, sigma: float, epsilon: float, subsamples: int, symmetry: bool = True
) -> AngularReflection:
    """Direct integration of all but epsilon of the lobe."""
    return prefilter_angular(
        light,
        material(sigma),
        tolerance=epsilon,
        size=len(light.pixels),
        subsamples=subsamples,
        symmetry=symmetry,
    )


def shrm_of(light: Environment, sigma: float, chosen: tuple[int, int]) -> ReflectionMap:
    """The SHRM of orders (F, P)."""
    return prefilter(light, material(sigma), orders=chosen, size=len(light.pixels))
