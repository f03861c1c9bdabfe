"""[RH02] figure 6: the accuracy of the reflected light to order F, measured and estimated.

For a Phong lobe the reflected light field is a picture: that of order F is compared with one by direct
integration, which knows nothing of orders, and its accuracy with the estimates of section 5.1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from shrm.arrays import FloatArray
from shrm.brdf import Phong
from shrm.frequency.light_power import LightPower
from shrm.frequency.orders import Criterion, error_of
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.integrate.angular import AngularReflection, prefilter_angular

from shrm_papers.errors import relative_rms_on_sphere
from shrm_papers.result import Result, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "rh02-figure-6"
EXPONENT = 32.0
VIEW = (1.0, 0.0, 0.0)
"""Any view: the lobe is symmetric about R, so that all share one map."""

CURVES = {
    "measured": ("reflected light, measured", "0.0", "-", 2.2),
    "light": ("criterion light (ours)", "#d95f02", ":", 2.2),
    "minimum": ("minimum of light and BRDF", "#1b9e77", "-.", 1.4),
    "bound": ("bound on the residual", "#7570b3", "--", 1.4),
}
"""Label, color, line style and width of each curve, from the highest accuracy down."""


def make(settings: Settings) -> Result:
    """Measure and estimate the accuracy of every order to 30 (quick: to 12)."""
    brdf = Phong(EXPONENT)
    orders = range(13 if settings.quick else 31)
    L, rows = (60, 32) if settings.quick else (120, 128)
    power = LightPower.of(settings.env, L)

    exact = _map(prefilter_angular(settings.env, brdf, size=rows))
    accuracy = {name: np.zeros(len(orders)) for name in (*CURVES, "brdf")}
    for F in orders:
        series = _map(prefilter(settings.env, brdf, orders=(F, 0), size=rows))
        accuracy["measured"][F] = 1 - relative_rms_on_sphere(series, exact) ** 2
        for criterion in ("light", "bound", "minimum", "brdf"):
            accuracy[criterion][F] = 1 - _fraction(brdf, F, power, criterion)
    return Result(
        NAME,
        f"Accuracy of an order F approximation of the reflected light, Phong s = {EXPONENT:g}, "
        f"{settings.env_name}",
        ["F", *(f"accuracy, {text}" for text, *_ in CURVES.values()), "accuracy of the BRDF alone"],
        [[F, *(float(accuracy[name][F]) for name in accuracy)] for F in orders],
        [
            "Accuracy is the fraction of energy captured, 1 - eps. [RH02] measures against its own series to "
            "F = 30; here against direct integration.",
            *(_verdict(text, accuracy[name], accuracy["measured"]) for name, text in _ESTIMATES.items()),
            "Criterion light predicts the energy itself: it is to agree with what is measured, to "
            f"{np.max(np.abs(accuracy['light'] - accuracy['measured'])):.1e} here, not to be conservative.",
        ],
        _draw(accuracy),
    )


_ESTIMATES = {"minimum": "The minimum of light's and BRDF's error", "bound": "The bound of appendix B"}


def _map(reflection: ReflectionMap | AngularReflection) -> FloatArray:
    """Return the one reflection map, (H, W, 3)."""
    return reflection.at_view(VIEW).astype(np.float64)


def _fraction(brdf: Phong, F: int, power: LightPower, criterion: Criterion) -> float:
    """Return the fraction of the energy that is left out by an estimate."""
    error = error_of(brdf, [(F, 0)], power, criterion).error
    return error**2 if criterion == "light" else error  # `light` speaks of the RMS


def _verdict(text: str, estimate: FloatArray, measured: FloatArray) -> str:
    """Say whether an estimate of accuracy is conservative, and how tight."""
    above = np.flatnonzero(estimate > measured + _SLACK)
    where = ", ".join(str(F) for F in above)
    worst = np.max((estimate - measured)[above], initial=0.0)
    verdict = (
        f"not conservative at F = {where} (by at most {worst:.1e})" if where else "conservative at every F"
    )
    return (
        f"{text} is {verdict}: it promises an accuracy of .99 {_first(estimate)}, reached {_first(measured)}."
    )


_SLACK = 1e-6
"""Rounding of the measured accuracy, whose maps are float32."""


def _first(accuracy: FloatArray) -> str:
    """Say from which F on an accuracy is .99 or more."""
    enough = np.flatnonzero(accuracy >= 0.99)
    return f"from F = {enough[0]} on" if len(enough) else f"beyond F = {len(accuracy) - 1}"


def _draw(accuracy: dict[str, FloatArray]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    linear, logarithmic = figure.subplots(1, 2)
    for name, (text, color, dashes, width) in CURVES.items():
        style = {"color": color, "linestyle": dashes, "linewidth": width, "label": text}
        linear.plot(accuracy[name], **style)
        logarithmic.semilogy(1 - accuracy[name], **style)
    _label(linear, "accuracy 1 − ε", len(accuracy["measured"]) - 1)
    linear.set_ylim(0, 1.02)
    linear.legend(frameon=False, loc="lower right")
    _label(logarithmic, "error ε, fraction of energy", len(accuracy["measured"]) - 1)
    logarithmic.set_ylim(1e-8, 2)
    return figure


def _label(axes: Axes, ordinate: str, last: int) -> None:
    axes.set(xlabel="frequency F", ylabel=ordinate, xlim=(0, last))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", linewidth=0.6)
