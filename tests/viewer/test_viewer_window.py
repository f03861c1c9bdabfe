"""The window, driven without a person: what hands do, and what the picture does then."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from shrm.image_io import ImageWarning, read_image
from shrm.render import display
from shrm.viewer.gpu.context import ContextError
from shrm.viewer.window.choices import TECHNIQUES
from shrm.viewer.window.state import UNTURNED, State
from support.window_driver import GL, MIDDLE, SHAPE, WHOLE_PANEL, WIDTH, Application, Opened, glfw, same


def test_it_shows_the_objects_as_the_renderer_tone_maps_them(opened: Opened) -> None:
    hands = opened()
    shown, picture = hands.look(), hands.app.screen.picture()
    assert shown.shape == (240, 200, 3)
    assert picture.coverage[120, 100] == 1.0
    assert picture.coverage[2, 2] == 0.0
    assert shown[2, 2].any()
    expected = display(picture.radiance, hands.app.state.exposure)
    assert np.abs(shown.astype(int) - expected).max() <= 1


def test_left_drags_orbit_and_shifted_ones_pan(opened: Opened) -> None:
    hands = opened()
    app, before = hands.app, hands.look()
    eye = app.state.eye
    assert eye is not None
    hands.drag(glfw.MOUSE_BUTTON_LEFT, MIDDLE, (MIDDLE[0] + 60, MIDDLE[1] + 20))
    orbited = app.state.eye
    assert orbited is not None
    assert (orbited.azimuth, orbited.elevation) == pytest.approx((eye.azimuth - 24, eye.elevation + 8))
    assert not same(hands.look(), before)
    app.on_cursor(*MIDDLE)  # released: nothing follows
    assert app.state.eye == orbited
    hands.drag(glfw.MOUSE_BUTTON_MIDDLE, MIDDLE, (MIDDLE[0] + 10, MIDDLE[1]))
    hands.drag(glfw.MOUSE_BUTTON_LEFT, MIDDLE, (MIDDLE[0] + 10, MIDDLE[1]), mods=glfw.MOD_SHIFT)
    panned = app.state.eye
    assert panned is not None
    assert (panned.azimuth, panned.target == eye.target) == (orbited.azimuth, False)
    app.on_scroll(0.0, 2.0)
    assert app.state.eye is not None
    assert app.state.eye.distance < panned.distance
    hands.press(glfw.KEY_F)
    assert app.state.eye.target == pytest.approx(eye.target)
    assert app.state.light == UNTURNED
    assert app.prefiltering.answered == 1  # no eye needs other maps


def test_right_drags_turn_the_light_and_what_is_behind(opened: Opened) -> None:
    hands = opened()
    app, before = hands.app, hands.look()
    eye, exposure = app.state.eye, app.state.exposure
    path = [(MIDDLE[0] + 12 * k, MIDDLE[1] + 5 * k) for k in range(6)]
    hands.drag(glfw.MOUSE_BUTTON_RIGHT, *path)
    hands.settle()
    assert app.result is not None
    assert app.result.request.light == app.state.light != UNTURNED
    assert (app.state.eye, app.state.exposure) == (eye, exposure)
    turned = hands.look()
    changed = np.abs(turned.astype(int) - before).max(axis=2) > 1
    assert changed[118:122, 60:140].mean() > 0.5  # on the sphere
    assert changed[:10].mean() > 0.5  # behind it
    hands.press(glfw.KEY_R)
    back = hands.look()
    assert np.abs(back.astype(int) - before).max() <= 1


@pytest.mark.slow
def test_a_slider_prefilters_while_it_moves(opened: Opened) -> None:
    hands = opened()
    app, before = hands.app, hands.look()
    left, right = hands.place("alpha", 0.3), hands.place("alpha", 0.9)
    app.on_cursor(*left)
    app.frame()
    app.on_mouse_button(glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, 0)
    app.frame()
    pictures = []
    for share in (0.0, 0.5, 1.0):
        app.on_cursor(left[0] + share * (right[0] - left[0]), left[1])
        hands.settle()  # the button is still down
        pictures.append(hands.look(away=False))
    app.on_mouse_button(glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, 0)
    hands.settle()
    assert all(not same(a, b) for a, b in zip([before, *pictures], pictures, strict=False))
    assert app.result is not None
    assert app.result.maps[0].brdf == app.state.materials[0] != "ggx(alpha=0.4)"
    assert app.state.eye is not None
    assert app.state.eye.azimuth == 0.0


@pytest.mark.slow
def test_controls_of_method_accuracy_and_picture(opened: Opened) -> None:
    hands = opened(WHOLE_PANEL)
    app = hands.app
    hands.click("orders F, P")
    assert app.result is not None
    assert app.state.orders == (app.result.maps[0].F, app.result.maps[0].P)
    hands.click("near (eq. 7)")
    assert app.state.viewer == "near"
    near = hands.look()
    hands.click("distant (eq. 12)")
    assert not same(hands.look(), near)
    with_background = hands.look()
    hands.click("background")
    assert not hands.look()[2, 2].any()
    hands.press(glfw.KEY_B)
    assert same(hands.look(), with_background)
    exposure = app.state.exposure
    hands.click("exposure")
    assert app.state.exposure != pytest.approx(exposure, abs=0.02)
    assert not app.state.automatic
    assert not same(hands.look(), with_background)
    hands.press(glfw.KEY_E)
    assert app.state.automatic
    assert app.state.exposure == pytest.approx(exposure, abs=0.02)  # found with fewer samples at first


@pytest.mark.slow
def test_objects_are_added_and_removed(opened: Opened) -> None:
    hands = opened(WHOLE_PANEL, materials=("lambert:0.8", "phong:8"))
    app, before = hands.app, hands.look()
    assert app.result is not None
    assert len(app.result.maps) == 2
    hands.click("Add object")
    assert app.state.materials == ("lambert:0.8", "phong:8", "lambert:0.8")
    assert app.state.selected == 2
    assert not same(hands.look(), before)
    hands.click("object 2")
    assert app.state.selected == 1
    hands.click("object 3")
    hands.click("Remove")
    assert same(hands.look(), before)


def test_a_wrong_material_is_said_and_the_last_one_comes_back(opened: Opened) -> None:
    hands = opened()
    app, before = hands.app, hands.look()
    app.state = app.state.with_material(0, "velvet:3")
    hands.settle()
    assert "velvet" in app.fault
    assert app.state.materials == ("ggx:0.4",)
    assert same(hands.look(), before)


def test_resizing_and_hiding_the_panel(opened: Opened) -> None:
    hands = opened()
    glfw.set_window_size(hands.app.window, WIDTH + 300, 260)
    hands.settle()
    assert hands.look().shape == (260, 300, 3)
    assert hands.app.screen.picture().radiance.shape == (260, 300, 3)
    hands.press(glfw.KEY_TAB)
    assert hands.look().shape == (260, WIDTH + 300, 3)
    glfw.set_window_size(hands.app.window, *SHAPE[::-1])
    hands.press(glfw.KEY_TAB)
    assert hands.look().shape == (240, 200, 3)
    glfw.set_window_size(hands.app.window, 100, 100)  # narrower than the panel
    hands.settle()
    glfw.set_window_size(hands.app.window, *SHAPE[::-1])
    hands.settle()
    assert hands.look().shape == (240, 200, 3)


def test_screenshots_are_what_is_shown(opened: Opened, tmp_path: Path) -> None:
    hands = opened()
    shown, picture = hands.look(), hands.app.screen.picture()
    hands.press(glfw.KEY_S)
    hands.press(glfw.KEY_S)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"shrm-00{number}{suffix}" for number in (1, 2) for suffix in (".exr", ".png")
    ]
    assert np.array_equal(read_image(tmp_path / "shrm-001.exr").pixels, picture.radiance)
    with pytest.warns(ImageWarning, match="decoded from sRGB"):
        stored = read_image(tmp_path / "shrm-001.png").pixels
    assert np.abs(display(stored).astype(int) - shown).max() <= 1


def test_the_state_is_saved_and_opened(opened: Opened, tmp_path: Path) -> None:
    hands = opened()
    hands.drag(glfw.MOUSE_BUTTON_LEFT, MIDDLE, (MIDDLE[0] + 40, MIDDLE[1]))
    hands.drag(glfw.MOUSE_BUTTON_RIGHT, MIDDLE, (MIDDLE[0] + 40, MIDDLE[1]))
    hands.settle()
    state, before = hands.app.state, hands.look()
    hands.press(glfw.KEY_S, glfw.MOD_CONTROL)
    assert State.load(tmp_path / "shrm-view.json") == state
    hands.app.state = replace(state, light=UNTURNED, materials=("ggx:0.4", "lambert:0.5"))
    hands.settle()
    assert hands.app.state.eye != state.eye
    assert not same(hands.look(), before)
    hands.press(glfw.KEY_O, glfw.MOD_CONTROL)
    assert hands.app.state == state
    assert same(hands.look(), before)


@pytest.mark.slow
def test_integration_agrees_with_the_maps(opened: Opened) -> None:
    hands = opened(materials=("lambert:0.8", "ggx:0.4"), viewer="near", background=False)
    drawn = hands.app.screen.picture()
    hands.press(glfw.KEY_2)
    integrated = hands.app.screen.picture()
    inside = drawn.coverage == 1.0
    difference = (integrated.radiance - drawn.radiance)[inside]
    assert hands.app.comparison.says.startswith("integrated: the maps are ")
    assert np.any(difference != 0.0)
    assert np.sqrt((difference**2).mean() / (drawn.radiance[inside] ** 2).mean()) < hands.app.state.tolerance
    hands.press(glfw.KEY_3)
    shown = hands.app.screen.picture().radiance[inside]
    assert shown == pytest.approx(8.0 * np.abs(difference), abs=1e-4)
    hands.press(glfw.KEY_1)
    assert np.array_equal(hands.app.screen.picture().radiance, drawn.radiance)


@pytest.mark.slow
def test_techniques_are_compared(opened: Opened) -> None:
    hands = opened(WHOLE_PANEL, materials=("ggx(alpha=0.4,f0=0.04)",), orders=(6, 4), viewer="near")
    choices = [choice for choice, _, _ in TECHNIQUES]
    app, pictures = hands.app, {choices[0]: hands.look()}
    for choice in choices[1:]:
        hands.press(glfw.KEY_M)
        assert (app.state.technique, app.state.filter) == choice
        pictures[choice] = hands.look()
    assert not any(same(pictures[a], pictures[b]) for a, b in combinations(choices, 2))
    hands.press(glfw.KEY_2)
    answered, off = app.comparison.worker.answered, {}
    for _ in choices:
        drawn, integrated = app.screen.drawn_picture(), app.screen.picture()
        inside = (drawn.coverage == 1.0) & (integrated.coverage == 1.0)
        difference = (drawn.radiance - integrated.radiance)[inside]
        expected = np.sqrt((difference**2).sum() / (integrated.radiance[inside] ** 2).sum())
        found = re.fullmatch(r"integrated: the maps are (.+) % off", app.comparison.says)
        assert found
        off[app.state.technique, app.state.filter] = float(found[1])
        assert float(found[1]) == pytest.approx(100 * expected, rel=0.06)  # two digits; half-covered pixels
        hands.press(glfw.KEY_M)
    assert off["shrm", None] == min(off.values())
    assert off["kautz-mccool-3d", None] <= off["kautz-mccool-2d", None]
    assert max(off.values()) < 60.0
    assert app.comparison.worker.answered == answered  # the same integral serves all of them


@pytest.mark.slow
@pytest.mark.parametrize("filter", ["two-pass", "exact"])
def test_the_gpu_filters_for_a_turned_light_and_refuses_hair(opened: Opened, filter: str) -> None:
    filtered = {"technique": "kautz-mccool-2d", "filter": filter}
    hands = opened(materials=("ggx(alpha=0.4)",), **filtered, viewer="near")
    before = hands.look()
    hands.drag(glfw.MOUSE_BUTTON_RIGHT, MIDDLE, (MIDDLE[0] + 80, MIDDLE[1]))
    hands.settle()
    turned = hands.look()
    assert not same(turned, before)
    # As the SHRM turns: both are approximations of one picture.
    hands.app.state = replace(hands.app.state, technique="shrm", filter=None)
    hands.settle()
    frequency = hands.look()
    assert np.abs(frequency.astype(int) - turned).mean() < np.abs(frequency.astype(int) - before).mean()
    hands.app.state = replace(hands.app.state, **filtered, materials=("kajiya-kay(exponent=8)",))
    hands.settle()
    assert "about the tangent" in hands.app.fault
    assert (hands.app.state.technique, hands.app.state.filter) == ("shrm", None)


def test_more_maps_than_layers_are_said_and_the_viewer_goes_far(
    opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    hands = opened(orders=(6, 2))
    app, before = hands.app, hands.look()
    monkeypatch.setitem(app.context.gl.info, "GL_MAX_ARRAY_TEXTURE_LAYERS", 6 * 9 - 1)
    app.state = replace(app.state, viewer="near")
    hands.settle()
    assert "distant viewer" in app.fault
    assert app.state.viewer == "distant"
    assert same(hands.look(), before)


def test_keys_are_listed_and_end_it(opened: Opened) -> None:
    hands = opened()
    before = hands.look()
    hands.app.on_char(ord("?"))
    hands.settle()
    assert not same(hands.look(), before)
    hands.app.on_char(ord("?"))
    hands.settle()
    assert same(hands.look(), before)
    hands.press(glfw.KEY_ESCAPE)
    assert same(hands.look(), before)
    hands.app.on_key(glfw.KEY_Q, 0, glfw.PRESS, 0)
    hands.app.run()  # and returns


@pytest.mark.slow
def test_two_hundred_frames_leave_as_many_objects_on_the_gpu(opened: Opened) -> None:
    hands = opened()
    app = hands.app

    def objects() -> int:
        kinds = (GL.glIsTexture, GL.glIsBuffer, GL.glIsFramebuffer, GL.glIsVertexArray, GL.glIsProgram)
        return sum(bool(exists(name)) for exists in kinds for name in range(1, 2000))

    def frames(count: int) -> None:
        app.on_cursor(*MIDDLE)
        for index in range(count):
            app.on_mouse_button(glfw.MOUSE_BUTTON_LEFT + index % 2, glfw.PRESS, 0)
            app.on_cursor(MIDDLE[0] + index % 50, MIDDLE[1])
            app.on_mouse_button(glfw.MOUSE_BUTTON_LEFT + index % 2, glfw.RELEASE, 0)
            app.frame()
            if index % 40 == 0:
                app.state = app.state.with_material(0, f"ggx:{0.4 + 0.0005 * index:.3f}")
                hands.settle()
        hands.settle()

    frames(20)
    before = objects(), len(app.renderer.resources)
    frames(200)
    assert (objects(), len(app.renderer.resources)) == before
    assert GL.glGetError() == 0


def test_the_first_fault_ends_it(screen: None, tmp_path: Path) -> None:
    app = Application(State(environment=str(tmp_path / "missing.hdr")), SHAPE, visible=False)
    with pytest.raises((OSError, ValueError), match="missing"):
        app.run()
    app.close()


@pytest.mark.slow
def test_without_a_display_one_line_says_what_to_do() -> None:
    without = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    code = "import sys; from shrm.cli import main; sys.exit(main(['view']))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=without)
    assert done.returncode == 1
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert "DISPLAY" in line
    assert "shrm render --gpu" in line
    assert issubclass(ContextError, RuntimeError)


@pytest.mark.parametrize(
    "arguments", [("--brdf", "velvet:1"), ("--size", "3"), ("--near", "--distant"), ("--orders", "3")]
)
def test_a_wrong_command_line_opens_nothing(
    shrm: Callable[..., tuple[int, str, str]], arguments: tuple[str, ...]
) -> None:
    status, out, err = shrm("view", *arguments)
    assert status == 2
    assert out == ""
    assert len(err.splitlines()) == 1
