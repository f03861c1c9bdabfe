"""Dual-paraboloid maps: lookups, and objects that are drawn with them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from shrm import Environment, brdf
from shrm.environment.paraboloid import face_directions
from shrm.prefiltered.paraboloid import blended_band
from shrm.render import Camera, Mesh, Object, Sphere, render
from shrm.viewer import (
    HardwarePrefilter,
    ParaboloidMap,
    ParaboloidMaps,
    Renderer,
    Scene,
)
from support import opengl, oracles
from support.directions import sphere
from support.opengl import lookup_error

PIXELS = 96
CAMERA = Camera((4.0, 2.0, 1.5), fov=32.0)


def smooth(d: np.ndarray) -> np.ndarray:
    """Radiance of a light that is known everywhere."""
    x, y, z = np.moveaxis(d, -1, 0)
    return np.stack([2 + x, 2 + x * y - z, 3 + z * z - y], axis=-1)


def known(size: int, border: int, center: str = "reflection") -> ParaboloidMap:
    return ParaboloidMap(smooth(face_directions(size, border)).astype(np.float32), border, center)


@pytest.fixture(scope="module", params=["egl", "osmesa"])
def renderer(request: pytest.FixtureRequest) -> Iterator[Renderer]:
    context = opengl.context(request.param)
    made = Renderer((PIXELS, PIXELS), context=context)
    yield made
    assert made.gl.error == "GL_NO_ERROR"
    made.release()
    context.release()


# ---- Lookups


@pytest.mark.parametrize(("size", "border"), [(64, 8), (64, 1), (33, 4)])
def test_lookups_are_those_of_the_light(size, border):
    D = np.concatenate([sphere(4000, 1), np.eye(3), -np.eye(3)])
    found = known(size, border).about(D)
    # Linear interpolation: h^2 / 8 for each of two axes, h = 4 / size radians at the most, second derivatives
    # of up to 4 along a great circle and as much again by the texture's own stretching.
    assert np.abs(found - smooth(D)).max() < 8 * 2 * (4 / size) ** 2 / 8


@pytest.mark.parametrize("border", [1, 2, 8])
def test_faces_that_differ_are_blended_without_a_step(border):
    size = 64
    pixels = np.zeros((2, size + 2 * border, size + 2 * border, 3), np.float32)
    pixels[1] = 1.0
    z = np.linspace(-0.5, 0.5, 20001)
    D = np.stack([np.sqrt(1 - z**2), 0 * z, z], axis=1)
    found = ParaboloidMap(pixels, border).about(D)[:, 0]
    band = blended_band(size, border)
    assert 0 < band < 0.2
    np.testing.assert_allclose(found, np.clip(0.5 - 0.5 * z / band, 0, 1), atol=1e-12)


def test_each_lobe_is_looked_up_about_its_own_center():
    N, V = sphere(500, 2), sphere(500, 3)
    reflected = 2 * (N * V).sum(axis=1, keepdims=True) * N - V
    both = ParaboloidMaps([known(128, 16, "normal"), known(128, 16)]).radiance(N, V)
    np.testing.assert_allclose(both, smooth(N) + smooth(reflected), atol=4e-3)


# ---- Drawing


def torus() -> Mesh:
    """A torus without normals of its own."""
    around, rings = 48, 24
    u, v = np.meshgrid(np.arange(around), np.arange(rings), indexing="ij")
    a, b = 2 * np.pi * u.ravel() / around, 2 * np.pi * v.ravel() / rings
    r = 1 + 0.4 * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), 0.4 * np.sin(b)], axis=1)
    i, j = u.ravel(), v.ravel()
    corners = [(x % around) * rings + y % rings for x, y in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
    return Mesh(
        vertices, np.concatenate([np.stack([corners[k] for k in t], axis=1) for t in ((0, 1, 2), (0, 2, 3))])
    )


def compared(renderer: Renderer, scene: Scene, expected: ParaboloidMaps) -> float:
    """Relative RMS difference to the CPU's picture, where both see an object."""
    found = renderer.render(scene)
    wanted = render(
        [replace(thing, material=expected) for thing in scene.objects],
        scene.camera,
        (PIXELS, PIXELS),
        viewer=scene.viewer,
        samples=1,
    )
    both = (found.coverage == 1) & (wanted.coverage == 1)
    assert both.sum() > 0.95 * max((found.coverage == 1).sum(), (wanted.coverage == 1).sum()) > 0
    return oracles.relative_rms(found.radiance[both], wanted.radiance[both])


# Of a sphere both are the same sums in float32; a mesh's normals are interpolated in float32 and float64.
@pytest.mark.parametrize(("shape", "largest"), [(Sphere(), 2e-5), (torus(), 5e-3)], ids=["sphere", "torus"])
@pytest.mark.parametrize("viewer", ["near", "distant"])
@pytest.mark.parametrize("source", ["filtered", "array"])
def test_objects_are_those_of_the_cpu(renderer, shape, largest, viewer, source):
    material = 0.5 * brdf.Lambert((0.8, 0.5, 0.2)) + brdf.Phong(30)
    with HardwarePrefilter(material, size=64, filter="two-pass", context=renderer.context) as prefilter:
        prefilter.update(Environment.daylight(size=64))
        maps = prefilter.maps()
        drawn = prefilter if source == "filtered" else maps
        for camera in (CAMERA, Camera((-3.0, 2.0, -2.5), fov=35.0), Camera((3.0, 1.0, 0.2), height=3.0)):
            scene = Scene([Object(shape, drawn)], camera, None, viewer)
            # A lobe of exponent 30 on 64 texels: from texel to texel it changes by up to a half
            assert compared(renderer, scene, maps) < largest + lookup_error(renderer.context, 0.5)


def test_maps_are_drawn_beside_others_and_follow_the_light(renderer):
    from shrm import prefilter as shrm_prefilter

    env = Environment.daylight(size=64)
    cubes = shrm_prefilter(env, brdf.GGX(0.4), orders=(8, 2), size=16, layout="cube")
    with HardwarePrefilter(brdf.Phong(30), size=32, context=renderer.context) as prefilter:
        scene = Scene(
            [Object(Sphere((0.0, -0.8, 0.0), 0.7), cubes), Object(Sphere((0.0, 0.8, 0.0), 0.7), prefilter)],
            CAMERA,
            env,
            "distant",
        )
        pictures = []
        for light in (env, Environment(2 * env.pixels), env):
            prefilter.update(light)
            pictures.append(renderer.render(scene).radiance)
    np.testing.assert_array_equal(pictures[0], pictures[2])
    changed = np.any(pictures[0] != pictures[1], axis=2)
    assert 0.05 < changed.mean() < 0.4  # the one sphere only
    np.testing.assert_allclose(pictures[1][changed], 2 * pictures[0][changed], rtol=1e-4)


def test_nothing_piles_up_on_the_gpu(renderer):
    fresh = Renderer((16, 16), context=renderer.context)
    counts = set()
    for frame in range(20):
        maps = ParaboloidMaps([known(16 + frame % 3, 2)])
        fresh.render(Scene([Object(Sphere(), maps)], CAMERA, None, ("near", "distant")[frame % 2]))
        counts.add(len(fresh.resources))
    assert counts == {2}  # shape, lobe
    fresh.release()


def test_a_prefilter_of_another_context_is_refused(renderer):
    with HardwarePrefilter(brdf.Phong(8), size=16) as stranger:
        stranger.update(Environment.daylight(size=16))
        with pytest.raises(ValueError, match=r"context must be the renderer's .* context=renderer\.context"):
            renderer.render(Scene([Object(Sphere(), stranger)], CAMERA))
    with (
        HardwarePrefilter(brdf.Phong(8), size=16, context=renderer.context) as empty,
        pytest.raises(ValueError, match="nothing was filtered yet"),
    ):
        renderer.render(Scene([Object(Sphere(), empty)], CAMERA))


# ---- What cannot be


@pytest.mark.parametrize(
    ("pixels", "border", "center", "fault", "text"),
    [
        (np.ones((2, 8, 9, 3)), 1, "normal", ValueError, r"shape \(2, side, side, 3\), got \(2, 8, 9, 3\)"),
        (np.ones((8, 8, 3)), 1, "normal", ValueError, r"shape \(2, side, side, 3\)"),
        (np.ones((2, 8, 8, 4)), 1, "normal", ValueError, r"shape \(2, side, side, 3\)"),
        (np.full((2, 8, 8, 3), np.nan), 1, "normal", ValueError, "pixels must be finite"),
        (np.ones((2, 8, 8, 3), complex), 1, "normal", TypeError, "pixels must be an array of real numbers"),
        (np.ones((2, 8, 8, 3)), 0, "normal", ValueError, "border must be at least 1, got 0"),
        (
            np.ones((2, 8, 8, 3)),
            4,
            "normal",
            ValueError,
            "at least 2 texels within a border of 4, got faces of 8",
        ),
        (np.ones((2, 8, 8, 3)), 1, "tangent", ValueError, "center must be one of reflection, normal"),
    ],
)
def test_wrong_maps_are_said(pixels, border, center, fault, text):
    with pytest.raises(fault, match=text):
        ParaboloidMap(pixels, border, center)


def test_maps_are_at_least_one_and_of_their_kind():
    with pytest.raises(ValueError, match="maps must be at least one"):
        ParaboloidMaps([])
    with pytest.raises(TypeError, match="maps must be of ParaboloidMap, got ndarray"):
        ParaboloidMaps([np.ones((2, 8, 8, 3))])
    maps = ParaboloidMaps([known(8, 1)])
    with pytest.raises(ValueError, match="normals must be unit vectors"):
        maps.radiance([[0.0, 0.0, 2.0]], [0.0, 0.0, 1.0])
