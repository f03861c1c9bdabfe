"""Prefiltering by OpenGL, on every way to it without a display, against sums over all texels."""

from collections.abc import Iterator
from functools import cache
from types import SimpleNamespace

import moderngl
import numpy as np
import pytest
from shrm import Environment, brdf, prefilter_angular
from shrm.environment import layouts
from shrm.environment.paraboloid import face_directions
from shrm.prefiltered import Prefiltered
from shrm.prefiltered import prefilter as prefilter_explicit
from shrm.viewer import Context, ContextError, HardwarePrefilter, offscreen
from shrm.viewer.gpu.paraboloid_textures import Faces
from support import opengl, oracles
from support.directions import sphere
from support.light import band_limited_environment

FILTERS = ("exact", "two-pass", "one-pass")
SIZE, BORDER = 64, 8
SMOOTH = band_limited_environment(10, seed=1)
D = sphere(2000, 3)


@pytest.fixture(scope="module", params=["egl", "osmesa"])
def context(request: pytest.FixtureRequest) -> Iterator[Context]:
    made = opengl.context(request.param)
    yield made
    assert made.gl.error == "GL_NO_ERROR"
    made.release()


def profile(material: brdf.BRDF):
    return material.lobes[0].profile


def filtered(context: Context, material: brdf.BRDF, light: Environment, **options) -> np.ndarray:
    """The map of the first lobe."""
    with HardwarePrefilter(material, size=SIZE, context=context, **options) as prefilter:
        prefilter.update(light)
        return prefilter.maps().maps[0].pixels


# ---- The unfiltered map


def test_directions_are_those_of_the_layout(context):
    x, y = np.meshgrid(np.arange(2 * SIZE) + 0.5, np.arange(SIZE) + 0.5)
    centers = np.stack([x.ravel(), y.ravel()], axis=1)
    wanted = layouts.rays("dual-paraboloid", SIZE, 2 * SIZE, centers).reshape(SIZE, 2, SIZE, 3)
    found = face_directions(SIZE, BORDER)[:, BORDER:-BORDER, BORDER:-BORDER].transpose(1, 0, 2, 3)
    inside = ~np.isnan(wanted[..., 0])
    assert inside.mean() == pytest.approx(np.pi / 4, abs=0.02)
    np.testing.assert_allclose(found[inside], wanted[inside], atol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("filter", FILTERS)
def test_a_spot_is_reflected_where_it_is(context, axis, sign, filter):
    towards = sign * np.eye(3)[axis] * 0.99 + 0.01 * np.array([0.3, 0.5, 0.7])  # not quite on it
    towards /= np.linalg.norm(towards)
    d = layouts.directions("latlong", 64, 128)
    spot = np.where((d @ towards)[..., None] > np.cos(0.1), 100.0, 0.0) * np.ones(3)
    pixels = filtered(context, brdf.Phong(200), Environment(spot.astype(np.float32)), filter=filter)
    looks = face_directions(SIZE, BORDER)
    brightest = looks.reshape(-1, 3)[pixels[..., 0].argmax()]
    # A texel is 2 / 32 radians wide at most, and a shrunk one twice as much.
    assert np.arccos(np.clip(brightest @ towards, -1, 1)) < 0.13


def test_the_map_of_an_environment_is_its_mean_over_texels(context):
    with HardwarePrefilter(brdf.Phong(10), size=SIZE, context=context) as prefilter:
        prefilter.set_light(SMOOTH)
        found = prefilter.unfiltered()
    wanted = SMOOTH.picture("dual-paraboloid", SIZE).reshape(SIZE, 2, SIZE, 3).transpose(1, 0, 2, 3)
    looks = face_directions(SIZE, BORDER)
    inside = looks[:, BORDER:-BORDER, BORDER:-BORDER]
    within = np.stack([inside[0, ..., 2] > 0.1, inside[1, ..., 2] < -0.1])  # no texel that the rim cuts
    found = found[:, BORDER:-BORDER, BORDER:-BORDER]
    # Linear interpolation loses (l h)^2 / 8 = .03 of degree l = 10 at h = pi / 64, and all degrees above the
    # first are sqrt(120) / 11 / 8 = .12 of the light.
    assert oracles.relative_rms(found[within], wanted[within]) < 0.03 * 0.12


@pytest.mark.parametrize("shape", [(512, 1024), (64, 64), (30, 200)])
def test_no_light_is_lost_or_won_on_the_way_to_the_map(context, shape):
    # Texels without any pattern, from much finer to much coarser than the map's.
    pixels = np.random.default_rng(5).random((*shape, 3)).astype(np.float32)
    light = Environment(pixels)
    area = layouts.solid_angles("dual-paraboloid", SIZE, 2 * SIZE).reshape(SIZE, 2, SIZE).transpose(1, 0, 2)
    with HardwarePrefilter(brdf.Phong(10), size=SIZE, context=context) as prefilter:
        prefilter.set_light(light)
        found = prefilter.unfiltered()[:, BORDER:-BORDER, BORDER:-BORDER]
    total = (area[..., None] * found).sum(axis=(0, 1, 2))
    exact = (layouts.solid_angles("latlong", *shape)[..., None] * pixels).sum(axis=(0, 1))
    # Independent texels may weigh a little differently, and their deviation is 1 / sqrt(12).
    np.testing.assert_allclose(total, exact, rtol=3e-3)


@pytest.mark.parametrize("theta", [0.002, 0.02, 0.2, 1.0, 1.5])
def test_a_small_sun_keeps_its_light_wherever_it_stands(context, theta):
    H, R = 512, 0.02
    towards = np.array([np.sin(theta), 0.0, np.cos(theta)])
    inside = layouts.directions("latlong", H, 2 * H) @ towards > np.cos(R)
    pixels = np.where(inside[..., None], np.float32(1e5), np.float32(0)) * np.ones(3, np.float32)
    exact = 1e5 * (layouts.solid_angles("latlong", H, 2 * H) * inside).sum()
    area = layouts.solid_angles("dual-paraboloid", SIZE, 2 * SIZE).reshape(SIZE, 2, SIZE).transpose(1, 0, 2)
    with HardwarePrefilter(brdf.Phong(10), size=SIZE, context=context) as prefilter:
        prefilter.set_light(Environment(pixels))
        found = prefilter.unfiltered()[:, BORDER:-BORDER, BORDER:-BORDER]
    # At the pole its edge lies between rows whose solid angles are as 5 to 7: linear interpolation of light
    # times solid angle moves it by .056 of a row of its 3.2, 3.5% of its area. Elsewhere rows are alike.
    assert (area * found[..., 0]).sum() == pytest.approx(exact, rel=0.06 if theta < 0.1 else 0.02)


# ---- Filtered maps


@pytest.mark.parametrize("exponent", [10, 50, 100])
def test_the_exact_filter_is_the_sum_over_all_texels(context, exponent):
    material = brdf.Phong(exponent)
    exact = prefilter_angular(SMOOTH, material, subsamples=1).radiance(D, D)
    errors = []
    for count in (16, 64, 256):
        with HardwarePrefilter(material, size=128, taps=count, context=context) as prefilter:
            prefilter.update(SMOOTH)
            errors.append(oracles.relative_rms(prefilter.radiance(D, D), exact))
    assert errors[-1] < 0.002
    assert errors[0] > errors[-1]
    assert max(errors) < 0.01


@pytest.mark.slow
def test_lobes_about_the_normal_and_of_three_channels(context):
    material = brdf.Lambert((0.8, 0.5, 0.2)) + 0.5 * brdf.Phong(30)
    N, V = sphere(1000, 4), sphere(1000, 5)
    exact = prefilter_angular(SMOOTH, material, subsamples=1).radiance(N, V)
    for filter, bound in (("exact", 0.003), ("two-pass", 0.03), ("one-pass", 0.1)):
        with HardwarePrefilter(material, size=128, taps=256, filter=filter, context=context) as prefilter:
            prefilter.update(SMOOTH)
            assert [lobe.center for lobe in prefilter.lobes] == ["normal", "reflection"]
            assert oracles.relative_rms(prefilter.radiance(N, V), exact) < bound


def test_any_radial_lobe_is_taken(context):
    def ring(cosine):
        return np.exp(-(((np.arccos(np.clip(cosine, -1, 1)) - 0.3) / 0.1) ** 2))

    lobe = brdf.lobe.RadialLobe("reflection", ring)
    exact = prefilter_angular(SMOOTH, brdf.Material((lobe,), "ring"), subsamples=1).radiance(D, D)
    for filter, bound in (("exact", 0.005), ("two-pass", 0.1)):
        with HardwarePrefilter(lobe, size=128, taps=512, filter=filter, context=context) as prefilter:
            prefilter.update(SMOOTH)
            assert oracles.relative_rms(prefilter.radiance(D, D), exact) < bound


@cache
def integrated(material: brdf.BRDF) -> Prefiltered:
    """The same for every way to OpenGL."""
    return prefilter_explicit(SMOOTH, material, technique="kautz-mccool-2d", size=64, tolerance=0.003)


@pytest.mark.slow
def test_lobes_that_change_with_the_view_are_factored(context):
    """Kautz and McCool's of two dimensions, as `shrm.prefiltered` integrates them."""
    material = brdf.Lambert(0.3) + brdf.GGX(0.4, (1.0, 0.7, 0.3))
    exact = integrated(material)
    N, V = oracles.random_views(400, seed=21)
    for filter, bound in (("exact", 0.02), ("two-pass", 0.08)):
        with HardwarePrefilter(material, size=128, taps=512, filter=filter, context=context) as prefilter:
            prefilter.update(SMOOTH)
            assert oracles.relative_rms(prefilter.radiance(N, V), exact.radiance(N, V)) < bound


@pytest.mark.parametrize(("size", "border"), [(45, 3), (33, 1), (4, 2), (100, 50)])
@pytest.mark.parametrize("filter", FILTERS)
def test_faces_may_have_any_size(context, filter, size, border):
    white = Environment(np.full((16, 32, 3), 2.0, np.float32))
    with HardwarePrefilter(
        brdf.Phong(20), size=size, border=border, filter=filter, context=context
    ) as prefilter:
        prefilter.update(white)
        np.testing.assert_allclose(prefilter.maps().maps[0].pixels, 2.0, rtol=1e-5)
        if size < 30:
            return
        prefilter.update(SMOOTH)
        exact = prefilter_angular(SMOOTH, brdf.Phong(20), subsamples=1).radiance(D, D)
        assert oracles.relative_rms(prefilter.radiance(D, D), exact) < {"exact": 0.005}.get(filter, 0.05)


@pytest.mark.parametrize("exponent", [10, 50, 100])
def test_two_passes_are_better_than_one(context, exponent):
    """The small filter is half as wide as it must be at the rim: too much is left there."""
    material = brdf.Phong(exponent)
    exact = prefilter_angular(SMOOTH, material, subsamples=1).radiance(D, D)
    # What no filter at all leaves bounds both: they are filters of about the right width.
    none = prefilter_angular(SMOOTH, brdf.Phong(3000)).radiance(D, D)
    errors = {}
    for filter in ("two-pass", "one-pass"):
        with HardwarePrefilter(material, size=128, filter=filter, context=context) as prefilter:
            prefilter.update(SMOOTH)
            errors[filter] = oracles.relative_rms(prefilter.radiance(D, D), exact)
    assert errors["two-pass"] < 0.6 * errors["one-pass"]
    assert errors["one-pass"] < oracles.relative_rms(none, exact)
    assert errors["two-pass"] < 0.02


@pytest.mark.parametrize("half", [False, True], ids=["float", "half"])
@pytest.mark.parametrize("filter", FILTERS)
def test_white_light_stays_white_to_the_corners(context, filter, half):
    white = Environment(np.full((16, 32, 3), 0.75, np.float32))
    material = brdf.Lambert((0.8, 0.5, 0.2))
    pixels = filtered(context, material, white, filter=filter, half=half)
    wanted = 0.75 * np.broadcast_to([0.8, 0.5, 0.2], pixels.shape)
    # Half floats may be cut off to 11 bits: of the light, of both kernels' maps, of their blend.
    np.testing.assert_allclose(pixels, wanted, rtol=3 * 2.0**-10 if half else 1e-4)


@pytest.mark.parametrize("exponent", [10, 500])
@pytest.mark.parametrize("filter", FILTERS)
def test_no_dark_border_and_no_fireflies(context, filter, exponent):
    """Filters of positive weights give means of the light: nothing is darker or brighter than all of it."""
    light = np.random.default_rng(7).uniform(1.0, 2.0, (64, 128, 3)).astype(np.float32)
    light[20, 30] = 1e5
    pixels = filtered(context, brdf.Phong(exponent), Environment(light), filter=filter, taps=64)
    assert np.isfinite(pixels).all()
    assert pixels.min() > 1.0 - 1e-3
    assert pixels.max() < 1e5
    # The sun is one texel: where the lobe does not reach it, it must not be seen.
    towards = layouts.directions("latlong", 64, 128)[20, 30]
    away = face_directions(SIZE, BORDER) @ towards < -0.5
    if filter == "exact":
        assert pixels[away].max() < 2.0


@pytest.mark.parametrize(("filter", "bound"), [("exact", 0.002), ("two-pass", 0.05), ("one-pass", 0.1)])
def test_both_faces_agree_at_the_equator(context, filter, bound):
    phi = np.linspace(0, 2 * np.pi, 500)
    material = brdf.Phong(30)
    exact = prefilter_angular(SMOOTH, material, subsamples=1).radiance
    at = np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1)
    with HardwarePrefilter(material, size=128, filter=filter, taps=256, context=context) as prefilter:
        prefilter.update(SMOOTH)
        faces = prefilter.maps().maps[0].pixels
    # s = -y and, downwards, t = x above and -x below: from the middle of texels.
    seen = []
    for face, sign in zip(faces, (1, -1), strict=True):
        x, y = (64 * (1 + k) + 16 - 0.5 for k in (-np.sin(phi), sign * np.cos(phi)))
        j, i = x.astype(int), y.astype(int)
        a, b = (x - j)[:, None], (y - i)[:, None]
        seen.append(
            (1 - b) * ((1 - a) * face[i, j] + a * face[i, j + 1])
            + b * ((1 - a) * face[i + 1, j] + a * face[i + 1, j + 1])
        )
    assert oracles.relative_rms(*seen) < bound
    assert oracles.relative_rms(seen[0], exact(at, at)) < bound


@pytest.mark.parametrize("filter", FILTERS)
def test_a_black_lobe_reflects_nothing(context, filter):
    assert not filtered(context, brdf.Lambert(0.0), SMOOTH, filter=filter).any()


# ---- Every frame


@pytest.mark.parametrize("filter", FILTERS)
def test_maps_follow_the_light(context, filter):
    lights = [band_limited_environment(6, seed, H) for seed, H in ((1, 32), (2, 32), (3, 16))]
    wanted = [filtered(context, brdf.Phong(40), light, filter=filter) for light in lights]
    with HardwarePrefilter(brdf.Phong(40), size=SIZE, filter=filter, context=context) as prefilter:
        for k in (0, 1, 2, 0, 2, 1):
            prefilter.update(lights[k])
            np.testing.assert_array_equal(prefilter.maps().maps[0].pixels, wanted[k])
    assert np.abs(wanted[0] - wanted[1]).max() > 0.01


def test_textures_and_framebuffers_are_taken(context):
    gl = context.gl
    light = SMOOTH.resized((64, 128))
    wanted = filtered(context, brdf.Phong(40), light)
    texture = gl.texture((128, 64), 3, light.pixels.tobytes(), dtype="f4")
    faces = light.picture("faces", 64)
    cube = gl.texture_cube((64, 64), 3, np.ascontiguousarray(faces), dtype="f4")
    with HardwarePrefilter(brdf.Phong(40), size=SIZE, context=context) as prefilter:
        prefilter.update(texture)
        np.testing.assert_allclose(prefilter.maps().maps[0].pixels, wanted, rtol=1e-5)
        texture.write(2 * light.pixels)  # somebody draws the next frame
        prefilter.update(texture)
        np.testing.assert_allclose(prefilter.maps().maps[0].pixels, 2 * wanted, rtol=1e-5)
        prefilter.update(cube)
        assert oracles.relative_rms(prefilter.maps().maps[0].pixels, wanted) < 2e-3
        target = gl.framebuffer([gl.texture((16, 8), 4, dtype="f4")])
        target.clear(3.0, 2.0, 1.0)
        prefilter.update(target)
        np.testing.assert_allclose(
            prefilter.maps().maps[0].pixels, np.broadcast_to([3.0, 2.0, 1.0], wanted.shape), rtol=1e-5
        )
    for held in (texture, cube, *target.color_attachments, target):
        held.release()


def test_light_is_not_clamped_but_by_what_half_floats_hold(context):
    bright = Environment(np.full((16, 32, 3), 1e5, np.float32))
    for filter in FILTERS:
        pixels = filtered(context, brdf.Phong(50), bright, filter=filter)
        np.testing.assert_allclose(pixels, 1e5, rtol=1e-4)
        pixels = filtered(context, brdf.Phong(50), bright, filter=filter, half=True)
        np.testing.assert_allclose(pixels, 65504.0, rtol=1e-3)


def test_both_ways_to_opengl_filter_alike():
    maps = []
    for route in ("egl", "osmesa"):
        made = opengl.context(route)
        maps.append(filtered(made, brdf.Phong(40), SMOOTH))
        made.release()
    np.testing.assert_array_equal(*maps)


# ---- What cannot be


@pytest.mark.parametrize(
    ("options", "fault", "text"),
    [
        ({"brdf": "phong"}, TypeError, "brdf must be a material of shrm.brdf or a RadialLobe, got str"),
        (
            {"brdf": brdf.Banks(0.3)},
            ValueError,
            "one about the tangent, whose map has three dimensions",
        ),
        ({"size": 3}, ValueError, r"size must be in \[4, 8192\], got 3"),
        ({"size": 64.0}, TypeError, "size must be a whole number"),
        ({"border": 0}, ValueError, "border must be in"),
        ({"border": 33}, ValueError, r"border must be in \[1, 32\], got 33"),
        ({"filter": "fast"}, ValueError, "filter must be one of exact, two-pass, one-pass, got 'fast'"),
        ({"taps": 0}, ValueError, "taps must be in"),
        ({"clamp": 0.0}, ValueError, "clamp must be above 0 and below 1, got 0"),
        ({"clamp": 1.0}, ValueError, "clamp must be above 0 and below 1"),
        ({"largest_kernel": 2}, ValueError, r"largest_kernel must be in \[3, 63\], got 2"),
        ({"brdf": brdf.Phong(0), "filter": "two-pass"}, ValueError, "to fit into a face"),
        ({"size": 8192}, ValueError, r"size \+ 2 border must be at most 64 here, got 10240"),
    ],
    ids=str,
)
def test_wrong_arguments_are_said(context, monkeypatch, options, fault, text):
    monkeypatch.setitem(context.gl.info, "GL_MAX_TEXTURE_SIZE", 64)
    material, options = options.get("brdf", brdf.Phong(8)), {k: v for k, v in options.items() if k != "brdf"}
    with pytest.raises(fault, match=text) as caught:
        HardwarePrefilter(material, **{"size": 64, "context": context, **options})
    assert "\n" not in str(caught.value)


def test_what_is_no_light_is_said(context):
    with HardwarePrefilter(brdf.Phong(8), size=16, context=context) as prefilter:
        for call in (prefilter.apply_filter, prefilter.maps, prefilter.unfiltered, lambda: prefilter.lobes):
            with pytest.raises(ValueError, match="nothing was filtered yet"):
                call()
        with pytest.raises(TypeError, match=r"source must be an Environment, .* got ndarray"):
            prefilter.update(np.ones((8, 16, 3)))
        depth = context.gl.framebuffer(depth_attachment=context.gl.depth_renderbuffer((8, 8)))
        with pytest.raises(TypeError, match="a Framebuffer with a texture, got Framebuffer"):
            prefilter.update(depth)
        depth.release()


def test_a_texture_of_another_context_is_said(context):
    other = offscreen((context.route,))
    texture = other.gl.texture((8, 4), 3, dtype="f4")
    with HardwarePrefilter(brdf.Phong(8), size=16, context=context) as prefilter:
        with pytest.raises(ValueError, match="of the prefilter's OpenGL context"):
            prefilter.update(texture)
        prefilter.update(SMOOTH)
    other.release()


def test_what_was_released_is_said(context):
    prefilter = HardwarePrefilter(brdf.Phong(8), size=16, context=context)
    prefilter.update(SMOOTH)
    texture = prefilter.lobes[0].faces.texture
    prefilter.release()
    prefilter.release()
    assert isinstance(texture.mglo, moderngl.InvalidObject)
    with pytest.raises(ContextError, match="the prefilter was released"):
        prefilter.update(SMOOTH)
    assert context.gl.error == "GL_NO_ERROR"


def test_its_own_context_goes_with_it():
    opengl.context().release()
    prefilter = HardwarePrefilter(brdf.Phong(8), size=16)
    prefilter.update(SMOOTH)
    prefilter.release()
    assert prefilter.context.released


@pytest.mark.parametrize("texels", ["f4", "f2"])
def test_opengl_without_targets_of_floats_is_one_line(texels):
    released = []
    texture = SimpleNamespace(release=lambda: released.append(True))

    def refuse(_):
        raise moderngl.Error("the framebuffer is not complete\n(UNSUPPORTED)")

    gl = SimpleNamespace(texture_array=lambda *_, **__: texture, framebuffer=refuse)
    with pytest.raises(
        ContextError, match=r"^this OpenGL cannot draw into textures of \d\d-bit floats"
    ) as caught:
        Faces(gl, 8, texels)
    assert "\n" not in str(caught.value)
    assert released
