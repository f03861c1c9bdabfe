"""Run-time lighting: each method against plain sums in float64, by formulas of their own."""

from itertools import pairwise

import numpy as np
import oracles
import pytest
from directions import sphere
from shrm import brdf
from shrm.brdf_matrix import rows as material_rows
from shrm.transfer.lighting import (
    Compressed,
    Convolution,
    Diffuse,
    FixedLight,
    FixedView,
    Projection,
    Tents,
    parabolic_map,
    zonal_kernel,
)

V = 531  # two whole blocks, and vectors that are not full
EYE, VIEW = np.array([1.4, -0.7, 0.9]), np.array([0.48, -0.6, 0.64])
SEEN = pytest.mark.parametrize("seen", [{"eye": EYE}, {"view": VIEW}], ids=["near", "distant"])


# ---- Objects


def frames(count: int, seed: int) -> np.ndarray:
    return oracles.rotations(np.random.default_rng(seed).uniform(size=(count, 3))).astype(np.float32)


def vertices(count: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-0.5, 0.5, size=(count, 3)).astype(np.float32)


def random(shape: tuple[int, ...], seed: int, dtype: type = np.float32) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=shape).astype(dtype)


POINTS, FRAMES = vertices(V, 1), frames(V, 2)


# ---- Oracles


def local_views(seen: dict, points: np.ndarray = POINTS, axes: np.ndarray = FRAMES) -> np.ndarray:
    """In float64, brought to the horizon where below."""
    d = seen["eye"] - points.astype(np.float64) if "eye" in seen else np.tile(seen["view"], (len(points), 1))
    local = np.einsum("vij,vi->vj", axes.astype(np.float64), d)
    below = local[:, 2] < 0
    local[below, 2] = 0
    return local / np.linalg.norm(local, axis=1, keepdims=True)


def hats(M: int, w: np.ndarray) -> np.ndarray:
    """All tents (n, M^2) at directions above the horizon, the concentric map by its sectors of the disk."""
    r, phi = np.sqrt(np.maximum(1 - w[:, 2], 0)), np.arctan2(w[:, 1], w[:, 0])
    phi = np.where(phi < -np.pi / 4, phi + 2 * np.pi, phi)
    sector = np.clip(((phi + np.pi / 4) // (np.pi / 2)).astype(int), 0, 3)
    along = 4 / np.pi * (phi - sector * np.pi / 2) * r
    a = np.choose(sector, [r, -along, -r, along])
    b = np.choose(sector, [along, r, -along, -r])
    one = [np.maximum(0, 1 - np.abs((M - 1) * (x + 1)[:, None] / 2 - np.arange(M))) for x in (a, b)]
    return (one[1][:, :, None] * one[0][:, None, :]).reshape(len(w), M * M)


def tents_oracle(matrices: np.ndarray, light: np.ndarray, seen: dict) -> np.ndarray:
    """[LK03] eq. 9, every tent."""
    A, M = matrices.astype(np.float64), round(np.sqrt(matrices.shape[1]))
    rows = np.einsum("vt,vtcj->vcj", hats(M, local_views(seen)), A)
    return np.einsum("vcj,jc->vc", np.broadcast_to(rows, (V, 3, rows.shape[2])), light)


def tolerance(matrices: np.ndarray, light: np.ndarray, M: int) -> float:
    """What float32 may err, for random values of deviation 1 and light likewise.

    Positions on the square err by some 4e-7 of its side, M - 1 cells, of the difference of two tents' values,
    each of deviation |light|; sums of n^2 products by n^2 times 6e-8 of it. Three channels of V vertices
    reach four deviations.
    """
    spread = np.abs(matrices.astype(np.float64)).std() + np.abs(matrices.astype(np.float64)).mean()
    return 4 * spread * np.linalg.norm(light, axis=0).max() * (2 * 4e-7 * (M - 1) + 6e-8 * len(light) ** 0.5)


def assert_close(found: np.ndarray, expected: np.ndarray, atol: float) -> None:
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol)


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


def some_of(kind: str, channels: int) -> Tents | Compressed:
    if kind == "tents":
        return Tents(POINTS, FRAMES, random((V, 49, channels, 25), 31))
    if kind == "halves":
        return Tents(POINTS, FRAMES, random((V, 49, channels, 25), 32, np.float16))
    weights, components = random((V, 9), 33), random((3, 9, 49, channels, 25), 34)
    if kind == "compressed":
        return Compressed(POINTS, FRAMES, weights, components[0], K=6)
    return Compressed(POINTS, FRAMES, weights, components, np.arange(V) % 3, K=7)


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


# ---- The earlier methods


def band_matrix(R: np.ndarray, n: int) -> np.ndarray:
    """Local coefficients from global ones (n^2, n^2), by least squares at many directions."""
    w = sphere(400, 37)
    return np.linalg.lstsq(
        oracles.real_harmonics(n - 1, w), oracles.real_harmonics(n - 1, w @ R.T), rcond=None
    )[0]


def bilinear(samples: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Between samples (S, S, ...) from -1 to 1, columns along x."""
    S = len(samples)
    hat = [np.maximum(0, 1 - np.abs((S - 1) * (p + 1)[:, None] / 2 - np.arange(S))) for p in (x, y)]
    return np.einsum("vj,vi,jick->vck", hat[1], hat[0], samples.astype(np.float64), optimize=True)


def shadows(count: int, n: int, seed: int, dtype: type = np.float32) -> np.ndarray:
    return (np.eye(n * n) + 0.3 * random((count, n * n, n * n), seed)).astype(dtype)


@SEEN
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("way", ["stored rotation", "prerotated", "no shadows", "halves"])
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 7, 10])
def test_projection_is_row_times_rotation_times_transfer_times_light(n, way, channels, seen):
    S, count = 9, 37
    points, axes, samples = POINTS[:count], FRAMES[:count], random((S, S, channels, n * n), 38)
    T = None if way == "no shadows" else shadows(count, n, 39, np.float16 if way == "halves" else np.float32)
    light = random((n * n, 3), 40, np.float64)
    lighting = Projection(points, axes, samples, T, prerotated=way == "prerotated")
    w = local_views(seen, points, axes)
    b = bilinear(samples, w[:, 0] / (1 + w[:, 2]), w[:, 1] / (1 + w[:, 2]))
    R = np.array([band_matrix(frame.astype(float), n) for frame in axes])
    transferred = np.broadcast_to(light, (count, n * n, 3)) if T is None else T.astype(float) @ light
    expected = np.einsum("vcj,vjc->vc", np.broadcast_to(b, (count, 3, n * n)), R @ transferred)
    # Frames of float32 turn degree n by n 1e-7; sums of n^4 products
    assert_close(lighting.radiance(light, **seen), expected, 2e-6 * n * np.abs(expected).max() + 2e-6 * n * n)


@pytest.mark.parametrize("channels", [1, 3])
def test_a_material_in_tents_without_shadows_is_matrix_radiance_transfer(channels):
    """A_p = P R_p: nothing but frames is stored."""
    P, light, count = random((49, channels, 25), 41), random((25, 3), 42, np.float64), 60
    A = np.array([P @ band_matrix(frame.astype(float), 5) for frame in FRAMES[:count]])
    whole = Tents(POINTS[:count], FRAMES[:count], A).radiance(light, eye=EYE)
    found = Projection(POINTS[:count], FRAMES[:count], P).radiance(light, eye=EYE)
    assert_close(found, whole, 1e-5 * np.abs(whole).max())


def test_projection_nears_direct_evaluation_as_its_map_gets_finer():
    material, n, count = brdf.GGX(0.5), 4, 40
    T, light = shadows(count, n, 43), random((n * n, 3), 44, np.float64)
    points, axes = POINTS[:count], FRAMES[:count]
    w = local_views({"eye": EYE}, points, axes)
    above = w[:, 2] > 0.3
    R = np.array([band_matrix(frame.astype(float), n) for frame in axes])
    exact = np.einsum("vj,vjc->vc", material_rows(material, w, n), R @ (T.astype(float) @ light))
    errors = []
    for side in (9, 17, 33):
        lighting = Projection(points, axes, parabolic_map(material, n, side), T)
        found = lighting.radiance(light, eye=EYE)
        errors.append([oracles.relative_rms(found[which], exact[which]) for which in (above, ~above)])
    # Bilinear interpolation errs by the square of the step; at the horizon, where rows end, by the step
    assert sum(above) > 10
    assert max(errors[0]) < 0.1
    for coarse, fine in pairwise(errors):
        assert fine[0] < 0.35 * coarse[0]
        assert fine[1] < 0.65 * coarse[1]


@SEEN
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("axis", ["reflection", "normal"])
@pytest.mark.parametrize("shadowed", [False, True])
@pytest.mark.parametrize("n", [1, 3, 5, 10])
def test_convolution_scales_degrees_and_is_evaluated_at_the_axis(n, shadowed, axis, channels, seen):
    kernel, light = random((n, channels), 45, np.float64), random((n * n, 3), 46, np.float64)
    T = shadows(V, n, 47, np.float16) if shadowed else None
    found = Convolution(POINTS, FRAMES, kernel, T, axis=axis).radiance(light, **seen)
    local = local_views(seen) * [-1, -1, 1] if axis == "reflection" else np.array([[0.0, 0.0, 1.0]] * V)
    Y = oracles.real_harmonics(n - 1, np.einsum("vij,vj->vi", FRAMES.astype(float), local))
    degree = np.sqrt(np.arange(n * n)).astype(int)
    transferred = np.broadcast_to(light, (V, n * n, 3)) if T is None else T.astype(float) @ light
    expected = np.einsum("vj,jc,vjc->vc", Y, np.broadcast_to(kernel, (n, 3))[degree], transferred)
    # Gradients of degree n are n times the value, directions err by 3e-7
    assert_close(found, expected, 2e-6 * n * np.abs(expected).max())


def test_the_kernel_of_lambert_and_phong():
    """Lambert's is known, [RH01]: albedo times 1, 2/3, 1/4, 0, -1/24; Phong's by its integral."""
    expected = 0.7 * np.array([1, 2 / 3, 1 / 4, 0, -1 / 24])
    np.testing.assert_allclose(zonal_kernel(brdf.Lambert(0.7), 5)[:, 0], expected, atol=1e-6)
    s, x = 20.0, (np.arange(20000) + 0.5) / 20000
    for l, value in enumerate(zonal_kernel(brdf.Phong(s), 6)[:, 0]):
        legendre = np.polynomial.Legendre.basis(l)(x)
        assert value == pytest.approx(np.mean((s + 1) * x**s * legendre), abs=1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float16])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("n", [1, 3, 5, 8])
def test_diffuse_is_a_product_whatever_the_view(n, channels, dtype):
    rows, light = random((V, channels, n * n), 48, dtype), random((n * n, 3), 49, np.float64)
    lighting = Diffuse(rows)
    found = lighting.radiance(light)
    expected = np.einsum("vcj,jc->vc", np.broadcast_to(rows.astype(float), (V, 3, n * n)), light)
    assert_close(found, expected, 1e-6 * n * np.abs(expected).max())
    np.testing.assert_array_equal(lighting.radiance(light, eye=EYE), found)


# ---- All of them


def all_methods() -> dict:
    T, samples = shadows(V, 5, 50), random((17, 17, 1, 25), 51)
    tents = some_of("tents", 1)
    return {
        "tents": tents,
        "tents, halves, 3 channels": some_of("halves", 3),
        "compressed": some_of("compressed", 3),
        "clustered": some_of("clustered", 1),
        "fixed light": FixedLight(tents),
        "fixed view": FixedView(tents),
        "projection": Projection(POINTS, FRAMES, samples, T),
        "prerotated": Projection(POINTS, FRAMES, samples, T, prerotated=True),
        "projection, no shadows": Projection(POINTS, FRAMES, samples),
        "convolution": Convolution(POINTS, FRAMES, np.linspace(1, 0.2, 5), T),
        "convolution, no shadows": Convolution(POINTS, FRAMES, np.linspace(1, 0.2, 5)),
        "diffuse": Diffuse(random((V, 1, 25), 52)),
    }


METHODS = all_methods()
EACH = pytest.mark.parametrize("lighting", METHODS.values(), ids=METHODS.keys())


@EACH
def test_radiance_is_linear_in_the_light(lighting):
    one, two = random((2, 25, 3), 53, np.float64)
    found = [lighting.radiance(light, eye=EYE).astype(float) for light in (one, two, 0.3 * one - 2 * two)]
    assert_close(np.float32(0.3 * found[0] - 2 * found[1]), found[2], 1e-6 * np.abs(found[2]).max())


@EACH
def test_the_result_goes_where_it_is_wanted(lighting):
    light, out = random((25, 3), 54, np.float64), np.full((V, 3), np.nan, dtype=np.float32)
    assert lighting.radiance(light, view=VIEW, out=out) is out
    np.testing.assert_array_equal(out, lighting.radiance(light, view=VIEW))


@EACH
def test_calls_that_make_no_sense_are_refused(lighting):
    light = np.zeros((25, 3))
    for wrong, message in {
        "light": r"light must have the shape \(25, 3\), got \(16, 3\)",
        "eye": r"eye must have the shape \(3,\), got \(2,\)",
        "view": "view must be unit vectors",
        "both": "eye or view must be given, got both",
        "out": rf"out must have the shape \({V}, 3\)",
        "nan": "light must be finite",
        "far": "eye must be finite in float32, got 1e",
    }.items():
        arguments: dict = {"light": light, "eye": EYE}
        if wrong == "light":
            arguments["light"] = np.zeros((16, 3))
        elif wrong == "nan":
            arguments["light"] = np.full((25, 3), np.nan)
        elif wrong == "eye":
            arguments["eye"] = [0, 1]
        elif wrong == "far":
            arguments["eye"] = [0, 1e39, 0]
        elif wrong == "out":
            arguments["out"] = np.zeros((3, V), dtype=np.float32)
        else:
            arguments["view"] = [0, 0, 2]
        if wrong == "view":
            del arguments["eye"]
        if wrong == "both":
            arguments["view"] = VIEW
        with pytest.raises(ValueError, match=message):
            lighting.radiance(**arguments)


def test_an_eye_is_needed():
    with pytest.raises(ValueError, match="eye or view must be given, got neither"):
        METHODS["tents"].radiance(np.zeros((25, 3)))


BAD = {
    "vertices must have the shape": lambda: Tents(POINTS[:, :2], FRAMES, np.zeros((V, 9, 1, 4))),
    "vertices must be finite, got values that are not, the first in row 3": lambda: Tents(
        np.where(np.arange(V)[:, None] == 3, np.nan, POINTS), FRAMES, np.zeros((V, 9, 1, 4))
    ),
    "frames must have the shape": lambda: Tents(POINTS, FRAMES[1:], np.zeros((V, 9, 1, 4))),
    "frames must be rotations": lambda: Tents(POINTS, -FRAMES, np.zeros((V, 9, 1, 4))),
    r"matrices must have M\^2 tents, M in \[2, 33\], got 8": lambda: Tents(
        POINTS, FRAMES, np.zeros((V, 8, 1, 4))
    ),
    r"matrices must have n\^2 coefficients of light, n in \[1, 10\], got 5": lambda: Tents(
        POINTS, FRAMES, np.zeros((V, 9, 1, 5))
    ),
    "matrices must have 1 or 3 channels, got 2": lambda: Tents(POINTS, FRAMES, np.zeros((V, 9, 2, 4))),
    "matrices must have the shape": lambda: Tents(POINTS, FRAMES, np.zeros((V - 1, 9, 1, 4))),
    "matrices must be finite": lambda: Tents(POINTS, FRAMES, np.full((V, 9, 1, 4), np.inf)),
    "matrices must be finite, got values that are not, the first in row 0": lambda: Tents(
        POINTS, FRAMES, np.full((V, 9, 1, 4), 1e300)
    ),
    r"K must be in \[1, 4\], got 5": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((4, 9, 1, 4)), K=5
    ),
    "components must have the shape": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((3, 9, 1, 4))
    ),
    r"clusters must be in \[0, 2\), got 2 to 2": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((2, 4, 9, 1, 4)), np.full(V, 2)
    ),
    r"clusters must have the shape": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((2, 4, 9, 1, 4)), np.zeros(3, dtype=int)
    ),
    "transfer must have the shape": lambda: Projection(
        POINTS, FRAMES, np.zeros((8, 8, 1, 4)), np.zeros((V, 4, 9))
    ),
    "transfer must be given": lambda: Projection(POINTS, FRAMES, np.zeros((8, 8, 1, 4)), prerotated=True),
    "rows must have the shape": lambda: Projection(POINTS, FRAMES, np.zeros((8, 9, 1, 4))),
    "axis must be one of reflection, normal, got 'view'": lambda: Convolution(
        POINTS, FRAMES, np.ones(3), axis="view"
    ),
    "kernel must have 1 or 3 channels": lambda: Convolution(POINTS, FRAMES, np.ones((3, 2))),
    "brdf must have one lobe": lambda: zonal_kernel(brdf.GGX(0.3), 5),
}


@pytest.mark.parametrize("message", BAD.keys())
def test_bad_input_is_one_line_that_names_the_argument(message):
    with pytest.raises(ValueError, match=message) as caught:
        BAD[message]()
    assert "\n" not in str(caught.value)


def test_wrong_types_are_refused():
    with pytest.raises(TypeError, match="matrices must be an array of real numbers, got dtype complex128"):
        Tents(POINTS, FRAMES, np.zeros((V, 9, 1, 4), dtype=complex))
    with pytest.raises(TypeError, match="clusters must be an array of whole numbers"):
        Compressed(POINTS, FRAMES, np.zeros((V, 4)), np.zeros((2, 4, 9, 1, 4)), np.zeros(V))
    with pytest.raises(TypeError, match="of must be Tents or Compressed, got Diffuse"):
        FixedLight(METHODS["diffuse"])
    with pytest.raises(TypeError, match="brdf must be a material"):
        zonal_kernel("lambert", 5)
