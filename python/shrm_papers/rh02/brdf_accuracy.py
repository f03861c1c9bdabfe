"""The fraction of a material's energy that orders hold, and where the rest is, for [RH02] figure 8.

Energy is that of the squared BRDF with its cosine, colors pooled, over all lights and over views with
cos^2(theta_v) uniform, as in `shrm.frequency.analysis`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from shrm import sh
from shrm.arrays import FloatArray
from shrm.brdf import BRDF
from shrm.brdf.lobe import Center, IsotropicLobe
from shrm.frequency.analysis import LobeAnalysis, analyse
from shrm.lobes.center import lobe_center
from shrm.lobes.quadrature import horizon_quadrature, tabulate

F = 30
ORDERS = range(6)
"""The orders F and P of [RH02] figure 8."""

CENTERS: Mapping[Center, str] = {"reflection": "R", "lobe": "the lobe"}

GRAZING = 80.0
"""Degrees of theta_v beyond which views graze: measurements are few and noisy there, and fits extrapolate."""

WIDE = 10.0
"""Degrees about the lobe center within which a wide lobe has less than half its energy."""

REACHED = 0.9
"""The accuracy above which [RH02] counts a material."""


@dataclass(frozen=True)
class Accuracy:
    """The accuracies of one material.

    Attributes
    ----------
    name : str
    by_order : {center: (6,) float64}
        Fraction of the energy that F and P = 0..5 hold.
    every_order : float
        Fraction that F and every P hold.
    below_grazing : {center: float}
        Fraction that F and P = 5 hold of the energy of views to `GRAZING`.
    half : float
        Angle about the lobe center within which half the energy lies, degrees.
    half_grazing : float
        The same for views beyond `GRAZING` alone.
    """

    name: str
    by_order: Mapping[Center, FloatArray]
    every_order: float
    below_grazing: Mapping[Center, float]
    half: float
    half_grazing: float

    @property
    def wide(self) -> bool:
        """True if half the energy takes an angle of more than `WIDE`."""
        return self.half > WIDE

    def reaches(self, center: Center) -> bool:
        """Tell whether F and P = 5 hold more than 90% about a center."""
        return bool(self.by_order[center][-1] > REACHED)


def measure(name: str, brdf: BRDF) -> Accuracy:
    """Analyse one material about both centers."""
    by_order, below_grazing = {}, {}
    for center in CENTERS:
        (lobe,) = brdf.recentered(center, merge=True).lobes
        assert isinstance(lobe, IsotropicLobe)
        analysis = analyse(lobe, F, ORDERS[-1])
        total = analysis.energy.sum()
        by_order[center] = np.array([analysis.captured(P).sum() / total for P in ORDERS])

        # The same of the views below grazing
        theta_v, theta_i, energy = _energy(lobe, analysis)
        below = theta_v <= np.radians(GRAZING)
        captured = (analysis.weight * _captured_by_view(analysis, ORDERS[-1]))[below].sum()
        below_grazing[center] = float(captured / energy[below].sum())

    # About the last center, the lobe's
    every_order = float(analysis.degree_energy().sum() / total)
    halves = _half(theta_i, energy), _half(theta_i[~below], energy[~below])
    return Accuracy(name, by_order, every_order, below_grazing, *halves)


def _energy(lobe: IsotropicLobe, analysis: LobeAnalysis) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the views theta_v (n,) of an analysis, angles theta_i (n, I) to the center, energies (n, I)."""
    fine = np.linspace(0, np.pi / 2, len(analysis.gamma))
    theta_v = np.interp(analysis.theta_o, fine + analysis.gamma, fine)
    gamma = analysis.theta_o - theta_v
    nodes = horizon_quadrature(gamma, lobe_center(lobe.function)[1], F, K=32)
    table = tabulate(lobe.transfer, theta_v, gamma, nodes)
    squared = np.einsum("vkic,vkic->vki", table, table)
    ring = 2 * nodes.weight_theta * nodes.arc * (nodes.weight_share @ squared)
    return theta_v, nodes.theta_i, analysis.weight[:, None] * ring


def _captured_by_view(analysis: LobeAnalysis, P: int) -> FloatArray:
    """Return the energy that an expansion to order P keeps of each view, (views,).

    It is the sum over l, q of U_q (g_lq^2 - (g_lq - fit)^2), the fit being sum_p rho_lpq f_pq(theta_o).
    """
    # The fit at the views of the analysis, azimuth by azimuth
    rho = analysis.coefficients(F, P)
    theta_o = analysis.theta_o
    views = np.stack([np.sin(theta_o), np.zeros_like(theta_o), np.cos(theta_o)], axis=1)
    captured = np.zeros(len(theta_o))
    for q in range(min(P, analysis.Q) + 1):
        U = 1 if q == 0 else 2
        p = np.arange(q, P + 1)
        series = np.zeros(((P + 1) ** 2, rho.shape[0] * rho.shape[3]))
        # The real basis at azimuth 0 is f_p0, or sqrt(2) f_pq
        series[p * (p + 1) + q] = rho[:, p, q].transpose(1, 0, 2).reshape(len(p), -1) / np.sqrt(U)
        fit = sh.evaluate(series, views).reshape(len(views), rho.shape[0], -1).transpose(2, 1, 0)
        captured += U * (fit * (2 * analysis.g[:, q] - fit)).sum(axis=(0, 1))
    return captured


def _half(theta_i: FloatArray, energy: FloatArray) -> float:
    """Return the angle within which half of an energy lies, degrees; 0 if there is no energy."""
    if energy.sum() <= 0:
        return 0.0
    order = np.argsort(theta_i, axis=None)
    inside = np.cumsum(energy.ravel()[order])
    return float(np.degrees(np.interp(inside[-1] / 2, inside, theta_i.ravel()[order])))
