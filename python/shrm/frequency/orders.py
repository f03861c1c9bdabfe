"""Choosing orders: the smallest F and P for a tolerance, and the error of given orders.

Four criteria [RH02 section 5.1]:

`brdf`
    The paper's choice. The error is the fraction of the BRDF's energy left out.
`light`
    The relative RMS of the reflected radiance, over frames (N, V) of every orientation and cos^2(theta_v)
    uniform, colors pooled. The mean square of a degree is sum_m |L_lm|^2 / (2l+1) times the degree's energy
    E_l in the BRDF; E_l is taken over all p straight from the table, so that what a truncation of P loses is
    known without an expansion to a large P. The light is told apart twice as far as the lobe is analysed, and
    what is beyond either counts (`shrm.frequency.measure`).
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
from shrm.frequency.light_power import LightPower
from shrm.frequency.measure import Measure
from shrm.validation import one_of, positive, whole_number

Criterion = Literal["light", "brdf", "minimum", "bound"]

F_MAX = 120
"""Cap on the degree of the light: beyond it, integration in a pyramid of the light is cheaper."""

P_MAX = 8
"""Cap on the order of the view: 81 maps for each channel."""

_TRIED_FIRST = (30, 60)
"""Degrees that are tried before F_max: [RH02] appendix C, 'we repeat the algorithm with larger values'."""

_TOLD_APART = 2
"""Degrees of the light that are told apart, for each that the lobe is analysed to."""

LARGEST_DEGREE = 1000
"""Largest degree of the light that may be asked for."""

NEGLIGIBLE_GAIN = 1.02
"""Factor on the squared error that P leaves: degrees of the light that lower it by less are not kept."""


class ToleranceWarning(UserWarning):
    """The tolerance is not met within the caps on the orders."""


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
        power = light_power(env, L)
        orders, limited_by_P = _choose_at(lobes, power, tolerance, criterion, P_max)
        if not orders.limited_by:
            break
    assert orders is not None
    return orders


def light_power(env: Environment | None, L: int) -> LightPower:
    """Return the spectrum of a light, or of natural light, for a lobe that is analysed to degree L."""
    K = min(_TOLD_APART * max(L, 1), LARGEST_DEGREE)
    return LightPower.natural(K) if env is None else LightPower.of(env, K)


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
    *,
    L: int | None = None,
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
    L : int, optional
        The degree that the lobes are analysed to; by default as far as the light is told apart.

    Returns
    -------
    Orders
    """
    L = len(power.degrees) - 1 if L is None else L
    lobes = analysed(brdf, L, max(P for _, P in orders))
    results = []
    for index, (lobe, (F, P)) in enumerate(zip(lobes, orders, strict=True)):
        measure = Measure(lobe, power, criterion)
        window = None if degree_weights is None else degree_weights[index]
        results.append(LobeOrders(F, P, measure.squared_error(F, P, window), measure.total))
    return _combined(results, "", criterion)


def require_orders(F: int, P: int, names: tuple[str, str] = ("F", "P")) -> None:
    """Raise TypeError or ValueError unless F and P are whole numbers, 0 <= F <= 1000 and 0 <= P <= 24."""
    whole_number(names[0], F, 0, LARGEST_DEGREE)
    whole_number(names[1], P, 0, 24)


def require_lobes(brdf: BRDF, criterion: Criterion) -> None:
    """Raise ValueError if a criterion cannot choose orders for as many lobes as a material has."""
    if criterion != "light" and len(brdf.lobes) > 1:
        raise ValueError(
            f"criterion {criterion!r} is for materials of one lobe, and {brdf.name} has {len(brdf.lobes)}: "
            "use criterion='light', or brdf.recentered('reflection', merge=True)"
        )


def analysed(brdf: BRDF, L: int, P: int) -> tuple[LobeAnalysis, ...]:
    """Analyse every lobe of a material; what was analysed to the same (L, P) lately is kept."""
    return tuple(analyse(lobe, L, P) for lobe in brdf.lobes)


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
