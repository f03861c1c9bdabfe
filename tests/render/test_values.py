"""What pictures are made of are values: said in one line, and the same after a pickle."""

from __future__ import annotations

import pickle
import re
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest
import shrm
from shrm import render
from support.transfer_objects import globe, transferred

VERTICES, FACES, UV = globe(4, 8)
MESH = render.Mesh(VERTICES, FACES, uv=UV)
CAMERA = render.Camera((4.0, 1.0, 1.0))
RADIANCE = render.VertexRadiance(np.full((len(VERTICES), 3), 0.5, np.float32))
MAP = shrm.prefilter(shrm.Environment.daylight(size=16), shrm.brdf.Lambert(0.5), orders=(2, 0))

VALUES: dict[str, Any] = {
    "Camera": CAMERA,
    "Hits": MESH.intersect(*CAMERA.rays(np.arange(5.0), np.arange(5.0), (5, 5))),
    "Mesh": MESH.with_tangents("principal"),
    "Object": render.Object(MESH, MAP, np.ones((2, 3, 3))),
    "Picture": render.render([render.Object(MESH, RADIANCE)], CAMERA, (5, 6)),
    "Placement": MESH.placement((0.0, 1.0, 2.0), turn=30.0),
    "Sphere": render.Sphere((1.0, 2.0, 3.0), 0.5),
    "TransferredMesh": render.TransferredMesh.placed(transferred(), turn=30.0),
    "VertexRadiance": RADIANCE,
}


def require_same(a: object, b: object) -> None:
    """Compare what two values hold, field by field."""
    assert type(a) is type(b)
    if is_dataclass(a):
        for item in fields(a):
            require_same(getattr(a, item.name), getattr(b, item.name))
    elif isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b)
    elif isinstance(a, tuple | list):
        for x, y in zip(a, b, strict=True):
            require_same(x, y)
    elif isinstance(a, str | int | float | None):
        assert a == b


def test_every_public_class_is_listed() -> None:
    public = {name for name in render.__all__ if isinstance(getattr(render, name), type)}
    protocols = {name for name in public if getattr(getattr(render, name), "_is_protocol", False)}
    assert public - protocols == set(VALUES)
    assert {name for name, value in VALUES.items() if type(value) is not getattr(render, name)} == set()


@pytest.mark.parametrize("name", VALUES)
def test_a_value_is_said_in_one_line(name: str) -> None:
    text = repr(VALUES[name])
    assert re.match(rf"<?{name}\b", text)
    assert "\n" not in text
    assert "array(" not in text
    assert len(text) < 200


@pytest.mark.parametrize("name", VALUES)
def test_a_value_comes_back_from_a_pickle(name: str) -> None:
    value = VALUES[name]
    again = pickle.loads(pickle.dumps(value))
    assert repr(again) == repr(value)
    require_same(value, again)


def test_a_mesh_that_has_traced_rays_comes_back_from_a_pickle() -> None:
    """What Embree holds stays behind, and is built again."""
    rays = CAMERA.rays(*np.random.default_rng(0).uniform(0.0, 9.0, (2, 50)), (9, 9))
    expected = MESH.intersect(*rays)
    require_same(pickle.loads(pickle.dumps(MESH)).intersect(*rays), expected)
