"""Reflection maps: local against global, integration, look-ups, rotation, bad input."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shrm import Prefilter, _core, brdf, prefilter, sh
from shrm.environment import Environment, layouts
from shrm.prefiltered.explicit import three_dimensional_texture
from support import oracles
from support.light import band_limited_environment

EPS32 = float(np.finfo(np.float32).eps)


def random_light(F: int, P: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    rho = rng.normal(size=(F + 1, P + 1, P + 1, 3))
    l, p, q = np.meshgrid(np.arange(F + 1), np.arange(P + 1), np.arange(P + 1), indexing="ij")
    rho[q > np.minimum(l, p)] = 0
    return rng.normal(size=((F + 1) ** 2, 3)), rho


@pytest.mark.parametrize(
    ("F", "P", "H", "W"),
    [(7, 3, 12, 24), (2, 4, 9, 20), (0, 0, 4, 8), (5, 2, 8, 14), (20, 1, 6, 6), (30, 24, 4, 8)],
)
def test_local_and_global_form_agree(F, P, H, W):
    """Eq. 14 turned by eq. 8 is the band-limited global form, computed without either."""
    light, rho = random_light(F, P, seed=1)
    turned = _core.global_from_local(local=_core.local_reflection_map(light=light, rho=rho, H=H, W=W))
    coefficients = _core.global_coefficients(light=light, rho=rho)
    at_once = _core.synthesis(coefficients=coefficients.reshape(len(coefficients), -1), H=H, W=W)
    scale = np.abs(turned).max()
    np.testing.assert_allclose(at_once.reshape(turned.shape), turned, atol=1e-5 * scale)


def test_local_form_is_equation_14():
    """Against the sum itself, with the oracle's d^l_mq."""
    F, P, H, W = 4, 2, 5, 8
    light, rho = random_light(F, P, seed=2)
    L = oracles.complex_from_real(light, F)
    rings = _core.local_reflection_map(light=light, rho=rho, H=H, W=W)
    alpha = (np.arange(H) + 0.5) * np.pi / H
    beta = np.pi - 2 * np.pi * (np.arange(W) + 0.5) / W
    for p in range(P + 1):
        for q in range(p + 1):
            B = np.zeros((H, W, 3), complex)
            for l in range(q, F + 1):
                for m in range(-l, l + 1):
                    d = oracles.small_d(l, m, q, alpha)[:, None] * np.exp(1j * m * beta)
                    B += d[..., None] * L[l * (l + 1) + m] * rho[l, p, q]
            root = np.sqrt(2) if q else 1
            np.testing.assert_allclose(rings[:, p * (p + 1) + q].transpose(0, 2, 1), root * B.real, atol=2e-5)
            if q:
                np.testing.assert_allclose(
                    rings[:, p * (p + 1) - q].transpose(0, 2, 1), -root * B.imag, atol=2e-5
                )


def test_global_maps_are_band_limited():
    """The coefficients of B~_pq above degree F + p vanish."""
    F, P = 5, 3
    light, rho = random_light(F, P, seed=3)
    coefficients = _core.global_coefficients(light=light, rho=rho)
    assert coefficients.shape == ((F + P + 1) ** 2, (P + 1) ** 2, 3)
    for p in range(P + 1):
        maps = slice(p * p, (p + 1) ** 2)
        assert np.all(coefficients[(F + p + 1) ** 2 :, maps] == 0)


MATERIALS = [
    (brdf.Lambert(0.8), oracles.lambert(0.8), "normal", False),
    (brdf.Phong(12), oracles.phong(12), "normal", False),
    (brdf.Microfacet(0.3), oracles.microfacet(0.3), "normal", True),
    (brdf.GGX(0.4, f0=(0.9, 0.5, 0.2)), oracles.ggx(0.4, (0.9, 0.5, 0.2)), "normal", True),
    (brdf.Beckmann(0.5), oracles.beckmann(0.5), "normal", True),
    (brdf.KajiyaKay(8), oracles.kajiya_kay(8), "tangent", False),
    (brdf.Banks(0.1), oracles.banks(0.1), "tangent", False),
]
IDS = [m.name for m, *_ in MATERIALS]


@pytest.mark.parametrize(("material", "transfer", "frame", "horizon"), MATERIALS, ids=IDS)
def test_band_limited_light_and_a_large_P_equal_integration(material, transfer, frame, horizon):
    """What remains is the truncation in P, which falls; the light's degrees are all there."""
    F = 5
    env = band_limited_environment(F, seed=4)
    T, N, V = (
        oracles.random_hairs(60, seed=5) if frame == "tangent" else (None, *oracles.random_views(60, seed=5))
    )
    expected = oracles.reflected(env.pixels, transfer, N, V, T, frame=frame, hemisphere=horizon, subsamples=2)
    errors = []
    for P in (1, 4, 12):
        rm = prefilter(env, material, orders=(10, P), size=128)
        errors.append(oracles.relative_rms(rm.radiance(N, V, T), expected))
        if rm.parts[0].P == 0:
            break
    # a radial lobe keeps everything; the oracle's cosine edge crosses texels: midpoints of 1 / 128 of a row
    assert errors[-1] < 2e-3
    assert np.all(np.diff(errors) < 0)


def test_band_limited_light_and_brdf_equal_integration():
    """To 1e-5: a zonal transfer function of finite degree, q up to 1, integrated by an exact rule."""
    F, P = 4, 2
    env = band_limited_environment(F, seed=6)
    light = sh.analysis(env.pixels, F)
    _, rho = random_light(F, P, seed=7)
    coefficients = _core.global_coefficients(light=light, rho=rho)
    N, V = oracles.random_views(20, seed=8)
    R = 2 * np.sum(N * V, axis=1, keepdims=True) * N - V
    theta, w = np.polynomial.legendre.leggauss(24)
    x, weight = theta, w * 2 * np.pi / 48
    phi = 2 * np.pi * np.arange(48) / 48
    s = np.sqrt(1 - x**2)[:, None]
    nodes = np.stack([s * np.cos(phi), s * np.sin(phi), x[:, None] + 0 * phi], axis=-1).reshape(-1, 3)
    radiance = oracles.real_harmonics(F, nodes) @ light
    weights = np.repeat(weight, 48)
    frames = oracles.frames(R, V)  # z = R, V at azimuth 0
    Y_view = oracles.real_harmonics(P, V)
    for i in range(len(N)):
        local = nodes @ frames[i]
        theta_i, phi_i = np.arccos(local[:, 2]), np.arctan2(local[:, 1], local[:, 0])
        theta_o = np.arccos(V[i] @ R[i])
        rho_hat = np.zeros((len(nodes), 3))
        for l in range(F + 1):
            for p in range(P + 1):
                for q in range(min(l, p) + 1):
                    fl = oracles.special.sph_harm_y(l, q, theta_i, 0).real
                    fp = oracles.special.sph_harm_y(p, q, theta_o, 0).real
                    U = 1 if q == 0 else 2
                    rho_hat += U * (fl * fp * np.cos(q * phi_i))[:, None] * rho[l, p, q]
        expected = (weights[:, None] * radiance * rho_hat).sum(axis=0)
        at_R = _core.evaluate(
            coefficients=coefficients.reshape(len(coefficients), -1), directions=R[i : i + 1]
        )
        actual = Y_view[i] @ at_R.reshape((P + 1) ** 2, 3)
        np.testing.assert_allclose(actual, expected, atol=1e-5 * np.abs(expected).max())


def test_turning_light_and_geometry_together_changes_nothing():
    """Rotation equivariance in frequency space, to 1e-5; and of the resampled picture, within the error."""
    env = band_limited_environment(8, seed=11)
    R = Rotation.random(rng=np.random.default_rng(12)).as_matrix()
    N, V = oracles.random_views(100, seed=13)
    rm = prefilter(env, brdf.GGX(0.3), orders=(8, 4), size=192)
    part = rm.parts[0]
    turned = _core.global_coefficients(light=sh.rotate(part.light, R), rho=part.rho)
    both = sh.evaluate(turned.reshape(len(turned), -1), unit(N @ R.T))
    once = sh.evaluate(part.coefficients.reshape(len(turned), -1), unit(N))
    Y, Y_turned = (oracles.real_harmonics(part.P, v) for v in (V, unit(V @ R.T)))
    a = np.einsum("nz,nzc->nc", Y, once.reshape(len(N), -1, 3))
    b = np.einsum("nz,nzc->nc", Y_turned, both.reshape(len(N), -1, 3))
    np.testing.assert_allclose(b, a, atol=1e-5 * np.abs(a).max())


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def looked_up_one_by_one(rings: np.ndarray, C: np.ndarray, V: np.ndarray, bilinear: bool) -> np.ndarray:
    """Eq. 7 for P = 1, point after point, by Lagrange's formula, across poles and seam."""
    H, _, _, W = rings.shape
    k = np.sqrt(3 / (4 * np.pi))
    nodes = (0, 1) if bilinear else (-1, 0, 1, 2)
    out = np.zeros((len(C), 3))
    for n, (c, v) in enumerate(zip(C, V, strict=True)):
        Y = np.array([np.sqrt(1 / (4 * np.pi)), -k * v[1], k * v[2], -k * v[0]])
        row = np.arctan2(np.hypot(c[0], c[1]), c[2]) / np.pi * H - 0.5
        column = (np.pi - np.arctan2(c[1], c[0])) / (2 * np.pi) * W - 0.5
        i, j = int(np.floor(row)), int(np.floor(column))
        for a in nodes:
            wa = np.prod([(row - i - b) / (a - b) for b in nodes if b != a])
            r, turn = i + a, 0
            if r < 0 or r >= H:
                r, turn = (-1 - r if r < 0 else 2 * H - 1 - r), W // 2
            for b in nodes:
                wb = np.prod([(column - j - d) / (b - d) for d in nodes if d != b])
                out[n] += wa * wb * (Y @ rings[r, :, :, (j + b + turn) % W])
    return out


@pytest.mark.parametrize("bilinear", [False, True])
@pytest.mark.parametrize(("H", "n"), [(2, 200), (12, 3000), (64, 300)])
def test_look_ups_in_any_order_are_those_of_each_point(H, n, bilinear):
    """Few and many points to a texel, poles and seam among them; C the axis itself."""
    rng = np.random.default_rng(5)
    rings = rng.normal(size=(H, 4, 3, 2 * H)).astype(np.float32)
    C, V = (Rotation.random(n, rng=rng).apply([0, 0, 1.0]) for _ in range(2))
    C[:6] = [[0, 0, 1], [0, 0, -1], [-1, 0, 0], [-1, -0.0, 0], [1, 0, 0], [0, -1, 0]]
    C[6:60] = C[6:60] * [0.01, 0.01, 1]
    C[60:90] = C[60:90] * [1, 0.001, 1] * np.where(C[60:90, :1] > 0, -1, 1)
    C /= np.linalg.norm(C, axis=1, keepdims=True)
    looked_up = _core.look_up(rings=rings, cube=False, zonal=False, C=C, views=V, bilinear=bilinear)
    radiance = np.ones((n, 3), np.float32)  # sums are added to what is there
    _core.add_radiance(
        rings=rings,
        cube=False,
        zonal=False,
        center="tangent",
        gamma=np.zeros(0),
        axes=C,
        views=V,
        bilinear=bilinear,
        radiance=radiance,
    )
    np.testing.assert_allclose(radiance, 1 + looked_up, rtol=0, atol=64 * EPS32 * np.abs(rings).max())
    expected = 1 + looked_up_one_by_one(rings, C, V, bilinear)
    np.testing.assert_allclose(radiance, expected, rtol=0, atol=64 * EPS32 * np.abs(rings).max())


def test_look_ups_are_as_exact_as_the_grid_allows():
    """Cubic look-ups against the exact series: poles, seam, cube edges and corners included."""
    env = band_limited_environment(12, seed=14)
    N, V = oracles.random_views(500, seed=15)
    special_points = unit(
        np.array(
            [[0, 0, 1.0], [0, 0, -1], [-1, 1e-9, 0], [-1, -1e-9, 0], [1, 1, 1], [1, 0.999, -1], [1e-9, 0, -1]]
        )
    )
    N = np.concatenate([N, special_points])
    V = np.concatenate([V, special_points])  # seen head on: C = N
    for layout, size in (("latlong", 96), ("cube", 64)):
        rm = prefilter(env, brdf.GGX(0.3), orders=(12, 3), size=size, layout=layout)
        part = rm.parts[0]
        C = central(part, N, V)
        series = sh.evaluate(part.coefficients.reshape(len(part.coefficients), -1), C).reshape(len(N), -1, 3)
        exact = np.einsum("nz,nzc->nc", oracles.real_harmonics(part.P, V), series)
        cubic = oracles.relative_rms(rm.radiance(N, V), exact)
        linear = oracles.relative_rms(rm.radiance(N, V, interpolation="bilinear"), exact)
        assert cubic < 3e-4
        assert cubic < linear / 5
        np.testing.assert_allclose(rm.radiance(N[-7:], V[-7:]), exact[-7:], rtol=2e-3)


def central(part, N, V):
    """C, written again from its definition."""
    cosine = np.sum(N * V, axis=1, keepdims=True)
    across = V - cosine * N
    sine = np.linalg.norm(across, axis=1, keepdims=True)
    theta_v = np.arctan2(sine, cosine)[:, 0]
    gamma = np.interp(theta_v, np.linspace(0, np.pi / 2, len(part.gamma)), part.gamma)[:, None]
    return unit(np.cos(gamma) * N - np.sin(gamma) * across / np.maximum(sine, 1e-300))


@pytest.mark.parametrize("layout", ["latlong", "cube"])
@pytest.mark.parametrize(
    "material", [brdf.GGX(0.4).recentered("reflection"), brdf.Lambert(0.5), brdf.KajiyaKay(8)]
)
def test_the_dynamic_map_is_the_map_at_that_view(material, layout):
    """Eq. 12: its texels are the radiance at C = the texel's direction."""
    env = band_limited_environment(6, seed=16)
    rm = prefilter(env, material, orders=(6, 3), size=16, layout=layout)
    view = unit(np.array([[0.3, -0.5, 0.6]]))[0]
    dynamic = rm.at_view(view)
    C = rm.parts[0].directions()
    assert dynamic.shape == C.shape
    # texels at which C can be R (any), N or T: for R the normal is half way between
    axis = C.reshape(-1, 3)
    if material.lobes[0].center == "reflection":
        axis = axis + view
        axis = axis[np.linalg.norm(axis, axis=1) > 1e-2]
        keep = np.linalg.norm(C.reshape(-1, 3) + view, axis=1) > 1e-2
        axis = unit(axis)
    else:
        keep = np.ones(len(axis), bool)
    other = axis
    radiance = rm.radiance(other, view, tangents=axis)
    np.testing.assert_allclose(dynamic.reshape(-1, 3)[keep], radiance, atol=2e-5 * np.abs(radiance).max())


def test_several_centers_give_several_maps():
    env = band_limited_environment(4, seed=17)
    rm = prefilter(env, brdf.Lambert(0.5) + brdf.GGX(0.3) + 0.5 * brdf.GGX(0.6), orders=(4, 2), size=16)
    maps = rm.maps_at_view([0, 0, 1.0])
    assert set(maps) == {"normal", "lobe", "lobe 2"}
    assert (rm.F, rm.P) == (4, 2)
    one = prefilter(env, brdf.Lambert(0.5) + brdf.Lambert(0.2), orders=(4, 2), size=16)
    assert one.at_view([0, 0, 1.0]).shape == (16, 32, 3)


def test_a_sum_of_materials_reflects_the_sum():
    env = band_limited_environment(6, seed=18)
    N, V = oracles.random_views(50, seed=19)
    a, b = brdf.Lambert(0.5), brdf.GGX(0.3)
    options = {"orders": (6, 3), "size": 64}
    both = prefilter(env, a + 0.3 * b, **options).radiance(N, V)
    np.testing.assert_allclose(
        both,
        prefilter(env, a, **options).radiance(N, V) + 0.3 * prefilter(env, b, **options).radiance(N, V),
        rtol=1e-5,
    )


@pytest.mark.parametrize(
    "material", [brdf.Phong(8), brdf.GGX(0.3), brdf.GGX(0.3).recentered("reflection"), brdf.Lambert(1.0)]
)
def test_normals_turned_away_from_the_eye_are_continuous(material):
    """Interpolated normals go past the horizon; what is seen there follows on from what is seen before."""
    env = band_limited_environment(6, seed=20)
    rm = prefilter(env, material, orders=(6, 4), size=64)
    angle = np.pi / 2 + np.array([-2e-4, 2e-4])
    N = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    before, after = rm.radiance(N, [0, 0, 1.0])
    np.testing.assert_allclose(after, before, rtol=5e-3)


@pytest.mark.parametrize("center", ["lobe", "normal"])
def test_views_below_the_horizon_are_seen_as_at_the_horizon(center):
    """The fit over the views ends there: a series in the view must not be carried on beyond it."""
    env = band_limited_environment(6, seed=20)
    rm = prefilter(env, brdf.GGX(0.5), orders=(6, 8), size=64, center=center)
    below = np.array([[np.sin(a), 0, np.cos(a)] for a in np.radians([91, 100, 120, 150])])
    N = np.tile([0, 0, 1.0], (len(below), 1))
    at_horizon = rm.radiance(N, [1.0, 0, 0])
    np.testing.assert_allclose(rm.radiance(N, below), at_horizon, rtol=1e-5)


def test_black_light_reflects_nothing():
    rm = prefilter(Environment(np.zeros((16, 32, 3), np.float32)), brdf.GGX(0.2))
    N, V = oracles.random_views(5, seed=21)
    assert np.all(rm.radiance(N, V) == 0)
    assert rm.error == 0


def test_window_damps_and_is_counted_in_the_error():
    pixels = np.full((32, 64, 3), 0.1, np.float32)
    pixels[10, 20] = 500
    env = Environment(pixels)
    material = brdf.Phong(400)
    plain, windowed = (prefilter(env, material, orders=(16, 0), window=w, size=64) for w in (None, "hann"))
    assert plain.parts[0].maps.min() < 3 * min(windowed.parts[0].maps.min(), -1e-3)
    assert windowed.error > plain.error
    N, V = oracles.random_views(400, seed=22)
    clamped = prefilter(env, material, orders=(16, 0), clamp=True, size=64)
    assert clamped.radiance(N, V).min() == 0
    assert np.all(plain.at_view([0, 0, 1.0]).min() < clamped.at_view([0, 0, 1.0]).min())


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda rm: rm.radiance([[0, 0, 2.0]], [0, 0, 1.0]), "normals must be unit vectors"),
        (
            lambda rm: rm.radiance([[0, 0, 1.0]], [[0, 0, 1.0], [0, 0, 1.0]]),
            r"views must have the shape .*, got \(2, 3\)",
        ),
        (lambda rm: rm.radiance([[0, 0, 1.0]], [0, 0, np.nan]), "views must be finite"),
        (
            lambda rm: rm.radiance([[0, 0, 1.0]], [0, 0, 1.0], interpolation="nearest"),
            "interpolation must be one of",
        ),
        (lambda rm: rm.at_view([[1.0, 0], [0, 1]]), "view must have the shape"),
        (lambda rm: rm.at_view("up"), "view must be an array of real numbers"),
        (lambda rm: three_dimensional_texture(rm, 0), r"T must be in \[1, 4096\]"),
    ],
)
def test_bad_look_ups_are_named(call, text):
    rm = prefilter(Environment(np.ones((8, 16, 3), np.float32)), brdf.Lambert(1.0))
    with pytest.raises((ValueError, TypeError), match=text):
        call(rm)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"orders": (-1, 2)}, r"F must be in \[0, 1000\], got -1"),
        ({"orders": (4, 99)}, r"P must be in \[0, 24\], got 99"),
        ({"orders": 4}, r"orders must be a pair \(F, P\)"),
        ({"orders": (4.5, 1)}, "F must be a whole number"),
        ({"size": 7}, "size must be even, got 7"),
        ({"size": 1}, r"size must be in \[2, 8192\]"),
        ({"layout": "sphere"}, "layout must be one of latlong, cube"),
        ({"window": "box"}, "window must be one of hann, lanczos"),
        ({"tolerance": -1}, "tolerance must be"),
        ({"center": "tangent"}, "cannot be centered on the tangent"),
    ],
)
def test_bad_arguments_of_prefilter_are_named(arguments, text):
    env = Environment(np.ones((8, 16, 3), np.float32))
    with pytest.raises((ValueError, TypeError), match=text):
        prefilter(env, brdf.GGX(0.3), **arguments)


def test_a_lobe_about_the_tangent_needs_tangents():
    rm = prefilter(Environment(np.ones((8, 16, 3), np.float32)), brdf.KajiyaKay(8))
    with pytest.raises(ValueError, match="radiance needs tangents"):
        rm.radiance([[0, 0, 1.0]], [0, 0, 1.0])


def test_prefilter_wants_an_environment_and_a_material():
    with pytest.raises(TypeError, match="env must be an Environment, got ndarray"):
        prefilter(np.ones((8, 16, 3)), brdf.Lambert(1.0))
    with pytest.raises(TypeError, match=r"brdf must be a material of shrm\.brdf, got str"):
        prefilter(Environment(np.ones((8, 16, 3), np.float32)), "lambert")


def test_an_argument_that_there_is_not_is_refused_in_the_name_of_what_was_called():
    env = Environment(np.ones((8, 16, 3), np.float32))
    with pytest.raises(TypeError, match=r"^prefilter\(\) got an unexpected keyword argument 'method'"):
        prefilter(env, brdf.Lambert(1.0), method="angular")
    with pytest.raises(TypeError, match=r"^Prefilter.__init__\(\) got an unexpected keyword"):
        Prefilter(env, brdf.Lambert(1.0), views=2)


def test_cubes_have_the_faces_of_the_strip_layout():
    """One orientation of cube maps in the whole package."""
    rm = prefilter(Environment(np.ones((8, 16, 3), np.float32)), brdf.Lambert(1.0), size=6, layout="cube")
    expected = layouts.directions("strip", 36, 6).reshape(6, 6, 6, 3)
    np.testing.assert_allclose(rm.parts[0].directions(), expected, atol=1e-12)


@pytest.mark.parametrize("given", [{"orders": (900, 24)}, {"orders": (6, 8), "size": 8192}])
def test_maps_beyond_memory_are_refused_before_they_are_made(given):
    env = Environment(np.ones((4, 8, 3), dtype=np.float32))
    with pytest.raises(ValueError, match="GiB, over the limit"):
        prefilter(env, brdf.Microfacet(0.5), **given)
