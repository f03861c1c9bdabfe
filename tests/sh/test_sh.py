"""Analysis, synthesis, evaluation and rotation: properties, then the oracles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from shrm import _core, sh
from support import oracles

EPS32 = float(np.finfo(np.float32).eps)


def band_limited(F: int, channels: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=((F + 1) ** 2, channels))


def scipy_fejer(H: int) -> np.ndarray:
    """Fejer's first rule, from its definition: exact for cos(k theta), k < H, by solving for the weights."""
    theta = (np.arange(H) + 0.5) * np.pi / H
    k = np.arange(H)[:, None]
    integrals = np.where(k % 2 == 0, 2 / (1 - k.astype(float) ** 2 + (k == 1)), 0.0)[:, 0]
    return np.linalg.solve(np.cos(k * theta), integrals)


@pytest.mark.parametrize("H", [1, 2, 5, 16, 33])
def test_fejer_weights_integrate_cosines_exactly(H):
    np.testing.assert_allclose(_core.fejer_weights(H=H), scipy_fejer(H), atol=1e-13)


# Odd and even sizes take different foldings of the ring; W = 34 has a texel on the fold.
SIZES = [(16, 32), (17, 34), (15, 31), (24, 20), (9, 7), (1, 4), (10, 128), (3, 1088)]


@pytest.mark.parametrize(("H", "W"), SIZES)
def test_synthesis_and_evaluation_agree_with_scipy(H, W):
    F = 6
    c = band_limited(F, 5, seed=1)
    directions = oracles.directions(H, W).reshape(-1, 3)
    expected = oracles.real_harmonics(F, directions) @ c
    # float32 sums of (F+1)^2 terms
    np.testing.assert_allclose(
        sh.synthesis(c, (H, W)).reshape(-1, 5), expected, atol=(F + 1) ** 2 * EPS32 * np.abs(c).max()
    )
    np.testing.assert_allclose(sh.evaluate(c, directions), expected, atol=1e-12)


@pytest.mark.parametrize("W", [256, 250, 251])
def test_large_results_are_those_of_their_parts(W):
    """From 8 MB on, rings go past the caches, three channels at a time: bit for bit the same."""
    H, channels = 128, 67
    assert H * W * channels * 4 >= 2**23
    c = band_limited(4, channels, seed=2)
    parts = [sh.synthesis(part, (H, W)) for part in np.split(c, [33, 34], axis=1)]
    np.testing.assert_array_equal(sh.synthesis(c, (H, W)), np.concatenate(parts, axis=-1))


@pytest.mark.parametrize(("H", "W"), SIZES)
def test_analysis_is_the_adjoint_of_synthesis(H, W):
    """<analysis(x), c> = <x, synthesis(c)> under the quadrature's weights, for any x and c."""
    F = min(H, W) // 2
    rng = np.random.default_rng(2)
    x = rng.normal(size=(H, W, 3)).astype(np.float32)
    c = band_limited(F, 3, seed=3)
    weights = _core.fejer_weights(H=H)[:, None, None] * (2 * np.pi / W)
    left = (sh.analysis(x, F) * c).sum()
    right = (weights * x * sh.synthesis(c, (H, W))).sum()
    # float32 sums of W / 4 texels and of (F+1)^2 terms, against the size of the summands
    assert abs(left - right) < 8 * EPS32 * np.sqrt(H * W) * (weights * np.abs(x)).max() * np.abs(c).sum()


@pytest.mark.parametrize(("H", "F"), [(16, 7), (64, 31), (128, 63)])
def test_round_trip_is_exact_within_the_sampling_theorem(H, F):
    """Fejer's rule with H rows integrates products of degree up to H - 1."""
    c = band_limited(F, 2, seed=4)
    back = sh.analysis(sh.synthesis(c, (H, 2 * H)), F)
    assert oracles.relative_rms(back, c) < 20 * EPS32


def test_parseval():
    """The energy of a band-limited picture is the sum of its squared coefficients."""
    H, F = 48, 20
    c = band_limited(F, 1, seed=5)
    pixels = sh.synthesis(c, (H, 2 * H)).astype(np.float64)
    energy = (scipy_fejer(H)[:, None, None] * pixels**2).sum() * np.pi / H
    assert energy == pytest.approx((c**2).sum(), rel=1e-5)


def test_linear_in_the_picture():
    rng = np.random.default_rng(6)
    x, y = rng.random((2, 20, 40, 3))
    both = sh.analysis(2 * x - 3 * y, 8)
    np.testing.assert_allclose(both, 2 * sh.analysis(x, 8) - 3 * sh.analysis(y, 8), atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("W", [24, 26, 25])
def test_areas_are_integrated_exactly(W):
    """Texels as areas: the integral of Y over each, here by a fine product rule that shares no code."""
    H, F = 12, 9
    x = np.random.default_rng(7).random((H, W, 3)).astype(np.float32)
    expected = oracles.coefficients(x, F, subsamples=24)
    actual = _core.analysis(pixels=x, F=F, areas=True)
    # the oracle's sub-samples: a midpoint error of (F pi / (H 24))^2 / 24 a texel, relative
    np.testing.assert_allclose(actual, expected, atol=(F * np.pi / H / 24) ** 2 / 24 * 4 * np.pi * 2)


def test_constant_picture_has_one_coefficient():
    for areas in (False, True):
        c = _core.analysis(pixels=np.full((40, 80, 1), 0.7, np.float32), F=12, areas=areas)
        assert c[0, 0] == pytest.approx(0.7 * np.sqrt(4 * np.pi), rel=4 * EPS32)
        assert np.abs(c[1:]).max() < 20 * EPS32


def test_a_sun_of_one_texel_keeps_its_energy():
    """The mean is the texel's value times its solid angle, poles included: no sin(theta) dtheta rule."""
    H = 64
    areas = oracles.solid_angles(H, 2 * H)
    for i in (0, 1, 31, 63):
        x = np.zeros((H, 2 * H, 1), np.float32)
        x[i, 5] = 1e5
        c = _core.analysis(pixels=x, F=0, areas=True)[0, 0] * np.sqrt(4 * np.pi)
        assert c == pytest.approx(1e5 * areas[i, 5], rel=1e-6)


@pytest.mark.parametrize("F", [0, 1, 30, 200])
def test_rotation_moves_the_function(F):
    """L'(w) = L(R^T w) at random directions, to float64 accuracy."""
    c = band_limited(F, 1, seed=8) / (F + 1)
    R = Rotation.random(rng=np.random.default_rng(9)).as_matrix()
    w = oracles.rotations(np.random.default_rng(10).random((40, 3)))[:, :, 2]
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    np.testing.assert_allclose(sh.evaluate(sh.rotate(c, R), w), sh.evaluate(c, w @ R), atol=1e-10)


def test_rotation_is_a_group():
    c = band_limited(25, 2, seed=11)
    A, B = Rotation.random(2, rng=np.random.default_rng(12)).as_matrix()
    np.testing.assert_allclose(sh.rotate(sh.rotate(c, B), A), sh.rotate(c, A @ B), atol=1e-11)
    np.testing.assert_allclose(sh.rotate(sh.rotate(c, A), A.T), c, atol=1e-11)


@pytest.mark.parametrize(
    "euler", [(0, 0, 0), (0.4, 0, 0), (0, np.pi, 0.7), (1e-9, 1e-9, 0), (0, np.pi / 2, 0)]
)
def test_rotation_at_degenerate_angles(euler):
    c = band_limited(6, 1, seed=13)
    R = Rotation.from_euler("zyz", euler).as_matrix()
    np.testing.assert_allclose(sh.rotate(c, R), oracles.rotated_coefficients(c, R), atol=1e-7)


@pytest.mark.parametrize("m", [0, 1, 500, 999])
def test_legendre_functions_are_orthonormal_to_degree_1000(m):
    """2 pi int f_lm f_km sin(theta) dtheta = 1 for l = k, else 0, by Gauss's rule, exact at these degrees.

    A node off by a rounding error changes a function of degree l by l times that, and the sum of a product by
    l^2 times.
    """
    F = sh.MAX_DEGREE
    x, weight = np.polynomial.legendre.leggauss(F + 1)
    f = _core.legendre(F=F, m=m, theta=np.arccos(x))[m:]
    products = 2 * np.pi * (f * weight) @ f.T
    np.testing.assert_allclose(products, np.eye(len(f)), atol=F**2 * np.finfo(float).eps)


def test_wigner_d_against_the_explicit_sum():
    assert _core.wigner_d(m=1, q=0, F=1, alpha=0.3)[1] == pytest.approx(-np.sin(0.3) / np.sqrt(2), abs=1e-15)
    for l in (0, 1, 4, 9):
        for m in range(-l, l + 1):
            for q in range(-min(l, 6), min(l, 6) + 1):
                for alpha in (0.0, 1e-3, 0.8, np.pi / 2, 2.5, np.pi):
                    actual = _core.wigner_d(m=m, q=q, F=l, alpha=alpha)[l]
                    assert actual == pytest.approx(float(oracles.small_d(l, m, q, alpha)), abs=1e-12)


@pytest.mark.parametrize("alpha", [1e-3, 0.05, 1.0, 3.0])
def test_wigner_d_rows_are_unit_vectors_at_high_degree(alpha):
    """sum_m d^l_mq^2 = 1: the recurrence is stable to l = 200, near the poles too."""
    l = 200
    for q in (0, 3, -8):
        row = [_core.wigner_d(m=m, q=q, F=l, alpha=alpha)[l] for m in range(-l, l + 1)]
        assert np.sum(np.square(row)) == pytest.approx(1, abs=1e-10)


@settings(max_examples=40)
@given(
    H=st.integers(1, 24),
    W=st.integers(1, 40),
    F=st.integers(0, 12),
    channels=st.integers(1, 9),
    scale=st.sampled_from([0.0, 1e-20, 1.0, 1e20]),
)
def test_any_size_gives_finite_linear_results(H, W, F, channels, scale):
    x = np.random.default_rng(14).random((H, W, channels)).astype(np.float32)
    one, many = sh.analysis(x, F), sh.analysis(x * np.float32(scale), F)
    assert np.isfinite(many).all()
    np.testing.assert_allclose(many, scale * one, rtol=1e-3, atol=abs(scale) * 1e-4)
    assert np.isfinite(sh.synthesis(many, (H, W))).all()


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: sh.analysis(np.zeros((4, 8, 3)), -1), r"F must be in \[0, 1000\], got -1"),
        (lambda: sh.analysis(np.zeros((4, 8, 3)), 2.5), "F must be a whole number"),
        (lambda: sh.analysis(np.zeros((4,)), 2), r"pixels must have the shape .* got \(4,\)"),
        (lambda: sh.analysis(np.full((4, 8, 3), np.nan), 2), "pixels must be finite"),
        (lambda: sh.analysis(np.array([["a"]]), 2), "pixels must be an array of real numbers"),
        (lambda: sh.synthesis(np.zeros((5, 3)), (4, 8)), r"\(F\+1\)\^2 rows, got 5"),
        (lambda: sh.synthesis(np.zeros((4, 3)), (0, 8)), r"shape\[0\] must be in \[1, 65536\]"),
        (lambda: sh.evaluate(np.zeros((4, 3)), [[1, 1, 0]]), "directions must be unit vectors"),
        (lambda: sh.rotate(np.zeros((4, 3)), np.diag([1, 1, -1])), "R must be a rotation"),
        (lambda: sh.rotate(np.zeros((4, 3)), np.eye(2)), r"R must have the shape \(3, 3\)"),
    ],
)
def test_bad_input_is_named(call, text):
    with pytest.raises((ValueError, TypeError), match=text):
        call()


def test_core_guards_memory():
    with pytest.raises(TypeError):
        _core.analysis(pixels=np.zeros((4, 8, 3)), F=2, areas=False)  # float64
    with pytest.raises(TypeError):
        _core.analysis(pixels=np.zeros((4, 8, 6), np.float32)[:, :, ::2], F=2, areas=False)  # strided
    with pytest.raises(ValueError, match="pixels must have the shape"):
        _core.analysis(pixels=np.zeros((4, 8), np.float32), F=2, areas=False)


def test_masked_arrays_are_refused():
    with pytest.raises(TypeError, match="pixels must be a plain array, got a masked one"):
        sh.analysis(np.ma.masked_less(np.ones((4, 8, 3)), 0), F=1)
