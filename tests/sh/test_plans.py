"""Plans: the same transforms as the free functions, again and again, into the caller's arrays."""

import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from shrm import _core, sh
from shrm.environment import Environment
from support import oracles

EPS32 = float(np.finfo(np.float32).eps)

# One texel, one ring, one column; a ring folded in four (W even), with a texel on the fold (W % 4 == 2), or
# in two (W odd); rings in pairs, with one on the equator (H odd); whole vectors and what is left over.
SIZES = [
    (1, 1),
    (1, 2),
    (2, 1),
    (1, 64),
    (13, 1),
    (3, 5),
    (2, 6),
    (5, 10),
    (7, 14),
    (8, 16),
    (16, 34),
    (24, 48),
    (33, 65),
    (64, 70),
    (70, 67),
]
CHANNELS = (1, 2, 3, 4, 5, 6, 7, 48)


def degrees(H: int) -> tuple[int, ...]:
    """The smallest, one below a vector's worth, one above it, and one that H rows cannot resolve."""
    return (0, 1, 14, 17, H + 3)


def picture(H: int, W: int, channels: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(H, W, channels)).astype(np.float32)


def coefficients(F: int, channels: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=((F + 1) ** 2, channels))


@pytest.mark.parametrize(("H", "W"), SIZES)
def test_a_plan_gives_what_the_free_functions_give(H, W):
    """Bit for bit: tables that are kept hold the numbers that are otherwise made on the way."""
    for i, channels in enumerate(CHANNELS):
        F = degrees(H)[i % 5]
        x, c = picture(H, W, channels, seed=1), coefficients(F, channels, seed=2)
        plan = sh.Plan((H, W), F, channels)
        np.testing.assert_array_equal(plan.analysis(x), sh.analysis(x, F))
        np.testing.assert_array_equal(plan.synthesis(c).transpose(0, 2, 1), sh.synthesis(c, (H, W)))
        areas = sh.Plan((H, W), F, channels, areas=True)
        np.testing.assert_array_equal(areas.analysis(x), _core.analysis(pixels=x, F=F, areas=True))


@pytest.mark.parametrize(("H", "W"), [(2, 4), (9, 13), (32, 64), (31, 62)])
@pytest.mark.parametrize("F", [0, 3, 40])
def test_areas_are_those_of_the_environment(H, W, F):
    env = Environment(picture(H, W, 3, seed=3))
    np.testing.assert_array_equal(sh.Plan((H, W), F, areas=True).analysis(env.pixels), env.coefficients(F))


def fejer_weights(H: int) -> np.ndarray:
    """Fejer's first rule from its definition: exact for cos(k theta), k < H."""
    theta = (np.arange(H) + 0.5) * np.pi / H
    k = np.arange(H)[:, None]
    integrals = np.where(k % 2 == 0, 2 / (1 - k.astype(float) ** 2 + (k == 1)), 0.0)[:, 0]
    return np.linalg.solve(np.cos(k * theta), integrals)


@pytest.mark.parametrize(("H", "W"), SIZES)
def test_a_plan_agrees_with_plain_sums(H, W):
    """Against the matrix of all Y_lm at all texels, which shares no code."""
    for i, channels in enumerate(CHANNELS):
        F = (0, 1, 9, 12, min(H + 3, 15))[i % 5]
        Y = oracles.real_harmonics(F, oracles.directions(H, W).reshape(-1, 3))
        plan = sh.Plan((H, W), F, channels)
        x, c = picture(H, W, channels, seed=4), coefficients(F, channels, seed=5)

        weight = np.repeat(fejer_weights(H), W)[:, None] * (2 * np.pi / W)
        terms = weight * x.reshape(-1, channels)
        # A float32 sum of n terms errs as the root of n, relative to the sum of their sizes; the table and
        # the Legendre sum add a few roundings more. |Y_lm| <= sqrt((2l+1) / 4 pi).
        l = np.floor(np.sqrt(np.arange((F + 1) ** 2)))
        largest = np.sqrt((2 * l + 1) / (4 * np.pi))[:, None] * np.abs(terms).sum(axis=0)
        bound = (4 + np.sqrt(H * W)) * EPS32 * largest
        assert np.all(np.abs(plan.analysis(x) - Y.T @ terms) <= bound)

        values = plan.synthesis(c).transpose(0, 2, 1).reshape(-1, channels)
        bound = (4 + F + 1) * EPS32 * np.linalg.norm(Y, axis=1)[:, None] * np.linalg.norm(c, axis=0)
        assert np.all(np.abs(values - Y @ c) <= bound)


@pytest.mark.parametrize(("H", "W", "F", "channels"), [(33, 34, 20, 3), (16, 32, 40, 7), (6, 65, 5, 1)])
def test_repeated_use_gives_the_same_bit_for_bit(H, W, F, channels):
    """Nothing of one picture is left for the next, not even of one that is refused."""
    plan = sh.Plan((H, W), F, channels)
    x, c = picture(H, W, channels, seed=6), coefficients(F, channels, seed=7)
    first, maps = plan.analysis(x).copy(), plan.synthesis(c).copy()
    plan.analysis(picture(H, W, channels, seed=8))
    plan.synthesis(coefficients(F, channels, seed=9))
    broken = x.copy()
    broken[H // 2, W // 2] = np.nan
    with pytest.raises(ValueError, match="pixels must be finite"):
        plan.analysis(broken)
    np.testing.assert_array_equal(plan.analysis(x), first)
    np.testing.assert_array_equal(plan.synthesis(c), maps)


def test_out_is_filled_and_returned():
    plan = sh.Plan((12, 26), 7, 5)
    x, c = picture(12, 26, 5, seed=10), coefficients(7, 5, seed=11)
    out = np.full((64, 5), np.nan)
    assert plan.analysis(x, out=out) is out
    np.testing.assert_array_equal(out, plan.analysis(x))
    rings = np.full((12, 5, 26), np.nan, dtype=np.float32)
    assert plan.synthesis(c, out=rings) is rings
    np.testing.assert_array_equal(rings, plan.synthesis(c))


@pytest.mark.parametrize("areas", [False, True])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_one_texel_that_is_not_finite_is_found_anywhere(areas, value):
    H, W = 5, 11
    plan = sh.Plan((H, W), 3, 2, areas=areas)
    for i, j in [(0, 0), (2, 5), (4, 10), (1, 7), (3, 3)]:
        for channel in (0, 1):
            x = picture(H, W, 2, seed=12)
            x[i, j, channel] = value
            with pytest.raises(ValueError, match="pixels must be finite"):
                plan.analysis(x)


PLAN = sh.Plan((6, 12), 2, 3)
PIXELS, COEFFICIENTS = np.zeros((6, 12, 3), np.float32), np.zeros((9, 3))
READ_ONLY = np.zeros((9, 3))
READ_ONLY.flags.writeable = False
UNALIGNED = np.frombuffer(bytearray(6 * 12 * 3 * 4 + 1), np.uint8)[1:].view(np.float32).reshape(6, 12, 3)


@pytest.mark.parametrize(
    ("call", "kind", "text"),
    [
        (
            lambda: PLAN.analysis(PIXELS.astype(float)),
            TypeError,
            "pixels must be an array of float32, got fl",
        ),
        (
            lambda: PLAN.analysis(PIXELS.astype(">f4")),
            TypeError,
            "pixels must be an array of float32, got >f4",
        ),
        (lambda: PLAN.analysis([[1.0]]), TypeError, "pixels must be an array of float32, got list"),
        (lambda: PLAN.analysis(np.ma.masked_array(PIXELS)), TypeError, "pixels must be a plain array"),
        (
            lambda: PLAN.analysis(PIXELS[:5]),
            ValueError,
            r"pixels must have the shape \(6, 12, 3\), got \(5, 12",
        ),
        (lambda: PLAN.analysis(PIXELS[..., 0]), ValueError, r"pixels must have the shape .* got \(6, 12\)"),
        (
            lambda: PLAN.analysis(np.asfortranarray(PIXELS)),
            ValueError,
            "pixels must be contiguous in C order",
        ),
        (lambda: PLAN.analysis(PIXELS[:, ::-1]), ValueError, "pixels must be contiguous in C order"),
        (lambda: PLAN.analysis(UNALIGNED), ValueError, "pixels must be contiguous in C order"),
        (lambda: PLAN.analysis(PIXELS + np.nan), ValueError, "pixels must be finite"),
        (
            lambda: PLAN.analysis(PIXELS + np.float32(3e38)),
            ValueError,
            "pixels must have sums that are finite",
        ),
        (lambda: PLAN.analysis(PIXELS, PIXELS), TypeError, "out must be an array of float64, got float32"),
        (lambda: PLAN.analysis(PIXELS, READ_ONLY), ValueError, "out must be writeable"),
        (lambda: PLAN.analysis(PIXELS, COEFFICIENTS.T), ValueError, r"out must have the shape \(9, 3\)"),
        (lambda: PLAN.analysis(PIXELS, np.zeros((3, 9)).T), ValueError, "out must be contiguous in C order"),
        (lambda: PLAN.synthesis(PIXELS), TypeError, "coefficients must be an array of float64, got float32"),
        (lambda: PLAN.synthesis(np.zeros((10, 3))), ValueError, r"coefficients must have the shape \(9, 3\)"),
        (
            lambda: PLAN.synthesis(np.zeros((3, 9)).T),
            ValueError,
            "coefficients must be contiguous in C order",
        ),
        (lambda: PLAN.synthesis(COEFFICIENTS + np.inf), ValueError, "coefficients must be finite"),
        (lambda: PLAN.synthesis(COEFFICIENTS, PIXELS), ValueError, r"out must have the shape \(6, 3, 12\)"),
        (lambda: PLAN.synthesis(COEFFICIENTS, COEFFICIENTS), TypeError, "out must be an array of float32"),
        (lambda: sh.Plan((0, 12), 2), ValueError, r"shape\[0\] must be in \[1, 65536\], got 0"),
        (lambda: sh.Plan((6, 12.0), 2), TypeError, r"shape\[1\] must be a whole number, got 12.0"),
        (lambda: sh.Plan((6, 12), 1001), ValueError, r"F must be in \[0, 1000\], got 1001"),
        (lambda: sh.Plan((6, 12), 2, 0), ValueError, r"channels must be in \[1, 4096\], got 0"),
        (lambda: sh.Plan((6, 12), 2, areas=1), TypeError, "areas must be True or False, got 1"),
    ],
)
def test_bad_input_is_named(call, kind, text):
    with pytest.raises(kind, match=text):
        call()


def test_the_core_names_its_arguments_too():
    plan = _core.Analysis(H=6, W=12, channels=3, F=2, areas=False)
    with pytest.raises(ValueError, match=r"pixels must have the shape \(6, 12, 3\), got \(5, 12, 3\)"):
        plan.run(PIXELS[:5].copy(), COEFFICIENTS)
    with pytest.raises(ValueError, match=r"coefficients must have the shape \(9, 3\), got \(8, 3\)"):
        plan.run(PIXELS, np.zeros((8, 3)))
    with pytest.raises(TypeError):
        plan.run(PIXELS, COEFFICIENTS.astype(np.float32))
    rings = np.zeros((6, 3, 12), np.float32)
    with pytest.raises(ValueError, match="rings must have the shape"):
        _core.Synthesis(H=6, W=12, channels=3, F=2).run(COEFFICIENTS, rings[:5].copy())
    with pytest.raises(ValueError, match="F must be at least 0, got -1"):
        _core.CubeSynthesis(N=2, channels=3, F=-1)
    with pytest.raises(ValueError, match="N must be even, got 3"):
        _core.CubeSynthesis(N=3, channels=3, F=1)
    product = _core.MapCoefficients(F=2, P=1, channels=3, zonal=False)
    with pytest.raises(ValueError, match="light must have the shape"):
        product.run(np.zeros((4, 3)), np.zeros((16, 4, 3)))
    with pytest.raises(ValueError, match="coefficients must have the shape"):
        product.run(COEFFICIENTS, np.zeros((9, 4, 3)))


def test_threads_may_share_a_plan():
    """Each waits for its turn; four callers, first calls included, and both directions at once."""
    plan = sh.Plan((33, 70), 15)
    pictures = [picture(33, 70, 3, seed) for seed in range(4)]
    alone = [sh.analysis(x, 15) for x in pictures]
    maps = [sh.synthesis(c, (33, 70)).transpose(0, 2, 1) for c in alone]

    def work(k: int) -> None:
        for _ in range(20):
            c = plan.analysis(pictures[k])
            np.testing.assert_array_equal(c, alone[k])
            np.testing.assert_array_equal(plan.synthesis(c), maps[k])

    with ThreadPoolExecutor(4) as threads:
        for done in [threads.submit(work, k) for k in range(4)]:
            done.result()


def test_the_steady_state_allocates_no_arrays():
    H, W, F = 128, 256, 20
    plan = sh.Plan((H, W), F)
    x, c = picture(H, W, 3, seed=13), np.empty(((F + 1) ** 2, 3))
    rings = np.empty((H, 3, W), dtype=np.float32)
    plan.synthesis(plan.analysis(x, out=c), out=rings)
    tracemalloc.start()
    try:
        for _ in range(3):
            plan.synthesis(plan.analysis(x, out=c), out=rings)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < c.nbytes < x.nbytes / 20  # a byte for each coefficient: whether it is finite
