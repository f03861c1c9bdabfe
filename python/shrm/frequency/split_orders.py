"""How much of a material its orders can hold within an error, and what must be split off.

A lobe that its orders do not hold is split (`shrm.lobes.split`) at the largest height whose smooth part they
do. All errors are relative to the light that the whole material reflects.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from shrm.brdf import BRDF
from shrm.brdf.lobe import IsotropicLobe, Lobe, Material, RadialLobe
from shrm.environment import Environment
from shrm.frequency.analysis import LobeAnalysis, analyse
from shrm.frequency.orders import LightPower, Measure, ToleranceWarning, analysed, choose
from shrm.lobes.split import split

SMOOTH_SHARE, CORE_SHARE = 0.8, 0.5
"""Of the error wanted, what the orders may leave of the smooth parts, and what the cores may be off by:
together, and with what interpolation adds, within it."""

DEGREES, WHOLE_DEGREES = 60, 120
"""Degrees told apart of smooth parts and of the whole, at least: with fewer the light above them, and what a
lobe has there, would be guessed from degrees where there is more of both."""


@dataclass(frozen=True)
class Split:
    """A material in two.

    Attributes
    ----------
    smooth : BRDF
        For the orders: a lobe for each of the material's, some of them smooth parts.
    cores : tuple of Lobe or None
        What is missing of each.
    orders : tuple of (F, P)
        Of each.
    whole : BRDF
        The material itself.
    """

    smooth: BRDF
    cores: tuple[IsotropicLobe | RadialLobe | None, ...]
    orders: tuple[tuple[int, int], ...]
    whole: BRDF

    @property
    def has_cores(self) -> bool:
        """Whether anything was split off."""
        return any(core is not None for core in self.cores)

    @property
    def analysed_to(self) -> tuple[int, int]:
        """(L, P), the degree and the order that its smooth parts are analysed to."""
        return max(DEGREES, *(F for F, _ in self.orders)), max(P for _, P in self.orders)

    def energy(self, env: Environment) -> SplitEnergy:
        """Measure it under a light."""
        L, P = self.analysed_to
        power = LightPower.of(env, L)
        measures = [Measure(lobe, power, "light") for lobe in analysed(self.smooth, L, P)]
        residual = sum(m.residual(*pair) for m, pair in zip(measures, self.orders, strict=True))
        return SplitEnergy(residual, sum(m.total for m in measures), whole_energy(self.whole, env, P))


@dataclass(frozen=True)
class SplitEnergy:
    """Mean squares of radiance, over frames as `shrm.orders` has them, channels summed.

    Attributes
    ----------
    residual : float
        Of what the orders leave of the smooth parts.
    smooth : float
        Of the smooth parts; cross terms between lobes, which only add, are left out.
    whole : float
        Of the whole material, likewise; what its degrees above `WHOLE_DEGREES` reflect is left out too.
    """

    residual: float
    smooth: float
    whole: float

    @property
    def truncation(self) -> float:
        """The relative RMS error that the orders leave."""
        return float(np.sqrt(self.residual / self.whole)) if self.whole > 0 else 0.0

    @property
    def smooth_share(self) -> float:
        """The RMS of the smooth parts against that of the whole."""
        return float(np.sqrt(min(self.smooth / self.whole, 1.0))) if self.whole > 0 else 0.0


def split_for(
    env: Environment, brdf: BRDF, tolerance: float, orders: tuple[int, int] | None, F_max: int, P_max: int
) -> Split | None:
    """Split off what the orders cannot hold, as little as meets the tolerance.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material.
    tolerance : float
        Relative RMS error of the reflected light.
    orders : (F, P), optional
        By default they are chosen, the smallest that do.
    F_max, P_max : int
        Caps on the orders that are chosen.

    Returns
    -------
    Split or None
        None if the orders that `shrm.orders.choose` finds meet the tolerance. Lobes about the tangent, and
        others that depend on two angles from their center, stay whole.
    """
    if orders is None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ToleranceWarning)
            chosen = choose(brdf, tolerance, "light", env, F_max=F_max, P_max=P_max)
        if not chosen.limited_by:
            return None
    F, P = orders or (F_max, P_max)
    L = max(F, DEGREES)
    power = LightPower.of(env, L)
    whole = whole_energy(brdf, env, P)
    allowed = (SMOOTH_SHARE * tolerance) ** 2 * whole / len(brdf.lobes)

    smooths: list[Lobe] = []
    cores: list[IsotropicLobe | RadialLobe | None] = []
    found: list[tuple[int, int]] = []
    for lobe, analysis in zip(brdf.lobes, analysed(brdf, L, P), strict=True):
        most = F, 0 if isinstance(lobe, RadialLobe) else P
        measure = Measure(analysis, power, "light")
        smooth, core = lobe, None
        if measure.residual(*most) > allowed and isinstance(lobe, IsotropicLobe | RadialLobe):
            smooth, core = split(lobe, _height(lobe, most, power, allowed))
            measure = Measure(analyse(smooth, L, P), power, "light")
        smooths.append(smooth)
        cores.append(core)
        found.append(most if orders is not None else _smallest(measure, most, allowed))
    smooth_part = Material(tuple(smooths), brdf.name) if any(cores) else brdf
    return Split(smooth_part, tuple(cores), tuple(found), brdf)


def whole_energy(brdf: BRDF, env: Environment, P: int) -> float:
    """Mean square of the radiance that a material reflects, its lobes apart, in the degrees told apart."""
    L = WHOLE_DEGREES
    light = LightPower.of(env, L).degrees / (2 * np.arange(L + 1)[:, None] + 1)
    return float(sum((light * lobe.degree_energy()).sum() for lobe in analysed(brdf, L, P)))


def _height(
    lobe: IsotropicLobe | RadialLobe, orders: tuple[int, int], power: LightPower, allowed: float
) -> float:
    """The largest height, to a few per cent, whose smooth part orders (F, P) hold within a squared error.

    What they leave grows about as a power of the height: secants in logarithms, kept within a bracket.
    """
    L = len(power.degrees) - 1

    def excess(log_height: float) -> float:
        smooth, _ = split(lobe, float(np.exp(log_height)))
        analysis: LobeAnalysis = analyse(smooth, L, orders[1])
        left = Measure(analysis, power, "light").residual(*orders)
        return float(np.log(max(left, 1e-300) / allowed))

    at, value = 0.0, excess(0.0)
    low, high = (at, np.inf) if value <= 0 else (-np.inf, at)
    at_low = at_high = value
    for _ in range(_TRIALS):
        if np.isfinite(low) and (at_low > -_CLOSE or high - low < _CLOSE / 8):
            break
        if np.isfinite(low) and np.isfinite(high):
            part = (-_CLOSE / 2 - at_low) / (at_high - at_low)
            at = low + (high - low) * float(np.clip(part, 0.05, 0.95))
        else:
            at = at - (value + np.copysign(_CLOSE, value)) / _POWER
        value = excess(at)
        if value <= 0:
            low, at_low = at, value
        else:
            high, at_high = at, value
    return float(np.exp(low))


def _smallest(measure: Measure, most: tuple[int, int], allowed: float) -> tuple[int, int]:
    """The smallest P, then the smallest F, within caps, of which the latter leave no more than is allowed."""
    F_max, P_max = most
    target = max(allowed, 1.02 * measure.residual(F_max, P_max))
    # the caps themselves where squares underflow
    P = next((P for P in range(P_max) if measure.residual(F_max, P) <= target), P_max)
    return next((F for F in range(F_max) if measure.residual(F, P) <= target), F_max), P


_CLOSE = 0.3
"""How far below what is allowed a squared error may stay, as a logarithm."""
_POWER = 1.0
"""Of the height, by which the squared error grows, or more."""
_TRIALS = 40
