"""How many orders are enough: F and P for a wanted error, and the error of given orders.

Four criteria [RH02 section 5.1]:

`brdf`
    The paper's choice. The error is the fraction of the BRDF's energy left out.
`light`
    The relative RMS of the reflected radiance, over frames (N, V) of every orientation and cos^2(theta_v)
    uniform, colors pooled. The mean square of a degree is sum_m |L_lm|^2 / (2l+1) times the degree's energy
    E_l in the BRDF; E_l is taken over all p straight from the table, so that what a truncation of P loses is
    known without an expansion to a large P.
`minimum`
    The paper's estimate min(eps_L, eps_rho), fractions of energy.
`bound`
    [RH02] appendix B, a bound on the fraction of reflected energy left out, with two corrections: the proof
    needs Lambda_{F+1}^2 where Lambda_{F+1} is printed, and what degrees l <= F lose in p > P is added.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import BRDF
from shrm.environment import Environment
from shrm.frequency.analysis import LobeAnalysis, analyse
from shrm.validation import fraction, one_of, whole_number

Criterion = Literal["light", "brdf", "minimum", "bound"]

F_MAX = 120
P_MAX = 8
_ENLARGEMENTS = (30, 60)
"""Degrees that are tried before F_max: [RH02] appendix C, 'we repeat the algorithm with larger values'."""


class ToleranceWarning(UserWarning):
    """The wanted error is not met within the caps on the orders."""


@dataclass(frozen=True)
class LightPower:
    """What order selection needs to know of the light.

    Attributes
    ----------
    degrees : (L+1, channels) float64
        sum_m |L_lm|^2.
    rest : (channels,) float64
        Energy of all higher degrees.
    """

    degrees: FloatArray
    rest: FloatArray

    @classmethod
    def of(cls, env: Environment, L: int) -> LightPower:
        """Measure an environment to degree L; the rest by Parseval's theorem [RH02 section 5.1]."""
        power = degree_power(env.coefficients(L))
        H, W, _ = env.pixels.shape
        rows = np.einsum("hwc,hwc->hc", env.pixels, env.pixels, dtype=np.float64)
        edges = np.cos(np.pi * np.arange(H + 1) / H)
        energy = 2 * np.pi / W * (edges[:-1] - edges[1:]) @ rows
        return cls(power, np.maximum(energy - power.sum(axis=0), 0.0))

    @classmethod
    def natural(cls, L: int, slope: float = 0.35) -> LightPower:
        """Return the spectrum of typical photographed light: 1 at l = 0 and slope / l above."""
        l = np.arange(L + 1)
        return cls(np.where(l == 0, 1.0, slope / np.maximum(l, 1))[:, None], np.zeros(1))

    def to(self, L: int) -> LightPower:
        """Return the same light with only the degrees to L told apart."""
        return LightPower(self.degrees[: L + 1], self.rest + self.degrees[L + 1 :].sum(axis=0))


@dataclass(frozen=True)
class LobeOrders:
    """Orders of one lobe, with the squared error they leave and the whole, in the criterion's measure."""

    F: int
    P: int
    residual: float
    total: float


@dataclass(frozen=True)
class Orders:
    """Chosen orders.

    Attributes
    ----------
    F, P : int
        The largest over the lobes.
    error : float
        The error these orders leave, in the criterion's measure.
    limited_by : str
        "" if the tolerance is met, else "P" or "F": the cap that prevents it.
    lobes : tuple of LobeOrders
        One for each lobe of the material.
    """

    F: int
    P: int
    error: float
    limited_by: str
    lobes: tuple[LobeOrders, ...]


def choose(
    brdf: BRDF,
    tolerance: float = 0.05,
    criterion: Criterion = "light",
    env: Environment | None = None,
    *,
    F_max: int = F_MAX,
    P_max: int = P_MAX,
) -> Orders:
    """Choose the smallest P that reaches the tolerance, then the smallest F [RH02 appendix C].

    Parameters
    ----------
    brdf : BRDF
        The material.
    tolerance : float
        The error wanted, in (0, 1): a relative RMS for `light`, a fraction of energy for the others.
    criterion : {"light", "brdf", "minimum", "bound"}
        The measure of the error, see the module.
    env : Environment, optional
        The light. Without one, `light`, `minimum` and `bound` use the spectrum of typical natural light
        (`LightPower.natural`).
    F_max, P_max : int
        Caps on the orders.

    Returns
    -------
    Orders
        With the error achieved. If the tolerance is not met within the caps, a `ToleranceWarning` names
        the cap, and the orders are the largest.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type or out of its range; if a material of several lobes is judged by
        another criterion than `light`.
    """
    if not isinstance(brdf, BRDF):
        raise TypeError(f"brdf must be a material of shrm.brdf, got {type(brdf).__name__}")
    if env is not None and not isinstance(env, Environment):
        raise TypeError(f"env must be an Environment, got {type(env).__name__}")
    require_tolerance(tolerance)
    one_of("criterion", criterion, get_args(Criterion))
    require_orders(F_max, P_max, names=("F_max", "P_max"))
    if criterion != "light" and len(brdf.lobes) > 1:
        raise ValueError(
            f"criterion {criterion!r} is for materials of one lobe, and {brdf.name} has {len(brdf.lobes)}: "
            "use criterion='light', or brdf.recentered('reflection', merge=True)"
        )
    found, beyond_help = None, False
    for L in degrees_tried(F_max):
        if beyond_help and F_max > L:
            continue
        lobes = analysed(brdf, L, P_max)
        power = LightPower.natural(L) if env is None else LightPower.of(env, L)
        found, beyond_help = _choose_at(lobes, power, tolerance, criterion, P_max)
        if not found.limited_by:
            return found
    assert found is not None
    cap = P_max if found.limited_by == "P" else F_max
    warnings.warn(
        f"{brdf.name}: tolerance {tolerance:g} ({criterion}) is not met with "
        f"{found.limited_by} <= {cap}: the error is {found.error:.3g}; "
        f"raise {found.limited_by}_max (shrm prefilter --max-orders), split the core off (residual='auto', "
        "--residual auto) or integrate (prefilter_hierarchical, shrm render --method hierarchical)",
        ToleranceWarning,
        stacklevel=2,
    )
    return found


def degrees_tried(F_max: int) -> list[int]:
    """Return the largest degrees that are analysed, one after the other, until the tolerance is met."""
    return [*(L for L in _ENLARGEMENTS if F_max > L), F_max]


def analysis_degree(F: int, F_max: int) -> int:
    """Return the smallest of `degrees_tried` that holds F."""
    return next(L for L in degrees_tried(F_max) if L >= F)


def error_of(
    brdf: BRDF,
    orders: Sequence[tuple[int, int]],
    power: LightPower,
    criterion: Criterion = "light",
    degree_weights: Sequence[FloatArray] | None = None,
) -> Orders:
    """Return the error that given orders leave.

    Parameters
    ----------
    brdf : BRDF
        The material.
    orders : sequence of (F, P)
        One pair for each lobe.
    power : LightPower
        The light; its degrees are the ones told apart.
    criterion : {"light", "brdf", "minimum", "bound"}
        The measure of the error.
    degree_weights : sequence of (F+1,) float64, optional
        A window on the degrees of each lobe; `minimum` and `bound` leave it out.

    Returns
    -------
    Orders
    """
    L = len(power.degrees) - 1
    lobes = analysed(brdf, L, max(P for _, P in orders))
    results = []
    for index, (lobe, (F, P)) in enumerate(zip(lobes, orders, strict=True)):
        measure = Measure(lobe, power, criterion)
        window = None if degree_weights is None else degree_weights[index]
        results.append(LobeOrders(F, P, measure.residual(F, P, window), measure.total))
    return _combined(results, "", criterion)


def require_orders(F: int, P: int, names: tuple[str, str] = ("F", "P")) -> None:
    """Raise TypeError or ValueError unless F and P are whole numbers, 0 <= F <= 1000 and 0 <= P <= 24."""
    whole_number(names[0], F, 0, 1000)
    whole_number(names[1], P, 0, 24)


def require_tolerance(tolerance: float) -> float:
    """Return an error that can be asked for: a number above 0 and below 1."""
    if fraction("tolerance", tolerance) == 0:
        raise ValueError(f"tolerance must be above 0 and below 1, got {tolerance!r}")
    return float(tolerance)


def degree_power(coefficients: FloatArray) -> FloatArray:
    """Sum |L_lm|^2 over m: ((F+1)^2, channels) coefficients to (F+1, channels)."""
    F = int(np.sqrt(len(coefficients))) - 1
    starts = np.arange(F + 1) ** 2
    return np.asarray(np.add.reduceat(np.asarray(coefficients, dtype=np.float64) ** 2, starts, axis=0))


@lru_cache(maxsize=64)
def analysed(brdf: BRDF, L: int, P: int) -> tuple[LobeAnalysis, ...]:
    """Analyse every lobe of a material, once for each (L, P)."""
    return tuple(analyse(lobe, L, P) for lobe in brdf.lobes)


class Measure:
    """Squared errors of one lobe under one light, in one criterion's measure."""

    def __init__(self, lobe: LobeAnalysis, power: LightPower, criterion: Criterion) -> None:
        self.lobe = lobe
        self.criterion = criterion
        L = len(power.degrees) - 1
        self.degree_energy = lobe.degree_energy()[: L + 1]
        # Degrees and azimuths not analysed, by Parseval.
        self.unresolved = np.maximum(lobe.energy - self.degree_energy.sum(axis=0), 0.0)
        self.power = power
        # Lambda_l^2 |L_l|^2 / 4 pi; the brdf criterion weighs all degrees alike
        flat = criterion == "brdf"
        self.light = np.ones((L + 1, 1)) if flat else power.degrees / (2 * np.arange(L + 1)[:, None] + 1)
        # They meet light as strong as the strongest of the upper half of the degrees.
        self.tail = self.light[L // 2 :].max(axis=0)
        self.total = float((self.light * self.degree_energy).sum() + (self.tail * self.unresolved).sum())

    def residual(self, F: int, P: int, window: FloatArray | None = None) -> float:
        """What orders (F, P) leave of `total`: a squared radiance, or an energy."""
        if self.criterion == "minimum":
            return min(self._light_residual(F) * self.total, self._brdf_residual(F, P) * self.total)
        if self.criterion == "bound":
            return self._bound(F, P)
        kept = self.lobe.captured(P)[: F + 1]
        if window is not None:  # a degree kept with weight w errs by (1 - w)^2
            kept = kept * (1 - (1 - window[: F + 1, None]) ** 2)
        left_out = max(self.total - float((self.light[: F + 1] * kept).sum()), 0.0)
        return left_out + self.lobe.quadrature_error * self.total

    def _light_residual(self, F: int) -> float:
        """eps_L, the fraction of the light's energy above degree F [RH02 section 5.1]."""
        above = self.power.degrees[F + 1 :].sum() + self.power.rest.sum()
        return float(above / max(self.power.degrees.sum() + self.power.rest.sum(), 1e-300))

    def _brdf_residual(self, F: int, P: int) -> float:
        """eps_rho, the fraction of the BRDF's energy outside (F, P) [RH02 section 5.1]."""
        kept = self.lobe.captured(P)[: F + 1].sum()
        return max(1 - float(kept / max(self.lobe.energy.sum(), 1e-300)), 0.0)

    def _bound(self, F: int, P: int) -> float:
        """[RH02] appendix B, corrected; Lambda_l^2 = 4 pi / (2l+1), 4 pi left out everywhere."""
        captured = self.lobe.captured(P)
        light_above = self.power.degrees[F + 1 :].sum(axis=0) + self.power.rest
        brdf_above = self.degree_energy[F + 1 :].sum(axis=0) + self.unresolved
        in_degrees = np.maximum(self.degree_energy[: F + 1] - captured[: F + 1], 0.0)
        residual = float(
            (light_above * brdf_above).sum() / (2 * F + 3) + (self.light[: F + 1] * in_degrees).sum()
        )
        kept = float((self.light[: F + 1] * captured[: F + 1]).sum())
        return self.total * residual / max(kept + residual, 1e-300)


def _choose_at(
    lobes: tuple[LobeAnalysis, ...], power: LightPower, tolerance: float, criterion: Criterion, P_max: int
) -> tuple[Orders, bool]:
    """Reduce P, then F, each lobe to its share of the whole material's error.

    Also tells whether no larger degree can help: what degrees lose in p > P_max stays lost.
    """
    measures = [Measure(lobe, power, criterion) for lobe in lobes]
    whole = sum(measure.total for measure in measures)
    squared = tolerance**2 if criterion == "light" else tolerance
    allowed = squared * whole / len(lobes)
    chosen, limited_by, lost = [], "", 0.0
    for lobe, measure in zip(lobes, measures, strict=True):
        L = lobe.L
        most = 0 if lobe.kind == "radial" else P_max
        P = next((P for P in range(most + 1) if measure.residual(L, P) <= allowed), None)
        if P is None:
            # Either more p would help or nothing but more l: which loses more?
            P = most
            beyond_P = measure.degree_energy - lobe.captured(P)
            lost_in_p = float((measure.light * beyond_P).sum()) if criterion != "minimum" else 0.0
            lost += lost_in_p
            limited_by = "P" if most and lost_in_p > measure.residual(L, P) / 2 else "F"
        # Within 2% of the squared error, if that is more than allowed: degrees that P makes useless are not
        # kept.
        target = max(allowed, 1.02 * measure.residual(L, P))
        F = next(F for F in range(L + 1) if measure.residual(F, P) <= target)
        chosen.append(LobeOrders(F, P, measure.residual(F, P), measure.total))
    combined = _combined(chosen, limited_by, criterion)
    # Lobes that miss their share may be made up for by the others.
    if limited_by and combined.error <= tolerance:
        return _combined(chosen, "", criterion), False
    return combined, criterion in ("light", "brdf") and lost > squared * whole


def _combined(lobes: Sequence[LobeOrders], limited_by: str, criterion: Criterion) -> Orders:
    """Errors of several lobes combine by root mean square; cross terms only add to the whole."""
    whole = sum(lobe.total for lobe in lobes)
    fraction = sum(lobe.residual for lobe in lobes) / whole if whole > 0 else 0.0
    error = float(np.sqrt(fraction)) if criterion == "light" else float(fraction)
    return Orders(max(o.F for o in lobes), max(o.P for o in lobes), error, limited_by, tuple(lobes))
