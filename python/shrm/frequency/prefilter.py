"""Prefiltering in frequency space: from an environment and a material to a reflection map.

The three steps of [RH02] appendix C: coefficients of light and material, their product, synthesis. The
global form is synthesised at once, as an ordinary band-limited function (see
`cpp/shrm/map_coefficients.hpp`).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cache
from typing import Literal, get_args

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import BRDF
from shrm.brdf.lobe import Center, IsotropicLobe, RadialLobe
from shrm.environment import Environment
from shrm.frequency.analysis import LobeAnalysis
from shrm.frequency.interpolation import interpolation_error, map_spectrum, measured_interpolation_error
from shrm.frequency.orders import (
    F_MAX,
    P_MAX,
    Criterion,
    LightPower,
    ToleranceWarning,
    analysed,
    analysis_degree,
    choose,
    error_of,
    require_orders,
    require_tolerance,
)
from shrm.frequency.part import Part
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.split_orders import CORE_SHARE, Split, split_for
from shrm.integrate.angular import DEFAULT_SIZE
from shrm.integrate.residual import Residual, residual_for
from shrm.lobes.reflection import Layout, map_names
from shrm.validation import one_of, whole_number

Window = Literal["hann", "lanczos"]

MAX_BYTES = 4 << 30
"""What the maps, or their coefficients, of one lobe may take."""

_SIZES = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024)


def prefilter(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float = 0.05,
    orders: tuple[int, int] | None = None,
    criterion: Criterion = "light",
    size: int | None = None,
    layout: Layout = "latlong",
    center: Center | None = None,
    F_max: int = F_MAX,
    P_max: int = P_MAX,
    window: Window | None = None,
    clamp: bool = False,
    half: bool = False,
    residual: Literal["auto"] | None = None,
) -> ReflectionMap:
    """Prefilter an environment with a material.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material, of one lobe or several.
    tolerance : float
        The error wanted, in (0, 1); by default the relative RMS of the reflected radiance.
    orders : (F, P), optional
        Use these orders instead. Radial lobes have P = 0 whatever is asked for.
    criterion : {"light", "brdf", "minimum", "bound"}
        What the error measures, see `shrm.orders`.
    size : int, optional
        Rows of a lat-long map (even, its width is twice that), or of a cube's face. By default chosen so that
        cubic interpolation adds less than a tenth of the predicted error.
    layout : {"latlong", "cube"}
        The grid of the maps.
    center : {"lobe", "reflection", "normal"}, optional
        Put the lobes that are not exactly symmetric about this center; "reflection" is the paper's.
    F_max, P_max : int
        Caps on the orders that a tolerance may take.
    window : {"hann", "lanczos"}, optional
        Damp the high degrees against ringing; counted in the predicted error by the criteria `light` and
        `brdf`.
    clamp : bool
        Set negative radiance to zero when the map is read.
    half : bool
        Keep the maps as half floats: half the memory, half the time of `at_view`, 5e-4 of relative rounding.
        The coefficients stay in full precision; files hold the rounded maps as 32-bit floats.
    residual : "auto", optional
        Split off the cores of lobes that the orders, given or within the caps, cannot hold at the tolerance;
        they are integrated, or looked up, whenever the map is read (`shrm.integrate.residual`). The maps are
        then 128
        rows, or 64 of a face, at least. For the criterion `light` without a window; lobes about the tangent
        stay whole.

    Returns
    -------
    ReflectionMap

    Warns
    -----
    ToleranceWarning
        If the tolerance cannot be met within the caps; with a residual, if it is not met even so.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type or out of its range, a residual does not go with others, the maps
        would take more than 4 GiB, or, as half floats, hold values beyond 65504.
    """
    return prefilter_split(
        env,
        brdf,
        tolerance=tolerance,
        orders=orders,
        criterion=criterion,
        size=size,
        layout=layout,
        center=center,
        F_max=F_max,
        P_max=P_max,
        window=window,
        clamp=clamp,
        half=half,
        residual=residual,
    )[0]


def prefilter_split(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float,
    orders: tuple[int, int] | None,
    criterion: Criterion,
    size: int | None,
    layout: Layout,
    center: Center | None,
    F_max: int,
    P_max: int,
    window: Window | None,
    clamp: bool,
    half: bool,
    residual: Literal["auto"] | None,
) -> tuple[ReflectionMap, Split | None, float]:
    """Return what `prefilter` does, what was split off, and the relative error of the cores."""
    if not isinstance(env, Environment):
        raise TypeError(f"env must be an Environment, got {type(env).__name__}")
    if not isinstance(brdf, BRDF):
        raise TypeError(f"brdf must be a material of shrm.brdf, got {type(brdf).__name__}")
    one_of("layout", layout, get_args(Layout))
    one_of("criterion", criterion, get_args(Criterion))
    if window is not None:
        one_of("window", window, get_args(Window))
    if size is not None:
        whole_number("size", size, 2, 8192)
        if size % 2:
            raise ValueError(f"size must be even, got {size}")
    if residual is not None:
        one_of("residual", residual, ("auto",))
        if criterion != "light" or window is not None:
            raise ValueError("residual='auto' is for criterion='light' without a window")
    if center is not None:
        brdf = brdf.recentered(center)

    for name, flag in (("clamp", clamp), ("half", half)):
        if not isinstance(flag, bool):
            raise TypeError(f"{name} must be True or False, got {flag!r}")
    require_tolerance(tolerance)
    split = None
    if residual is not None:
        split = split_for(env, brdf, tolerance, None if orders is None else _pair(orders), F_max, P_max)
    whole, cores = brdf, False
    if split is not None:
        brdf, lobe_orders, cores = split.smooth, list(split.orders), split.has_cores
        L, most = split.analysed_to
    elif orders is None:
        chosen = choose(brdf, tolerance, criterion, env, F_max=F_max, P_max=P_max)
        lobe_orders = [(lobe.F, lobe.P) for lobe in chosen.lobes]
        L, most = analysis_degree(max(F for F, _ in lobe_orders), F_max), P_max
    else:
        L, most = _pair(orders)
        lobe_orders = [(L, 0 if isinstance(lobe, RadialLobe) else most) for lobe in brdf.lobes]
    for lobe, (F, P) in zip(brdf.lobes, lobe_orders, strict=True):
        _require_memory(F, P, not isinstance(lobe, IsotropicLobe), size, layout)
    lobes = analysed(brdf, L, most)

    light = env.coefficients(max(F for F, _ in lobe_orders))

    def truncation_error() -> float:
        if split is not None:
            return split.energy(env).truncation
        power = LightPower.of(env, max(F_max, *(F for F, _ in lobe_orders)))
        windows = [degree_window(window, F) for F, _ in lobe_orders]
        return error_of(brdf, lobe_orders, power, criterion, windows).error

    parts = [_unsampled(lobe, light, *pair, window) for lobe, pair in zip(lobes, lobe_orders, strict=True)]

    @cache
    def spectra() -> list[FloatArray]:  # only where a size or an error is asked for
        return [map_spectrum(part) for part in parts]

    def share() -> float:  # of the smooth parts in what is reflected
        return 1.0 if split is None else max(split.energy(env).smooth_share, 1e-3)

    if size is not None:
        sizes, wanted = [int(size)], np.inf
    else:
        wanted = 0.1 * max(truncation_error(), 1e-3) / share()
        least = DEFAULT_SIZE[layout] if cores else 0
        enough = [s for s in _SIZES if s >= least and interpolation_error(spectra(), s, layout) <= wanted]
        sizes = enough[:4] or [_SIZES[-1]]
    for chosen_size in sizes:  # the first suffices but for fits that are ill-conditioned
        sampled = tuple(part.resized(chosen_size, layout) for part in parts)
        if chosen_size == sizes[-1] or measured_interpolation_error(sampled) <= wanted:
            break

    def between_texels() -> float:
        return max(interpolation_error(spectra(), chosen_size, layout), measured_interpolation_error(sampled))

    of_cores, off = None, 0.0
    if split is not None:
        of_cores, off = _residual(env, split, sampled, tolerance)
        error = float(np.hypot(truncation_error(), off))
        if error > tolerance:
            warnings.warn(
                f"{whole.name}: tolerance {tolerance:g} is not met with a residual: the error is {error:.3g}",
                ToleranceWarning,
                stacklevel=3,
            )

    def predict() -> float:
        between = share() * between_texels() if criterion == "light" else 0.0
        return float(np.sqrt(truncation_error() ** 2 + between**2 + off**2))

    if half:
        sampled = tuple(part.as_half() for part in sampled)
    return ReflectionMap(sampled, whole.name, criterion, window, clamp, predict, of_cores), split, off


def _residual(
    env: Environment, split: Split, parts: Sequence[Part], tolerance: float
) -> tuple[Residual | None, float]:
    """The residual of a split material, and its error relative to what the whole reflects."""
    names = map_names([part.center for part in parts])
    cores = [
        (name, core, part.center, part.gamma)
        for name, core, part in zip(names, split.cores, parts, strict=True)
        if core is not None
    ]
    if not cores:
        return None, 0.0
    whole = split.energy(env).whole
    allowed = (CORE_SHARE * tolerance) ** 2 * whole
    made, error = residual_for(env.pixels, cores, parts[0].layout, parts[0].size, allowed)
    return made, float(np.sqrt(error / whole)) if whole > 0 else 0.0


def predicted_split_error(env: Environment, split: Split, parts: Sequence[Part], of_cores: float) -> float:
    """Return the error of maps with a residual, as `predicted_error` does; that of the cores is given."""
    energy = split.energy(env)
    spectra = [map_spectrum(part) for part in parts]
    between = energy.smooth_share * interpolation_error(spectra, parts[0].size, parts[0].layout)
    return float(np.sqrt(energy.truncation**2 + between**2 + of_cores**2))


def predicted_error(
    env: Environment,
    brdf: BRDF,
    parts: Sequence[Part],
    criterion: Criterion,
    window: Window | None,
    F_max: int,
) -> float:
    """Return the error of maps, from the spectra of light, material and maps alone.

    Parameters
    ----------
    env, brdf, criterion, window, F_max
        What the maps were made from, as in `prefilter`.
    parts : sequence of Part
        The maps.
    """
    orders = [(part.F, part.P) for part in parts]
    power = LightPower.of(env, max(F_max, *(F for F, _ in orders)))
    truncation = error_of(brdf, orders, power, criterion, [degree_window(window, F) for F, _ in orders]).error
    if criterion != "light":
        return truncation
    spectra = [map_spectrum(part) for part in parts]
    return float(np.hypot(truncation, interpolation_error(spectra, parts[0].size, parts[0].layout)))


def windowed(lobe: LobeAnalysis, F: int, P: int, window: Window | None) -> FloatArray:
    """rho_lpq of a lobe for three channels, its degrees weighted: (F+1, P+1, P+1, 3)."""
    rho = lobe.coefficients(F, P) * degree_window(window, F)[:, None, None, None]
    return np.ascontiguousarray(np.broadcast_to(rho, (*rho.shape[:3], 3)))


def degree_window(name: Window | None, F: int) -> FloatArray:
    """Weights of the degrees 0..F: 1 without a window; Hann's cosine or Lanczos' sinc to zero at F + 1."""
    x = np.arange(F + 1) / (F + 1)
    if name == "hann":
        return np.asarray((1 + np.cos(np.pi * x)) / 2)
    if name == "lanczos":
        return np.asarray(np.sinc(x))
    return np.ones(F + 1)


def _unsampled(lobe: LobeAnalysis, light: FloatArray, F: int, P: int, window: Window | None) -> Part:
    """A part with its coefficients, and maps of no size yet."""
    zonal = lobe.kind != "isotropic"
    return Part(
        center=lobe.center,
        gamma=lobe.gamma,
        zonal=zonal,
        layout="latlong",
        light=np.ascontiguousarray(light[: (F + 1) ** 2], dtype=np.float64),
        rho=windowed(lobe, F, P, window),
        rings=np.zeros((0, P + 1 if zonal else (P + 1) ** 2, 3, 0), dtype=np.float32),
    )


def _require_memory(F: int, P: int, zonal: bool, size: int | None, layout: Layout) -> None:
    """Raise ValueError if a lobe's maps or coefficients are larger than MAX_BYTES."""
    maps = P + 1 if zonal else (P + 1) ** 2
    coefficients = 8 * 3 * maps * (F + 1 if zonal else F + P + 1) ** 2
    texels = 0 if size is None else size * size * (2 if layout == "latlong" else 6)
    largest = max(coefficients, 4 * 3 * maps * texels)
    if largest > MAX_BYTES:
        at = "" if size is None else f" and size {size}"
        raise ValueError(
            f"orders ({F}, {P}){at} take {largest / 2**30:.1f} GiB, over the limit of {MAX_BYTES >> 30} GiB: "
            "lower them"
        )


def _pair(orders: tuple[int, int]) -> tuple[int, int]:
    try:
        F, P = orders
    except (TypeError, ValueError):
        raise ValueError(f"orders must be a pair (F, P), got {orders!r}") from None
    require_orders(F, P)
    return int(F), int(P)
