"""Radiance at vertices, and objects with transfer in the world."""

import numpy as np
import pytest
from shrm import sh
from shrm.render import (
    Camera,
    Mesh,
    Object,
    Placement,
    Sphere,
    TransferredMesh,
    VertexRadiance,
    about_vertical,
    render,
    texture_lookup,
    turned_camera,
)
from support.directions import sphere
from support.transfer_objects import N, globe, transferred

SIZE = 48
CAMERA = Camera((4.0, 2.0, 1.5), fov=32.0)
SIDE = Camera((3.0, 1.0, 2.0), height=3.0)


def globe_mesh(**given) -> Mesh:
    vertices, faces, uv = globe()
    return Mesh(vertices.astype(float), faces.astype(int), uv=uv, **given).placed()


def affine(points: np.ndarray) -> np.ndarray:
    return (points @ np.array([[1.0, 0.3, -0.2], [0.1, -0.7, 0.4], [-0.5, 0.2, 0.9]]) + 2.0).astype(
        np.float32
    )


def seen(camera: Camera, mesh: Mesh):
    """Rays through the pixels, and what they hit of a mesh."""
    rows, columns = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5, indexing="ij")
    origins, directions = camera.rays(columns.ravel(), rows.ravel(), (SIZE, SIZE))
    hits = mesh.intersect(origins, directions)
    hit = np.isfinite(hits.distances)
    return hit, (origins + np.where(hit, hits.distances, 0.0)[:, None] * directions)[hit], hits


# ---- Radiance at vertices


@pytest.mark.parametrize("viewer", ["near", "distant"])
@pytest.mark.parametrize(
    "camera", [CAMERA, SIDE, Camera((0.1, 0.0, 0.1), (1.0, 0.3, 0.2), fov=60)], ids=["near", "far", "inside"]
)
def test_what_is_linear_in_space_is_linear_in_the_picture(camera, viewer):
    mesh = globe_mesh()
    picture = render(
        [Object(mesh, VertexRadiance(affine(mesh.vertices)))], camera, (SIZE, SIZE), viewer=viewer, samples=1
    )
    hit, points, _ = seen(camera, mesh)
    assert hit.sum() > 0.2 * SIZE**2
    # Embree's distances and barycentric coordinates are those of float32.
    np.testing.assert_allclose(picture.radiance.reshape(-1, 3)[hit], affine(points), atol=2e-5)
    assert not picture.radiance.reshape(-1, 3)[~hit].any()


def test_a_texture_multiplies_it():
    mesh = globe_mesh()
    texture = np.random.default_rng(0).random((5, 7, 3)).astype(np.float32)
    plain, textured = (
        render(
            [Object(mesh, VertexRadiance(affine(mesh.vertices)), t)], CAMERA, (SIZE, SIZE), samples=1
        ).radiance
        for t in (None, texture)
    )
    hit, _, hits = seen(CAMERA, mesh)
    expected = plain.reshape(-1, 3)[hit] * texture_lookup(texture, hits.uv[hit])
    np.testing.assert_allclose(textured.reshape(-1, 3)[hit], expected, rtol=1e-6)


def test_shading_once_a_pixel_changes_nothing():
    mesh = globe_mesh()
    thing = Object(mesh, VertexRadiance(affine(mesh.vertices)))
    a, b = (
        render([thing], CAMERA, (SIZE, SIZE), samples=2, shading=shading) for shading in ("sample", "pixel")
    )
    np.testing.assert_array_equal(a.radiance, b.radiance)


def test_radiance_of_other_vertices_is_refused():
    mesh = globe_mesh()
    few = VertexRadiance(affine(mesh.vertices)[:-1])
    with pytest.raises(ValueError, match=rf"values must have the shape \({len(mesh.vertices)}, 3\), got"):
        Object(mesh, few)
    with pytest.raises(TypeError, match="shape must be a Mesh where radiance is given"):
        Object(Sphere(), few)
    for values in (few.values.astype(np.float64), few.values[:, :2], few.values[0]):
        with pytest.raises((TypeError, ValueError), match=r"values must (be an array of float32|have the)"):
            VertexRadiance(values)


# ---- Where an object stands


def test_placements_are_undone():
    mesh = globe_mesh()
    placement = Mesh(*globe()[:2]).placement((1.0, -2.0, 0.5), radius=0.7, turn=33.0)
    points = sphere(20, seed=0)
    there = placement.world_from_object(points)
    np.testing.assert_allclose(placement.object_from_world(there), points, atol=1e-14)
    lengths = np.linalg.norm(there - there[0], axis=1)[1:] / np.linalg.norm(points - points[0], axis=1)[1:]
    np.testing.assert_allclose(lengths, placement.scale, rtol=1e-12)
    np.testing.assert_allclose(mesh.vertices.min(axis=0)[:2], -1.0, atol=1e-6)


def test_light_is_turned_and_carried_into_the_objects_coordinates():
    thing = TransferredMesh.placed(transferred(), turn=40.0)
    coefficients = np.random.default_rng(1).normal(size=((N + 2) ** 2, 3))
    q, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    turned = q * np.linalg.det(q)
    w = sphere(50, seed=3)
    found = sh.evaluate(thing.light(coefficients, turned), w)
    # L'(w) = L(R^T w) in the world, where the object's w is turned by 40 degrees
    expected = sh.evaluate(coefficients[: N * N], w @ about_vertical(40.0).T @ turned)
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("camera", [CAMERA, SIDE], ids=["perspective", "orthographic"])
@pytest.mark.parametrize("viewer", ["near", "distant"])
def test_each_vertex_is_seen_along_its_own_view_in_the_world(camera, viewer):
    transfer = transferred()
    thing = TransferredMesh.placed(transfer, center=(0.2, 0.1, -0.3), turn=-70.0)
    light = thing.light(np.random.default_rng(4).normal(size=(N * N, 3)), np.eye(3))
    lit = thing.lit(transfer.lighting(), light, camera, viewer).values
    for p in np.random.default_rng(5).choice(len(lit), 12, replace=False):
        towards = np.subtract(camera.position, thing.mesh.vertices[p])
        if viewer == "distant" or camera.height is not None:
            towards = np.subtract(camera.position, camera.target)
        view = about_vertical(70.0) @ towards / np.linalg.norm(towards)
        expected = transfer.radiance(light, view=view)[p]
        # Tents are piecewise linear in views that are known to float32.
        np.testing.assert_allclose(lit[p], expected, atol=1e-5 * np.abs(lit).max())


def test_turning_object_light_and_eye_together_changes_nothing():
    transfer = transferred()
    coefficients = np.random.default_rng(6).normal(size=(N * N, 3))
    still = TransferredMesh.placed(transfer, center=(0.5, 0.2, 0.0)).placement
    lit = []
    for degrees in (0.0, 130.0):
        R = about_vertical(degrees)
        thing = TransferredMesh(transfer, Placement(R, still.scale, R @ still.offset))
        light = thing.light(coefficients, R)
        lit.append(thing.lit(transfer.lighting(), light, turned_camera(CAMERA, degrees)).values)
    np.testing.assert_allclose(*lit, atol=1e-5 * np.abs(lit[0]).max())
