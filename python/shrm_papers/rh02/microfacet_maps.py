"""A microfacet lobe's T x T reflection maps by direct integration and from SHRMs: errors and times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

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

from shrm_papers import single_thread
from shrm_papers.errors import relative_rms
from shrm_papers.rh02 import flops
from shrm_papers.rh02.light_fields import root_areas
from shrm_papers.rh02.peak import flops_per_second

Call = Callable[[], object]

EPSILON = 0.05
"""Fraction of the lobe's integral that direct integration leaves out [RH02 section 7.4]."""

BRDF_EPSILON = 0.03
"""Fraction of the BRDF's energy that the paper's orders leave out."""

T = 10
"""Rows and columns of the grid of views."""

MOST_F, MOST_P = 64, 12
"""Largest orders that are tried."""

PAPER = {
    0.1: (24, 3, 923.0, 9.23, 2.70, 1.55),
    0.2: (12, 2, 2744.0, 27.44, 1.55, 0.72),
    0.3: (7, 2, 5731.0, 57.31, 1.49, 0.67),
    0.4: (5, 2, 9034.0, 90.34, 1.47, 0.65),
    0.5: (5, 2, 12580.0, 125.80, 1.45, 0.64),
}
"""[RH02] table 5, by sigma: F and P; seconds in angular space, of 100 maps and of one; seconds in frequency
space, of 100 maps and of the SHRM alone; at 1.4 GHz."""


@dataclass(frozen=True)
class MapSamples:
    """Texels of the maps of some of the T x T views, at which methods are compared.

    Attributes
    ----------
    views : (n, 3) float64
        One view from each ring of the grid of views.
    texels : (n, k) int
        Flat indices into each view's map, drawn with chances as their solid angles.
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
        """Return the radiance at the texels of the views' maps, (n k, 3)."""
        samples = [pixels.reshape(-1, 3)[chosen] for pixels, chosen in zip(maps, self.texels, strict=True)]
        return np.concatenate(samples).astype(np.float64)

    def integrated(self, angular: AngularReflection) -> FloatArray:
        """Return the radiance at the texels by direct integration, (n k, 3)."""
        R = layouts.directions("latlong", self.size, 2 * self.size).reshape(-1, 3)[self.texels.ravel()]
        V = np.repeat(self.views, self.texels.shape[1], axis=0)
        N = R + V
        return angular.radiance(N / np.linalg.norm(N, axis=1, keepdims=True), V).astype(np.float64)


def draw_samples(size: int, count: int) -> MapSamples:
    """Draw `count` texels of the maps of T views, each from a ring and a column of its own."""
    ring = np.arange(T)
    area = root_areas(size, 2 * size).astype(np.float64) ** 2
    texels = np.random.default_rng(5).choice(len(area), (T, count), p=area / area.sum())
    return MapSamples(grid_views(T)[ring, 3 * ring % T], texels, size)


def measure(env: Environment, quick: bool) -> dict[str, Any]:
    """Return the orders, errors and median seconds of every sigma, and what they were measured with."""
    size, count, rounds = (16, 40, 2) if quick else (128, 200, 3)
    sigmas = (0.3, 0.5) if quick else tuple(PAPER)
    light = env.resized((size, 2 * size))
    samples = draw_samples(size, count)
    rows: list[dict[str, Any]] = []
    calls: list[Call] = []
    for sigma in sigmas:
        rows.append(compared(light, sigma, samples))
        calls += timed(light, sigma, rows[-1], samples)
    # All take turns, so that what disturbs one disturbs all.
    seconds = np.median(single_thread.processor_seconds(calls, rounds), axis=0)
    for row, of_row in zip(rows, seconds.reshape(len(rows), -1), strict=True):
        of_row[:2] /= len(samples.timed)  # of one map
        row["seconds"] = of_row.tolist()
        row["samples"] = samples_of_map(row["sigma"], samples)
    return {
        "rows": rows,
        "size": size,
        "views": len(samples.timed),
        "texels": samples.texels.size,
        "peak": flops_per_second(),
    }


def compared(light: Environment, sigma: float, samples: MapSamples) -> dict[str, Any]:
    """Return the orders and errors for one roughness."""
    exact = samples.integrated(angular_of(light, sigma, 0.0, subsamples=4))
    cut = angular_of(light, sigma, EPSILON, subsamples=1)
    angular = relative_rms(samples.integrated(cut), exact)
    rescaled = relative_rms(samples.integrated(cut) / (1 - EPSILON), exact)
    by_energy = orders.choose(None, material(sigma), tolerance=BRDF_EPSILON, criterion="brdf")
    F, P = smallest_orders(light, sigma, samples, exact, min(angular, rescaled))
    return {
        "sigma": sigma,
        "by energy": (by_energy.F, by_energy.P),
        "energy error": error_of(shrm_of(light, sigma, (by_energy.F, by_energy.P)), samples, exact),
        "paper's error": error_of(shrm_of(light, sigma, PAPER[sigma][:2]), samples, exact),
        "orders": (F, P),
        "angular error": angular,
        "rescaled error": rescaled,
        "frequency error": error_of(shrm_of(light, sigma, (F, P)), samples, exact),
    }


def smallest_orders(
    light: Environment, sigma: float, samples: MapSamples, exact: FloatArray, largest_error: float
) -> tuple[int, int]:
    """Return the smallest P, then the smallest F, with no larger error.

    Raises
    ------
    RuntimeError
        If there are none up to `MOST_F` and `MOST_P`.
    """
    for P in range(MOST_P + 1):
        rm = shrm_of(light, sigma, (MOST_F, P))
        if error_of(rm, samples, exact) > largest_error:
            continue
        F = 0
        while error_of(truncated(rm, F), samples, exact) > largest_error:
            F += 1
        return F, P
    raise RuntimeError(
        f"sigma = {sigma}: no orders up to ({MOST_F}, {MOST_P}) have an error of {largest_error:.3g}"
    )


def truncated(rm: ReflectionMap, F: int) -> ReflectionMap:
    """Return a map of one lobe with fewer degrees."""
    (part,) = rm.expanded_parts()
    fewer = replace(part, light=part.light[: (F + 1) ** 2].copy(), rho=part.rho[: F + 1].copy())
    return replace(rm, parts=(fewer.resized(part.size, part.layout),))


def error_of(rm: ReflectionMap, samples: MapSamples, exact: FloatArray) -> float:
    """Return the relative RMS error of a SHRM's maps at samples of them."""
    return relative_rms(samples.of_maps([rm.at_view(view) for view in samples.views]), exact)


def timed(light: Environment, sigma: float, row: dict[str, Any], samples: MapSamples) -> list[Call]:
    """Return the calls to time.

    Angular (a) and (b); the SHRM and all its maps, of the orders in the row and of the paper's; the SHRM with
    nothing kept.
    """
    calls = [integration(light, sigma, samples, symmetry) for symmetry in (False, True)]
    for chosen in (row["orders"], PAPER[sigma][:2]):
        plan = Prefilter(light, material(sigma), orders=chosen, size=samples.size)
        calls += [relighting(plan, light), all_maps(plan, light)]
    return [*calls, lambda: in_one_shot(light, sigma, row["orders"])]


def integration(light: Environment, sigma: float, samples: MapSamples, symmetry: bool) -> Call:
    """Time one map for each view, half vectors found for each pixel, or by symmetry once for the view."""
    angular = angular_of(light, sigma, EPSILON, subsamples=1, symmetry=symmetry)
    return lambda: [angular.at_view(view) for view in samples.timed]


def samples_of_map(sigma: float, samples: MapSamples) -> float:
    """Return the mean number of texels that direct integration visits for one of the timed maps."""
    lobe = IsotropicIntegral.of("reflection", brdf.Microfacet(sigma).lobes[0].transfer, EPSILON, share=False)
    R = layouts.directions("latlong", samples.size, 2 * samples.size).reshape(-1, 3)
    visited = []
    for view in samples.timed:
        V = np.tile(view, (len(R), 1))
        visited.append(len(R) * flops.samples_in_caps(samples.size, *lobe.caps(lobe.normals(R, V), V)))
    return float(np.mean(visited))


def relighting(plan: Prefilter, light: Environment) -> Call:
    """Time light to the SHRM, all tables and memory made before."""
    return lambda: plan.update(light)


def all_maps(plan: Prefilter, light: Environment) -> Call:
    """Time light to the SHRM to T x T maps [RH02 eq. 12], each over the last, to time no memory."""
    out = np.empty(light.pixels.shape, dtype=np.float32)
    views = grid_views(T).reshape(-1, 3)

    def make_maps() -> None:
        rm = plan.update(light)
        for view in views:
            rm.at_view(view, out)

    return make_maps


def in_one_shot(light: Environment, sigma: float, chosen: tuple[int, int]) -> ReflectionMap:
    """Make the SHRM from light and material, with nothing kept from before."""
    analyse.cache_clear()
    return shrm_of(Environment(light.pixels), sigma, chosen)


# ---- The material, its maps about the reflection as the paper has them


def material(sigma: float) -> brdf.BRDF:
    """Return the material of [RH02] eq. 11."""
    return brdf.Microfacet(sigma).recentered("reflection")


def angular_of(
    light: Environment, sigma: float, epsilon: float, subsamples: int, symmetry: bool = True
) -> AngularReflection:
    """Integrate all but epsilon of the lobe's integral."""
    return prefilter_angular(
        light,
        material(sigma),
        cutoff=epsilon,
        size=len(light.pixels),
        subsamples=subsamples,
        symmetry=symmetry,
    )


def shrm_of(light: Environment, sigma: float, chosen: tuple[int, int]) -> ReflectionMap:
    """Return the SHRM of orders (F, P)."""
    return prefilter(light, material(sigma), orders=chosen, size=len(light.pixels))
