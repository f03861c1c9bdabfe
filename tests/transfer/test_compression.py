"""Principal components of transfer matrices: best in radiance, with the SNR that they say."""

import numpy as np
import pytest
from shrm.transfer.compression import pca as pca_module
from shrm.transfer.compression.clusters import clustered
from shrm.transfer.compression.components import PrincipalComponents
from shrm.transfer.compression.pca import factored, streamed
from shrm.transfer.directional_basis import DirectionalBasis
from support.transfer_components import exact

M, N2 = 5, 9
TENTS = M * M


def slow_matrices(V: int, C: int, seed: int, power: float = 1.2) -> np.ndarray:
    """Matrices whose singular values fall as slowly as k^-power, (V, M^2, C, n^2) float32."""
    rng = np.random.default_rng(seed)
    size = TENTS * C * N2
    rank = min(V, size)
    left, right = (np.linalg.qr(rng.normal(size=(rows, rank)))[0] for rows in (V, size))
    falling = (np.arange(rank) + 1.0) ** -power
    return (10 * (left * falling) @ right.T).reshape(V, TENTS, C, N2).astype(np.float32)


def in_clusters(V: int, Q: int, seed: int) -> np.ndarray:
    """Vertices in Q subspaces of two dimensions each, with little noise."""
    rng = np.random.default_rng(seed)
    forms = rng.normal(size=(Q, 2, TENTS, 1, N2))
    index, weights = rng.integers(Q, size=V), rng.normal(size=(V, 2))
    noise = 0.01 * rng.normal(size=(V, TENTS, 1, N2))
    return (np.einsum("pk,pktcj->ptcj", weights, forms[index]) + noise).astype(np.float32)


def radiance(matrices: np.ndarray) -> np.ndarray:
    """Radiance times the roots of weights at nodes that are exact for squares, under each unit light."""
    basis = DirectionalBasis(M)
    directions, weights = basis.quadrature(3)
    rows = np.moveaxis(matrices.astype(np.float64), 1, 0).reshape(TENTS, -1)
    return np.sqrt(weights)[:, None] * basis.evaluate(rows, directions)


def restored(compressed: PrincipalComponents, K: int | None = None) -> np.ndarray:
    weights, forms = compressed.weights.astype(np.float64)[:, :K], compressed.components.astype(np.float64)
    if compressed.clusters is None:
        return np.einsum("pk,ktcj->ptcj", weights, forms[:K])
    return np.einsum("pk,pktcj->ptcj", weights, forms[compressed.clusters, :K])


def measured_snr(matrices: np.ndarray, compressed: PrincipalComponents, K: int | None = None) -> float:
    # lights that are random and white have the mean of the unit lights'
    signal, noise = radiance(matrices), radiance(matrices - restored(compressed, K))
    return 10 * np.log10((signal**2).sum() / (noise**2).sum())


# Exact


@pytest.mark.parametrize(("V", "C"), [(300, 1), (60, 1), (40, 3)])
def test_the_components_are_those_of_the_singular_value_decomposition_in_radiance(V, C):
    A = slow_matrices(V, C, seed=1)
    L = np.linalg.cholesky(DirectionalBasis(M).gram())
    whitened = np.einsum("ts,ptcj->pscj", L, A.astype(np.float64)).reshape(V, -1)
    left, values, right = np.linalg.svd(whitened, full_matrices=False)
    energies = np.append(np.cumsum(values[::-1] ** 2)[::-1], 0)
    K = 20
    pca = exact(A, K=K)
    assert pca.weights.shape == (V, K)
    assert pca.components.shape == (K, TENTS, C, N2)
    np.testing.assert_allclose(pca.left, energies[: K + 1], rtol=1e-9)
    best = ((left[:, :K] * values[:K]) @ right[:K]).reshape(V, TENTS, C, N2)
    best = np.einsum("st,pscj->ptcj", np.linalg.inv(L), best)
    np.testing.assert_allclose(restored(pca), best, atol=1e-6 * np.abs(A).max() * K)


def test_components_are_orthonormal_in_radiance_and_not_in_coefficients():
    flat = radiance(exact(slow_matrices(100, 1, seed=2), K=10).components).reshape(-1, 10, N2)
    np.testing.assert_allclose(np.einsum("dkj,dlj->kl", flat, flat), np.eye(10), atol=1e-6)


@pytest.mark.parametrize(("C", "r"), [(1, 4), (1, 30), (3, 6)])
def test_the_small_factor_gives_the_same(C, r):
    rng = np.random.default_rng(3)
    P, X = rng.normal(size=(TENTS, C, r)), rng.normal(size=(80, r, N2))
    if r == 6:
        P[..., -1] = P[..., 0]  # of lower rank
    A = np.einsum("tcr,prj->ptcj", P, X)
    small, full = factored(P, X, K=12), exact(A, K=12)
    np.testing.assert_allclose(small.left, full.left, rtol=1e-9)
    scale = np.abs(A).max()
    np.testing.assert_allclose(restored(small), restored(full), atol=1e-5 * scale)


def test_all_components_leave_nothing():
    A = slow_matrices(30, 1, seed=4)
    pca = exact(A)
    assert pca.K == TENTS * N2
    np.testing.assert_allclose(restored(pca), A, atol=1e-5 * np.abs(A).max())
    assert pca.snr[-1] == np.inf


# Randomised


@pytest.fixture(params=[0, pca_module.GRAM_COLUMNS], ids=["by blocks", "by the Gram matrix"])
def columns(request, monkeypatch):
    """Both ways of the randomised: on the blocks, and on the Gram matrix."""
    monkeypatch.setattr(pca_module, "GRAM_COLUMNS", request.param)
    return request.param


@pytest.mark.parametrize("power", [0.6, 1.2])
def test_the_randomised_are_within_a_tenth_of_a_decibel_of_the_exact(power, columns):
    A = slow_matrices(600, 1, seed=5, power=power)
    best, found = exact(A, K=40), streamed(A, K=40)
    loss = best.snr - found.snr
    assert loss.max() < 0.1
    assert loss.min() > -1e-4  # nothing is better than the best, but for float32
    assert found.left[0] == pytest.approx(best.left[0], rel=1e-6)


def test_blocks_from_anywhere_give_the_same_and_are_read_as_often_as_said(tmp_path, columns):
    A, reads = slow_matrices(90, 3, seed=6), []

    def blocks():
        reads.append(1)
        yield from np.array_split(A, 7)

    np.save(tmp_path / "A.npy", A)
    whole = streamed(A, K=8)
    parts = streamed(blocks, K=8, passes=2)
    mapped = streamed(np.load(tmp_path / "A.npy", mmap_mode="r"), K=8)
    # The shape, the Gram matrix or two passes and the values, the last
    assert len(reads) == 1 + (1 if columns else 3) + 1
    np.testing.assert_array_equal(mapped.weights, whole.weights)
    np.testing.assert_allclose(parts.snr, whole.snr, atol=0.1)


def test_the_randomised_are_the_same_each_time_and_for_other_seeds_nearly(columns):
    A = slow_matrices(200, 1, seed=7)
    one, same, other = streamed(A, K=6), streamed(A, K=6), streamed(A, K=6, seed=1)
    np.testing.assert_array_equal(one.components, same.components)
    np.testing.assert_allclose(restored(other), restored(one), atol=1e-3 * np.abs(A).max())


# What they say of themselves


@pytest.mark.parametrize("make", [exact, streamed], ids=["exact", "streamed"])
@pytest.mark.parametrize("C", [1, 3])
def test_the_snr_is_that_of_radiance(make, C):
    A = slow_matrices(200, C, seed=8)
    pca = make(A, K=16)
    for K in (1, 7, 16):
        assert measured_snr(A, pca, K) == pytest.approx(pca.snr[K - 1], abs=1e-3)
        assert measured_snr(A, pca.truncated(K)) == pytest.approx(pca.truncated(K).snr[-1], abs=1e-3)


def test_the_snr_is_that_of_random_views_and_lights():
    rng, count = np.random.default_rng(9), 4000
    A = slow_matrices(50, 1, seed=9)
    pca = exact(A, K=10)
    z, phi = rng.random(count), 2 * np.pi * rng.random(count)
    sine = np.sqrt(1 - z * z)
    views = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)
    tents, shares = DirectionalBasis(M).tents(views)
    lights = rng.normal(size=(count, N2))

    def seen(matrices):
        rows = np.einsum("vi,pvij->pvj", shares, matrices[:, tents, 0])
        return (np.einsum("pvj,vj->pv", rows, lights) ** 2).sum(axis=0)

    signal, noise = seen(A.astype(np.float64)), seen(A - restored(pca))
    spread = sum((x.std() / x.mean()) ** 2 / count for x in (signal, noise)) ** 0.5
    assert 10 * np.log10(signal.mean() / noise.mean()) == pytest.approx(pca.snr[-1], abs=4 * 4.35 * spread)


def test_as_many_components_as_the_accuracy_takes(columns, monkeypatch):
    monkeypatch.setattr(pca_module, "_FIRST", 4)  # and then four times as many, again and again
    A = slow_matrices(150, 1, seed=10)
    snr = exact(A).snr
    for accuracy in (5.0, 12.0, 20.0):
        for make in (exact, streamed):
            pca = make(A, accuracy=accuracy)
            assert pca.snr[-1] >= accuracy
            assert np.flatnonzero(snr >= accuracy)[0] + 1 == pca.K
    with pytest.warns(UserWarning, match=r"3 components reach .* dB of the 30 asked for"):
        assert streamed(A, accuracy=30, most=3).K == 3


def test_nothing_is_compressed_without_loss():
    dark = np.zeros((10, TENTS, 1, N2), np.float32)
    for pca in (exact(dark, accuracy=20), streamed(dark, K=2), clustered(exact(dark, K=3), 4, 2)):
        assert np.all(pca.snr == np.inf)
        assert np.all(restored(pca.halved()) == 0)


# Clusters


def test_clusters_beat_global_components_where_vertices_cluster():
    A = in_clusters(600, 8, seed=11)
    pca = exact(A, K=24)
    local = clustered(pca, 8, 2)
    assert local.snr[-1] > pca.snr[1] + 10
    assert local.snr[-1] > 25  # noise of .01 in signals of 1 to 2: about 40 dB, less where seeds were unlucky
    assert local.components.shape == (8, 2, TENTS, 1, N2)
    for K in (1, 2):
        assert measured_snr(A, local, K) == pytest.approx(local.snr[K - 1], abs=1e-3)


def test_one_cluster_is_all_vertices():
    A = slow_matrices(100, 1, seed=12)
    pca = exact(A, K=30)
    one = clustered(pca, 1, 5)
    np.testing.assert_allclose(one.left, pca.left[:6], rtol=1e-5)
    np.testing.assert_allclose(restored(one), restored(pca, 5), atol=1e-4 * np.abs(A).max())


def test_more_clusters_and_more_components_leave_less():
    pca = exact(slow_matrices(300, 1, seed=13, power=0.8), K=60)
    few, many = clustered(pca, 4, 3), clustered(pca, 24, 3)
    assert pca.left[3] > few.left[3] > many.left[3] > pca.left[60]
    assert np.all(np.diff(many.left) <= 0)


@pytest.mark.parametrize("copies", [1, 5])
def test_no_cluster_is_empty_even_of_vertices_that_are_alike(copies):
    A = np.repeat(slow_matrices(3, 1, seed=14), copies, axis=0)
    local = clustered(exact(A, K=4), len(A), 2)
    assert local.clusters.dtype == np.int32
    np.testing.assert_array_equal(np.unique(local.clusters), np.arange(len(A)))
    np.testing.assert_allclose(restored(local), A, atol=1e-5 * np.abs(A).max())


def test_clusters_are_the_same_each_time():
    pca = streamed(slow_matrices(200, 1, seed=15), K=20)
    np.testing.assert_array_equal(clustered(pca, 6, 2).clusters, clustered(pca, 6, 2).clusters)


# Half floats


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize("components", [False, True])
@pytest.mark.parametrize("Q", [None, 5])
def test_half_floats_cost_what_they_say_and_little(scale, components, Q):
    A = (scale * slow_matrices(200, 1, seed=16)).astype(np.float32)
    pca = exact(A, K=40)
    pca = pca if Q is None else clustered(pca, Q, 10)
    halves = pca.halved(components=components)
    assert halves.weights.dtype == np.float16
    assert halves.components.dtype == (np.float16 if components else np.float32)
    noise = radiance(restored(pca) - restored(halves))
    assert halves.rounding[-1] == pytest.approx((noise**2).sum(), rel=1e-2)
    # relative errors are uniform up to 2^-11 at worst
    assert halves.rounding[-1] < (1 + components) * 2.0**-22 / 3 * pca.left[0]
    assert measured_snr(A, halves) == pytest.approx(halves.snr[-1], abs=1e-2)
    assert halves.report()["SNR of rounding"] > 66
    for K in (3, 10):
        part = radiance(restored(pca, K) - restored(halves, K))
        assert halves.truncated(K).rounding[-1] == pytest.approx((part**2).sum(), rel=1e-2)


def test_half_floats_do_not_overflow():
    A = slow_matrices(50, 1, seed=17).astype(np.float64) * 1e12
    pca = exact(A, K=5)
    assert np.isfinite(pca.halved().weights).all()
    with pytest.raises(ValueError, match="must be within the range of half floats"):
        pca.halved(components=True)
    with pytest.raises(ValueError, match="weights must be float32 before they are halved"):
        pca.halved().halved()


# What does not fit

SOME = slow_matrices(12, 1, seed=18)
HOLE = np.where(np.arange(12)[:, None, None, None] == 7, np.nan, SOME)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: streamed(SOME[0]), ValueError, "shape"),
        (lambda: exact(SOME[:, :24]), ValueError, "M\\^2 tents"),
        (lambda: exact(SOME, K=226), ValueError, r"K must be in \[1, 225\], got 226"),
        (lambda: exact(SOME, K=2, accuracy=3), ValueError, "K must be None where accuracy is given, got 2"),
        (lambda: exact(SOME, accuracy=np.nan), ValueError, "accuracy must be finite"),
        (lambda: exact(HOLE), ValueError, "X must be finite"),
        (
            lambda: factored(np.ones((25, 3)), np.ones((4, 3, 9))),
            ValueError,
            r"P must have .* \(M\^2, C, r\)",
        ),
        (
            lambda: factored(np.ones((25, 1, 3)), np.ones((4, 2, 9))),
            ValueError,
            r"X must have .* \(V, 3, n\^2\)",
        ),
        (lambda: factored(np.full((25, 1, 3), np.inf), np.ones((4, 3, 9))), ValueError, "P must be finite"),
        (lambda: streamed(HOLE), ValueError, "matrices must be finite"),
        (lambda: streamed(SOME, K=0), ValueError, "K must be in"),
        (lambda: streamed(lambda: [SOME, SOME[:, :, :, :4]]), ValueError, "must be alike"),
        (lambda: streamed(lambda: []), ValueError, "shape"),
        (lambda: clustered(exact(SOME, K=4), 13, 2), ValueError, r"clusters must be in \[1, 12\]"),
        (lambda: clustered(exact(SOME, K=4), 3, 5), ValueError, "K must be in"),
        (lambda: clustered(exact(SOME, K=4).halved(), 3, 2), ValueError, "before rounding"),
        (lambda: exact(SOME, K=4).truncated(5), ValueError, "K must be in"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(call, error, text):
    with pytest.raises(error, match=text):
        call()
