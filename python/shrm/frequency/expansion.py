"""The expansion of a material: the orders of each lobe, chosen or given, and the coefficients.

A lobe that its orders do not hold may be split (`shrm.frequency.split_orders`): then they are those of its
smooth part, and its core is left to integration.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import BRDF
from shrm.brdf.lobe import IsotropicLobe, RadialLobe
from shrm.environment import Environment
from shrm.frequency.analysis import LobeAnalysis
from shrm.frequency.orders import (
    Criterion,
    ToleranceWarning,
    analysed,
    analysis_degree,
    limit_text,
    smallest_orders,
)
from shrm.frequency.part import Part
from shrm.frequency.request import Request, Window
from shrm.frequency.split_orders import split_material
from shrm.lobes.reflection import Layout

LARGEST_BYTES = 4 << 30
"""Most bytes that the maps of one lobe, or their coefficients, may take."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """A material, the orders of its lobes and what they are judged by.

    Attributes
    ----------
    material : BRDF
        The material itself.
    smooth : BRDF
        The material that is expanded: the same, or one with smooth parts in place of some of its lobes.
    cores : tuple of Lobe or None, or None
        The core that is missing of each lobe, if one is; None if no residual was to be split off.
    orders : tuple of (F, P)
        The orders of each lobe.
    analysed_to : (L, P)
        The degree and the order that the smooth lobes are analysed to.
    criterion : {"light", "brdf", "minimum", "bound"}
        The measure of the error.
    window : {"hann", "lanczos"} or None
        The window on the degrees.
    F_max : int
        The degree up to which the predicted error tells degrees of the light apart, if the orders are lower.
    """

    material: BRDF
    smooth: BRDF
    cores: tuple[IsotropicLobe | RadialLobe | None, ...] | None
    orders: tuple[tuple[int, int], ...]
    analysed_to: tuple[int, int]
    criterion: Criterion
    window: Window | None
    F_max: int

    @property
    def F(self) -> int:
        """The largest degree of the lobes."""
        return max(F for F, _ in self.orders)

    @property
    def has_cores(self) -> bool:
        """True if the core of a lobe was split off."""
        return self.cores is not None and any(core is not None for core in self.cores)

    def windows(self) -> list[FloatArray]:
        """Return the weights of the degrees of each lobe."""
        return [degree_window(self.window, F) for F, _ in self.orders]

    def analyses(self) -> tuple[LobeAnalysis, ...]:
        """Return the analysis of each smooth lobe."""
        return analysed(self.smooth, *self.analysed_to)

    def parts(self, env: Environment) -> list[Part]:
        """Return the coefficients of each lobe under a light, with maps of no size yet."""
        light = env.coefficients(self.F)
        parts = []
        for lobe, (F, P) in zip(self.analyses(), self.orders, strict=True):
            zonal = lobe.kind != "isotropic"
            part = Part(
                center=lobe.center,
                gamma=lobe.gamma,
                layout="latlong",
                rings=np.zeros((0, P + 1 if zonal else (P + 1) ** 2, 3, 0), dtype=np.float32),
                zonal=zonal,
                light=np.ascontiguousarray(light[: (F + 1) ** 2], dtype=np.float64),
                rho=windowed(lobe, F, P, self.window),
            )
            parts.append(part)
        return parts


def expansion_for(request: Request) -> Expansion:
    """Choose the orders that a request leaves open, and split off what they cannot hold if it is asked to.

    Warns
    -----
    ToleranceWarning
        If the tolerance cannot be met within the caps, and nothing is to be split off.
    """
    env, brdf, tolerance, caps = request.env, request.brdf, request.tolerance, (request.F_max, request.P_max)
    if request.orders is None:
        chosen = smallest_orders(env, brdf, tolerance, request.criterion, *caps)
        if request.residual is None or not chosen.limited_by:
            if chosen.limited_by:
                text = limit_text(chosen, brdf, tolerance, request.criterion, *caps)
                warnings.warn(text, ToleranceWarning, stacklevel=4)
            orders = tuple((lobe.F, lobe.P) for lobe in chosen.lobes)
            analysed_to = analysis_degree(chosen.F, request.F_max), request.P_max
            return _expansion(request, brdf, None, orders, analysed_to)
    elif request.residual is None:
        F, P = request.orders
        orders = tuple((F, 0 if isinstance(lobe, RadialLobe) else P) for lobe in brdf.lobes)
        return _expansion(request, brdf, None, orders, request.orders)

    # The largest orders do not hold the material, or a residual goes with those that are given.
    split = split_material(env, brdf, tolerance, request.orders or caps, fixed=request.orders is not None)
    return _expansion(request, split.smooth, split.cores, split.orders, split.analysed_to)


def windowed(lobe: LobeAnalysis, F: int, P: int, window: Window | None) -> FloatArray:
    """Return rho_lpq of a lobe for three channels, its degrees weighted: (F+1, P+1, P+1, 3)."""
    rho = lobe.coefficients(F, P) * degree_window(window, F)[:, None, None, None]
    return np.ascontiguousarray(np.broadcast_to(rho, (*rho.shape[:3], 3)))


def degree_window(name: Window | None, F: int) -> FloatArray:
    """Return weights of the degrees 0..F: 1 without a window; Hann's cosine or Lanczos' sinc, 0 at F + 1."""
    x = np.arange(F + 1) / (F + 1)
    if name == "hann":
        return np.asarray((1 + np.cos(np.pi * x)) / 2)
    if name == "lanczos":
        return np.asarray(np.sinc(x))
    return np.ones(F + 1)


def _expansion(
    request: Request,
    smooth: BRDF,
    cores: tuple[IsotropicLobe | RadialLobe | None, ...] | None,
    orders: tuple[tuple[int, int], ...],
    analysed_to: tuple[int, int],
) -> Expansion:
    """Return the expansion of a request's material, with the attributes that the request itself has."""
    return Expansion(
        request.brdf, smooth, cores, orders, analysed_to, request.criterion, request.window, request.F_max
    )


def require_memory(expansion: Expansion, size: int | None, layout: Layout) -> None:
    """Raise ValueError if the maps or coefficients of a lobe would take more than `LARGEST_BYTES`."""
    for lobe, (F, P) in zip(expansion.smooth.lobes, expansion.orders, strict=True):
        _require_memory(F, P, not isinstance(lobe, IsotropicLobe), size, layout)


def _require_memory(F: int, P: int, zonal: bool, size: int | None, layout: Layout) -> None:
    """Raise ValueError if the maps or coefficients of one lobe would take more."""
    maps = P + 1 if zonal else (P + 1) ** 2
    coefficients = 8 * 3 * maps * (F + 1 if zonal else F + P + 1) ** 2
    texels = 0 if size is None else size * size * (2 if layout == "latlong" else 6)
    if max(coefficients, 4 * 3 * maps * texels) > LARGEST_BYTES:
        largest = max(coefficients, 4 * 3 * maps * texels) / 2**30
        and_size = "" if size is None else f" and size {size}"
        raise ValueError(
            f"orders ({F}, {P}){and_size} take {largest:.1f} GiB, over the limit of "
            f"{LARGEST_BYTES >> 30} GiB: lower them"
        )
