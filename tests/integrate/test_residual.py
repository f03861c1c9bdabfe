"""Cores of sharp lobes beside the maps: both together are the lobe, and the error is as predicted."""

import pickle
import warnings
from dataclasses import replace

import numpy as np
import pytest
from shrm import Environment, Prefilter, ReflectionMap, ToleranceWarning, brdf, image_io, prefilter
from shrm.brdf.lobe import IsotropicLobe, RadialLobe
from shrm.environment.layouts import directions
from shrm.frequency.orders import choose
from shrm.integrate.angular import integrate
from shrm.lobes.split import split
from shrm.prefiltered import explicit
from shrm_papers.rh02 import fits
from support import oracles
from support.data import environment, require
from support.directions import hemisphere

SMALL = {"F_max": 16, "P_max": 4, "residual": "auto"}
SHARP = [brdf.GGX(0.05), brdf.Phong(5000)]


@pytest.fixture(scope="module")
def env() -> Environment:
    """A small picture of bright and dark texels."""
    pixels = np.random.default_rng(3).random((24, 48, 3)) ** 4
    return Environment(pixels.astype(np.float32))


@pytest.fixture(scope="module")
def chrome(env) -> ReflectionMap:
    return prefilter(env, brdf.GGX(0.05, f0=(0.9, 0.8, 0.5)), **SMALL)


def fit(source: str, name: str) -> brdf.BRDF:
    found = fits.read(require("brdf/merl_abc_low2012.json").parent)
    return next(materials[name] for title, materials in found.items() if source in title)


@pytest.mark.parametrize("height", [1e-3, 1.0, 50.0])
def test_the_parts_of_a_lobe_sum_to_it_and_none_is_negative(height):
    wi, wo = hemisphere(2000, 1), hemisphere(2000, 2)
    mirrored = wo * [-1.0, -1.0, 1.0] + 0.01 * wi  # about the highlight
    wi[::2] = (mirrored / np.linalg.norm(mirrored, axis=1, keepdims=True))[::2]
    for material in (brdf.GGX(0.05, f0=(1.0, 0.5, 0.1)), brdf.Phong(5000)):
        (lobe,) = material.lobes
        smooth, core = (part.transfer(wi, wo) for part in split(lobe, height))
        whole = lobe.transfer(wi, wo)
        assert smooth.min() >= 0
        assert core.min() >= 0
        np.testing.assert_allclose(smooth + core, whole, rtol=1e-14)
        assert smooth.reshape(len(wi), -1).mean(axis=1).max() <= height


def test_equal_splits_are_equal():
    """What is kept for a lobe, such as its center, is found again."""
    (lobe,) = brdf.GGX(0.1).lobes
    assert split(lobe, 2.0) == split(lobe, 2.0)
    assert hash(split(lobe, 2.0)[0].function) == hash(split(lobe, 2.0)[0].function)
    assert split(lobe, 2.0) != split(lobe, 3.0)
    assert [type(part) for part in split(lobe, 2.0)] == [IsotropicLobe] * 2
    assert [type(part) for part in split(brdf.Phong(9).lobes[0], 2.0)] == [RadialLobe] * 2


@pytest.mark.slow
def test_there_is_no_residual_where_none_is_needed(env):
    for material in (brdf.Lambert(0.5), brdf.GGX(0.3), brdf.Lambert(0.5) + brdf.GGX(0.3), brdf.KajiyaKay(8)):
        plain, auto = (prefilter(env, material, tolerance=0.1, residual=how) for how in (None, "auto"))
        assert auto.residual is None
        assert (auto.error, auto.size) == (plain.error, plain.size)
        for mine, theirs in zip(auto.parts, plain.parts, strict=True):
            np.testing.assert_array_equal(mine.rings, theirs.rings)
    rm = prefilter(env, brdf.Lambert(0.5) + brdf.GGX(0.05), **SMALL)
    assert [name for name, _ in rm.residual.cores] == ["lobe"]  # the diffuse lobe has none


def test_a_lobe_about_the_tangent_stays_whole_and_says_so(env):
    with pytest.warns(ToleranceWarning, match="not met with a residual"):
        rm = prefilter(env, brdf.KajiyaKay(200), **SMALL)
    assert rm.residual is None


def frames_of(light: Environment, n: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normals and views, and the weights that make a mean over them one over all frames.

    The mirrored view is where light is bright, or near that, as often as anywhere else: errors of a few
    bright frames are most of an RMS. cos^2(theta_v) has 20 values, evenly spaced.
    """
    H, W, _ = light.pixels.shape
    random = np.random.default_rng(seed)
    edges = np.cos(np.pi * np.arange(H + 1) / H)
    area = np.broadcast_to((edges[:-1] - edges[1:])[:, None] / (2 * W), (H, W))
    energy = area * (light.pixels.astype(np.float64) ** 2).sum(axis=2)
    near = sum(np.roll(energy, (0, k), axis=(0, 1)) for k in range(-3, 4))
    near = sum(np.pad(near, ((3, 3), (0, 0)))[k : k + H] for k in range(7))
    chance = 0.4 * area + 0.3 * energy / energy.sum() + 0.3 * near / near.sum()
    drawn = random.choice(H * W, n, p=chance.ravel() / chance.sum())
    i, j = np.divmod(drawn, W)
    z = edges[i + 1] + (edges[i] - edges[i + 1]) * random.random(n)
    phi = np.pi - 2 * np.pi * (j + random.random(n)) / W
    R = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)
    cosine = np.sqrt((random.permutation(n) % 20 + 0.5) / 20)[:, None]
    across = np.cross(R, random.normal(size=(n, 3)))
    N = cosine * R + np.sqrt(1 - cosine**2) * across / np.linalg.norm(across, axis=1, keepdims=True)
    return N, 2 * cosine * N - R, (area / chance).ravel()[drawn]


def exact_radiance(light: Environment, material: brdf.BRDF, N, V, cut: int) -> np.ndarray:
    """The plain sum, with 16 cut x 16 cut nodes in the texels within 12 degrees of the mirrored view."""
    C = directions("latlong", *light.pixels.shape[:2])
    result = np.zeros((len(N), 3))
    for k, (n, v) in enumerate(zip(N, V, strict=True)):
        near = (C @ (2 * (n @ v) * n - v) > np.cos(np.radians(12)))[..., None]
        about = np.where(near, light.pixels, 0).repeat(cut, axis=0).repeat(cut, axis=1)
        for pixels, subsamples in ((about, 16), (np.where(near, 0, light.pixels), 2)):
            result[k] += integrate(Environment(pixels), material, n[None], v[None], subsamples=subsamples)[0]
    return result


GRACE, VENICE = "debevec_grace_cross.hdr", "venice_sunset_1k.hdr"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "cut", "name"),
    [
        (brdf.GGX(0.02), 1, GRACE),
        (brdf.GGX(0.02), 1, VENICE),
        (brdf.GGX(0.05, f0=(0.9, 0.8, 0.5)), 1, VENICE),
        (brdf.Beckmann(0.03), 1, GRACE),
        (0.5 * brdf.Lambert(1.0) + 0.3 * brdf.GGX(0.05), 1, GRACE),
        (brdf.Phong(5000), 1, GRACE),
        (brdf.Phong(5000), 1, VENICE),
        (("Löw", "chrome-steel"), 2, VENICE),
        (("Löw", "nickel"), 1, GRACE),
        (("Bagher", "alum-bronze"), 1, VENICE),
    ],
    ids=str,
)
def test_the_error_is_as_predicted_and_within_the_tolerance(material, cut, name):
    """Against the plain sum over nodes in the texels, at orders that alone miss the tolerance by far."""
    light = environment(name, 48, 96)
    if isinstance(material, tuple):
        material = fit(*material)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ToleranceWarning)
        rm = prefilter(light, material, tolerance=0.05, **SMALL)
    assert rm.residual is not None
    assert rm.error <= 0.055  # the tolerance, and what interpolation adds
    N, V, weight = frames_of(light, 160, seed=4)
    exact = exact_radiance(light, material, N, V, cut)
    measured = oracles.relative_rms(rm.radiance(N, V), exact, weight)
    assert measured <= 1.25 * rm.error + 1e-4
    with pytest.warns(ToleranceWarning):
        alone = prefilter(light, material, tolerance=0.05, F_max=16, P_max=4)
    assert oracles.relative_rms(alone.radiance(N, V), exact, weight) > 2 * measured


@pytest.mark.slow
@pytest.mark.parametrize("material", SHARP, ids=str)
def test_given_orders_meet_the_tolerance_too(env, material):
    for tolerance in (0.1, 0.03):
        rm = prefilter(env, material, orders=(10, 2), tolerance=tolerance, residual="auto")
        assert (rm.F, rm.residual is None) == (10, False)
        assert rm.error <= 1.1 * tolerance
    chosen = choose(env, brdf.GGX(0.5), tolerance=0.1)
    assert (
        prefilter(env, brdf.GGX(0.5), orders=(chosen.F, chosen.P), tolerance=0.1, residual="auto").residual
        is None
    )


@pytest.mark.parametrize("material", SHARP, ids=str)
def test_a_white_furnace_gives_the_directional_albedo(material):
    """Within the predicted error; descent in constant light sums the lobe's table at points."""
    white = Environment(np.ones((32, 64, 3), np.float32))
    rm = prefilter(white, material, tolerance=0.02, orders=(4, 2), residual="auto")
    levels = np.sqrt((np.arange(20) + 0.5) / 20)
    N, V = oracles.random_views(400, seed=5)
    across = V - np.sum(N * V, axis=1, keepdims=True) * N
    cosine = np.tile(levels, 20)[:, None]
    V = cosine * N + np.sqrt(1 - cosine**2) * across / np.linalg.norm(across, axis=1, keepdims=True)
    expected = np.tile(brdf.directional_albedo(material, levels)[:, 0], 20)
    assert oracles.relative_rms(rm.radiance(N, V)[:, 0], expected) <= 1.25 * rm.error + 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("material", [0.7 * brdf.GGX(1e-4), 0.7 * brdf.Phong(1e7)], ids=["ggx", "phong"])
def test_what_is_narrower_than_texels_can_be_cut_is_looked_up(material):
    """A mirror: the texel in its direction, times the albedo."""
    H = 64
    rows = 1.5 + np.sin(6 * np.cos(np.pi * (np.arange(H) + 0.5) / H))
    light = Environment(np.ascontiguousarray(np.broadcast_to(rows[:, None, None], (H, 2 * H, 3)), np.float32))
    rm = prefilter(light, material, orders=(2, 1), residual="auto")
    ((_, core),) = rm.residual.cores
    assert core.look_up is not None
    N, V = oracles.random_views(300, seed=6)
    R = 2 * np.sum(N * V, axis=1, keepdims=True) * N - V
    expected = 0.7 * rows[(np.arccos(R[:, 2]) * H / np.pi).astype(int)]
    assert oracles.relative_rms(rm.radiance(N, V)[:, 0], expected) <= 1.25 * rm.error + 1e-4


@pytest.mark.slow
def test_maps_for_a_view_hold_the_residual(chrome):
    view = [0.0, 0.6, 0.8]
    pixels = chrome.at_view(view)
    alone = replace(chrome, residual=None).at_view(view)
    np.testing.assert_allclose(pixels, alone + chrome.residual.maps_at_view(view)["lobe"], rtol=1e-6)
    # Texels are what radiance is at their central direction: about the lobe, the normal that has it.
    part = chrome.parts[0]
    N, _ = oracles.random_views(500, seed=7)
    N = N[N @ view > 0.2]
    gamma = np.interp(np.arccos(N @ view), np.linspace(0, np.pi / 2, len(part.gamma)), part.gamma)[:, None]
    across = view - (N @ view)[:, None] * N
    C = np.cos(gamma) * N - np.sin(gamma) * across / np.linalg.norm(across, axis=1, keepdims=True)
    H, W, _ = pixels.shape
    row = (np.arccos(C[:, 2]) * H / np.pi).astype(int)
    column = ((np.pi - np.arctan2(C[:, 1], C[:, 0])) * W / (2 * np.pi)).astype(int) % W
    looked_up = pixels[row, column]
    assert oracles.relative_rms(looked_up, chrome.radiance(N, view)) < 0.25  # the nearest of 1.4 degrees


@pytest.mark.slow
@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_a_saved_map_has_its_residual(env, layout, tmp_path):
    material = 0.5 * brdf.Lambert(0.4) + brdf.GGX(0.05, f0=(1.0, 0.7, 0.2)) + brdf.Phong(4000)
    rm = prefilter(env, material, layout=layout, size=12, **SMALL)
    assert len(rm.residual.cores) == 2
    rm.save(tmp_path / "map.exr")
    back = ReflectionMap.load(tmp_path / "map.exr")
    N, V = oracles.random_views(300, seed=8)
    for mine, theirs in ((rm, back), (rm, pickle.loads(pickle.dumps(rm)))):
        assert theirs.error == mine.error
        np.testing.assert_array_equal(theirs.radiance(N, V), mine.radiance(N, V))
        for name, pixels in mine.maps_at_view([0, 0, 1]).items():
            np.testing.assert_array_equal(theirs.maps_at_view([0, 0, 1])[name], pixels)


@pytest.mark.slow
def test_files_of_version_2_are_read(env, tmp_path):
    """They called the table of gamma of a core `centre`."""
    rm = prefilter(env, brdf.GGX(0.05), size=16, **SMALL)
    rm.save(tmp_path / "new.exr")
    first, *others = image_io.read_parts(tmp_path / "new.exr")
    assert any(part.name == "residual.0.gamma" for part in others)
    old = [replace(part, name=part.name.replace("residual.0.gamma", "residual.0.centre")) for part in others]
    first = replace(first, metadata={**first.metadata, "shrm:version": 2})
    image_io.write_parts(tmp_path / "old.exr", [first, *old])
    N, V = oracles.random_views(50, seed=8)
    new, old_map = (ReflectionMap.load(tmp_path / f"{name}.exr") for name in ("new", "old"))
    np.testing.assert_array_equal(old_map.radiance(N, V), new.radiance(N, V))


@pytest.mark.slow
def test_a_core_that_is_missing_or_damaged_is_no_whole_map(env, tmp_path):
    prefilter(env, brdf.GGX(0.05), size=16, **SMALL).save(tmp_path / "map.exr")
    parts = image_io.read_parts(tmp_path / "map.exr")
    for k, part in enumerate(parts):
        if not part.name.startswith("residual"):
            continue
        for others in (
            parts[:k] + parts[k + 1 :],
            [*parts[:k], replace(part, pixels=part.pixels[:1, :1]), *parts[k + 1 :]],
            [*parts[:k], replace(part, pixels=part.pixels * np.nan), *parts[k + 1 :]],
        ):
            image_io.write_parts(tmp_path / "bad.exr", others)
            with pytest.raises(ValueError, match=r"bad\.exr.*damaged") as fault:
                ReflectionMap.load(tmp_path / "bad.exr")
            assert "\n" not in str(fault.value)
    light = next(part for part in parts if part.name == "residual.light")
    for key, value in (
        ("shrm:cut", "-1"),
        ("shrm:cores", "2"),
        ("shrm:0.map", "normal"),
        ("shrm:0.threshold", "nan"),
        ("shrm:0.width", "x"),
        ("shrm:0.looked up", "1"),
    ):
        changed = replace(light, metadata={**light.metadata, key: value})
        image_io.write_parts(tmp_path / "bad.exr", [changed if part is light else part for part in parts])
        with pytest.raises(ValueError, match=r"bad\.exr.*damaged"):
            ReflectionMap.load(tmp_path / "bad.exr")


@pytest.mark.slow
def test_relighting_follows_light_and_turns(env):
    material = brdf.GGX(0.05)
    relit = Prefilter(env, material, size=32, **SMALL)
    N, V = oracles.random_views(300, seed=9)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # by whole texels
    turned = relit.update(rotation=turn)
    np.testing.assert_allclose(
        turned.residual.radiance(N, V), relit.update(rotation=np.eye(3)).residual.radiance(N @ turn, V @ turn)
    )
    other = Environment(np.ascontiguousarray(env.pixels[:, ::-1]))
    exact = integrate(other, material, N, V, subsamples=8)
    rm = relit.update(other)
    assert oracles.relative_rms(rm.radiance(N, V), exact) <= 1.25 * rm.error + 1e-4
    with pytest.raises(ValueError, match="residual"):
        relit.update(brdf=brdf.GGX(0.06))


@pytest.mark.slow
def test_the_same_twice(env, chrome):
    again = prefilter(env, brdf.GGX(0.05, f0=(0.9, 0.8, 0.5)), **SMALL)
    N, V = oracles.random_views(200, seed=10)
    np.testing.assert_array_equal(again.radiance(N, V), chrome.radiance(N, V))
    assert again.error == chrome.error
    np.testing.assert_array_equal(chrome.radiance(N, V[0]), chrome.radiance(N, np.tile(V[0], (200, 1))))


@pytest.mark.slow
def test_what_cannot_hold_a_residual_says_so(env):
    chrome = prefilter(env, brdf.GGX(0.05), size=12, **SMALL)
    for lose in (explicit.without_azimuth, lambda rm: explicit.three_dimensional_texture(rm, 4)):
        with pytest.raises(ValueError, match="residual"):
            lose(chrome)
    views = explicit.grid_views(3)
    whole = explicit.reflection_maps(chrome, 3)
    np.testing.assert_allclose(whole[1, 2], chrome.at_view(views[1, 2]), rtol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"residual": "mirror"}, "residual must be"),
        ({"residual": True}, "residual must be"),
        ({"residual": "auto", "criterion": "brdf"}, "residual='auto' is for criterion='light'"),
        ({"residual": "auto", "window": "hann"}, "without a window"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(env, arguments, text):
    with pytest.raises((TypeError, ValueError), match=text) as fault:
        prefilter(env, brdf.GGX(0.1), **arguments)
    assert "\n" not in str(fault.value)
