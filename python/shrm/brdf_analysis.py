"""From a lobe to its coefficients rho_lpq: the three steps of [RH02] appendix C, about any centre.

In the frame of the central direction C (z axis), with N and V at azimuth 0,

    N = (sin gamma, 0, cos gamma)      V = (sin theta_o, 0, cos theta_o)
    L = (sin theta_i cos phi, sin theta_i sin phi, cos theta_i)

theta_v is the angle between N and V, gamma(theta_v) the one between C and N, theta_o = theta_v + gamma.
gamma = theta_v makes C the reflection R of the paper, gamma = 0 the normal. The *lobe centre* takes gamma so
that C is the mean direction of rho_hat^2. A lobe about the tangent has no N: theta_o runs over [0, pi].

Each (l, q) projection of the light's degree and the azimuth,

    g_lq(theta_o) = int int f_lq(theta_i) cos(q phi) rho_hat sin(theta_i) dtheta_i dphi,

is a function of the view alone, and rho_lpq are the coefficients of its weighted least-squares fit by
f_pq(theta_o), p <= P. The weight is the measure cos^2(theta_v) uniform. For C = R that is V uniform on the
sphere about R, sin(theta_o) dtheta_o / 2; there the f_pq are orthogonal, of mean square 1 / 4 pi, and the fit
is the integral rho_lpq = 2 pi int g_lq f_pq sin(theta_o) dtheta_o of [RH02] eq. 13.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
[R02]  R. Ramamoorthi. PhD thesis, Stanford, 2002, chapter 5.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.brdf.lobe import Center, IsotropicLobe, Lobe, RadialLobe, ZonalLobe

FloatArray = npt.NDArray[np.float64]
Kind = Literal["radial", "zonal", "isotropic"]

GAMMA_SIZE = 257
"""Entries of a table of gamma, uniform in theta_v over [0, pi/2], linear in between."""

_GRAZING = np.radians(89.5)  # the last view at which gamma is measured; models may vanish at 90 degrees


@dataclass(frozen=True)
class Quadrature:
    """Nodes over the light directions in the frame of C, one set per view.

    Attributes
    ----------
    theta_i, weight_theta : (views, I) float64
        Colatitudes, and weights that include sin(theta_i).
    phi, weight_phi : (views, I, K) float64
        Azimuths in [0, pi], and weights that count both signs.
    """

    theta_i: FloatArray
    weight_theta: FloatArray
    phi: FloatArray
    weight_phi: FloatArray


def gauss(a: FloatArray, b: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on [a, b], along a new last axis."""
    x, w = _leggauss(n)
    half = (b - a)[..., None] / 2
    return a[..., None] + half * (x + 1), half * w


@lru_cache(maxsize=256)
def _leggauss(n: int) -> tuple[FloatArray, FloatArray]:
    return np.polynomial.legendre.leggauss(n)


def _panels(edges: FloatArray, L: int, least: int) -> tuple[FloatArray, FloatArray]:
    """Composite Gauss nodes on the panels between edges (views, n+1); enough for degree L on each."""
    nodes, weights = [], []
    for a, b in zip(edges[:, :-1].T, edges[:, 1:].T, strict=True):
        # f_lq turns by L radians per radian; Gauss needs pi nodes per wave, half a node per radian
        n = least + int(np.ceil(0.5 * L * float(np.max(b - a))))
        # theta = a + (b - a) sin^2: square-root ends, where the horizon enters, become smooth
        t, w = gauss(np.zeros_like(a), np.full_like(a, np.pi / 2), n)
        nodes.append(a[:, None] + (b - a)[:, None] * np.sin(t) ** 2)
        weights.append((b - a)[:, None] * np.sin(2 * t) * w)
    return np.concatenate(nodes, axis=1), np.concatenate(weights, axis=1)


def horizon_quadrature(gamma: FloatArray, width: float, L: int, K: int, least: int = 10) -> Quadrature:
    """Nodes for lobes that end at N.L = 0, exact about that edge.

    Parameters
    ----------
    gamma : (views,) float64
        Angles between C and N in [0, pi/2], radians.
    width : float
        Angle within which most of the lobe lies, radians: panels double in size from there.
    L : int
        Largest degree to be integrated.
    K : int
        Azimuths for each colatitude.
    least : int
        Colatitudes in each panel, before those that L needs.

    Returns
    -------
    Quadrature
    """
    full = np.pi / 2 - gamma  # below, the whole circle is above the horizon; above, an arc of it
    rungs = width * 2.0 ** np.arange(np.ceil(np.log2(np.pi / width)))
    inner = np.minimum(np.concatenate([[0.0], rungs])[None, :], full[:, None])
    outer = full[:, None] + 2 * gamma[:, None] * np.array([0.0, 0.25, 1.0])
    edges = np.concatenate([inner, outer], axis=1)
    theta_i, weight = _panels(edges, L, least)
    # N.L > 0: cos(phi) > -cot(gamma) cot(theta_i)
    with np.errstate(divide="ignore"):
        limit = -1 / (np.tan(gamma[:, None]) * np.tan(theta_i))
    end = np.where(theta_i <= full[:, None], np.pi, np.arccos(np.clip(limit, -1, 1)))
    phi, weight_phi = gauss(np.zeros_like(end), end, K)
    return Quadrature(theta_i, weight * np.sin(theta_i), phi, 2 * weight_phi)


def _whole_quadrature(views: int, width: float, L: int, K: int) -> Quadrature:
    """Nodes over the whole sphere, for lobes without a horizon."""
    rungs = width * 2.0 ** np.arange(np.ceil(np.log2(np.pi / 2 / width)))
    edges = np.concatenate([[0.0], rungs[rungs < np.pi / 2], [np.pi / 2, np.pi]])
    theta_i, weight = _panels(np.tile(edges, (views, 1)), L, least=12)
    if K == 1:
        phi, weight_phi = np.zeros((*theta_i.shape, 1)), np.full((*theta_i.shape, 1), 2 * np.pi)
    else:
        phi, weight_phi = gauss(np.zeros_like(theta_i), np.full_like(theta_i, np.pi), K)
        weight_phi = 2 * weight_phi
    return Quadrature(theta_i, weight * np.sin(theta_i), phi, weight_phi)


def _uniform_quadrature(views: int, L: int, K: int, panels: int = 8) -> Quadrature:
    """Nodes over the whole sphere with no preferred colatitude, for lobes about the tangent."""
    edges = np.tile(np.linspace(0, np.pi, panels + 1), (views, 1))
    theta_i, weight = _panels(edges, L, least=24)
    phi, weight_phi = gauss(np.zeros_like(theta_i), np.full_like(theta_i, np.pi), K)
    return Quadrature(theta_i, weight * np.sin(theta_i), phi, 2 * weight_phi)


@dataclass(frozen=True, eq=False)
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
    """

    center: Center
    kind: Kind
    gamma: FloatArray
    theta_o: FloatArray
    weight: FloatArray
    g: FloatArray
    energy: FloatArray
    _fits: dict[int, tuple[FloatArray, FloatArray]] = field(default_factory=dict, repr=False)

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

    def degree_energy(self) -> FloatArray:
        """Energy of each degree over all p, (L+1, channels): sum_q U_q of the mean over views of g_lq^2."""
        return np.asarray(np.einsum("cqlv,v,q->lc", self.g**2, self.weight, _multiplicity(self.Q)))

    def captured(self, P: int) -> FloatArray:
        """Energy of each degree that an expansion to order P keeps, (L+1, channels)."""
        return self._fit(P)[1]

    def coefficients(self, F: int, P: int) -> FloatArray:
        """Return rho_lpq, (F+1, P+1, P+1, channels) float64, indices l, p, q; zero where q > min(l, p).

        For C = R these are the integrals [RH02] eq. 13.
        """
        return self._fit(P)[0][: F + 1]

    def _fit(self, P: int) -> tuple[FloatArray, FloatArray]:
        """Least squares over theta_o for every (l, q): the coefficients and the energy they keep."""
        if P not in self._fits:
            rho = np.zeros((self.L + 1, P + 1, P + 1, self.channels))
            kept = np.zeros((self.L + 1, self.channels))
            root = np.sqrt(self.weight)
            for q in range(min(P, self.Q) + 1):
                # [RH02] appendix C, step 1, the integral over theta_o with the factor 2 pi: eq. 13
                basis = (_core.legendre(F=P, m=q, theta=self.theta_o)[q:] * root).T
                wanted = np.moveaxis(self.g[:, q] * root, -1, 0).reshape(
                    len(root), -1
                )  # (views, channels (L+1))
                fit = np.linalg.lstsq(basis, wanted, rcond=1e-6)[0]
                lost = ((wanted - basis @ fit) ** 2).sum(axis=0)
                energy = ((wanted**2).sum(axis=0) - lost).reshape(self.channels, self.L + 1)
                kept += (1 if q == 0 else 2) * energy.T
                rho[:, q:, q] = fit.reshape(P - q + 1, self.channels, self.L + 1).transpose(2, 0, 1)
            self._fits[P] = rho, kept
        return self._fits[P]


def analyse(lobe: Lobe, L: int, P: int) -> LobeAnalysis:
    """Project a lobe on the degrees l <= L, with views enough for orders p <= P.

    Parameters
    ----------
    lobe : Lobe
        The lobe, about its own centre.
    L : int
        Largest degree of the light.
    P : int
        Largest order of the view that will be asked for.

    Returns
    -------
    LobeAnalysis
    """
    if isinstance(lobe, RadialLobe):
        return _analyse_radial(lobe, L)
    if isinstance(lobe, ZonalLobe):
        return _analyse_zonal(lobe, L, P)
    assert isinstance(lobe, IsotropicLobe)
    return _analyse_isotropic(lobe, L, P)


def gamma_table(center: Center, lobe: Lobe | None = None) -> FloatArray:
    """Return gamma over theta_v in [0, pi/2], (257,) float64 radians; empty about the tangent.

    `lobe` is needed for the lobe centre only.
    """
    theta_v = np.linspace(0, np.pi / 2, GAMMA_SIZE)
    if center == "reflection":
        return theta_v
    if center == "normal":
        return np.zeros(GAMMA_SIZE)
    if center == "tangent":
        return np.zeros(0)
    assert lobe is not None
    return _lobe_centre(lobe)[0]


def _analyse_radial(lobe: RadialLobe, L: int) -> LobeAnalysis:
    """The one-dimensional path: P = 0, rho_l00 = sqrt(4 pi) rho_l  [RH02] appendix C, radially symmetric."""
    nodes = _whole_quadrature(1, _radial_width(lobe), L, K=1)
    profile = _columns(lobe.profile(np.cos(nodes.theta_i[0])))
    g, energy = _project(profile[None, :, None, :], nodes, L, 0)
    one = np.ones(1)
    return LobeAnalysis(lobe.center, "radial", gamma_table(lobe.center), 0 * one, one, g, energy @ one)


def _analyse_zonal(lobe: ZonalLobe, L: int, P: int) -> LobeAnalysis:
    """No azimuth: only q = 0 [RH02 section 7.1, Kajiya-Kay]. V uniform on the sphere."""
    x, w = _leggauss(max(96, 8 * (P + 1)))
    theta_o, weight = np.arccos(x), w / 2
    nodes = _uniform_quadrature(len(x), L, K=1)
    shape = nodes.phi.shape
    table = lobe.profile(nodes.theta_i.ravel(), np.repeat(theta_o, shape[1]))
    g, energy = _project(_columns(table).reshape(*shape, -1), nodes, L, 0)
    return LobeAnalysis(lobe.center, "zonal", gamma_table("tangent"), theta_o, weight, g, energy @ weight)


def _analyse_isotropic(lobe: IsotropicLobe, L: int, P: int) -> LobeAnalysis:
    # Low orders need fewer nodes: a fifth of the time for a relative error of 3e-4 in rho_lpq.
    views, K, least, Q_least = (24, 24, 8, 8) if P <= 3 and L <= 32 else (64, 48, 10, 24)
    # cos^2(theta_v) uniform, as cos(2 theta_v) uniform on [-1, 1]
    x, w = _leggauss(views)
    theta_v, weight = np.arccos(x) / 2, w / 2
    measured, width = _lobe_centre(lobe)
    gamma = measured if lobe.center == "lobe" else gamma_table(lobe.center)
    at_view = gamma_at(gamma, theta_v)
    nodes = horizon_quadrature(at_view, width, L, K, least)
    Q = min(L, max(P, Q_least))  # beyond P for the energy of all azimuths, which order selection needs
    table = _tabulate(lobe, theta_v, at_view, nodes)
    g, energy = _project(table, nodes, L, Q)
    return LobeAnalysis(lobe.center, "isotropic", gamma, theta_v + at_view, weight, g, energy @ weight)


def gamma_at(gamma: FloatArray, theta_v: FloatArray) -> FloatArray:
    """Look gamma(theta_v) up in its table, linearly: what renderers do, too."""
    return np.interp(theta_v, np.linspace(0, np.pi / 2, len(gamma)), gamma)


def _tabulate(lobe: Lobe, theta_v: FloatArray, gamma: FloatArray, nodes: Quadrature) -> FloatArray:
    """rho_hat at the nodes, (views, I, K, channels): L and V carried from the frame of C to that of N."""
    sin_i, cos_i = np.sin(nodes.theta_i)[..., None], np.cos(nodes.theta_i)[..., None]
    x, y = sin_i * np.cos(nodes.phi), sin_i * np.sin(nodes.phi)
    c, s = np.cos(gamma)[:, None, None], np.sin(gamma)[:, None, None]
    wi = np.stack([x * c - cos_i * s, y, x * s + cos_i * c], axis=-1)
    wo = np.stack([np.sin(theta_v), np.zeros_like(theta_v), np.cos(theta_v)], axis=-1)
    wo = np.broadcast_to(wo[:, None, None, :], wi.shape)
    values = lobe.transfer(wi.reshape(-1, 3), np.ascontiguousarray(wo.reshape(-1, 3)))
    return _columns(values).reshape(*nodes.phi.shape, -1)


@lru_cache(maxsize=64)
def _lobe_centre(lobe: Lobe) -> tuple[FloatArray, float]:
    """The table of gamma for the mean direction of rho_hat^2, and the angle that holds half the energy."""
    theta_v = np.linspace(0, _GRAZING, 25)
    nodes = horizon_quadrature(
        theta_v, 0.01, L=0, K=16, least=6
    )  # about R, from a hundredth of a radian outwards
    energy = (_tabulate(lobe, theta_v, theta_v, nodes) ** 2).sum(axis=-1)
    energy *= nodes.weight_theta[..., None] * nodes.weight_phi
    along_x = (energy * np.sin(nodes.theta_i)[..., None] * np.cos(nodes.phi)).sum(axis=(1, 2))
    along_z = (energy * np.cos(nodes.theta_i)[..., None]).sum(axis=(1, 2))
    gamma = np.clip(theta_v - np.arctan2(along_x, along_z), 0, np.pi / 2)
    gamma[0] = 0  # by symmetry
    fine = np.linspace(0, np.pi / 2, GAMMA_SIZE)
    table = _hermite(theta_v, gamma, np.minimum(fine, _GRAZING))
    inside = np.cumsum(energy.sum(axis=2), axis=1)
    total = inside[:, -1]
    half = [t[np.searchsorted(e, e[-1] / 2)] for t, e in zip(nodes.theta_i, inside, strict=True) if e[-1] > 0]
    if not np.any(total > 0):
        return np.linspace(0, np.pi / 2, GAMMA_SIZE), 0.5
    return table, float(np.clip(np.min(half), 1e-3, 0.8))


def _radial_width(lobe: RadialLobe) -> float:
    nodes = _whole_quadrature(1, 1e-3, 0, K=1)
    energy = (_columns(lobe.profile(np.cos(nodes.theta_i[0]))) ** 2).sum(axis=-1) * nodes.weight_theta[0]
    inside = np.cumsum(energy)
    if inside[-1] <= 0:
        return 0.5
    return float(np.clip(nodes.theta_i[0][np.searchsorted(inside, inside[-1] / 2)], 1e-3, 0.8))


def _hermite(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Cubic Hermite interpolation with central differences as slopes."""
    slope = np.gradient(y, x)
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    h = x[i + 1] - x[i]
    t = (at - x[i]) / h
    return np.asarray(
        (1 + 2 * t) * (1 - t) ** 2 * y[i]
        + t * (1 - t) ** 2 * h * slope[i]
        + t**2 * (3 - 2 * t) * y[i + 1]
        + t**2 * (t - 1) * h * slope[i + 1]
    )


def _project(table: FloatArray, nodes: Quadrature, L: int, Q: int) -> tuple[FloatArray, FloatArray]:
    arrays = (nodes.theta_i, nodes.weight_theta, nodes.phi, nodes.weight_phi)
    theta_i, weight_theta, phi, weight_phi = (np.ascontiguousarray(a, dtype=np.float64) for a in arrays)
    g, energy = _core.project(
        rho_hat=np.ascontiguousarray(table, dtype=np.float64),
        theta_i=theta_i,
        weight_theta=weight_theta,
        phi=phi,
        weight_phi=weight_phi,
        L=L,
        Q=Q,
    )
    return g, energy


def _columns(values: FloatArray) -> FloatArray:
    return values if values.ndim == 2 else values[:, None]


def _multiplicity(Q: int) -> FloatArray:
    """U_q: 1 for q = 0, else 2."""
    return np.where(np.arange(Q + 1) == 0, 1.0, 2.0)
