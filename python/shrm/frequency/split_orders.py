"""Splitting a material into what its orders can hold within an error, and cores.

A lobe that its orders do not hold is split (`shrm.lobes.split`) at the largest height whose smooth part they
hold. All errors are relative to the light that the whole material reflects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shrm.brdf import BRDF
from shrm.brdf.lobe import IsotropicLobe, Lobe, RadialLobe
from shrm.brdf.material import Material
from shrm.environment import Environment
from shrm.frequency.analysis import analyse
from shrm.frequency.light_power import LightPower
from shrm.frequency.measure import Measure
from shrm.frequency.orders import NEGLIGIBLE_GAIN, analysed, light_power
from shrm.lobes.split import split

SMOOTH_SHARE, CORE_SHARE = 0.8, 0.5
"""Fractions of the tolerance that are allowed to the orders of the smooth parts, and to the cores. Their root
sum of squares is .94, which leaves room for interpolation."""

DEGREES, WHOLE_DEGREES = 60, 120
"""Least degrees of the spectra of smooth parts, and of the whole: with fewer, the light above them and what a
lobe has there would be estimated from degrees where there is more of both."""

_CLOSE = 0.3
"""Logarithm of the factor by which a squared error may stay below what is allowed: a search ends there."""

_TRIALS = 40
"""Most heights that are tried; each takes an analysis."""


@dataclass(frozen=True, eq=False)
class Split:
    """A material in two parts.

    Attributes
    ----------
    smooth : BRDF
        The part that the orders hold: a lobe for each of the material's, some of them smooth parts.
    cores : tuple of Lobe or None
        The core that is missing of each lobe, if one is.
    orders : tuple of (F, P)
        The orders of each lobe.
    """

    smooth: BRDF
    cores: tuple[IsotropicLobe | RadialLobe | None, ...]
    orders: tuple[tuple[int, int], ...]

    @property
    def analysed_to(self) -> tuple[int, int]:
        """(L, P), the degree and the order that its smooth parts are analysed to."""
        return max(DEGREES, *(F for F, _ in self.orders)), max(P for _, P in self.orders)


@dataclass(frozen=True)
class SplitEnergy:
    """Mean squares of radiance, over frames as `shrm.orders` has them, channels summed.

    Attributes
    ----------
    left_out : float
        Mean square that the orders leave out of the smooth parts.
    smooth : float
        That of the smooth parts; cross terms between lobes, which only add, are left out.
    total : float
        That of the whole material, likewise; what its degrees above `WHOLE_DEGREES` reflect is left out too.
    """

    left_out: float
    smooth: float
    total: float

    @property
    def truncation(self) -> float:
        """The relative RMS error that the orders leave."""
        return float(np.sqrt(self.left_out / self.total)) if self.total > 0 else 0.0

    @property
    def smooth_share(self) -> float:
        """The RMS of the smooth parts against that of the whole."""
        return float(np.sqrt(min(self.smooth / self.total, 1.0))) if self.total > 0 else 0.0


def split_material(
    env: Environment, brdf: BRDF, tolerance: float, caps: tuple[int, int], *, fixed: bool
) -> Split:
    """Split off what orders cannot hold, as little as meets the tolerance.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material.
    tolerance : float
        Relative RMS error of the reflected light.
    caps : (F, P)
        The largest orders.
    fixed : bool
        True if all lobes have these orders; False if each has the smallest that hold its smooth part.

    Returns
    -------
    Split
        Lobes about the tangent, and others that depend on two angles from their center, stay whole.
    """
    # The squared error that is allowed to each lobe
    F, P = caps
    L = max(F, DEGREES)
    power = light_power(env, L)
    allowed = (SMOOTH_SHARE * tolerance) ** 2 * whole_energy(brdf, env, P) / len(brdf.lobes)

    # Lobes that the largest orders do not hold are split, then orders chosen for what is left.
    smooth_lobes: list[Lobe] = []
    cores: list[IsotropicLobe | RadialLobe | None] = []
    orders: list[tuple[int, int]] = []
    for lobe, analysis in zip(brdf.lobes, analysed(brdf, L, P), strict=True):
        most = F, 0 if isinstance(lobe, RadialLobe) else P
        measure = Measure(analysis, power, "light")
        smooth, core = lobe, None
        if measure.squared_error(*most) > allowed and isinstance(lobe, IsotropicLobe | RadialLobe):
            smooth, core = split(lobe, _height(lobe, most, power, allowed))
            measure = Measure(analyse(smooth, L, P), power, "light")
        smooth_lobes.append(smooth)
        cores.append(core)
        orders.append(most if fixed else _smallest(measure, most, allowed))
    smooth_part = Material(tuple(smooth_lobes), brdf.name) if any(cores) else brdf
    return Split(smooth_part, tuple(cores), tuple(orders))


def split_energy(
    env: Environment,
    smooth: BRDF,
    material: BRDF,
    orders: Sequence[tuple[int, int]],
    analysed_to: tuple[int, int],
) -> SplitEnergy:
    """Measure a material and the smooth parts that are expanded of it, under a light."""
    L, P = analysed_to
    power = light_power(env, L)
    measures = [Measure(lobe, power, "light") for lobe in analysed(smooth, L, P)]
    left_out = sum(measure.squared_error(*pair) for measure, pair in zip(measures, orders, strict=True))
    total = sum(measure.total for measure in measures)
    return SplitEnergy(left_out, total, whole_energy(material, env, P))


def whole_energy(brdf: BRDF, env: Environment, P: int) -> float:
    """Return the mean square of the radiance that a material reflects in the degrees told apart.

    Its lobes are summed as if they reflected apart from each other.
    """
    L = WHOLE_DEGREES
    light = LightPower.of(env, L).per_coefficient
    return float(sum((light * lobe.degree_energy()).sum() for lobe in analysed(brdf, L, P)))


def _height(
    lobe: IsotropicLobe | RadialLobe, orders: tuple[int, int], power: LightPower, allowed: float
) -> float:
    """Find the largest height, to a few per cent, whose smooth part orders hold within a squared error.

    What they leave grows about in proportion to the height, or faster: the search steps as if it did until
    there is a bracket, then takes secants in logarithms, kept within it.
    """
    L = max(orders[0], DEGREES)

    def excess(log_height: float) -> float:
        smooth, _ = split(lobe, float(np.exp(log_height)))
        left_out = Measure(analyse(smooth, L, orders[1]), power, "light").squared_error(*orders)
        return float(np.log(max(left_out, 1e-300) / allowed))

    # A bracket of the logarithm of the height, and the excess at its ends
    log_height, value = 0.0, excess(0.0)
    low, high = (log_height, np.inf) if value <= 0 else (-np.inf, log_height)
    at_low = at_high = value
    for _ in range(_TRIALS):
        if np.isfinite(low) and (at_low > -_CLOSE or high - low < _CLOSE / 8):
            break
        if np.isfinite(low) and np.isfinite(high):
            share = (-_CLOSE / 2 - at_low) / (at_high - at_low)
            log_height = low + (high - low) * float(np.clip(share, 0.05, 0.95))
        else:
            log_height = log_height - (value + np.copysign(_CLOSE, value))
        value = excess(log_height)
        if value <= 0:
            low, at_low = log_height, value
        else:
            high, at_high = log_height, value
    return float(np.exp(low))


def _smallest(measure: Measure, most: tuple[int, int], allowed: float) -> tuple[int, int]:
    """Find the smallest P, then the smallest F, that leave no more than is allowed or than the caps do."""
    F_max, P_max = most
    target = max(allowed, NEGLIGIBLE_GAIN * measure.squared_error(F_max, P_max))
    # the caps themselves where squares underflow
    P = next((P for P in range(P_max) if measure.squared_error(F_max, P) <= target), P_max)
    return next((F for F in range(F_max) if measure.squared_error(F, P) <= target), F_max), P
