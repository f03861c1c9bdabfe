"""The coefficients rho_lpq against brute-force integrals, and the energies that order selection uses."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy import integrate, special
from shrm import _core, brdf
from shrm.frequency import analysis as brdf_analysis
from shrm.frequency.analysis import analyse
from shrm.lobes.center import gamma_at, gamma_table
from support import oracles

L, P = 24, 6


def f(l: int, m: int, theta: np.ndarray) -> np.ndarray:
    """The theta part of Y_lm, by scipy."""
    return special.sph_harm_y(l, m, theta, 0.0).real


def rho_about_reflection(transfer, triples) -> np.ndarray:
    """[RH02] eq. 13 by a product rule that knows nothing of the horizon: midpoints, 200 x 100 x 400."""
    ti, wi = np.polynomial.legendre.leggauss(200)
    to, wo = np.polynomial.legendre.leggauss(100)
    theta_i, theta_o = np.arccos(ti), np.arccos(to)
    phi = (np.arange(400) + 0.5) * np.pi / 400
    total = np.zeros(len(triples))
    for t, w in zip(theta_o, wo, strict=True):
        # the frame of R: N half way between R and V; carried to the frame of N by a turn about y
        si, ci = np.sin(theta_i)[:, None], np.cos(theta_i)[:, None]
        x, y, z = si * np.cos(phi), si * np.sin(phi), ci + 0 * phi
        c, s = np.cos(t / 2), np.sin(t / 2)
        light = np.stack([x * c - z * s, y, x * s + z * c], axis=-1).reshape(-1, 3)
        values = transfer(light, np.array([[np.sin(t / 2), 0, np.cos(t / 2)]])).reshape(200, 400)
        for k, (l, p, q) in enumerate(triples):
            inner = values @ np.cos(q * phi) * 2 * np.pi / 400
            total[k] += w * f(p, q, np.array([t]))[0] * (wi * f(l, q, theta_i) * inner).sum()
    return 2 * np.pi * total


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "oracle"),
    [
        (brdf.Microfacet(0.3), oracles.microfacet(0.3)),
        (brdf.GGX(0.4), oracles.ggx(0.4)),
        (brdf.Beckmann(0.4), oracles.beckmann(0.4)),
    ],
)
def test_coefficients_about_the_reflection_are_the_papers_integrals(material, oracle):
    rho = analyse(material.recentered("reflection").lobes[0], L, P).coefficients(L, P)
    scale = np.abs(rho).max()
    triples = [(0, 0, 0), (1, 0, 0), (2, 1, 1), (3, 2, 0), (5, 3, 2), (4, 4, 4), (9, 2, 1), (12, 5, 3)]
    actual = [rho[l, p, q, 0] for l, p, q in triples]
    # the oracle's midpoints cross the horizon: an error of order 1 / 400
    np.testing.assert_allclose(actual, rho_about_reflection(oracle, triples), rtol=0, atol=2e-3 * scale)


def test_coefficients_vanish_beyond_their_degree():
    rho = analyse(brdf.GGX(0.3).lobes[0], L, P).coefficients(L, P)
    l, p, q = np.meshgrid(np.arange(L + 1), np.arange(P + 1), np.arange(P + 1), indexing="ij")
    assert np.all(rho[q > np.minimum(l, p)] == 0)


def test_directions_are_those_of_the_frame_turned_about_y():
    """L and V of the frame of C, turned from C to N by rotation matrices; odd sizes, and all of [0, pi]."""
    rng = np.random.default_rng(3)
    views, I, K = 3, 21, 5
    theta_v, gamma = rng.uniform(0, np.pi / 2, (2, views))
    theta_i, arc = rng.uniform(0, np.pi, (2, views, I))
    theta_i[0, :2], arc[0, :2] = [0, np.pi], [np.pi, 0]
    share = rng.uniform(0, 1, K)
    wi, wo = _core.directions(theta_v=theta_v, gamma=gamma, theta_i=theta_i, arc=arc, share=share)
    phi, theta = arc[:, None] * share[:, None], theta_i[:, None]
    L = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi])
    V = np.stack([np.sin(theta_v + gamma), 0 * gamma, np.cos(theta_v + gamma)])
    for v in range(views):
        c, s = np.cos(gamma[v]), np.sin(gamma[v])
        local = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        np.testing.assert_allclose(wi[:, v], np.einsum("ab,bki->aki", local, L[:, v]), atol=1e-15)
        expected = np.broadcast_to((local @ V[:, v])[:, None, None], (3, K, I))
        np.testing.assert_allclose(wo[:, v], expected, atol=1e-15)


@pytest.mark.parametrize("center", ["reflection", "lobe", "normal"])
def test_parseval(center):
    """The energies of all degrees and azimuths sum to that of the transfer function [R02] eq. 5.18."""
    a = analyse(replace(brdf.GGX(0.4).lobes[0], center=center), 60, 8)
    resolved = a.degree_energy().sum() / a.energy.sum()
    assert 1 - 2e-4 < resolved < 1 + 1e-9


def test_a_jump_at_the_horizon_leaves_a_tail_that_halves_with_the_degree():
    """The energy of a jump falls as 1 / L: what degrees above L hold is what Parseval says is missing."""
    lobe = brdf.Microfacet(0.5).lobes[0]
    missing = []
    for degree in (30, 60):
        a = analyse(lobe, degree, 8)
        missing.append(1 - a.degree_energy().sum() / a.energy.sum())
    assert missing[0] / missing[1] == pytest.approx(2, rel=0.35)


@pytest.mark.parametrize("center", ["reflection", "lobe"])
def test_energy_kept_grows_with_the_order(center):
    a = analyse(replace(brdf.GGX(0.2).lobes[0], center=center), 40, 8)
    kept = [a.captured(p).sum() for p in range(9)]
    assert np.all(np.diff(kept) > 0)
    assert kept[-1] < a.degree_energy().sum() * (1 + 1e-9)


def test_radial_lobes_take_the_one_dimensional_path():
    """rho_l00 = sqrt(4 pi) rho_l, with rho_l = 2 pi int u(cos t) f_l0(t) sin(t) dt by scipy."""
    for material, u, kink in [
        (brdf.Lambert(0.8), lambda c: 0.8 / np.pi * max(c, 0.0), 0.0),
        (brdf.Phong(20), lambda c: 21 / (2 * np.pi) * max(c, 0.0) ** 20, 0.0),
        (brdf.Phong(0.5), lambda c: 1.5 / (2 * np.pi) * max(c, 0.0) ** 0.5, 0.0),
    ]:
        a = analyse(material.lobes[0], 12, 0)
        assert a.kind == "radial"
        rho = a.coefficients(12, 0)[:, 0, 0, 0]
        for l in range(13):
            Y = special.legendre(l)
            norm = np.sqrt((2 * l + 1) / (4 * np.pi))
            value = integrate.quad(lambda c, u=u, Y=Y: u(c) * Y(c), kink, 1, epsabs=1e-12, limit=200)[0]
            assert rho[l] == pytest.approx(np.sqrt(4 * np.pi) * 2 * np.pi * norm * value, abs=1e-8)


def test_lambert_has_the_published_coefficients():
    """A_l = pi, 2 pi / 3, pi / 4, 0 with A_l = sqrt(4 pi / (2l+1)) rho_l for the clamped cosine."""
    rho = analyse(brdf.Lambert(1.0).lobes[0], 4, 0).coefficients(4, 0)[:, 0, 0, 0] / np.sqrt(4 * np.pi)
    A = np.pi * np.sqrt(4 * np.pi / (2 * np.arange(5) + 1)) * rho
    np.testing.assert_allclose(A, [np.pi, 2 * np.pi / 3, np.pi / 4, 0, -np.pi / 24], atol=1e-12)


@pytest.mark.parametrize("material", [brdf.KajiyaKay(16), brdf.KajiyaKay(16, cone="mirror"), brdf.Banks(0.2)])
def test_zonal_lobes_have_only_q_zero(material):
    """Their coefficients are plain double integrals over theta_i and theta_o."""
    a = analyse(material.lobes[0], 16, 8)
    assert a.kind == "zonal"
    rho = a.coefficients(16, 8)
    assert np.all(rho[:, :, 1:] == 0)
    x, w = np.polynomial.legendre.leggauss(600)
    theta = np.arccos(x)
    table = (
        material.lobes[0]
        .profile(*(g.ravel() for g in np.meshgrid(theta, theta, indexing="ij")))
        .reshape(600, 600)
    )
    for l, p in [(0, 0), (1, 1), (4, 2), (5, 5), (10, 6)]:
        expected = (2 * np.pi) ** 2 * (w * f(l, 0, theta)) @ table @ (w * f(p, 0, theta))
        assert rho[l, p, 0, 0] == pytest.approx(expected, abs=1e-4 * np.abs(rho).max())


def test_channels_have_their_own_coefficients():
    colors = (0.9, 0.5, 0.1)
    together = analyse(brdf.GGX(0.3, f0=colors).lobes[0], 16, 3).coefficients(16, 3)
    assert together.shape == (17, 4, 4, 3)
    about_R = analyse(brdf.GGX(0.3, f0=colors).recentered("reflection").lobes[0], 16, 3).coefficients(16, 3)
    for c, f0 in enumerate(colors):
        alone = analyse(brdf.GGX(0.3, f0=f0).recentered("reflection").lobes[0], 16, 3).coefficients(16, 3)
        # they share nodes graded to the sharpest channel: a quadrature error apart
        np.testing.assert_allclose(about_R[..., c], alone[..., 0], atol=1e-5 * np.abs(alone).max())


@pytest.mark.parametrize("material", [brdf.GGX(0.1), brdf.GGX(0.5), brdf.Microfacet(0.2), brdf.Beckmann(0.3)])
def test_lobe_center_is_the_energy_weighted_mean_direction(material):
    """C = mean of L rho_hat^2, by an independent rule over the hemisphere; theta_o rises with theta_v."""
    lobe = material.lobes[0]
    gamma = analyse(lobe, 4, 0).gamma
    theta_v = np.linspace(0, np.pi / 2, len(gamma))
    assert gamma[0] == 0
    assert np.all(np.diff(theta_v + gamma) > 0)
    u = (np.arange(600) + 0.5) / 600
    c, phi = np.meshgrid(u, 2 * np.pi * u, indexing="ij")
    s = np.sqrt(1 - c**2)
    light = np.stack([s * np.cos(phi), s * np.sin(phi), c], axis=-1).reshape(-1, 3)
    for t in (0.3, 0.8, 1.2):
        view = np.tile([np.sin(t), 0, np.cos(t)], (len(light), 1))
        mean = (lobe.transfer(light, view)[:, None] ** 2 * light).sum(axis=0)
        # C lies at angle gamma from N, away from V
        assert gamma_at(gamma, np.array([t]))[0] == pytest.approx(np.arctan2(-mean[0], mean[2]), abs=2e-3)


def test_gamma_of_the_fixed_centers():
    np.testing.assert_array_equal(gamma_table("normal"), 0)
    np.testing.assert_allclose(gamma_table("reflection"), np.linspace(0, np.pi / 2, 257))
    assert len(gamma_table("tangent")) == 0


def test_a_black_lobe_has_no_energy_and_no_trouble():
    black = brdf.from_function(lambda wi, wo: np.zeros(len(wi)))
    a = analyse(black.lobes[0], 8, 2)
    assert a.energy.sum() == 0
    assert np.all(a.coefficients(8, 2) == 0)


def test_a_function_is_analysed_like_the_model_it_computes():
    def ggx(wi, wo):
        return oracles.ggx(0.3)(wi, wo) / np.maximum(wi[:, 2], 1e-300)

    from_function = analyse(brdf.from_function(ggx).lobes[0], 16, 4).coefficients(16, 4)
    model = analyse(brdf.GGX(0.3).lobes[0], 16, 4).coefficients(16, 4)
    np.testing.assert_allclose(from_function, model, atol=1e-6 * np.abs(model).max())


def test_low_orders_of_a_sharp_lobe_are_those_of_high_orders():
    sharp = brdf.from_function(lambda wi, wo: np.maximum((wi * wo).sum(axis=1), 0) ** 200, name="retro")
    lobe = sharp.recentered("reflection").lobes[0]
    low, high = (analyse(lobe, L, 8).coefficients(L, 8)[:5, :4, :4] for L in (12, 60))
    # The nodes' own error, 1e-5 relative, whatever the degree wanted.
    assert np.abs(low - high).max() < 2e-5 * np.abs(high).max()


def expanded(lobe_analysis, F, P, theta_o):
    """sum_p rho_lpq f_pq(theta_o), (q, l, channel, theta_o); q > 0 count for both signs."""
    rho = lobe_analysis.coefficients(F, P)
    parts = []
    for q in range(P + 1):
        of_view = np.array([f(p, q, theta_o) if p >= q else 0 * theta_o for p in range(P + 1)])
        parts.append(np.sqrt(1 if q == 0 else 2) * np.einsum("lpc,pv->lcv", rho[:, :, q], of_view))
    return np.array(parts)


CENTERED = [
    *itertools.product(
        [brdf.GGX(0.1), brdf.GGX(0.5), brdf.Beckmann(0.1), brdf.Microfacet(0.2), brdf.Microfacet(0.5)],
        ["lobe", "reflection"],
    ),
    (brdf.GGX(0.5), "normal"),  # sharp lobes have no business there
    (brdf.Microfacet(0.5), "normal"),
]
LOW, HIGH = [(8, 2), (24, 3), (30, 5)], [(60, 8), (120, 8)]
# Of the low orders and of the high ones each lobe has one, by turns; sharp ones have all the high ones.
CONVERGED = [
    *((*lobe, LOW[k % 3]) for k, lobe in enumerate(CENTERED)),
    *((*lobe, HIGH[k % 2]) for k, lobe in enumerate(CENTERED)),
    *((*lobe, HIGH[1 - k % 2]) for k, lobe in enumerate(CENTERED) if "alpha=0.1" in lobe[0].name),
]


@pytest.mark.slow
@pytest.mark.parametrize(("material", "center", "orders"), CONVERGED, ids=str)
def test_the_nodes_are_converged_to_1e_5(material, orders, center):
    # What is compared is the lobe as expanded, not its coefficients: where fits are ill-conditioned these
    # move without moving the lobe.
    F, P = orders
    lobe = material.recentered(center).lobes[0]
    finer = brdf_analysis._projected(lobe, F, P, min(F, max(P, 24)), views=160, K=96, least=24)
    exact = expanded(finer, F, P, finer.theta_o)
    difference = expanded(analyse(lobe, F, P), F, P, finer.theta_o) - exact
    assert (difference**2 @ finer.weight).sum() <= 1e-10 * (exact**2 @ finer.weight).sum()
