"""What is drawn, and what draws it: said in one line, and in a pickle what is not on the GPU."""

from __future__ import annotations

import pickle
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from shrm import Environment, brdf, prefilter, viewer
from shrm.render import Camera, Object, Sphere
from support.opengl import context

SKY = Environment.daylight(size=16)
ON_THE_GPU = ("Context", "HardwarePrefilter", "Renderer")


@pytest.fixture(scope="module")
def values() -> Iterator[dict[str, Any]]:
    gl = context("egl")
    light = prefilter(SKY, brdf.Lambert(0.5), orders=(2, 0))
    with (
        viewer.Renderer((8, 16), context=gl) as renderer,
        viewer.HardwarePrefilter(brdf.Phong(8), size=16, context=gl) as hardware,
    ):
        hardware.update(SKY)
        maps = hardware.maps()
        yield {
            "Context": gl,
            "HardwarePrefilter": hardware,
            "ParaboloidMap": maps.maps[0],
            "ParaboloidMaps": maps,
            "Renderer": renderer,
            "Scene": viewer.Scene([Object(Sphere(), light)], Camera((4.0, 1.0, 1.0)), SKY),
        }
    gl.release()


def test_every_public_class_is_listed(values: dict[str, Any]) -> None:
    public = {name for name in viewer.__all__ if isinstance(getattr(viewer, name), type)}
    assert public - {"ContextError"} == set(values)
    assert {name for name, value in values.items() if type(value) is not getattr(viewer, name)} == set()


def test_values_are_said_in_one_line(values: dict[str, Any]) -> None:
    for name, value in values.items():
        text = repr(value)
        assert re.match(rf"<?{name}\b", text), name
        assert "\n" not in text
        assert "array(" not in text
        assert len(text) < 200


def test_values_come_back_from_a_pickle(values: dict[str, Any]) -> None:
    for name in values.keys() - set(ON_THE_GPU):
        assert repr(pickle.loads(pickle.dumps(values[name]))) == repr(values[name])
    maps = values["ParaboloidMaps"]
    again = pickle.loads(pickle.dumps(maps))
    np.testing.assert_array_equal(again.maps[0].pixels, maps.maps[0].pixels)


def test_what_is_on_the_gpu_is_not_pickled(values: dict[str, Any]) -> None:
    for name in ON_THE_GPU:
        with pytest.raises(TypeError, match="pickle"):
            pickle.dumps(values[name])


@pytest.mark.parametrize(
    ("changed", "error", "text"),
    [
        ({"objects": [Sphere()]}, TypeError, r"objects\[0\] must be an Object, got Sphere"),
        ({"camera": None}, TypeError, "camera must be a Camera"),
        ({"viewer": "far"}, ValueError, "viewer must be one of near, distant"),
        ({"rotation": 2.0 * np.eye(3)}, ValueError, "rotation must be a rotation"),
    ],
)
def test_scenes_are_checked_at_the_door(changed: dict[str, Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        viewer.Scene(**{"objects": [], "camera": Camera((4.0, 1.0, 1.0)), **changed})
