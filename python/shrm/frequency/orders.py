"""Choosing orders: the smallest F and P for a tolerance, and the error of given orders.

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
from typing import Literal, get_args

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import BRDF, require_brdf
from shrm.environment import Environment, require_environment
from shrm.frequency.analysis import LobeAnalysis, analyse
from shrm.validation import one_of, positive, whole_number

Criterion = Literal["light", "brdf", "minimum", "bound"]

F_MAX = 120
"""Cap on the degree of the light: beyond it, integration in a pyramid of the light is cheaper."""

P_MAX = 8
"""Cap on the order of the view: 81 maps for each channel."""

_TRIED_FIRST = (30, 60)
"""Degrees that are tried before F_max: [RH02] appendix C, 'we repeat the algorithm with larger values'."""

NEGLIGIBLE_GAIN = 1.02
"""Factor on the squared error that P leaves: degrees of the light that lower it by less are not kept."""


class ToleranceWarning(UserWarning):
    """The tolerance is not met within the caps on the orders."""


@dataclass(frozen=True)
class LightPower:
    """The spectrum of a light: its energy by degree.

    Attributes
    ----------
    degrees : (L+1, channels) float64
        sum_m |L_lm|^2.
    above : (channels,) float64
        Energy of all higher degrees.
    """

    degrees: FloatArray
    above: FloatArray

    @classmethod
    def of(cls, env: Environment, L: int) -> LightPower:
        """Measure an environment to degree L, what lies above by Parseval's theorem [RH02 section 5.1]."""
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
        return LightPower(self.degrees[: L + 1], self.above + self.degrees[L + 1 :].sum(axis=0))


@dataclass(frozen=True)
class LobeOrders:
    """Orders of one lobe.

    Attributes
    ----------
    F, P : int
        The largest degree of the light and order of the view.
    squared_error, total : float
        The energy that they leave out of the lobe's, and all of that, in the criterion's measure.
    """

    F: int
    P: int
    squared_error: float
    total: float


@dataclass(frozen=True)
class Orders:
    """The orders of a material, and the error they leave.

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
    env: Environment | None,
    brdf: BRDF,
    *,
    tolerance: float = 0.05,
    criterion: Criterion = "light",
    F_max: int = F_MAX,
    P_max: int = P_MAX,
) -> Orders:
    """Choose the smallest P that reaches the tolerance, then the smallest F [RH02 appendix C].

    Parameters
    ----------
    env : Environment or None
        The light. Without one, `light`, `minimum` and `bound` use the spectrum of typical natural light
        (`LightPower.natural`).
    brdf : BRDF
        The material.
    tolerance : float
        The error allowed, in (0, 1): a relative RMS for `light`, a fraction of energy for the others.
    criterion : {"light", "brdf", "minimum", "bound"}
        The measure of the error, see the module.
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
    require_brdf(brdf)
    if env is not None:
        require_environment(env)
    positive("tolerance", tolerance, 1.0)
    one_of("criterion", criterion, get_args(Criterion))
    require_orders(F_max, P_max, names=("F_max", "P_max"))
    require_lobes(brdf, criterion)
    orders = smallest_orders(env, brdf, tolerance, criterion, F_max, P_max)
    if orders.limited_by:
        text = limit_text(orders, brdf, tolerance, criterion, F_max, P_max)
        warnings.warn(text, ToleranceWarning, stacklevel=2)
    return orders


def smallest_orders(
    env: Environment | None, brdf: BRDF, tolerance: float, criterion: Criterion, F_max: int, P_max: int
) -> Orders:
    """Return what `choose` does, without checks and without a warning."""
    orders, limited_by_P = None, False
    for L in degrees_tried(F_max):
        if limited_by_P and F_max > L:
            continue
        lobes = analysed(brdf, L, P_max)
        power = LightPower.natural(L) if env is None else LightPower.of(env, L)
        orders, limited_by_P = _choose_at(lobes, power, tolerance, criterion, P_max)
        if not orders.limited_by:
            break
    assert orders is not None
    return orders


def limit_text(
    orders: Orders, brdf: BRDF, tolerance: float, criterion: Criterion, F_max: int, P_max: int
) -> str:
    """Say which cap keeps orders from the tolerance, and what can be done."""
    cap, limit = orders.limited_by, P_max if orders.limited_by == "P" else F_max
    return (
        f"{brdf.name}: tolerance {tolerance:g} ({criterion}) is not met with "
        f"{cap} <= {limit}: the error is {orders.error:.3g}; "
        f"raise {cap}_max (shrm prefilter --max-orders), split the core off (residual='auto', "
        "--residual auto) or integrate (prefilter_hierarchical, shrm render --method hierarchical)"
    )


def degrees_tried(F_max: int) -> list[int]:
    """Return the largest degrees that are analysed, one after the other, until the tolerance is met."""
    return [*(L for L in _TRIED_FIRST if F_max > L), F_max]


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
        The spectrum of the light.
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
        results.append(LobeOrders(F, P, measure.squared_error(F, P, window), measure.total))
    return _combined(results, "", criterion)


def require_orders(F: int, P: int, names: tuple[str, str] = ("F", "P")) -> None:
    """Raise TypeError or ValueError unless F and P are whole numbers, 0 <= F <= 1000 and 0 <= P <= 24."""
    whole_number(names[0], F, 0, 1000)
    whole_number(names[1], P, 0, 24)


def require_lobes(brdf: BRDF, criterion: Criterion) -> None:
    """Raise ValueError if a criterion cannot choose orders for as many lobes as a material has."""
    if criterion != "light" and len(brdf.lobes) > 1:
        raise ValueError(
            f"criterion {criterion!r} is for materials of one lobe, and {brdf.name} has {len(brdf.lobes)}: "
            "use criterion='light', or brdf.recentered('reflection', merge=True)"
        )


def degree_power(coefficients: FloatArray) -> FloatArray:
    """Sum |L_lm|^2 over m: ((F+1)^2, channels) coefficients to (F+1, channels)."""
    F = int(np.sqrt(len(coefficients))) - 1
    starts = np.arange(F + 1) ** 2
    return np.asarray(np.add.reduceat(np.asarray(coefficients, dtype=np.float64) ** 2, starts, axis=0))


def analysed(brdf: BRDF, L: int, P: int) -> tuple[LobeAnalysis, ...]:
    """Analyse every lobe of a material; what was analysed to the same (L, P) lately is kept."""
    return tuple(analyse(lobe, L, P) for lobe in brdf.lobes)


class Measure:
    """Squared errors of one lobe under one light, in one criterion's measure."""

    def __init__(self, lobe: LobeAnalysis, power: LightPower, criterion: Criterion) -> None:
        # The lobe's energy by degree; that of degrees and azimuths that are not analysed, by Parseval
        self.lobe = lobe
        self.criterion = criterion
        L = len(power.degrees) - 1
        self.degree_energy = lobe.degree_energy()[: L + 1]
        self.unresolved = np.maximum(lobe.energy - self.degree_energy.sum(axis=0), 0.0)

        # The light's weights: Lambda_l^2 |L_l|^2 / 4 pi; the brdf criterion weighs all degrees alike.
        self.power = power
        flat = criterion == "brdf"
        self.light = np.ones((L + 1, 1)) if flat else power.degrees / (2 * np.arange(L + 1)[:, None] + 1)
        # What is not analysed meets light as strong as the strongest of the upper half of the degrees.
        self.tail = self.light[L // 2 :].max(axis=0)
        self.total = float((self.light * self.degree_energy).sum() + (self.tail * self.unresolved).sum())

    def squared_error(self, F: int, P: int, window: FloatArray | None = None) -> float:
        """Return what orders (F, P) leave of `total`: a squared radiance, or an energy."""
        if self.criterion == "minimum":
            return min(self._light_left_out(F) * self.total, self._brdf_left_out(F, P) * self.total)
        if self.criterion == "bound":
            return self._bound(F, P)
        captured = self.lobe.captured(P)[: F + 1]
        if window is not None:  # a degree with weight w errs by (1 - w)^2
            captured = captured * (1 - (1 - window[: F + 1, None]) ** 2)
        left_out = max(self.total - float((self.light[: F + 1] * captured).sum()), 0.0)
        return left_out + self.lobe.quadrature_error * self.total

    def _light_left_out(self, F: int) -> float:
        """Return eps_L, the fraction of the light's energy above degree F [RH02 section 5.1]."""
        above = self.power.degrees[F + 1 :].sum() + self.power.above.sum()
        return float(above / max(self.power.degrees.sum() + self.power.above.sum(), 1e-300))

    def _brdf_left_out(self, F: int, P: int) -> float:
        """Return eps_rho, the fraction of the BRDF's energy outside (F, P) [RH02 section 5.1]."""
        captured = self.lobe.captured(P)[: F + 1].sum()
        return max(1 - float(captured / max(self.lobe.energy.sum(), 1e-300)), 0.0)

    def _bound(self, F: int, P: int) -> float:
        """Return the bound of [RH02] appendix B, corrected; Lambda_l^2 = 4 pi / (2l+1), 4 pi left out."""
        captured = self.lobe.captured(P)
        light_above = self.power.degrees[F + 1 :].sum(axis=0) + self.power.above
        brdf_above = self.degree_energy[F + 1 :].sum(axis=0) + self.unresolved
        in_degrees = np.maximum(self.degree_energy[: F + 1] - captured[: F + 1], 0.0)
        residual = float(
            (light_above * brdf_above).sum() / (2 * F + 3) + (self.light[: F + 1] * in_degrees).sum()
        )
        reflected = float((self.light[: F + 1] * captured[: F + 1]).sum())
        return self.total * residual / max(reflected + residual, 1e-300)


def _choose_at(
    lobes: tuple[LobeAnalysis, ...], power: LightPower, tolerance: float, criterion: Criterion, P_max: int
) -> tuple[Orders, bool]:
    """Choose orders from analyses to one degree: reduce P, then F, each lobe to its share of the error.

    Also tells whether no larger degree can help: what degrees lose in p > P_max stays lost.
    """
    # The error allowed to each lobe
    measures = [Measure(lobe, power, criterion) for lobe in lobes]
    total = sum(measure.total for measure in measures)
    fraction_allowed = tolerance**2 if criterion == "light" else tolerance
    allowed = fraction_allowed * total / len(lobes)

    # P, then F, of each
    chosen, limited_by, lost_beyond_P_max = [], "", 0.0
    for lobe, measure in zip(lobes, measures, strict=True):
        L = lobe.L
        largest_P = 0 if lobe.kind == "radial" else P_max
        P = next((P for P in range(largest_P + 1) if measure.squared_error(L, P) <= allowed), None)
        if P is None:
            # Either more p would help or nothing but more l: which loses more?
            P = largest_P
            beyond_P = measure.degree_energy - lobe.captured(P)
            lost = float((measure.light * beyond_P).sum()) if criterion != "minimum" else 0.0
            lost_beyond_P_max += lost
            limited_by = "P" if largest_P and lost > measure.squared_error(L, P) / 2 else "F"
        target = max(allowed, NEGLIGIBLE_GAIN * measure.squared_error(L, P))
        F = next(F for F in range(L + 1) if measure.squared_error(F, P) <= target)
        chosen.append(LobeOrders(F, P, measure.squared_error(F, P), measure.total))

    # Lobes that miss their share may be made up for by the others.
    combined = _combined(chosen, limited_by, criterion)
    if limited_by and combined.error <= tolerance:
        return _combined(chosen, "", criterion), False
    return combined, criterion in ("light", "brdf") and lost_beyond_P_max > fraction_allowed * total


def _combined(lobes: Sequence[LobeOrders], limited_by: str, criterion: Criterion) -> Orders:
    """Combine the errors of several lobes by root mean square; cross terms only add to the total."""
    total = sum(lobe.total for lobe in lobes)
    fraction = sum(lobe.squared_error for lobe in lobes) / total if total > 0 else 0.0
    error = float(np.sqrt(fraction)) if criterion == "light" else float(fraction)
    return Orders(max(o.F for o in lobes), max(o.P for o in lobes), error, limited_by, tuple(lobes))
