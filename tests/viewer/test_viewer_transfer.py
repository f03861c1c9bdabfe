"""Objects with transfer in the window, driven without a person, and by OpenGL alone."""

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from shrm import Environment, brdf, sh
from shrm.integrate.angular import integrate
from shrm.render import Camera, Mesh, Object, TransferredMesh, VertexRadiance, about_vertical, render
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.viewer import Context, Renderer, Scene
from shrm.viewer.window.state import State
from support import opengl, oracles
from support.transfer_objects import COMPONENTS, GLOSSY, M, N, broken, globe, transferred
from support.window_driver import MIDDLE, SHAPE, WHOLE_PANEL, Application, Hands, Opened, glfw, same


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "globe.shrt"
    transferred(16, 32).save(path)
    return path


def expected(hands: Hands, path: Path, sky: Path) -> np.ndarray:
    """What the library draws of the window's state, with as many samples."""
    state = hands.app.state
    assert state.eye is not None
    transfer, env = RadianceTransfer.load(path), Environment.read(sky)
    thing = TransferredMesh.placed(transfer)
    light = thing.light(env.coefficients(N - 1), state.R, state.window)
    lighting = transfer.lighting(state.variant, components=state.components, tents=state.tents)
    lit = thing.lit(lighting, light, state.eye.camera, state.viewer)
    return render([Object(thing.mesh, lit)], state.eye.camera, hands.app.screen.shape, samples=3).radiance


def matches(hands: Hands, path: Path, sky: Path) -> bool:
    picture = hands.app.screen.picture()
    inside = picture.coverage == 1.0
    assert inside.mean() > 0.05
    # Samples near a silhouette may see its other side.
    inside[1:-1, 1:-1] &= inside[2:, 1:-1] & inside[:-2, 1:-1] & inside[1:-1, 2:] & inside[1:-1, :-2]
    there = expected(hands, path, sky)[inside]
    return float(np.abs(picture.radiance[inside] - there).max()) < 1e-4 * float(there.max())


# ---- The window


@pytest.mark.slow
@pytest.mark.parametrize("viewer", ["near", "distant"])
def test_it_shows_what_the_library_draws(opened: Opened, sky: Path, file: Path, viewer: str) -> None:
    hands = opened(transfer=str(file), viewer=viewer)
    assert hands.app.fault == ""
    assert matches(hands, file, sky)
    assert hands.app.drawing.relit.seconds > 0.0
    hands.drag(glfw.MOUSE_BUTTON_LEFT, MIDDLE, (MIDDLE[0] + 60, MIDDLE[1] + 20))
    hands.settle()
    assert matches(hands, file, sky)
    hands.drag(glfw.MOUSE_BUTTON_RIGHT, MIDDLE, (MIDDLE[0] + 60, MIDDLE[1] + 20))
    hands.settle()
    assert matches(hands, file, sky)
    assert hands.app.prefiltering.answered == 1  # light and eye take no worker


@pytest.mark.slow
def test_shadows_bounces_and_window_by_keys_and_in_the_panel(opened: Opened, sky: Path, file: Path) -> None:
    hands = opened(WHOLE_PANEL, transfer=str(file))
    app, pictures = hands.app, {"interreflected": hands.look()}
    for does, variant in (
        (lambda: hands.press(glfw.KEY_I), "shadowed"),
        (lambda: hands.press(glfw.KEY_H), "unshadowed"),
        (lambda: hands.click("interreflected"), "interreflected"),
        (lambda: hands.click("shadowed"), "unshadowed"),
        (lambda: hands.click("shadowed"), "shadowed"),
        (lambda: hands.press(glfw.KEY_I), "interreflected"),
    ):
        does()
        assert app.state.variant == variant
        assert same(hands.look(), pictures.setdefault(variant, hands.look()))
    assert not any(same(pictures[a], pictures[b]) for a in pictures for b in pictures if a != b)
    hands.press(glfw.KEY_W)
    assert app.state.window == "lanczos"
    hands.click("Hann")
    assert app.state.window == "hann"
    damped = hands.look()
    assert not same(damped, pictures["interreflected"])
    hands.press(glfw.KEY_W)
    assert same(hands.look(), pictures["interreflected"])


def test_without_other_variants_keys_and_boxes_do_nothing(opened: Opened, tmp_path: Path) -> None:
    transferred(variants=("shadowed",)).save(tmp_path / "one.shrt")
    hands = opened(WHOLE_PANEL, transfer=str(tmp_path / "one.shrt"))
    before = hands.look()
    hands.press(glfw.KEY_H)
    hands.press(glfw.KEY_I)
    hands.click("shadowed")
    hands.click("interreflected")
    assert same(hands.look(), before)
    assert hands.app.fault == ""


@pytest.mark.slow
def test_components_and_tents_by_sliders(opened: Opened, sky: Path, file: Path) -> None:
    hands = opened(WHOLE_PANEL, transfer=str(file))
    app, before = hands.app, hands.look()
    for name, least, most in (("components", 1, COMPONENTS), ("tents", 2, M)):
        pictures = []
        for share, value in ((0.0, least), (0.999, most)):
            hands.drag(glfw.MOUSE_BUTTON_LEFT, hands.place(name, 0.5), hands.place(name, share))
            hands.settle()
            assert getattr(app.state, name) == value
            pictures.append(hands.look())
        assert not same(pictures[0], before)
        assert same(pictures[1], before)
    app.state = replace(app.state, components=7, tents=3)
    hands.settle()
    assert matches(hands, file, sky)
    assert app.prefiltering.answered == 1


def test_light_turns_by_itself_as_time_passes(opened: Opened, sky: Path, file: Path) -> None:
    hands = opened(transfer=str(file))
    app, now = hands.app, [100.0]
    app.clock = lambda: now[0]
    app.on_key(glfw.KEY_T, 0, glfw.PRESS, 0)
    app.frame()
    seen = []
    for _ in range(3):
        now[0] += 2.0
        app.frame()
        seen.append(app.screen.picture().radiance)
    assert not any(np.array_equal(a, b) for a, b in pairwise(seen))
    app.on_key(glfw.KEY_T, 0, glfw.PRESS, 0)
    hands.settle()
    np.testing.assert_allclose(app.state.R, about_vertical(6.0 * 30.0), atol=1e-12)
    assert matches(hands, file, sky)
    now[0] += 2.0
    app.frame()
    np.testing.assert_allclose(app.state.R, about_vertical(6.0 * 30.0), atol=1e-12)


@pytest.mark.slow
def test_frames_of_turning_light_leave_as_much_on_the_gpu(opened: Opened, file: Path) -> None:
    hands = opened(transfer=str(file), turning=False)
    app, now = hands.app, [0.0]
    app.clock = lambda: now[0]
    app.state = replace(app.state, turning=True)
    before = len(app.renderer.resources)
    for step in range(100):
        now[0] += 0.05
        if step % 20 == 0:
            app.state = replace(app.state, components=1 + step // 2, tents=2 + step % 3)
        app.frame()
    assert len(app.renderer.resources) == before
    assert app.fault == ""


# ---- Compared with plain shading

ANISOTROPIC = brdf.AnisotropicGGX(0.5, 0.25, f0=(1.0, 0.7, 0.3))


@pytest.mark.slow
@pytest.mark.parametrize("material", [GLOSSY, ANISOTROPIC], ids=["isotropic", "anisotropic"])
def test_plain_shading_is_integrated_in_the_same_light(
    opened: Opened, sky: Path, tmp_path: Path, material: brdf.BRDF
) -> None:
    transferred(16, 32, material=material).save(tmp_path / "globe.shrt")
    hands = opened(transfer=str(tmp_path / "globe.shrt"), viewer="near", background=False)
    app = hands.app
    app.on_cursor(*MIDDLE)
    app.on_scroll(0.0, -5.0)  # fewer pixels to integrate
    app.state = app.state.with_light(about_vertical(50.0))
    hands.press(glfw.KEY_W)
    drawn = app.screen.picture()
    hands.press(glfw.KEY_2)
    integrated = app.screen.picture()
    assert not np.array_equal(integrated.radiance, drawn.radiance)

    # The same, found here at a few pixels: light by its harmonics, in many more texels.
    assert app.state.eye is not None
    coefficients = Environment.read(sky).coefficients(N - 1)
    damped = np.repeat(np.sinc(np.arange(N) / N), 2 * np.arange(N) + 1)[:, None] * coefficients
    light = Environment(sh.synthesis(damped, (90, 180)).astype(np.float32)).rotated(about_vertical(50.0))
    mesh = TransferredMesh.placed(RadianceTransfer.load(tmp_path / "globe.shrt")).mesh
    rows, columns = np.array([100.5, 110.5, 120.5, 135.5]), np.array([100.5, 85.5, 115.5, 105.5])
    origins, directions = app.state.eye.camera.rays(columns, rows, (240, 200))
    hits = mesh.intersect(origins, directions)
    assert hits.tangents is not None
    there = integrate(light, material, hits.normals, -directions, hits.tangents)
    found = integrated.radiance[rows.astype(int), columns.astype(int)]
    np.testing.assert_allclose(found, there, rtol=0.02)  # of 32 rows of texels, each of one color

    def off() -> float:
        match = re.fullmatch(r"integrated: with transfer it is (.+) % off", app.comparison.says)
        assert match
        return float(match[1])

    shadowed, answered = off(), app.comparison.worker.answered
    hands.press(glfw.KEY_H)
    assert app.state.variant == "unshadowed"
    assert off() < min(shadowed, 10.0)  # of few tents
    assert app.comparison.worker.answered == answered  # plain shading knows no shadows
    hands.press(glfw.KEY_3)
    drawn = app.screen.drawn_picture()
    inside = (drawn.coverage == 1.0) & (integrated.coverage == 1.0)
    difference = 8.0 * np.abs(drawn.radiance - integrated.radiance)[inside]
    assert app.screen.picture().radiance[inside] == pytest.approx(difference, abs=1e-4)


def test_a_material_without_text_is_not_integrated(opened: Opened, tmp_path: Path) -> None:
    transferred(named="moss / stone").save(tmp_path / "moss.shrt")
    hands = opened(transfer=str(tmp_path / "moss.shrt"))
    before = hands.look()
    hands.press(glfw.KEY_2)
    assert "moss" in hands.app.fault
    assert "\n" not in hands.app.fault
    assert hands.app.state.shown == "maps"
    assert same(hands.look(), before)


# ---- Files


@pytest.mark.slow
def test_objects_are_dropped_and_left(opened: Opened, file: Path, tmp_path: Path) -> None:
    hands = opened(WHOLE_PANEL)
    app, before = hands.app, hands.look()
    app.on_drop([str(file)])
    hands.settle()
    transferred_look = hands.look()
    assert not same(transferred_look, before)
    hands.click("Back to materials")
    hands.press(glfw.KEY_F)
    hands.press(glfw.KEY_E)
    assert same(hands.look(), before)
    app.on_drop([str(file)])
    hands.settle()
    (tmp_path / "triangle.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    app.on_drop([str(tmp_path / "triangle.obj")])
    hands.settle()
    assert (app.state.transfer, app.fault) == (None, "")
    assert app.result is not None
    assert app.result.transferred is None


@pytest.mark.parametrize("how", broken(bytes(2000)))
def test_a_broken_object_leaves_the_picture(opened: Opened, file: Path, tmp_path: Path, how: str) -> None:
    hands = opened(transfer=str(file))
    app, before, state = hands.app, hands.look(), hands.app.state
    (tmp_path / "broken.shrt").write_bytes(broken(file.read_bytes())[how])
    app.on_drop([str(tmp_path / "broken.shrt")])
    hands.settle()
    assert "broken.shrt" in app.fault
    assert "\n" not in app.fault
    assert app.state == state
    assert same(hands.look(), before)


def test_the_state_is_saved_and_opened(opened: Opened, file: Path, tmp_path: Path) -> None:
    changed = {"variant": "shadowed", "components": 12, "tents": 3, "window": "hann", "turning": False}
    hands = opened(transfer=str(file), **changed)
    state, before = hands.app.state, hands.look()
    hands.press(glfw.KEY_S, glfw.MOD_CONTROL)
    assert State.load(tmp_path / "shrm-view.json") == state
    hands.app.state = State(environment=state.environment)
    hands.settle()
    assert not same(hands.look(), before)
    hands.press(glfw.KEY_O, glfw.MOD_CONTROL)
    assert hands.app.state == state
    assert same(hands.look(), before)


def test_the_first_object_that_is_broken_ends_it(screen: None, tmp_path: Path, sky: Path) -> None:
    state = State(environment=str(sky), transfer=str(tmp_path / "missing.shrt"))
    app = Application(state, SHAPE, visible=False)
    with pytest.raises((OSError, ValueError), match="missing"):
        app.run()
    app.close()


# ---- By OpenGL


@pytest.fixture(params=["egl", "osmesa"])
def context(request: pytest.FixtureRequest) -> Iterator[Context]:
    found = opengl.context(request.param)
    yield found
    found.release()


@pytest.mark.parametrize(
    "camera",
    [
        Camera((4.0, 2.0, 1.5), fov=32.0),
        Camera((3.0, 1.0, 2.0), height=3.0),
        Camera((0.1, 0.0, 0.1), (1.0, 0.3, 0.2), fov=60),
    ],
    ids=["near", "orthographic", "inside"],
)
def test_radiance_at_vertices_is_drawn_as_on_the_cpu(context: Context, camera: Camera) -> None:
    vertices, faces, uv = globe()
    mesh = Mesh(vertices.astype(float), faces.astype(int), uv=uv).placed()
    texture = np.linspace(0.5, 1.0, 48, dtype=np.float32).reshape(4, 4, 3)
    places, place = np.unique(vertices, axis=0, return_inverse=True)  # on the seam both sides have the same
    values = np.random.default_rng(0).random((len(places), 3)).astype(np.float32)[place.reshape(-1)]
    with Renderer((96, 96), samples=2, context=context) as renderer:
        for radiance in (values, 1.0 - values):
            for shown in (None, texture):
                things = [Object(mesh, VertexRadiance(radiance), shown)]
                found = renderer.render(Scene(things, camera))
                there = render(things, camera, (96, 96), samples=2)
                both = (found.coverage == 1) & (there.coverage == 1)
                assert both.sum() > 0.9 * max((found.coverage == 1).sum(), 1)
                assert oracles.relative_rms(found.radiance[both], there.radiance[both]) < 1e-3
