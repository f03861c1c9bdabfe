"""Analysis of a lobe into its coefficients rho_lpq: the three steps of [RH02] appendix C, about any center.

In the frame of the central direction C (z axis), with N and V at azimuth 0,

    N = (sin gamma, 0, cos gamma)      V = (sin theta_o, 0, cos theta_o)
    L = (sin theta_i cos phi, sin theta_i sin phi, cos theta_i)

theta_v is the angle between N and V, gamma(theta_v) the one between C and N (`central_direction`), and
theta_o = theta_v + gamma. A lobe about the tangent has no N: theta_o runs over [0, pi].

Each (l, q) projection of the light's degree and the azimuth,

    g_lq(theta_o) = int int f_lq(theta_i) cos(q phi) rho_hat sin(theta_i) dtheta_i dphi,

is a function of the view alone, and rho_lpq are the coefficients of its weighted least-squares fit by
f_pq(theta_o), p <= P. The weight is the measure cos^2(theta_v) uniform. For C = R that is V uniform on the
sphere about R, sin(theta_o) dtheta_o / 2; there the f_pq are orthogonal, of mean square 1 / 4 pi, and the fit
is the integral rho_lpq = 2 pi int g_lq f_pq sin(theta_o) dtheta_o of [RH02] eq. 13.

Sources: [R02].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from shrm import _core
from shrm.arrays import FloatArray
from shrm.brdf.cosine_power import profile_at_angles
from shrm.brdf.lobe import Center, IsotropicLobe, Kind, Lobe, RadialLobe, ZonalLobe, refuse_anisotropic
from shrm.brdf.peaks import NARROW, NARROW_RING, narrower, peak_about_rings, peak_of_profile, with_support
from shrm.lobes.center import gamma_at, gamma_table, lobe_center
from shrm.lobes.quadrature import (
    Quadrature,
    columns,
    horizon_quadrature,
    leggauss,
    panel_quadrature,
    ring_edges,
    tabulate,
    uniform_quadrature,
    unit_gauss,
    whole_quadrature,
)

_MANY_VIEWS, _MOST_VALUES = 1001, 400_000
"""Views that tell whether a lobe has bands between those of an analysis, and the most values of the lobe that
are asked for to tell."""

_FINER = 8
"""Times as many views, by which bands are measured that are there."""

_VIEWS_AGREE = 2e-3
"""Fraction of the energy by which measured materials differ from view to view by their noise alone."""

_SMALLEST_SINGULAR = 1e-6
"""Singular values of the fit below this fraction of the largest are cut: no view tells them."""


@dataclass(frozen=True, eq=False, repr=False)
class LobeAnalysis:
    """A lobe projected on degrees and azimuths, for every order that may be asked for.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        The central direction.
    kind : {"radial", "zonal", "isotropic"}
        Radial lobes have P = 0, zonal ones only q = 0.
    gamma : (257,) float64
        The angle between C and N, radians, uniform in theta_v over [0, pi/2]; empty about the tangent.
    theta_o, weight : (views,) float64
        Angles between C and V, and the measure of the views (it sums to 1).
    g : (channels, Q+1, L+1, views) float64
        The projections g_lq(theta_o).
    energy : (channels,) float64
        The mean over the views of the integral of rho_hat^2 over the lights.
    P : int
        The largest order that the views are meant for.
    quadrature_error : float
        Fraction of the energy by which g may be off: next to nothing unless the lobe has jumps, or bands
        between the views.
    """

    center: Center
    kind: Kind
    gamma: FloatArray
    theta_o: FloatArray
    weight: FloatArray
    g: FloatArray
    energy: FloatArray
    P: int
    quadrature_error: float = 0.0
    _fits: dict[int, tuple[FloatArray, FloatArray]] = field(default_factory=dict, repr=False)
    _factors: dict[tuple[int, int], tuple[FloatArray, FloatArray]] = field(default_factory=dict, repr=False)

    @property
    def L(self) -> int:
        """The largest degree analysed."""
        return int(self.g.shape[2]) - 1

    @property
    def Q(self) -> int:
        """The largest azimuthal order analysed."""
        return int(self.g.shape[1]) - 1

    @property
    def channels(self) -> int:
        """1, or 3 for a lobe whose channels differ."""
        return int(self.g.shape[0])

    def __repr__(self) -> str:
        return f"<LobeAnalysis, {self.kind} about the {self.center}: L={self.L} Q={self.Q} P={self.P}>"

    def degree_energy(self) -> FloatArray:
        """Return the energy of each degree over all p, (L+1, channels): sum_q U_q mean(g_lq^2)."""
        return np.asarray(np.einsum("cql,q->lc", self.g**2 @ self.weight, _multiplicity(self.Q)))

    def captured(self, P: int) -> FloatArray:
        """Return the energy of each degree that an expansion to order P keeps, (L+1, channels)."""
        return self._fit(P)[1]

    def coefficients(self, F: int, P: int) -> FloatArray:
        """Return rho_lpq, (F+1, P+1, P+1, channels) float64, indices l, p, q; zero where q > min(l, p).

        For C = R these are the integrals [RH02] eq. 13.
        """
        return self._fit(P)[0][: F + 1]

    def _fit(self, P: int) -> tuple[FloatArray, FloatArray]:
        """Return the coefficients that fit every g_lq over theta_o by least squares, and their energy."""
        if P not in self._fits:
            rho = np.zeros((self.L + 1, P + 1, P + 1, self.channels))
            captured = np.zeros((self.L + 1, self.channels))
            for q in range(min(P, self.Q) + 1):
                # [RH02] appendix C, step 1, the integral over theta_o with the factor 2 pi: eq. 13
                triangle, projected = self._factored(q, max(P, self.P))
                n = P - q + 1
                U, singular, Vt = np.linalg.svd(triangle[:n, :n], full_matrices=False)
                used = singular > _SMALLEST_SINGULAR * singular[0]
                along = U.T[used] @ projected[:n]
                fit = Vt[used].T @ (along / singular[used, None])
                energy = (along**2).sum(axis=0).reshape(self.channels, self.L + 1)
                captured += (1 if q == 0 else 2) * energy.T
                rho[:, q:, q] = fit.reshape(n, self.channels, self.L + 1).transpose(2, 0, 1)
            self._fits[P] = rho, captured
        return self._fits[P]

    def _factored(self, q: int, P: int) -> tuple[FloatArray, FloatArray]:
        """Return the triangle R and Q^T g of the QR factors of the f_pq(theta_o), q <= p <= P.

        Their shapes are (P-q+1, P-q+1) and (P-q+1, channels (L+1)); those of every lower P are their corners.
        """
        if (q, P) not in self._factors:
            root = np.sqrt(self.weight)
            basis = (_core.legendre(F=P, m=q, theta=self.theta_o)[q:] * root).T
            orthogonal, triangle = np.linalg.qr(basis)
            projected = (self.g[:, q] @ (orthogonal * root[:, None])).reshape(-1, len(triangle)).T
            self._factors[q, P] = triangle, projected
        return self._factors[q, P]


@lru_cache(maxsize=64)
def analyse(lobe: Lobe, L: int, P: int) -> LobeAnalysis:
    """Project a lobe on the degrees l <= L, with views enough for orders p <= P.

    Analyses are kept: an equal lobe is analysed to the same (L, P) once.

    Parameters
    ----------
    lobe : Lobe
        The lobe, about its own center.
    L : int
        Largest degree of the light.
    P : int
        Largest order of the view that will be asked for.

    Returns
    -------
    LobeAnalysis

    Raises
    ------
    ValueError
        If the lobe is anisotropic.
    """
    refuse_anisotropic(lobe)
    if isinstance(lobe, RadialLobe):
        return _analyse_radial(lobe, L)
    if isinstance(lobe, ZonalLobe):
        return _analyse_zonal(lobe, L, P)
    assert isinstance(lobe, IsotropicLobe)
    return _analyse_isotropic(lobe, L, P)


def _analyse_radial(lobe: RadialLobe, L: int) -> LobeAnalysis:
    """Project the profile alone: P = 0, rho_l00 = sqrt(4 pi) rho_l  [RH02] appendix C, radially symmetric."""
    nodes = whole_quadrature(_width(lambda theta: profile_at_angles(lobe.profile, theta)), L)
    profile = columns(profile_at_angles(lobe.profile, nodes.theta_i[0]))
    g, energy = _project(profile.reshape(*nodes.shape, -1), nodes, L, 0)
    theta_o, weight = np.zeros(1), np.ones(1)
    return LobeAnalysis(
        lobe.center, "radial", gamma_table(lobe.center), theta_o, weight, g, energy @ weight, 0
    )


def _analyse_zonal(lobe: ZonalLobe, L: int, P: int) -> LobeAnalysis:
    """Project without azimuth: only q = 0 [RH02 section 7.1, Kajiya-Kay]."""
    views = max(96, 8 * (P + 1))
    if lobe.center == "tangent":  # V uniform on the sphere
        x, w = leggauss(views)
        theta_o, weight = np.arccos(x), w / 2
        nodes = _about_the_tangent(lobe, theta_o, L)
    else:  # cos^2(theta_v) uniform, as for isotropic lobes
        theta_v, weight = _views(views)
        theta_o = lobe.theta_o(theta_v)
        of_one_view = whole_quadrature(_narrowest(lobe, theta_o), L)
        nodes = replace(
            of_one_view, **{name: np.repeat(getattr(of_one_view, name), views, axis=0) for name in _BY_VIEW}
        )
    g, energy = _project(_table_of_angles(lobe, theta_o, nodes), nodes, L, 0)
    gamma = gamma_table(lobe.center)
    between = 0.0
    if lobe.center == "tangent":
        between = _disagreement(float((energy @ weight).sum()), _energy_about_the_tangent(lobe))
    return LobeAnalysis(lobe.center, "zonal", gamma, theta_o, weight, g, energy @ weight, P, between)


def _table_of_angles(lobe: ZonalLobe, theta_o: FloatArray, nodes: Quadrature) -> FloatArray:
    """Evaluate a lobe of two angles at nodes, (views, 1, I, channels)."""
    values = lobe.profile(nodes.theta_i.ravel(), np.repeat(theta_o, nodes.theta_i.shape[1]))
    return columns(values).reshape(*nodes.shape, -1)


@lru_cache(maxsize=64)
def _energy_about_the_tangent(lobe: ZonalLobe) -> float:
    """Return the energy of a lobe about the tangent over many views that lie evenly."""
    theta_o = np.pi * (np.arange(_MANY_VIEWS) + 0.5) / _MANY_VIEWS
    nodes = _about_the_tangent(lobe, theta_o, 0)
    energy = _project(_table_of_angles(lobe, theta_o, nodes), nodes, 0, 0)[1]
    return float((energy @ np.sin(theta_o)).sum()) * np.pi / 2 / _MANY_VIEWS


_BY_VIEW = ("theta_i", "weight_theta", "arc")
"""The attributes of `Quadrature` that have a row for each view."""


def _about_the_tangent(lobe: ZonalLobe, theta_o: FloatArray, L: int) -> Quadrature:
    """Return nodes for a lobe about the tangent: most about the cones of V and its mirror if it is narrow."""
    rings = np.stack([theta_o, np.pi - theta_o], axis=1)
    peak = peak_about_rings(lobe.profile, theta_o[::8], rings[::8])
    if peak < NARROW_RING:
        edges = ring_edges(rings, peak)
        return panel_quadrature(with_support(lobe.profile, theta_o, edges), L)
    return uniform_quadrature(len(theta_o), L)


def _narrowest(lobe: ZonalLobe, theta_o: FloatArray) -> float:
    """Return the smallest width of a lobe's profiles at about eight of the views, radians."""

    def width_at(angle: float) -> float:
        return _width(lambda theta: lobe.profile(theta, np.full_like(theta, angle)))

    return min(width_at(float(angle)) for angle in theta_o[:: max(len(theta_o) // 8, 1)])


def _analyse_isotropic(lobe: IsotropicLobe, L: int, P: int) -> LobeAnalysis:
    """Project over both angles of the light [RH02 appendix C], with more nodes if two sets do not agree."""
    # With either number of azimuths a lobe about R or its own center is exact to 3e-5 (relative RMS); low
    # orders need fewer, unless the lobe lies far from the center.
    low = P <= 3 and L <= 32 and lobe.center != "normal"

    # Azimuthal orders go beyond P, for the energy of all azimuths, which order selection needs.
    Q = min(L, max(P, 8 if low else 24))

    # Views for more orders than P, which g holds. The table of the lobe center is smooth in pieces only: from
    # 54 views on, more of them change nothing above 1e-5.
    views = max(54, 12 + (6 * P + L) // 3)
    analysis = _projected(lobe, L, P, Q, views, K=20 if low else 32, least=8)
    if analysis.quadrature_error > _ROUGH:
        views = max(views, 64)
        analysis = _projected(lobe, L, P, Q, views, K=48, least=24)
    between = _energy_between(lobe, views)
    return replace(analysis, quadrature_error=analysis.quadrature_error + between) if between else analysis


def _energy_between(lobe: IsotropicLobe, views: int) -> float:
    """Return the fraction of the energy in bands of views that so many views miss or see too much of."""
    values_of_a_view = np.prod(_coarse_nodes(lobe, np.zeros(1))[1].shape)
    if values_of_a_view * _MANY_VIEWS > _MOST_VALUES:
        return 0.0  # a slender lobe, which takes long
    few = _energy_of(lobe, *_views(views))
    if not _disagreement(few, _energy_of_many_views(lobe, _MANY_VIEWS)):
        return 0.0
    return _disagreement(few, _energy_of_many_views(lobe, _FINER * _MANY_VIEWS))


@lru_cache(maxsize=256)
def _energy_of_many_views(lobe: IsotropicLobe, count: int) -> float:
    """Return the energy of a lobe over views that lie evenly."""
    theta_v = np.pi / 2 * (np.arange(count) + 0.5) / count
    return _energy_of(lobe, theta_v, np.pi / 2 * np.sin(2 * theta_v) / count)


def _energy_of(lobe: IsotropicLobe, theta_v: FloatArray, weight: FloatArray) -> float:
    """Integrate the squares of a lobe over views, and over the lights by few nodes."""
    gamma, nodes = _coarse_nodes(lobe, theta_v)
    energy = _project(tabulate(lobe.transfer, theta_v, gamma, nodes), nodes, 0, 0)[1]
    return float((energy @ weight).sum())


def _coarse_nodes(lobe: IsotropicLobe, theta_v: FloatArray) -> tuple[FloatArray, Quadrature]:
    """Return the angles between C and N at views, and nodes that tell the energy there to a few per cent."""
    measured, width = lobe_center(lobe.function)
    gamma = gamma_at(measured if lobe.center == "lobe" else gamma_table(lobe.center), theta_v)
    return gamma, horizon_quadrature(gamma, width, 0, K=8, least=3)


def _disagreement(few: float, many: float) -> float:
    """Return the fraction of the energy that few views do not see as many do; 0 if it may be noise."""
    fraction = abs(many - few) / max(many, few, 1e-300)
    return fraction if fraction > _VIEWS_AGREE else 0.0


def _views(count: int) -> tuple[FloatArray, FloatArray]:
    """Return Gauss nodes in theta_v, in which lobes are smooth, with the measure cos^2(theta_v) uniform."""
    x, w = unit_gauss(count)
    return np.pi / 2 * x, np.pi / 2 * w * np.sin(np.pi * x)


_LEAST_DEGREE = 30
"""Smallest degree that nodes resolve: what a sharp lobe has beyond L must not be taken for what is below."""

_ROUGH = 1e-6
"""Quadrature error, a fraction of the energy, above which a lobe has jumps and gets more nodes."""


def _projected(lobe: IsotropicLobe, L: int, P: int, Q: int, views: int, K: int, least: int) -> LobeAnalysis:
    """Project on degrees l <= L and azimuths q <= Q with the nodes of `horizon_quadrature(..., K, least)`."""
    theta_v, weight = _views(views)
    # `function` is the same object for every L, so that the center is found once
    measured, width = lobe_center(lobe.function)
    gamma = measured if lobe.center == "lobe" else gamma_table(lobe.center)
    at_view = gamma_at(gamma, theta_v)

    # The projections
    resolved = max(L, _LEAST_DEGREE)
    nodes = horizon_quadrature(at_view, width, resolved, K, least)
    g, energy = _project(tabulate(lobe.transfer, theta_v, at_view, nodes), nodes, L, Q)

    # The same by other nodes at every eighth view: what smooth lobes agree on and jumps do not
    eighth = np.arange(3, views, 8)
    other_nodes = horizon_quadrature(at_view[eighth], width, resolved, K + 7, least + 3)
    other_table = tabulate(lobe.transfer, theta_v[eighth], at_view[eighth], other_nodes)
    other_g, _ = _project(other_table, other_nodes, L, Q)
    difference = np.einsum("cql,q->", (g[..., eighth] - other_g) ** 2 @ weight[eighth], _multiplicity(Q))
    total = float((energy[:, eighth] @ weight[eighth]).sum())
    error = float(difference / total) if total > 0 else 0.0
    return LobeAnalysis(
        lobe.center, "isotropic", gamma, theta_v + at_view, weight, g, energy @ weight, P, error
    )


def _width(profile: Callable[[FloatArray], FloatArray]) -> float:
    """Return the angle from the center within which half the energy of a profile of theta_i lies, radians."""
    peak = peak_of_profile(profile)
    nodes = whole_quadrature(min(NARROW, 0.25 * peak), 0)
    energy = (columns(profile(nodes.theta_i[0])) ** 2).sum(axis=-1) * nodes.weight_theta[0]
    inside = np.cumsum(energy)
    if inside[-1] <= 0:
        return 0.5
    half = nodes.theta_i[0][np.searchsorted(inside, inside[-1] / 2)]
    return narrower(float(half), peak)


def _project(table: FloatArray, nodes: Quadrature, L: int, Q: int) -> tuple[FloatArray, FloatArray]:
    """Return the projections g (channels, Q+1, L+1, views) of a table, and its energy (channels, views)."""
    return _core.project(
        rho_hat=np.ascontiguousarray(table, dtype=np.float64),
        theta_i=nodes.theta_i,
        weight_theta=nodes.weight_theta,
        arc=nodes.arc,
        share=nodes.share,
        weight_share=nodes.weight_share,
        L=L,
        Q=Q,
    )


def _multiplicity(Q: int) -> FloatArray:
    """Return U_q for q = 0..Q: 1 for q = 0, else 2 [R02 eq. 5.18]."""
    return np.where(np.arange(Q + 1) == 0, 1.0, 2.0)
