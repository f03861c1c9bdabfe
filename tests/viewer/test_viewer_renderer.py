"""The GPU's pictures against those of the CPU, on every way to OpenGL without a display."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from shrm import ReflectionMap, brdf, prefilter
from shrm.environment import Environment
from shrm.integrate.angular import prefilter_angular
from shrm.prefiltered import Prefiltered
from shrm.prefiltered import prefilter as prefilter_explicit
from shrm.prefiltered.explicit import without_azimuth
from shrm.render import Camera, Mesh, Object, Sphere, environment_lookup, render
from shrm.viewer import Context, ContextError, Renderer, Scene, offscreen
from support import opengl, oracles
from support.data import environment
from support.opengl import lookup_error

SIZE = 96
CAMERA = Camera((4.0, 2.0, 1.5), fov=32.0)


class Contexts(dict[str, Context]):
    """A context by its route, made when it is first asked for."""

    def __missing__(self, route: str) -> Context:
        self[route] = opengl.context(route)
        return self[route]


@pytest.fixture(scope="module")
def contexts() -> Iterator[dict[str, Context]]:
    """Both ways to OpenGL, made when they are asked for."""
    found: dict[str, Context] = Contexts()
    yield found
    for context in found.values():
        context.release()


@pytest.fixture(scope="module", params=["egl", "osmesa"])
def renderer(request, contexts) -> Renderer:
    return Renderer((SIZE, SIZE), context=contexts[request.param])


@pytest.fixture(scope="module")
def egl(contexts) -> Renderer:
    """One way, for what both of them draw alike: see `test_both_ways_to_opengl_draw_the_same_pixels`."""
    return Renderer((SIZE, SIZE), context=contexts["egl"])


class Bilinear:
    """A reflection map looked up as graphics hardware does."""

    def __init__(self, rm: ReflectionMap | Prefiltered) -> None:
        self.rm = rm

    def radiance(self, normals, views, tangents=None):
        return self.rm.radiance(normals, views, tangents, interpolation="bilinear")


def compared(renderer: Renderer, scene: Scene) -> float:
    """Relative RMS difference to the CPU's picture, where both see an object."""
    found = renderer.render(scene)
    objects = [replace(thing, material=Bilinear(thing.material)) for thing in scene.objects]
    expected = render(
        objects,
        scene.camera,
        renderer.shape,
        background=scene.background,
        viewer=scene.viewer,
        samples=renderer.samples,
    )
    both = (found.coverage == 1) & (expected.coverage == 1)
    assert both.sum() > 0.95 * max((found.coverage == 1).sum(), (expected.coverage == 1).sum()) > 0
    empty = (found.coverage == 0) & (expected.coverage == 0)
    if scene.background is None:
        assert not found.radiance[empty].any()
    else:  # OpenGL's arctangents are good to six digits: of a texel, to three
        assert oracles.relative_rms(found.radiance[empty], expected.radiance[empty]) < 1e-3
    return oracles.relative_rms(found.radiance[both], expected.radiance[both])


# For a viewer near by both are the same sum in float32; the dynamic map of a distant one is looked up across
# the edges of faces, where the CPU stays in the plane of each.
LARGEST = {"near": 2e-5, "distant": 5e-3}


def largest(renderer: Renderer, viewer: str) -> float:
    """Of maps of degree 12 in 90 degrees and 64 texels: from texel to texel they change by a tenth."""
    return LARGEST[viewer] + lookup_error(renderer.context, 0.1)


MATERIALS = [
    brdf.GGX(0.3, f0=(1.0, 0.7, 0.3)),
    brdf.Lambert(0.8) + brdf.GGX(0.3, f0=0.04),
    brdf.Phong(20),
    brdf.KajiyaKay(8),
    brdf.Microfacet(0.3).recentered("reflection"),
    brdf.Beckmann(0.4),
]


@cache
def light(name: str) -> Environment:
    if name == "daylight":
        return Environment.daylight(size=64)
    return environment(name)


@pytest.mark.slow
@pytest.mark.parametrize("env", ["daylight", "lamps.hdr"])
@pytest.mark.parametrize("viewer", ["near", "distant"])
@pytest.mark.parametrize("material", MATERIALS, ids=lambda material: material.name)
def test_spheres_are_those_of_the_cpu(renderer, material, viewer, env):
    env = light(env)
    rm = prefilter(env, material, orders=(12, 4), size=64, layout="cube")
    scene = Scene([Object(Sphere(), rm)], CAMERA, env, viewer)
    assert compared(renderer, scene) < largest(renderer, viewer)


# A dynamic map holds products of layers and shares, a near viewer's pixels look both up.
OF_LAYERS = {"near": 1e-4, "distant": 0.02}
TECHNIQUES = ["kautz-mccool-3d", "kautz-mccool-2d", "miller-heidrich", "cabral"]


@cache
def in_daylight(material: brdf.BRDF) -> ReflectionMap:
    return prefilter(light("daylight"), material, orders=(12, 4), size=64, layout="cube")


@cache
def layered(rm: ReflectionMap, material: brdf.BRDF, technique: str | None) -> ReflectionMap | Prefiltered:
    """The maps of a technique for the light of a reflection map; without one, its own without azimuth."""
    if technique is None:
        return without_azimuth(rm)
    return Prefiltered.from_reflection_map(rm, material, technique=technique)


@pytest.mark.parametrize("technique", [None, *TECHNIQUES])
@pytest.mark.parametrize("viewer", ["near", "distant"])
@pytest.mark.parametrize("material", [MATERIALS[1], MATERIALS[3]], ids=lambda material: material.name)
def test_earlier_methods_are_those_of_the_cpu(egl, material, viewer, technique):
    maps = layered(in_daylight(material), material, technique)
    scene = Scene([Object(Sphere(), maps), Object(torus(), maps)], CAMERA, None, viewer)
    assert compared(egl, scene) < OF_LAYERS[viewer] + lookup_error(egl.context, 0.1)
    turned = replace(scene, camera=Camera((1.0, -3.0, 2.5), fov=32.0))  # another triangle of views
    assert compared(egl, turned) < OF_LAYERS[viewer] + lookup_error(egl.context, 0.1)


@cache
def small_maps(material: brdf.BRDF, technique: str) -> Prefiltered:
    """Rough ones: both sides draw the same."""
    rough = {"slices": 9, "lobes": 2, "size": 32, "tolerance": 0.05}
    return prefilter_explicit(light("daylight"), material, technique=technique, layout="cube", **rough)


@pytest.mark.slow
@pytest.mark.parametrize("viewer", ["near", "distant"])
@pytest.mark.parametrize(
    ("material", "technique"),
    [
        (brdf.Lambert((0.8, 0.5, 0.2)) + brdf.Phong(20), "kautz-mccool-3d"),
        (brdf.GGX(0.3, (1.0, 0.7, 0.3)), "kautz-mccool-3d"),
        (brdf.GGX(0.3, (1.0, 0.7, 0.3)), "kautz-mccool-2d"),
        (brdf.MillerHeidrich((0.6, 0.4, 0.1), 20), "kautz-mccool-2d"),
        (brdf.GGX(0.4), "miller-heidrich"),
        (brdf.GGX(0.4), "cabral"),
        (brdf.Banks(0.5), "kautz-mccool-3d"),
    ],
    ids=lambda value: str(getattr(value, "name", value)),
)
def test_prefiltered_maps_of_all_classes_are_those_of_the_cpu(egl, material, technique, viewer):
    maps = small_maps(material, technique)
    scene = Scene([Object(Sphere(), maps), Object(torus(), maps)], CAMERA, None, viewer)
    assert compared(egl, scene) < OF_LAYERS[viewer] + lookup_error(egl.context, 0.1)


@pytest.mark.parametrize("technique", [None, "cabral"])
def test_clamped_maps_are_clamped_lobe_by_lobe(renderer, technique):
    material = brdf.KajiyaKay(8) + 0.2 * brdf.Lambert(0.5) + brdf.GGX(0.2)
    sun = np.full((32, 64, 3), 0.05, np.float32)
    sun[6, 20] = 200.0  # rings of negative radiance round it
    maps = [
        prefilter(Environment(sun), material, orders=(12, 4), size=32, layout="cube", clamp=clamp)
        for clamp in (True, False)
    ]
    if technique is not None:
        maps = [layered(rm, material, technique) for rm in maps]
    clamped, plain = (Scene([Object(Sphere(), found)], CAMERA, None, "near") for found in maps)
    assert compared(renderer, clamped) < largest(renderer, "near")
    assert oracles.relative_rms(renderer.render(clamped).radiance, renderer.render(plain).radiance) > 1e-3


@pytest.mark.parametrize("x", [5.0, 0.0, -0.5, -5.0])
@pytest.mark.parametrize("shape", [Sphere(), Sphere((0.0, 0.3, 0.0), 0.6)], ids=["whole", "part"])
def test_orthographic_rays_begin_at_the_eye(renderer, glossy, shape, x):
    camera = Camera((x, 0.1, 0.1), target=(x - 1.0, 0.1, 0.1), height=2.5)
    found = renderer.render(Scene([Object(shape, glossy)], camera))
    expected = render([Object(shape, Bilinear(glossy))], camera, (SIZE, SIZE), samples=1)
    assert np.mean(found.coverage != expected.coverage) < 0.01
    both = (found.coverage == 1) & (expected.coverage == 1)
    assert both.any() == (x > -0.6)
    np.testing.assert_allclose(found.radiance[both], expected.radiance[both], atol=1e-3)


def test_more_maps_than_textures_have_layers_are_said(renderer, glossy, monkeypatch):
    monkeypatch.setitem(
        renderer.gl.info, "GL_MAX_ARRAY_TEXTURE_LAYERS", 6 * glossy.parts[0].rings.shape[1] - 1
    )
    again = replace(glossy, parts=tuple(replace(part) for part in glossy.parts))
    fresh = Renderer((8, 8), context=renderer.context)
    with pytest.raises(ValueError, match="use a smaller P, or a distant viewer"):
        fresh.render(Scene([Object(Sphere(), again)], CAMERA))
    assert fresh.render(Scene([Object(Sphere(), again)], CAMERA, None, "distant")).radiance.any()
    fresh.release()


@pytest.mark.parametrize("technique", ["shrm", None, *TECHNIQUES])
@pytest.mark.parametrize("material", [MATERIALS[1], MATERIALS[3]], ids=lambda material: material.name)
def test_both_ways_to_opengl_draw_the_same_pixels(contexts, material, technique):
    maps = in_daylight(material)
    if technique != "shrm":
        maps = layered(maps, material, technique)
    for viewer in ("near", "distant"):
        scene = Scene([Object(Sphere(), maps), Object(torus(), maps)], CAMERA, light("daylight"), viewer)
        pictures = [
            Renderer((SIZE, SIZE), context=context).render(scene)
            for context in (contexts["egl"], contexts["osmesa"])
        ]
        np.testing.assert_array_equal(pictures[0].radiance, pictures[1].radiance)
        np.testing.assert_array_equal(pictures[0].coverage, pictures[1].coverage)


# ---- Shapes


def torus(rings: int = 24, around: int = 48, **given) -> Mesh:
    """A torus without normals of its own."""
    u, v = np.meshgrid(np.arange(around), np.arange(rings), indexing="ij")
    a, b = 2 * np.pi * u.ravel() / around, 2 * np.pi * v.ravel() / rings
    r = 1 + 0.4 * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), 0.4 * np.sin(b)], axis=1)

    def index(i, j):
        return (i % around) * rings + j % rings

    i, j = u.ravel(), v.ravel()
    corners = index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)
    faces = np.concatenate([np.stack(corners[:3], axis=1), np.stack([corners[k] for k in (0, 2, 3)], axis=1)])
    return Mesh(vertices, faces, **given)


@pytest.fixture(scope="module")
def glossy() -> ReflectionMap:
    return prefilter(Environment.daylight(size=64), brdf.GGX(0.4), orders=(10, 3), size=32, layout="cube")


def test_meshes_are_those_of_the_cpu(renderer, glossy):
    # Rasterised and traced rays meet the same triangles; normals are interpolated in float32 and float64.
    for viewer in ("near", "distant"):
        assert compared(renderer, Scene([Object(torus(), glossy)], CAMERA, None, viewer)) < 5e-3


def test_a_mesh_of_trimesh_is_drawn(renderer, glossy):
    import trimesh

    ours = torus()
    theirs = trimesh.Trimesh(ours.vertices, ours.faces, vertex_normals=ours.vertex_normals, process=False)
    pictures = [renderer.render(Scene([Object(shape, glossy)], CAMERA)).radiance for shape in (ours, theirs)]
    np.testing.assert_allclose(*pictures, atol=1e-6)


@pytest.mark.parametrize("viewer", ["near", "distant"])
@pytest.mark.parametrize("tangents", ["uv", "principal"])
@pytest.mark.parametrize("material", [brdf.Banks(0.6), brdf.KajiyaKay(8)], ids=lambda material: material.name)
def test_meshes_with_tangent_fields_are_those_of_the_cpu(renderer, material, tangents, viewer):
    rm = prefilter(light("daylight"), material, orders=(12, 4), size=64, layout="cube")
    plain = torus()
    aslant = plain.vertices @ np.array([[1.0, 0.3], [0.2, 1.0], [0.7, -0.4]])
    field = torus(uv=aslant).with_tangents(tangents)
    assert compared(renderer, Scene([Object(field, rm)], CAMERA, None, viewer)) < largest(renderer, viewer)
    pictures = [renderer.render(Scene([Object(mesh, rm)], CAMERA)).radiance for mesh in (field, plain)]
    assert oracles.relative_rms(*pictures) > 0.05


def test_a_mesh_of_spoilt_faces_is_drawn(renderer, glossy):
    whole = torus()
    spoilt = np.concatenate([whole.faces, [[0, 0, 1], [5, 5, 5], [2, 3, 2]]])
    unused = np.concatenate([whole.vertices, [[9.0, 9.0, 9.0]]])  # no face has it, and it has no normal
    scene = Scene([Object(Mesh(unused, spoilt), glossy)], CAMERA)
    assert compared(renderer, scene) < 5e-3
    assert np.isfinite(renderer.render(scene).radiance).all()
    hair = prefilter(light("daylight"), brdf.KajiyaKay(8), orders=(12, 4), size=64, layout="cube")
    field = Mesh(unused, spoilt).with_tangents("principal")
    assert compared(renderer, Scene([Object(field, hair)], CAMERA)) < 5e-3


@pytest.mark.slow
def test_a_million_triangles_are_drawn(egl, glossy):
    fine = torus(rings=500, around=1000)
    assert len(fine.faces) == 1_000_000
    found = egl.render(Scene([Object(fine, glossy)], CAMERA, None, "distant"))
    coarse = egl.render(Scene([Object(torus(100, 200), glossy)], CAMERA, None, "distant"))
    both = (found.coverage == 1) & (coarse.coverage == 1)
    assert both.sum() > 0.2 * SIZE**2
    # A facet of 100 x 200 departs from its tangent by a fiftieth of a radian.
    assert oracles.relative_rms(found.radiance[both], coarse.radiance[both]) < 0.02


def test_objects_hide_each_other_and_have_their_own_materials(renderer, glossy):
    red = prefilter(Environment.daylight(size=64), brdf.Lambert((0.8, 0.1, 0.1)), size=32, layout="cube")
    objects = [
        Object(Sphere((0.5, 0.3, 0.2), 0.7), red),
        Object(torus(), glossy),
        Object(Sphere((-1.5, 0, 0)), red),
    ]
    assert compared(renderer, Scene(objects, CAMERA, Environment.daylight(size=64))) < 5e-3


def test_an_orthographic_camera_and_one_inside(renderer, glossy):
    for camera in (Camera((3.0, 1.0, 2.0), height=3.0), Camera((0.2, 0.1, 0.0), (1.0, 0.3, 0.2), fov=60)):
        for viewer in ("near", "distant"):
            scene = Scene([Object(Sphere(), glossy)], camera, None, viewer)
            assert compared(renderer, scene) < largest(renderer, viewer)


def test_textures_multiply_the_reflected_light(renderer, glossy):
    texture = np.random.default_rng(0).random((5, 7, 3)).astype(np.float32)
    uv = np.random.default_rng(1).random((24 * 48, 2))
    for shape in (Sphere(), torus(uv=uv)):
        scene = Scene([Object(shape, glossy, texture)], CAMERA)
        assert compared(renderer, scene) < 5e-3


def test_samples_are_averaged_where_the_cpu_has_them(contexts, glossy):
    renderer = Renderer((30, 40), samples=3, context=contexts["egl"])
    scene = Scene([Object(Sphere(), glossy)], CAMERA, Environment.daylight(size=64))
    found = renderer.render(scene)
    expected = render(
        [Object(Sphere(), Bilinear(glossy))], CAMERA, (30, 40), background=scene.background, samples=3
    )
    np.testing.assert_allclose(found.coverage, expected.coverage, atol=1e-6)
    assert oracles.relative_rms(found.radiance, expected.radiance) < 1e-4


# ---- Light


def test_the_background_turns_with_the_light(renderer, glossy):
    env, R = Environment.daylight(size=64), np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]])
    nothing = [Object(Sphere((0, 0, -50.0), 0.1), glossy)]
    turned = renderer.render(Scene(nothing, CAMERA, env, rotation=R))
    rows, columns = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5, indexing="ij")
    _, d = CAMERA.rays(columns.ravel(), rows.ravel(), (SIZE, SIZE))
    expected = environment_lookup(env.pixels, d @ R)  # L'(w) = L(R^T w)
    assert oracles.relative_rms(turned.radiance.reshape(-1, 3), expected) < 1e-3


@pytest.mark.parametrize("size", [(128, 256), (64, 256), (64, 64), (128, 64)])
def test_a_background_too_large_for_a_texture_is_averaged_down(renderer, glossy, monkeypatch, size):
    env = light("daylight").resized(size)
    renderer.resources.release()
    monkeypatch.setitem(renderer.gl.info, "GL_MAX_TEXTURE_SIZE", 64)
    found = renderer.render(Scene([Object(Sphere(), glossy)], CAMERA, env))
    fitting = env.resized((min(size[0], 64), 64))
    expected = renderer.render(Scene([Object(Sphere(), glossy)], CAMERA, fitting))
    np.testing.assert_array_equal(found.radiance, expected.radiance)
    assert renderer.gl.error == "GL_NO_ERROR"


def test_a_texture_too_large_is_said(renderer, glossy, monkeypatch):
    monkeypatch.setitem(renderer.gl.info, "GL_MAX_TEXTURE_SIZE", 16)
    for shape in ((16, 17, 3), (17, 16, 3)):
        scene = Scene([Object(Sphere(), glossy, np.ones(shape, np.float32))], CAMERA)
        with pytest.raises(
            ValueError, match=rf"^texture must have at most 16 texels .*, got {shape[1]} x {shape[0]}$"
        ):
            renderer.render(scene)
    fits = Object(Sphere(), glossy, np.ones((16, 16, 3), np.float32))
    assert renderer.render(Scene([fits], CAMERA)).coverage.any()


def test_lat_long_maps_are_made_anew_as_cubes(renderer, glossy):
    env = Environment.daylight(size=64)
    maps = prefilter(env, brdf.GGX(0.4), orders=(10, 3))
    assert maps.layout == "latlong"
    renderer.map_size = 32
    pictures = [renderer.render(Scene([Object(Sphere(), rm)], CAMERA)).radiance for rm in (maps, glossy)]
    np.testing.assert_allclose(*pictures, atol=1e-5 * pictures[0].max())


def test_nothing_piles_up_on_the_gpu(contexts):
    env = Environment.daylight(size=32)
    renderer = Renderer((16, 16), context=contexts["egl"])
    maps = [
        prefilter(env, brdf.GGX(a), orders=(4, p), size=8, layout="cube") for a, p in ((0.3, 1), (0.5, 2))
    ]
    counts = set()
    for frame in range(60):
        viewer = ("near", "distant")[frame % 2]
        renderer.render(Scene([Object(Sphere(), maps[frame % 3 % 2])], CAMERA, env, viewer))
        counts.add(len(renderer.resources))
    assert counts == {3}  # background, shape, lobe
    assert renderer.gl.error == "GL_NO_ERROR"


class Plane:
    """A shape for rays alone."""

    def intersect(self, origins, directions):
        raise NotImplementedError


def test_what_cannot_be_drawn_is_said(contexts, glossy):
    renderer = Renderer((8, 8), context=contexts["egl"])
    env = Environment.daylight(size=32)
    with pytest.raises(TypeError, match=r"to be drawn by the GPU, got Angular"):
        renderer.render(Scene([Object(Sphere(), prefilter_angular(env, brdf.Phong(4)))], CAMERA))
    with pytest.raises(TypeError, match="a Mesh or a Sphere to be drawn, got Plane"):
        renderer.render(Scene([Object(Plane(), glossy)], CAMERA))
    with pytest.raises(ValueError, match=r"shape\[1\] must be in \[1, 16384\], got 0"):
        Renderer((4, 0), context=renderer.context)


def test_no_opengl_is_one_line_that_says_what_to_install(monkeypatch):
    from shrm.viewer.gpu import context

    def fails() -> Context:
        raise OSError("no\nlibrary")

    for name in ("_egl", "_osmesa", "_hidden_window"):
        monkeypatch.setattr(context, name, fails)
    with pytest.raises(
        ContextError, match=r"^no OpenGL without a display: apt-get install libegl1 .*$"
    ) as caught:
        offscreen()
    assert "\n" not in str(caught.value)
