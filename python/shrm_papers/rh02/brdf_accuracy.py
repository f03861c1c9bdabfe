"""How much of a material's energy given orders hold, and where the rest is: what figure 8 of [RH02] shows.

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
CENTERS: Mapping[Center, str] = {"reflection": "R", "lobe": "the lobe"}
GRAZING = 80.0
"""Degrees: views beyond it are grazing; measurements there are few and noisy, and fits extrapolate."""
WIDE = 10.0
"""Degrees within which a wide lobe has less than half its energy."""
REACHED = 0.9
"""The accuracy that [RH02] counts."""


@dataclass(frozen=True)
class Accuracy:
    """One material.

    Attributes
    ----------
    name : str
    by_order : {center: (6,) float64}
        Fraction of the energy that F and P = 0..5 hold.
    every_order : float
        What F holds with every P.
    below_grazing : {center: float}
        Fraction that F and P = 5 hold of the energy of views to `GRAZING`.
    half : float
        The angle about the lobe center that holds half the energy, degrees.
    half_grazing : float
        The same of the views beyond `GRAZING` alone.
    """

    name: str
    by_order: Mapping[Center, FloatArray]
    every_order: float
    below_grazing: Mapping[Center, float]
    half: float
    half_grazing: float

    @property
    def wide(self) -> bool:
        """Whether its lobe holds half its energy within more than `WIDE`."""
        return self.half > WIDE

    def reaches(self, center: Center) -> bool:
        """Whether F and P = 5 hold more than 90% about a center."""
        return bool(self.by_order[center][-1] > REACHED)


def measure(name: str, brdf: BRDF) -> Accuracy:
    """Analyse one material about both centers."""
    by_order, below_grazing = {}, {}
    for center in CENTERS:
        (lobe,) = brdf.recentered(center, merge=True).lobes
        assert isinstance(lobe, IsotropicLobe)
        analysis = analyse(lobe, F, ORDERS[-1])
        whole = analysis.energy.sum()
        by_order[center] = np.array([analysis.captured(P).sum() / whole for P in ORDERS])
        theta_v, theta_i, energy = _energy(lobe, analysis)
        below = theta_v <= np.radians(GRAZING)
        kept = (analysis.weight * _kept(analysis, ORDERS[-1]))[below].sum()
        below_grazing[center] = float(kept / energy[below].sum())
    # of the last center, the lobe's
    every_order = float(analysis.degree_energy().sum() / whole)
    halves = _half(theta_i, energy), _half(theta_i[~below], energy[~below])
    return Accuracy(name, by_order, every_order, below_grazing, *halves)


def _energy(lobe: IsotropicLobe, analysis: LobeAnalysis) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Views theta_v (n,) of an analysis, angles theta_i (n, I) to the center, and the energy there (n, I)."""
    fine = np.linspace(0, np.pi / 2, len(analysis.gamma))
    theta_v = np.interp(analysis.theta_o, fine + analysis.gamma, fine)
    gamma = analysis.theta_o - theta_v
    nodes = horizon_quadrature(gamma, lobe_center(lobe.function)[1], F, K=32)
    table = tabulate(lobe.transfer, theta_v, gamma, nodes)
    squared = np.einsum("vkic,vkic->vki", table, table)
    ring = 2 * nodes.weight_theta * nodes.arc * (nodes.weight_share @ squared)
    return theta_v, nodes.theta_i, analysis.weight[:, None] * ring


def _kept(analysis: LobeAnalysis, P: int) -> FloatArray:
    """Energy that an expansion to order P has in common with each view, (views,): its mean is what it keeps.

    sum over l, q of U_q (g_lq^2 - (g_lq - fit)^2), the fit being sum_p rho_lpq f_pq(theta_o).
    """
    rho = analysis.coefficients(F, P)
    theta_o = analysis.theta_o
    views = np.stack([np.sin(theta_o), np.zeros_like(theta_o), np.cos(theta_o)], axis=1)
    kept = np.zeros(len(theta_o))
    for q in range(min(P, analysis.Q) + 1):
        U = 1 if q == 0 else 2
        p = np.arange(q, P + 1)
        series = np.zeros(((P + 1) ** 2, rho.shape[0] * rho.shape[3]))
        # The real basis at azimuth 0 is f_p0, or sqrt(2) f_pq
        series[p * (p + 1) + q] = rho[:, p, q].transpose(1, 0, 2).reshape(len(p), -1) / np.sqrt(U)
        fit = sh.evaluate(series, views).reshape(len(views), rho.shape[0], -1).transpose(2, 1, 0)
        kept += U * (fit * (2 * analysis.g[:, q] - fit)).sum(axis=(0, 1))
    return kept


def _half(theta_i: FloatArray, energy: FloatArray) -> float:
    """The angle that holds half of an energy, degrees; 0 of none."""
    if energy.sum() <= 0:
        return 0.0
    order = np.argsort(theta_i, axis=None)
    inside = np.cumsum(energy.ravel()[order])
    return float(np.degrees(np.interp(inside[-1] / 2, inside, theta_i.ravel()[order])))
