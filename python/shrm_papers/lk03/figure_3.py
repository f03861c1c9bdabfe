"""[LK03] figure 3: the error of principal components by their number, glossy and matt, shadowed and not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from shrm import brdf
from shrm.arrays import FloatArray
from shrm.transfer.matrices.product import Route
from shrm.transfer.radiance_transfer import RadianceTransfer

from shrm_papers.lk03.subject import Subject, n, note, subject_of
from shrm_papers.plotting import COLORS, MARKS, panels
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "lk03-figure-3"

TENTS = 11
"""M, the tents along each side of the square."""

MATERIALS = {"glossy": brdf.AshikhminShirley(40, 40), "matt": brdf.AshikhminShirley(5, 5)}
"""[LK03 section 6]: N = 40 and 5."""

ROUTES = {"m = 5": Route(inner=n, m=5, extension="even"), "direct": Route()}
"""Routes by their names: through harmonics, as in the paper's figure, and straight from rays to tents."""

HIGHEST = 60.0
"""Upper end of the picture's axes, dB."""

TABULATED = (1, 2, 3, 5, 10, 15, 20, 25, 30, 40, 50, 60, 80, 100)
"""Numbers of components in the table."""


@dataclass(frozen=True, eq=False)
class Curve:
    """The accuracy of 1 to K components.

    Attributes
    ----------
    route_name, material : str
        Names of the route and of the material.
    shadowed : bool
        True if the object shadows itself.
    psnr : (K,) float64
        PSNR of radiance under random light of norm 1, in dB: the paper's measure.
    snr : (K,) float64
        SNR, relative to the uncompressed radiance, in dB.
    """

    route_name: str
    material: str
    shadowed: bool
    psnr: FloatArray
    snr: FloatArray

    @property
    def label(self) -> str:
        """The curve's name in tables and legends."""
        return f"{self.material}, {'shadowed' if self.shadowed else 'no shadows'}"


def make(settings: Settings) -> Result:
    """Compress the object's transfer in each material by both routes."""
    subject = subject_of(settings)
    routes = {"m = 5": ROUTES["m = 5"]} if settings.quick else ROUTES
    components = TABULATED[:8] if settings.quick else TABULATED
    curves = [
        curve
        for route_name, route in routes.items()
        for name, material in MATERIALS.items()
        for curve in _curves(subject, route_name, name, material, route, components[-1])
    ]
    columns = [
        "K",
        *(f"PSNR, {c.route_name}, {c.label}" for c in curves),
        *(f"SNR, {c.route_name}, {c.label}" for c in curves),
    ]
    rows: list[list[Cell]] = [
        [K, *(float(c.psnr[K - 1]) for c in curves), *(float(c.snr[K - 1]) for c in curves)]
        for K in components
    ]
    return Result(
        NAME,
        f"PSNR and relative SNR in dB against the number of principal components, {subject.name}",
        columns,
        rows,
        _notes(subject),
        _draw(curves),
    )


def _curves(
    subject: Subject, route_name: str, name: str, material: brdf.BRDF, route: Route, K: int
) -> list[Curve]:
    """Return the curves of one route and material, without shadows and with."""
    transfer = subject.precomputed(material, tents=TENTS, route=route, components=K, half=False)
    curves = []
    for shadowed, variant in ((False, "unshadowed"), (True, "shadowed")):
        reported = transfer.report["compression"][variant]["SNR of 1 to K"]
        snr = np.array([np.inf if x is None else x for x in reported])
        curves.append(Curve(route_name, name, shadowed, snr - 10 * np.log10(energy(transfer, variant)), snr))
    return curves


def energy(transfer: RadianceTransfer, variant: str) -> float:
    """Return the mean over vertices, and over random light of norm 1, of the squared norm of radiance.

    Components must not be rounded to half floats: they are orthonormal in radiance, so that squared weights
    are the energy that they hold.
    """
    weights = transfer.variants[variant].weights
    assert weights is not None
    captured = float(np.sum(weights.astype(np.float64) ** 2)) / len(weights)
    last = transfer.report["compression"][variant]["SNR"]
    missing = 0.0 if last is None else 10 ** (-last / 10)
    return captured / (1 - missing) / n**2


def _notes(subject: Subject) -> list[str]:
    return [
        note(subject),
        f"Ashikhmin and Shirley's model with N = 40 (glossy) and N = 5 (matt), {TENTS} x {TENTS} tents, "
        "light of order 5. With m = 5, as in the paper's figure, harmonics stand between rays and tents; "
        "direct has none.",
        "PSNR is the paper's measure, -10 log10 of the mean squared error over the hemisphere under random "
        "light of norm 1; of the first components it is higher with shadows, which are dark. SNR is relative "
        "to what is compressed.",
        "Frames whose tangents run around the vertical depend on two angles: without shadows there are "
        f"{(2 * n - 1) ** 2} components, products of trigonometric polynomials of degree {n - 1} in both.",
        "The paper shows curves and prints no numbers: shadows and gloss lower them, it says.",
    ]


def _draw(curves: list[Curve]) -> Figure:
    routes = list(dict.fromkeys(curve.route_name for curve in curves))
    figure, axes = panels(1, 1 + len(routes), 4.6 * (1 + len(routes)), 4.3)
    for panel, (route_name, kind) in zip(
        axes, [(routes[0], "PSNR"), *((route_name, "SNR") for route_name in routes)], strict=True
    ):
        for k, curve in enumerate(c for c in curves if c.route_name == route_name):
            values = curve.psnr if kind == "PSNR" else curve.snr
            K = np.arange(1, len(values) + 1)
            panel.plot(K, values, color=COLORS[k], linewidth=1.6)
            marked = [x for x in TABULATED if x <= len(values)]
            panel.plot(marked, values[np.array(marked) - 1], MARKS[k], color=COLORS[k], markersize=5)
            panel.plot([], [], MARKS[k], color=COLORS[k], linestyle="-", label=curve.label)
        label = "average PSNR, dB" if kind == "PSNR" else "relative SNR, dB"
        panel.set(xlabel="components K", ylabel=label, ylim=(0, HIGHEST))
        panel.set_title(f"{route_name}, as in [LK03]" if kind == "PSNR" else route_name, fontsize=10)
        panel.legend(frameon=False, fontsize=8)
    return figure
