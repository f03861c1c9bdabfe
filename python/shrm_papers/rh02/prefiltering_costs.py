"""The work of prefiltering that [RH02] table 3 counts, each growth at several sizes, ready to be timed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from shrm import brdf, sh
from shrm.arrays import Float32Array, FloatArray
from shrm.environment import Environment, layouts
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.relight import Prefilter
from shrm.integrate.angular import AngularReflection, prefilter_angular
from shrm.prefiltered import explicit

from shrm_papers import single_thread

Call = Callable[[], object]

MATERIAL = brdf.Microfacet(0.2).recentered("reflection")
EPSILON = 0.05
"""Fraction of a lobe's integral that angular integration leaves out [RH02 section 7.4]."""


@dataclass(frozen=True)
class Cost:
    """One stage of prefiltering whose cost grows with one size.

    Attributes
    ----------
    kind : str
        The row of the paper's table, and angular space or frequency space.
    theory : str
        The cost in the paper.
    stage : str
        The work that is timed.
    against : str
        The size that grows.
    fixed : str
        The others and their values.
    expected : float
        The theory's exponent.
    sizes : sequence of float
        The values of the one that grows.
    calls : sequence of callables
        The work for each of them.
    """

    kind: str
    theory: str
    stage: str
    against: str
    fixed: str
    expected: float
    sizes: Sequence[float]
    calls: Sequence[Call]


def measure(env: Environment, quick: bool) -> list[dict[str, Any]]:
    """Return every cost's attributes without its calls, with "seconds" (rounds, sizes)."""
    measured = []
    for costs in (radial_costs, map_costs, explicit_costs, angular_costs):
        for cost in costs(env, quick):
            attributes = {
                part.name: getattr(cost, part.name) for part in fields(cost) if part.name != "calls"
            }
            seconds = single_thread.processor_seconds(cost.calls, 2 if quick else 9)
            measured.append({**attributes, "seconds": seconds.tolist()})
    return measured


# ---- What is timed: each function prepares work and returns a call that repeats it


def analysis(pixels: Float32Array, F: int) -> Call:
    """Time light to L_lm [RH02 section 6.1]."""
    return lambda: sh.analysis(pixels, F)


def synthesis(coefficients: FloatArray, S: int) -> Call:
    """Time B_lm to the one map of a radial BRDF."""
    return lambda: sh.synthesis(coefficients, (S, 2 * S))


def both(pixels: Float32Array, F: int) -> Call:
    """Time light to the map of a radial BRDF, but for the product in between, which is of order F^2."""
    S = len(pixels)
    return lambda: sh.synthesis(sh.analysis(pixels, F), (S, 2 * S))


def maps(env: Environment, F: int, P: int, S: int) -> Call:
    """Time L_lm and rho_lpq to the SHRM; both are kept, and so are tables of orders and sizes."""
    relit = Prefilter(env, MATERIAL, orders=(F, P), size=S)
    return lambda: relit.update()


def explicit_maps(rm: ReflectionMap, T: int) -> Call:
    """Time a SHRM to T x T reflection maps [RH02 eq. 12]."""
    return lambda: explicit.reflection_maps(rm, T)


def integration(angular: AngularReflection, S: int, views: FloatArray) -> Call:
    """Time maps of S x 2 S pixels over R, one for each view (n, 3), every pixel integrated."""
    R = np.tile(layouts.directions("latlong", S, 2 * S).reshape(-1, 3), (len(views), 1))
    V = np.repeat(views, 2 * S * S, axis=0)
    N = R + V
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    return lambda: angular.radiance(N, V)


# ---- The table's rows, quick ones at fewer and smaller sizes


def light_of(env: Environment, S: int) -> Float32Array:
    """Return the environment to degree 15 as S x 2 S samples, so that every size has the same light."""
    return sh.synthesis(env.coefficients(15), (S, 2 * S))


def radial_costs(env: Environment, quick: bool) -> list[Cost]:
    """Return the costs of a 1D BRDF in frequency space: F_B S_B^2."""
    sizes = [128, 181, 256, 362] if quick else [256, 362, 512, 724, 1024, 1448]
    degrees = [12, 24, 48] if quick else [12, 18, 27, 40, 60, 90, 120]
    F, S = 30, (128 if quick else 512)
    pictures = {size: light_of(env, size) for size in {*sizes, S}}
    light = env.coefficients(max(degrees))

    def cost(stage: str, against: str, expected: float, calls: Sequence[Call]) -> Cost:
        fixed = f"S = {S}" if against == "F" else f"F = {F}"
        swept = degrees if against == "F" else sizes
        return Cost("1D BRDF, frequency", "F_B S_B^2", stage, against, fixed, expected, swept, calls)

    return [
        cost("analysis", "S_L", 2, [analysis(pictures[size], F) for size in sizes]),
        cost("synthesis", "S_B", 2, [synthesis(light[: (F + 1) ** 2], size) for size in sizes]),
        cost("both", "S", 2, [both(pictures[size], F) for size in sizes]),
        cost("analysis", "F", 1, [analysis(pictures[S], degree) for degree in degrees]),
        cost("synthesis", "F", 1, [synthesis(light[: (degree + 1) ** 2], S) for degree in degrees]),
        cost("both", "F", 1, [both(pictures[S], degree) for degree in degrees]),
    ]


def map_costs(env: Environment, quick: bool) -> list[Cost]:
    """Return the costs of a SHRM: F_B P_B^2 S_B^2."""
    sizes = [64, 90, 128] if quick else [128, 182, 256, 362, 512]
    degrees = [12, 24, 48] if quick else [12, 17, 24, 34, 48, 68]
    orders = [1, 3, 7] if quick else [1, 2, 3, 5, 8, 11]
    F, P, S = 30, 3, 128

    def cost(against: str, expected: float, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "F_B P_B^2 S_B^2", "product and maps"
        return Cost("SHRM, frequency", theory, stage, against, fixed, expected, swept, calls)

    return [
        cost("S_B", 2, f"F = {F}, P = {P}", sizes, [maps(env, F, P, size) for size in sizes]),
        cost("F", 1, f"P = {P}, S = {S}", degrees, [maps(env, degree, P, S) for degree in degrees]),
        cost("P + 1", 2, f"F = {F}, S = {S}", [p + 1 for p in orders], [maps(env, F, p, S) for p in orders]),
    ]


def explicit_costs(env: Environment, quick: bool) -> list[Cost]:
    """Return the costs of a 3D BRDF in frequency space: P_B T_B^2 S_B^2."""
    sizes = [32, 64, 90] if quick else [64, 90, 128, 182, 256]
    orders = [1, 3, 7] if quick else [1, 2, 3, 5, 8, 11]
    counts = [2, 4, 6] if quick else [3, 4, 6, 8, 11, 16]
    F, P, S, T = 12, 3, 64, 4
    T_B = 10  # [RH02 section 7.4]; fewer views share less of the sum over p

    def rm(P: int, S: int) -> ReflectionMap:
        return prefilter(env, MATERIAL, orders=(F, P), size=S)

    def cost(against: str, expected: float, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "P_B T_B^2 S_B^2", "T x T maps from the SHRM"
        return Cost("3D BRDF, frequency", theory, stage, against, fixed, expected, swept, calls)

    return [
        cost("T", 2, f"P = {P}, S = {S}", counts, [explicit_maps(rm(P, S), count) for count in counts]),
        cost("S_B", 2, f"P = {P}, T = {T}", sizes, [explicit_maps(rm(P, size), T) for size in sizes]),
        cost(
            "P + 1",
            1,
            f"S = {S}, T = {T_B}",
            [p + 1 for p in orders],
            [explicit_maps(rm(p, S), T_B) for p in orders],
        ),
    ]


def angular_costs(env: Environment, quick: bool) -> list[Cost]:
    """Return the costs of both kinds in angular space: W S_L^2 S_B^2, and T_B^2 times that."""
    light_sizes = [32, 64, 90] if quick else [256, 362, 512, 724, 1024]
    sizes = [4, 8, 12] if quick else [4, 6, 8, 12, 16]
    exponents = [8, 32, 128] if quick else [8, 16, 32, 64, 128, 256]
    counts = [1, 2, 3] if quick else [1, 2, 3, 4]
    S_L, S_B, s = (64, 8, 32) if quick else (512, 8, 32)
    above = np.array([[0.0, 0.0, 1.0]])

    def lobe(material: brdf.BRDF, light_size: int) -> AngularReflection:
        light = Environment(light_of(env, light_size))
        return prefilter_angular(light, material, cutoff=EPSILON, subsamples=1)

    def phong(s: float, light_size: int, size: int) -> Call:
        return integration(lobe(brdf.Phong(s), light_size), size, above)

    def radial(against: str, expected: float, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "W S_L^2 S_B^2", "integration"
        return Cost("1D BRDF, angular", theory, stage, against, fixed, expected, swept, calls)

    def general(against: str, fixed: str, swept: Sequence[float], calls: list[Call]) -> Cost:
        theory, stage = "W S_L^2 T_B^2 S_B^2", "integration"
        return Cost("3D BRDF, angular", theory, stage, against, fixed, 2, swept, calls)

    # W is the fraction of the sphere within the lobe's width; Phong's exponent varies it.
    widths = [0.5 * (1 - EPSILON ** (1 / (s + 1))) for s in exponents]  # [RH02] appendix D
    facets = {size: lobe(MATERIAL, size) for size in {*light_sizes, S_L}}
    views = {count: explicit.grid_views(count).reshape(-1, 3) for count in counts}
    return [
        radial("S_L", 2, f"s = {s}, S_B = {S_B}", light_sizes, [phong(s, size, S_B) for size in light_sizes]),
        radial("S_B", 2, f"s = {s}, S_L = {S_L}", sizes, [phong(s, S_L, size) for size in sizes]),
        radial("W", 1, f"S_L = {S_L}, S_B = {S_B}", widths, [phong(s, S_L, S_B) for s in exponents]),
        general(
            "S_L",
            f"sigma = .2, S_B = {S_B}, T = 1",
            light_sizes,
            [integration(facets[size], S_B, above) for size in light_sizes],
        ),
        general(
            "S_B",
            f"sigma = .2, S_L = {S_L}, T = 1",
            sizes,
            [integration(facets[S_L], size, above) for size in sizes],
        ),
        general(
            "T",
            f"sigma = .2, S_L = {S_L}, S_B = {S_B}",
            counts,
            [integration(facets[S_L], S_B, views[count]) for count in counts],
        ),
    ]
