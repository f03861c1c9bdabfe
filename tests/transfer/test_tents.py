"""Lighting from tents: in full, compressed, with something fixed, against plain sums in float64."""

import numpy as np
import pytest
from shrm.transfer.lighting import Compressed, Convolution, FixedLight, FixedView, Projection, Tents
from support.transfer_vertices import (
    EYE,
    FRAMES,
    POINTS,
    SEEN,
    VIEW,
    V,
    assert_close,
    hats,
    local_views,
    random,
    some_of,
    tents_oracle,
    tolerance,
)

# ---- Tents


@SEEN
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize(
    ("n", "M"),
    [(5, 11), (5, 7), (1, 2), (2, 3), (3, 5), (4, 9), (6, 4), (7, 3), (8, 2), (9, 3), (10, 6), (2, 33)],
)
def test_tents_are_the_sum_over_all_tents(n, M, channels, seen):
    matrices, light = random((V, M * M, channels, n * n), 3), random((n * n, 3), 4, np.float64)
    found = Tents(POINTS, FRAMES, matrices).radiance(light, **seen)
    assert_close(found, tents_oracle(matrices, light, seen), tolerance(matrices, light, M))


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize(("n", "M"), [(5, 11), (1, 3), (2, 5), (3, 4), (4, 4), (7, 3), (10, 2)])
def test_half_matrices_are_read_as_they_are(n, M, channels):
    halves, light = random((V, M * M, channels, n * n), 5, np.float16), random((n * n, 3), 6, np.float64)
    lighting = Tents(POINTS, FRAMES, halves)
    assert np.shares_memory(lighting.matrices, halves)
    found = lighting.radiance(light, eye=EYE)
    assert_close(found, tents_oracle(halves, light, {"eye": EYE}), tolerance(halves, light, M))


def test_halves_of_floats_are_within_their_rounding():
    matrices, light = random((V, 49, 1, 25), 7), random((25, 3), 8, np.float64)
    whole, half = (
        Tents(POINTS, FRAMES, a).radiance(light, eye=EYE) for a in (matrices, np.float16(matrices))
    )
    # Each value is off by at most 2^-11 of itself, or 2^-25
    bound = tents_oracle(np.abs(matrices), np.abs(light), {"eye": EYE}) * 2.0**-11 + 2.0**-20
    assert np.all(np.abs(half - whole) <= bound)
    assert np.any(half != whole)


def test_views_on_every_side_and_at_the_pole_and_the_corners():
    """Directions at which the map has its kinks, and straight down."""
    w = np.array(
        [
            *([0, 0, 1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0.6, 0.6, np.sqrt(0.28)], [0, 0, -1]),
            *([np.sqrt(0.5), np.sqrt(0.5), 0], [-np.sqrt(0.5), np.sqrt(0.5), 0], [0.6, 0, -0.8]),
            *([1e-5, 0, 1], [1e-4, -1e-4, np.sqrt(1 - 2e-8)], [0.48, -0.6, -0.64]),
        ]
    )
    M, identity = 9, np.tile(np.eye(3, dtype=np.float32), (len(w), 1, 1))
    ramp = np.arange(M) / (M - 1)
    u, v = np.tile(ramp, M), np.repeat(ramp, M)  # tents whose sum is the position on the square
    matrices = np.tile(np.stack([u, v, u * 0 + 1], axis=1)[None, :, :, None], (len(w), 1, 1, 1))
    found = Tents(-w, identity, matrices).radiance(np.ones((1, 3)), eye=np.zeros(3))
    up = w.copy()
    up[w[:, 2] < 0, 2] = 0
    up[6] = [1, 0, 0]  # below, everything is as near
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    assert_close(found[:, :2], hats(M, up) @ np.stack([u, v], axis=1), 1e-6)
    np.testing.assert_allclose(found[:, 2], 1, atol=1e-6)


@pytest.mark.parametrize("kind", ["tents", "parabolic map", "reflection"])
def test_an_eye_at_a_vertex_sees_it_from_above(kind):
    light = random((4, 3), 10, np.float64)
    lighting = {
        "tents": lambda: Tents(POINTS, FRAMES, random((V, 9, 1, 4), 9)),
        "parabolic map": lambda: Projection(POINTS, FRAMES, random((8, 8, 1, 4), 9)),
        "reflection": lambda: Convolution(POINTS, FRAMES, [1.0, 0.5]),
    }[kind]()
    found = lighting.radiance(light, eye=POINTS[7])[7]
    assert_close(found, lighting.radiance(light, view=FRAMES[7, :, 2])[7], 1e-5)


# ---- Principal components


@SEEN
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize(
    ("n", "M", "K"), [(5, 11, 10), (5, 11, 25), (3, 4, 1), (1, 2, 3), (10, 5, 6), (4, 7, 17)]
)
def test_components_are_summed(n, M, K, channels, seen):
    weights, components = random((V, K), 11), random((K, M * M, channels, n * n), 12) / np.float32(K**0.5)
    light = random((n * n, 3), 13, np.float64)
    found = Compressed(POINTS, FRAMES, weights, components).radiance(light, **seen)
    lit = np.einsum("ktcj,jc->ktc", np.broadcast_to(components, (K, M * M, 3, n * n)).astype(float), light)
    expected = np.einsum(
        "vt,vk,ktc->vc", hats(M, local_views(seen)), weights.astype(float), lit, optimize=True
    )
    assert_close(found, expected, 2 * tolerance(components * K**0.5, light, M))


def test_K_is_changed_and_changed_back():
    weights, components = random((V, 12), 14), random((12, 25, 1, 9), 15)
    light = random((9, 3), 16, np.float64)
    lighting = Compressed(POINTS, FRAMES, weights, components)
    whole = lighting.radiance(light, eye=EYE)
    for K in (1, 5, 8, 12):
        lighting.K = K
        few = Compressed(POINTS, FRAMES, weights[:, :K], components[:K])
        np.testing.assert_array_equal(lighting.radiance(light, eye=EYE), few.radiance(light, eye=EYE))
    np.testing.assert_array_equal(lighting.radiance(light, eye=EYE), whole)
    assert Compressed(POINTS, FRAMES, weights, components, K=5).K == 5


def test_half_weights():
    weights, components = random((V, 9), 17, np.float16), random((9, 25, 3, 9), 18)
    light = random((9, 3), 19, np.float64)
    half, whole = (Compressed(POINTS, FRAMES, w, components) for w in (weights, np.float32(weights)))
    assert half.weights.dtype == np.float16
    np.testing.assert_array_equal(half.radiance(light, eye=EYE), whole.radiance(light, eye=EYE))


def test_clusters_that_share_their_components_are_none():
    weights, components = random((V, 7), 20), random((7, 49, 1, 25), 21)
    clusters, light = np.random.default_rng(22).integers(0, 5, V), random((25, 3), 23, np.float64)
    one = Compressed(POINTS, FRAMES, weights, components)
    many = Compressed(POINTS, FRAMES, weights, np.tile(components, (5, 1, 1, 1, 1)), clusters)
    np.testing.assert_array_equal(many.radiance(light, eye=EYE), one.radiance(light, eye=EYE))


def test_every_cluster_has_its_own_components():
    weights, components = random((V, 3), 24), random((4, 3, 25, 3, 9), 25)
    clusters, light = np.random.default_rng(26).integers(0, 4, V), random((9, 3), 27, np.float64)
    found = Compressed(POINTS, FRAMES, weights, components, clusters).radiance(light, view=VIEW)
    for q in range(4):
        alone = Compressed(POINTS, FRAMES, weights, components[q]).radiance(light, view=VIEW)
        np.testing.assert_array_equal(found[clusters == q], alone[clusters == q])


def test_compressed_matrices_are_the_matrices_they_stand_for():
    weights, components = random((V, 6), 28), random((6, 25, 1, 16), 29)
    light = random((16, 3), 30, np.float64)
    matrices = np.einsum("vk,ktcj->vtcj", weights, components)
    whole = Tents(POINTS, FRAMES, matrices).radiance(light, eye=EYE)
    found = Compressed(POINTS, FRAMES, weights, components).radiance(light, eye=EYE)
    # Sums of 6 x 16 products of float32, in another order
    assert_close(found, whole, 100 * 6e-8 * np.abs(whole).max())


# ---- What is fixed


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("kind", ["tents", "halves", "compressed", "clustered"])
@pytest.mark.parametrize("fixed", [FixedLight, FixedView])
def test_what_is_fixed_changes_nothing(fixed, kind, channels):
    general = some_of(kind, channels)
    lighting = fixed(general)
    for seed in (35, 35, 36):
        light = random((25, 3), seed, np.float64)
        for seen in ({"eye": EYE}, {"eye": -EYE}, {"view": VIEW}, {"view": VIEW}):
            expected = general.radiance(light, **seen)
            # Positions of float32 and sums in another order; see `tolerance`
            assert_close(lighting.radiance(light, **seen), expected, 2e-5 * np.abs(expected).max())


@pytest.mark.parametrize("fixed", [FixedLight, FixedView])
def test_what_is_fixed_follows_the_number_of_components(fixed):
    general, light = some_of("compressed", 1), random((25, 3), 61, np.float64)
    lighting = fixed(general)
    for K in (6, 2, 9):
        general.K = K
        expected = general.radiance(light, eye=EYE)
        assert_close(lighting.radiance(light, eye=EYE), expected, 2e-5 * np.abs(expected).max())
