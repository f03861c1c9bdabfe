"""What the window is: its file, and materials as sliders."""

import argparse
import json
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from shrm import brdf
from shrm.cli import parser, view
from shrm.render import Tangents
from shrm.viewer.window.materials import KINDS, kind_of, value_of, with_value
from shrm.viewer.window.orbit import Orbit
from shrm.viewer.window.state import Filter, State, Technique


def unlike_the_default() -> State:
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return State(
        environment="sky ünï.hdr",
        layout="vertical-cross",
        border=2,
        repair=True,
        materials=("lambert:0.5", "0.5*lambert:0.8 + ggx:0.2"),
        mesh="bunny.ply",
        up="z",
        tangents="principal",
        tolerance=0.03,
        orders=(12, 2),
        technique="kautz-mccool-2d",
        filter="exact",
        viewer="near",
        shown="difference",
        automatic=False,
        exposure=-1.25,
        background=False,
        eye=Orbit(12.5, -3.0, 7.0, (1.0, 2.0, 3.0), 40.0),
        selected=1,
        transfer="bunny.shrt",
        variant="shadowed",
        components=25,
        tents=7,
        window="lanczos",
        turning=True,
    ).with_light(turned)


def test_a_saved_state_is_read_as_it_was(tmp_path: Path) -> None:
    for state in (State(), unlike_the_default()):
        state.save(tmp_path / "state.json")
        assert State.load(tmp_path / "state.json") == state


@pytest.mark.parametrize(
    "change",
    [
        {"format": "something else"},
        {"technique": "guess"},
        {"technique": "cabral"},  # which no filter makes
        {"filter": "one"},
        {"method": "shrm"},
        {"exposure": 10**400},
        {"exposure": True},
        {"orders": [1, 2, 3]},
        {"light": [[10**400, 0, 0], [0, 1, 0], [0, 0, 1]]},
        {"eye": {"distance": -1.0}},
        {"eye": {"distance": 1e308}},
        {"eye": {"target": [1.0]}},
        {"eye": {"target": [1e308, 0.0, 0.0]}},
        {"eye": {"fov": 1e-300}},
        {"viewer": "sideways"},
        {"tangents": "along"},
        {"tangents": None},
        {"shown": 3},
        {"tolerance": 2.0},
        {"orders": [3]},
        {"orders": "ab"},
        {"materials": []},
        {"materials": "ggx:0.3"},
        {"light": [[1, 0, 0], [0, 2, 0], [0, 0, 1]]},
        {"light": 5},
        {"eye": {"azimuth": "north"}},
        {"eye": {"azimuth": 0.0, "roll": 1.0}},
        {"eye": {"distance": 0.0}},
        {"eye": 3},
        {"selected": 2},
        {"exposure": "bright"},
        {"environment": None},
        {"background": 1},
        {"transfer": 3},
        {"variant": "dark"},
        {"components": 0},
        {"components": 2.5},
        {"tents": 1},
        {"window": "hamming"},
        {"turning": 1},
        {"volume": 11},
    ],
    ids=str,
)
def test_a_wrong_file_is_one_line_that_names_it(tmp_path: Path, change: dict[str, object]) -> None:
    path = tmp_path / "state.json"
    unlike_the_default().save(path)
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(ValueError, match=r"state\.json: ") as fault:
        State.load(path)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"[1, 2]", b"{", b"null"])
def test_garbage_is_no_state(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "state.json").write_bytes(content)
    with pytest.raises(ValueError, match=r"state\.json: "):
        State.load(tmp_path / "state.json")


def test_every_kind_of_material_has_sliders_for_all_its_numbers() -> None:
    for name, kind in KINDS.items():
        material = brdf.parse(kind.example)
        assert kind_of(material) == name
        for parameter in kind.parameters:
            value = value_of(material, parameter)
            assert brdf.parse(with_value(material, parameter, value)) == material
            for end in (parameter.low, parameter.high):
                moved = brdf.parse(with_value(material, parameter, (end,) * 3 if parameter.color else end))
                assert value_of(moved, parameter) == ((end,) * 3 if parameter.color else end)


def test_a_sum_has_no_sliders() -> None:
    assert kind_of(brdf.parse("0.5*lambert:0.8 + ggx:0.2")) is None
    assert kind_of(brdf.parse("0.5*lambert:0.8")) is None


def test_a_color_s_channels_are_kept() -> None:
    f0 = KINDS["ggx"].parameters[1]
    gold = with_value(brdf.GGX(0.3), f0, (1.0, 0.71, 0.29))
    assert brdf.parse(gold) == brdf.GGX(0.3, (1.0, 0.71, 0.29))


def test_the_command_line_says_otherwise_than_a_saved_window(tmp_path: Path) -> None:
    path = tmp_path / "state.json"
    unlike_the_default().save(path)

    def begun(*arguments: str) -> State:
        return view.state(parser().parse_args(["view", *arguments]))

    assert begun() == State()
    assert begun("--state", str(tmp_path / "none yet.json")) == State()
    assert begun("--state", str(path)) == unlike_the_default()
    changed = begun(
        "--state", str(path), "--brdf", "phong:8", "--tolerance", "0.2", "--exposure", "1", "--distant"
    )
    assert changed.materials == ("phong:8",)
    assert (changed.selected, changed.eye, changed.orders, changed.tolerance) == (0, None, None, 0.2)
    assert (changed.exposure, changed.automatic, changed.viewer) == (1.0, False, "distant")
    assert changed.light == unlike_the_default().light
    given = ("--mesh", "a.ply", "--up", "z", "--tangents", "uv", "--no-background", "--orders", "9,2")
    assert begun("sky.hdr", *given) == State(
        environment=str(Path("sky.hdr").absolute()),
        mesh=str(Path("a.ply").absolute()),
        up="z",
        tangents="uv",
        background=False,
        orders=(9, 2),
    )


def test_the_command_knows_the_techniques_filters_and_tangents() -> None:
    """Its own lists spare --help the core."""
    command = argparse.ArgumentParser()
    view.add_arguments(command)
    choices = {action.dest: action.choices for action in command._actions}
    assert choices["technique"] == get_args(Technique)
    assert choices["filter"] == get_args(Filter)
    assert choices["tangents"] == get_args(Tangents)
