"""Files that are dropped upon the window: what is shown then, and what is said of those that are none."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - to make a picture that image_io does not write
import pytest
from shrm import Environment
from shrm.image_io import write_image
from support.window_driver import MIDDLE, WHOLE_PANEL, WIDTH, Opened, glfw, same


@pytest.mark.slow
def test_pictures_and_meshes_are_dropped(opened: Opened, tmp_path: Path) -> None:
    hands = opened(WHOLE_PANEL)
    app, before = hands.app, hands.look()
    write_image(tmp_path / "other.exr", Environment.daylight(size=32).pixels)
    app.on_drop([str(tmp_path / "other.exr")])
    hands.settle()
    lit = hands.look()
    assert not same(lit, before)
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    (tmp_path / "triangle.obj").write_text(triangle)
    app.on_drop([str(tmp_path / "triangle.obj")])
    hands.settle()
    assert not same(hands.look(), lit)
    assert app.fault == ""
    hands.click("Back to sphere")
    assert same(hands.look(), lit)


@pytest.mark.slow
def test_tangents_are_chosen_where_a_material_has_a_lobe_about_them(opened: Opened, tmp_path: Path) -> None:
    hands = opened(WHOLE_PANEL, materials=("banks:0.5",))
    app = hands.app
    assert "tangents" in app.panel.widgets.places  # though a sphere has no choice of them
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    (tmp_path / "bare.obj").write_text(corners + "f 1 2 3\n")
    (tmp_path / "aslant.obj").write_text(corners + "vt 0 0\nvt 1 1\nvt -1 1\nf 1/1 2/2 3/3\n")
    app.on_drop([str(tmp_path / "aslant.obj")])
    hands.settle()
    before, eye = hands.look(), app.state.eye

    def choose(line: int) -> None:
        hands.click("tangents")  # its list opens
        left, top, _, bottom = app.panel.widgets.places["tangents"]
        place = left + 20.0, bottom + 10.0 + 0.8 * (line - 0.5) * (bottom - top)
        hands.drag(glfw.MOUSE_BUTTON_LEFT, place)
        hands.settle()

    choose(2)
    assert (app.state.tangents, app.fault) == ("uv", "")
    along_u = hands.look()
    assert not same(along_u, before)
    assert app.state.eye == eye
    app.on_drop([str(tmp_path / "bare.obj")])
    hands.settle()
    assert "bare.obj: no texture coordinates" in app.fault
    assert same(hands.look(), along_u)
    assert app.state.mesh == str(tmp_path / "aslant.obj")
    choose(1)
    assert (app.state.tangents, app.fault) == ("axis", "")
    app.state = app.state.with_material(0, "ggx:0.4")
    hands.settle()
    assert "tangents" not in app.panel.widgets.places


@pytest.mark.slow
def test_a_refused_picture_is_repaired_or_given_its_layout(opened: Opened, tmp_path: Path) -> None:
    hands = opened(WHOLE_PANEL)
    app, before = hands.app, hands.look()
    holed = np.ones((16, 32, 3), np.float32)
    holed[3, 5] = np.nan
    written = oiio.ImageBuf(holed)
    assert written.write(str(tmp_path / "holed.exr"))
    write_image(tmp_path / "odd.exr", np.ones((9, 25, 3), np.float32))
    app.on_drop([str(tmp_path / "holed.exr")])
    hands.settle()
    assert "holed.exr" in app.fault
    assert same(hands.look(), before)
    hands.click("repair")
    assert app.fault == app.refused == ""
    assert app.state.environment == str(tmp_path / "holed.exr")
    assert not same(hands.look(), before)
    app.on_drop([str(tmp_path / "odd.exr")])
    hands.settle()
    assert "odd.exr" in app.fault  # nothing says how it shows the sphere
    assert app.state.environment == str(tmp_path / "holed.exr")
    hands.click("layout")  # its list opens
    left, _, _, bottom = app.panel.widgets.places["layout"]
    hands.drag(glfw.MOUSE_BUTTON_LEFT, (left + 20.0, bottom + 31.0))  # the second line of it
    hands.settle()
    assert (app.state.environment, app.state.layout) == (str(tmp_path / "odd.exr"), "latlong")
    assert app.fault == app.refused == ""


@pytest.mark.parametrize("name", ["garbage.hdr", "garbage.ply", "garbage.json", "garbage", "missing.exr"])
def test_what_is_no_picture_leaves_the_picture(opened: Opened, tmp_path: Path, name: str) -> None:
    hands = opened()
    app, before, state = hands.app, hands.look(), hands.app.state
    if "missing" not in name:
        (tmp_path / name).write_bytes(bytes(range(256)))
    quiet = hands.look(whole=True)[:40, :WIDTH]
    app.on_drop([str(tmp_path / name)])
    hands.settle()
    assert name in app.fault
    assert "\n" not in app.fault
    assert same(hands.look(), before)
    assert app.state == state
    red = hands.look(whole=True)[:40, :WIDTH].astype(int)
    assert not same(red.astype(np.uint8), quiet)
    assert (red[..., 0] - red[..., 1]).max() > 100
    hands.drag(glfw.MOUSE_BUTTON_RIGHT, MIDDLE, (MIDDLE[0] + 40, MIDDLE[1]))
    hands.settle()
    assert not same(hands.look(), before)
