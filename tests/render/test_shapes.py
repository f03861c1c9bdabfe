"""Spheres and meshes: hits against exact formulas, files, what is refused."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from shrm.render import Camera, Mesh, Object, Sphere, render
from support.data import require
from support.pictures import Normals, icosphere


def test_sphere_normals_are_exact() -> None:
    rng = np.random.default_rng(3)
    normals = rng.normal(size=(1000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    center, radius = np.array([0.3, -0.2, 5.0]), 0.7
    inward = -normals + 0.9 * np.cross(normals, rng.normal(size=(1000, 3))) * 0.5
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    hits = Sphere(tuple(center), radius).intersect(center + radius * normals - 4.0 * inward, inward)
    np.testing.assert_allclose(hits.distances, 4.0, atol=1e-12)
    np.testing.assert_allclose(hits.normals, normals, atol=1e-12)


def test_rays_that_miss_or_look_away_hit_nothing() -> None:
    origins = np.array([[2.0, 1.01, 0.0], [2.0, 0.0, 0.0]])
    directions = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert not np.isfinite(Sphere().intersect(origins, directions).distances).any()
    assert not np.isfinite(icosphere(1).intersect(origins, directions).distances).any()


def test_inside_a_sphere_the_normal_faces_the_eye() -> None:
    direction = np.array([[0.6, 0.0, 0.8]])
    hits = Sphere().intersect(np.zeros((1, 3)), direction)
    np.testing.assert_allclose(hits.normals, -direction, atol=1e-12)


def test_a_mesh_sphere_agrees_with_the_exact_one() -> None:
    camera = Camera((-5.0, 1.0, 2.0), fov=28.0)
    exact = render([Object(Sphere(), Normals())], camera, (96, 96), samples=1)
    meshed = render([Object(icosphere(5), Normals())], camera, (96, 96), samples=1)
    both = (exact.coverage == 1.0) & (meshed.coverage == 1.0)
    assert np.abs(exact.coverage - meshed.coverage).mean() < 2e-3
    # Edges of length h = 2 / 2^5 leave a sagitta of h^2/8 = 5e-4 of a radius, and a hit that is
    # early by it moves along the surface by at most sqrt(2 x 5e-4) = 0.03 at the silhouette.
    difference = np.abs(exact.radiance - meshed.radiance)[both]
    assert difference.max() < 0.05
    assert difference.mean() < 1e-3


def test_seams_do_not_show_and_degenerate_faces_are_tolerated() -> None:
    smooth = icosphere(2)
    split = Mesh(smooth.vertices[smooth.faces].reshape(-1, 3), np.arange(smooth.faces.size).reshape(-1, 3))
    expected = smooth.vertex_normals[smooth.faces].reshape(-1, 3)
    np.testing.assert_allclose(split.vertex_normals, expected, atol=1e-12)
    with_sliver = Mesh(smooth.vertices, np.vstack([smooth.faces, [[0, 0, 1]]]))
    np.testing.assert_allclose(with_sliver.vertex_normals, smooth.vertex_normals, atol=1e-12)


def test_given_normals_are_used() -> None:
    plane = np.array([[0.0, -9, -9], [0, 9, -9], [0, 0, 9]])
    tilted = np.tile([-0.6, 0.0, 0.8], (3, 1))
    mesh = Mesh(plane, np.array([[0, 1, 2]]), normals=tilted)
    hits = mesh.intersect(np.array([[-3.0, 0, 0]]), np.array([[1.0, 0, 0]]))
    np.testing.assert_allclose(hits.normals, tilted[:1], atol=1e-7)
    np.testing.assert_allclose(hits.distances, 3.0, atol=1e-6)


@pytest.mark.parametrize("name", ["spot.obj", "teapot.obj", "trimesh_bunny.ply"])
def test_mesh_files_are_read_upright(name: str) -> None:
    path = require(f"mesh/{name}")
    mesh = Mesh.read(path).placed(radius=1.0)
    assert np.abs(mesh.vertices).max() == pytest.approx(1.0)
    lengths = np.linalg.norm(mesh.vertex_normals[np.unique(mesh.faces)], axis=1)
    assert np.isclose(lengths, 1.0).mean() > 0.998  # the bunny has corners of slivers only
    assert np.isin(np.round(lengths, 9), [0.0, 1.0]).all()
    raw = Mesh.read(path, up="z")
    np.testing.assert_allclose(
        np.ptp(raw.vertices, axis=0)[[2, 0, 1]] / np.ptp(mesh.vertices, axis=0),
        np.full(3, np.ptp(raw.vertices[:, 1]) / np.ptp(mesh.vertices[:, 2])),
    )


def test_a_file_with_normals_keeps_them(tmp_path: Path) -> None:
    file = tmp_path / "plane.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\nf 1//1 2//1 3//1\n")
    np.testing.assert_allclose(Mesh.read(file, up="z").vertex_normals, np.tile([0.6, 0.0, 0.8], (3, 1)))
    np.testing.assert_allclose(Mesh.read(file, up="y").vertex_normals, np.tile([-0.8, -0.6, 0.0], (3, 1)))


@pytest.mark.parametrize("content", [b"", b"not a mesh", b"v 1 2\nf 1 2 3", b"v 0 0 0\nf 1 2 9"])
def test_broken_mesh_files_are_named(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "broken.obj"
    file.write_bytes(content)
    with pytest.raises(ValueError, match=r"broken\.obj: not a mesh"):
        Mesh.read(file)


@pytest.mark.parametrize(
    "arguments",
    [
        {"vertices": np.zeros((3, 2))},
        {"vertices": np.full((3, 3), np.nan)},
        {"faces": np.array([[0, 1, 3]])},
        {"faces": np.zeros((0, 3), np.int64)},
        {"normals": np.zeros((2, 3))},
        {"uv": np.zeros((3, 3))},
        {"tangents": np.zeros((3, 3))},
        {"tangents": np.full((1, 3, 3), np.inf)},
    ],
)
def test_meshes_are_checked_at_the_door(arguments: dict[str, npt.NDArray[np.float64]]) -> None:
    good = {"vertices": np.eye(3), "faces": np.array([[0, 1, 2]])}
    with pytest.raises(ValueError, match=next(iter(arguments))):
        Mesh(**{**good, **arguments})


def test_a_mesh_of_trimesh_is_a_shape() -> None:
    """It is drawn as the mesh of its arrays, with the normals and the texture coordinates that it has."""
    import trimesh

    theirs = trimesh.creation.icosphere(3)
    uv = np.random.default_rng(0).random((len(theirs.vertices), 2))
    theirs.visual = trimesh.visual.TextureVisuals(uv=uv)
    ours = Mesh(np.array(theirs.vertices), np.array(theirs.faces), np.array(theirs.vertex_normals), uv)
    assert type(Mesh.from_trimesh(theirs).vertices) is np.ndarray
    texture = np.random.default_rng(1).random((8, 8, 3)).astype(np.float32)
    camera = Camera((-4.0, 1.0, 2.0))
    expected, picture = (
        render([Object(shape, Normals(), texture)], camera, (48, 64)).radiance for shape in (ours, theirs)
    )
    np.testing.assert_array_equal(picture, expected)
    coarse = Object(Mesh.from_trimesh(trimesh.creation.box()), Normals()).shape
    assert isinstance(coarse, Mesh)
    assert coarse.uv is None


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        ({"shape": "a sphere"}, TypeError, "mesh must have vertices, faces and vertex_normals, got str"),
        ({"material": 0.5}, TypeError, "material must have radiance"),
        ({"texture": np.ones((4, 4))}, ValueError, "texture must have the shape"),
        ({"texture": np.full((1, 1, 3), np.nan)}, ValueError, "texture must be finite"),
        ({"axis": (0.0, 1.0)}, ValueError, "axis must have the shape"),
    ],
)
def test_objects_are_checked_at_the_door(
    arguments: dict[str, object], error: type[Exception], text: str
) -> None:
    with pytest.raises(error, match=text):
        Object(**{"shape": Sphere(), "material": Normals(), **arguments})  # type: ignore[arg-type]
