"""Objects of transfer say what they are in one line, and come back from a pickle as they were."""

from __future__ import annotations

import importlib
import inspect
import pickle
import pkgutil
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shrm.transfer
from shrm import brdf
from shrm.transfer import RadianceTransfer, Route, Variant
from shrm.transfer.brdf_matrix import project
from shrm.transfer.directional_basis import DirectionalBasis
from shrm.transfer.file import Saved
from shrm.transfer.lighting import Convolution, Diffuse, FixedLight, FixedView, Lighting, Projection
from shrm.transfer.lighting.surface import Eye, Surface
from shrm.transfer.matrices.accuracy import Sample
from shrm.transfer.matrices.materials import Materials
from shrm.transfer.matrices.product import product
from shrm.transfer.matrices.vertex_matrices import Factors, Matrices
from shrm.transfer.precomputation import MeshLike, Precomputation
from shrm.transfer.rays.directions import local_directions
from shrm.transfer.rays.occluders import Occluders
from shrm.transfer.tangent_frames import vertex_frames
from support.transfer_components import exact
from support.transfer_contents import transfer
from support.transfer_meshes import Surface as MeshArrays
from support.transfer_meshes import bumpy
from support.transfer_vertices import EYE, FRAMES, POINTS, V, random, some_of
from support.visibility_folders import computed

GGX = brdf.GGX(0.5)
DIRECTIONS = local_directions(64)
VERTICES, FACES, NORMALS = bumpy(2)
WITHOUT_INSTANCES = {Lighting, MeshLike}
"""An abstract class, and a protocol."""


def examples(folder: Path) -> list[object]:
    """An object of every public class, and of those whose parts differ several."""
    held, frames = transfer(), vertex_frames(NORMALS)
    visibility = computed(folder)
    block = visibility[0]
    of_ggx = product(GGX, 3, 2, DIRECTIONS, Route(2))
    materials = Materials.of([GGX, brdf.Lambert(0.5)], np.ones((len(VERTICES), 2)), len(VERTICES))
    tents, compressed = some_of("tents", 1), some_of("compressed", 3)
    visible = np.ones((1, len(DIRECTIONS)), np.bool_)
    request: dict[str, Any] = dict.fromkeys(field.name for field in fields(Precomputation) if field.init)
    request |= {"mesh": MeshArrays(*bumpy(2)), "brdf": GGX, "order": 2, "directions": 64}
    request |= {"variants": ["shadowed"], "accuracy": 20.0, "half": True, "matrices": False}
    return [
        DirectionalBasis(5),
        Route(2, 3),
        project(GGX, 3, 2),
        held,
        *held.variants.values(),
        Variant(),
        Saved(**{field.name: getattr(held, field.name) for field in fields(Saved)}),
        visibility,
        block,
        block.hits,
        Occluders(VERTICES, FACES, NORMALS),
        of_ggx,
        Materials.of(GGX, None, 3),
        materials,
        Sample(DIRECTIONS, visible, DIRECTIONS, visible),
        Matrices(frames, materials, [of_ggx, of_ggx], 1, 2, folder),
        Factors(9, 1, random((4, 9, 4), 1)),
        exact(random((6, 9, 1, 4), 2), K=3),
        exact(random((6, 9, 1, 4), 2), K=3).halved(),
        Eye.checked(EYE, None),
        Surface(POINTS, FRAMES),
        tents,
        compressed,
        some_of("clustered", 1),
        FixedLight(tents),
        FixedView(compressed),
        Diffuse(random((V, 3, 25), 3)),
        Projection(POINTS, FRAMES, random((5, 5, 1, 25), 4)),
        Convolution(POINTS, FRAMES, np.linspace(1, 0.2, 5)),
        Precomputation(**request),
    ]


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> list[object]:
    return examples(tmp_path_factory.mktemp("visibility"))


def public_classes() -> set[type]:
    """Classes that a module of transfer defines, without exceptions and those of a leading underscore."""
    names = ["shrm.transfer"] + [
        module.name for module in pkgutil.walk_packages(shrm.transfer.__path__, "shrm.transfer.")
    ]
    defined = {
        member
        for name in names
        for _, member in inspect.getmembers(importlib.import_module(name), inspect.isclass)
        if member.__module__ == name and not member.__name__.startswith("_")
    }
    return {kind for kind in defined if not issubclass(kind, Exception)}


def require_same(actual: object, expected: object) -> None:
    """The same types, numbers and texts all the way down, except for what the core holds."""
    assert type(actual) is type(expected) or isinstance(expected, np.memmap)
    if isinstance(expected, np.ndarray):
        np.testing.assert_array_equal(np.asarray(actual), expected)
    elif isinstance(expected, dict):
        assert list(actual) == list(expected)
        for key in expected:
            require_same(actual[key], expected[key])
    elif isinstance(expected, list | tuple):
        assert len(actual) == len(expected)
        for a, b in zip(actual, expected, strict=True):
            require_same(a, b)
    elif type(expected).__module__.startswith(("shrm.transfer", "support.")):
        require_same(vars(actual), vars(expected))
    elif "_core" not in type(expected).__module__ and "embreex" not in type(expected).__module__:
        assert actual == expected


def test_every_public_class_has_an_example(objects: list[object]) -> None:
    described = [kind for kind in public_classes() if kind.__name__ != "Described"]
    assert set(described) - WITHOUT_INSTANCES == {type(example) for example in objects}


def test_reprs_are_one_line_that_names_the_class(objects: list[object]) -> None:
    for example in objects:
        text = repr(example)
        assert text.startswith(f"{type(example).__name__}(")
        assert "\n" not in text
        assert "array(" not in text
        assert " object at 0x" not in text
        assert len(text) < 600


def test_arrays_are_given_by_dtype_and_shape() -> None:
    assert repr(Variant(random((7, 3), 1, np.float16), random((3, 4, 1, 9), 2))) == (
        "Variant(weights=float16 (7, 3), components=float32 (3, 4, 1, 9), clusters=None, matrices=None)"
    )
    assert repr(transfer()) == (
        "RadianceTransfer(vertices=float32 (7, 3), faces=int32 (5, 3), n=2, M=2, channels=3, "
        "variants={unshadowed, shadowed, interreflected}, material='lambert(albedo=0.5) – Ω')"
    )


def test_pickles_come_back_as_they_were(objects: list[object]) -> None:
    for example in objects:
        again = pickle.loads(pickle.dumps(example))
        require_same(again, example)
        assert repr(again) == repr(example)


def test_what_comes_back_from_a_pickle_lights_as_before(objects: list[object]) -> None:
    light = random((25, 3), 5)
    for example in objects:
        if isinstance(example, Lighting):
            expected = example.radiance(light, eye=EYE)
            again = pickle.loads(pickle.dumps(example))  # with what it keeps of that light and eye
            np.testing.assert_array_equal(again.radiance(light, eye=EYE), expected)
    held, few = transfer(), random((4, 3), 6)
    expected = held.radiance(few, eye=EYE, components=2)
    again = pickle.loads(pickle.dumps(held))
    assert isinstance(again, RadianceTransfer)
    np.testing.assert_array_equal(again.radiance(few, eye=EYE, components=2), expected)


def test_what_comes_back_from_a_pickle_casts_the_same_rays() -> None:
    occluders, frames = Occluders(VERTICES, FACES, NORMALS), vertex_frames(NORMALS)
    again = pickle.loads(pickle.dumps(occluders))
    for expected, actual in zip(
        occluders.cast(slice(None), frames, DIRECTIONS)[:1],
        again.cast(slice(None), frames, DIRECTIONS)[:1],
        strict=True,
    ):
        np.testing.assert_array_equal(actual, expected)


def test_the_number_of_components_can_be_set_after_a_pickle() -> None:
    compressed = some_of("clustered", 1)
    again = pickle.loads(pickle.dumps(compressed))
    light = random((25, 3), 7)
    compressed.K = again.K = 2
    np.testing.assert_array_equal(again.radiance(light, eye=EYE), compressed.radiance(light, eye=EYE))
