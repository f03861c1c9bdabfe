"""Tangent fields: against surfaces whose directions are known, and what no mesh may change."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from shrm import brdf, prefilter
from shrm.environment import Environment
from shrm.render import Camera, Mesh, Object, Sphere, render, tangents_around
from shrm.render.line_field import aligned, orthogonalised
from support.pictures import icosphere

Array = npt.NDArray[np.float64]

TUBE = 0.4  # radius of the torus' tube; that of its middle is 1


def grid(rows: int, columns: int) -> npt.NDArray[np.int64]:
    """Faces of rows x columns quadrangles, two each."""
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def parametrised(n: int, surface: Callable[[Array, Array], Array], aspect: int = 2) -> Mesh:
    """A surface over [0, 1]^2 with uv: n x (aspect n) quadrangles; where it closes there is a seam of uv."""
    v, u = (x.ravel() for x in np.mgrid[0 : 1 : (n + 1) * 1j, 0 : 1 : (aspect * n + 1) * 1j])
    vertices = np.round(surface(u, v), 12) + 0.0  # so that a seam's two sides are at one place
    return Mesh(vertices, grid(n, aspect * n), uv=np.stack([u, v], axis=1))


def torus(n: int) -> Mesh:
    """Its u runs around the vertical, its v around the tube."""

    def surface(u: Array, v: Array) -> Array:
        a, b = 2.0 * np.pi * u, 2.0 * np.pi * v
        r = 1.0 + TUBE * np.cos(b)
        return np.stack([r * np.cos(a), r * np.sin(a), TUBE * np.sin(b)], axis=1)

    return parametrised(n, surface)


def around_the_tube(p: Array) -> Array:
    """Directions of the torus' largest curvature at points (..., 3)."""
    r = np.hypot(p[..., 0], p[..., 1])
    x, y = p[..., 0] / r, p[..., 1] / r
    b = np.arctan2(p[..., 2], r - 1.0)
    return np.stack([-np.sin(b) * x, -np.sin(b) * y, np.cos(b)], axis=-1)


def around_the_vertical(p: Array) -> Array:
    r = np.hypot(p[..., 0], p[..., 1])
    return np.stack([-p[..., 1] / r, p[..., 0] / r, 0.0 * r], axis=-1)


def rotation(seed: int) -> Array:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.linalg.det(q)


def soup(mesh: Mesh) -> Mesh:
    """The mesh with three vertices of its own for each face, in another order."""
    order = np.random.default_rng(5).permutation(mesh.faces.size)
    rows = np.empty_like(order)
    rows[order] = np.arange(len(order))
    corners = mesh.faces.ravel()[order]
    return Mesh(mesh.vertices[corners], rows.reshape(-1, 3), uv=None if mesh.uv is None else mesh.uv[corners])


def field(mesh: Mesh, name: str) -> Array:
    tangents = mesh.with_tangents(name).tangents
    assert tangents is not None
    return tangents


def angles(a: Array, b: Array) -> Array:
    """Between lines, in radians: good for small ones too."""
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.abs(np.sum(a * b, axis=-1)))


def edge_length(mesh: Mesh) -> float:
    corners = mesh.vertices[mesh.faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max())


def require_unit_tangents(mesh: Mesh, tangents: Array) -> None:
    assert tangents.shape == (len(mesh.faces), 3, 3)
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=-1), 1.0, atol=1e-12)
    across = np.sum(tangents * mesh.vertex_normals[mesh.faces], axis=-1)
    np.testing.assert_allclose(across, 0.0, atol=1e-12)


# --- directions that are known --------------------------------------------------------------------
#
# Lines are averages over about three edges of length h. On a regular grid a smooth field differs from such an
# average by the second order of 3 h over the length on which it changes, which is a radius of curvature;
# on irregular triangles the curvatures themselves are good to the first order of h only.


def test_principal_directions_of_a_torus_converge() -> None:
    meshes = [torus(n) for n in (12, 24, 48)]
    errors = [angles(field(m, "principal"), around_the_tube(m.vertices[m.faces])).max() for m in meshes]
    for mesh, error in zip(meshes, errors, strict=True):
        assert error < (3.0 * edge_length(mesh) / TUBE) ** 2
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2]


@pytest.mark.parametrize("turned", [0, 1])
def test_principal_directions_of_a_cylinder_are_around_it(turned: int) -> None:
    def surface(u: Array, v: Array) -> Array:
        return np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), 2 * v - 1], axis=1)

    mesh, R = parametrised(12, surface, 4), rotation(turned) if turned else np.eye(3)
    expected = around_the_vertical(mesh.vertices[mesh.faces]) @ R.T
    found = field(Mesh(mesh.vertices @ R.T, mesh.faces), "principal")
    # Triangles lie in the sides of a prism: only how many of each side a vertex has tilts its normal.
    assert angles(found, expected).max() < edge_length(mesh)


def quadric_direction(p: Array, A: Array) -> tuple[Array, Array]:
    """Of x.Ax = 1 at p (n, 3): the direction of the larger |curvature| and by what part it is larger."""
    gradient = p @ A
    size = np.linalg.norm(gradient, axis=1)
    n = gradient / size[:, None]
    P = np.eye(3) - n[:, :, None] * n[:, None, :]
    k, directions = np.linalg.eigh(P @ A @ P / size[:, None, None])
    order = np.argsort(np.abs(k), axis=1)  # the normal's zero, the smaller, the larger
    smaller, larger = np.abs(np.take_along_axis(k, order[:, 1:], axis=1)).T
    return np.take_along_axis(directions, order[:, None, 2:], axis=2)[:, :, 0], 1.0 - smaller / larger


def hyperboloid(n: int) -> Mesh:
    def surface(u: Array, v: Array) -> Array:
        z = 2.4 * v - 1.2
        r = np.sqrt(1.0 + z**2 / 4.0)
        return np.stack([r * np.cos(2 * np.pi * u), r * np.sin(2 * np.pi * u), z], axis=1)

    return parametrised(n, surface, 3)


@pytest.mark.parametrize(
    ("meshes", "A", "radius"),
    [
        ([icosphere(k, (1.0, 0.7, 0.45)) for k in (3, 4, 5)], np.diag([1.0, 0.7**-2, 0.45**-2]), 0.2),
        ([hyperboloid(n) for n in (8, 16, 32)], np.diag([1.0, 1.0, -0.25]), 1.0),
    ],
    ids=["ellipsoid", "hyperboloid"],
)
def test_principal_directions_of_quadrics_converge(meshes: list[Mesh], A: Array, radius: float) -> None:
    errors = []
    for mesh in meshes:
        expected, differ = quadric_direction(mesh.vertices, A)
        # Not at umbilics, nor at the hyperboloid's rims, whose vertices have faces on one side only.
        known = (differ > 0.2) & (np.abs(mesh.vertices[:, 2]) < 0.8)
        error = angles(field(mesh, "principal"), expected[mesh.faces])[known[mesh.faces]]
        assert error.max() < edge_length(mesh) / radius
        errors.append(np.sqrt(np.mean(error**2)))
    assert errors[0] > 1.8 * errors[1] > 1.8**2 * errors[2]


def test_uv_tangents_are_along_u() -> None:
    meshes = [torus(n) for n in (12, 24, 48)]
    errors = [angles(field(m, "uv"), around_the_vertical(m.vertices[m.faces])).max() for m in meshes]
    for mesh, error in zip(meshes, errors, strict=True):
        assert error < edge_length(mesh)  # the vertices of a seam have faces on one side only
    assert errors[0] > 1.6 * errors[1] > 1.6**2 * errors[2]


def test_uv_tangents_of_an_affine_map_are_exact() -> None:
    rng = np.random.default_rng(2)
    plane = np.stack([rng.random(60), rng.random(60), np.zeros(60)], axis=1)
    faces = rng.integers(0, 60, (100, 3))
    M = rng.normal(size=(2, 2))
    mesh = Mesh(plane, faces, np.tile([0.0, 0.0, 1.0], (60, 1)), plane[:, :2] @ M.T)
    along = np.append(np.linalg.inv(M)[:, 0], 0.0)  # dP/du
    used = np.linalg.norm(np.cross(*np.moveaxis(np.diff(plane[faces], axis=1), 1, 0)), axis=1) > 1e-3
    assert used.sum() > 80
    # A triangle of area 1e-3 / 2 takes three of float64's sixteen digits.
    assert angles(field(mesh, "uv")[used], along).max() < 1e-10


# --- what does not matter -------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["uv", "principal"])
def test_fields_turn_move_and_scale_with_the_mesh(name: str) -> None:
    mesh = torus(16)
    for seed in range(3):
        R = rotation(seed)
        turned = Mesh(
            2.5 * mesh.vertices @ R.T + [3.0, -1.0, 0.5], mesh.faces, mesh.vertex_normals @ R.T, mesh.uv
        )
        assert angles(field(turned, name), field(mesh, name) @ R.T).max() < 1e-9


@pytest.mark.parametrize("name", ["uv", "principal"])
def test_split_vertices_and_the_sides_of_faces_make_no_difference(name: str) -> None:
    mesh = torus(16)
    assert angles(field(soup(mesh), name), field(mesh, name)).max() < 1e-9
    inside_out = Mesh(mesh.vertices, mesh.faces, -mesh.vertex_normals, mesh.uv)
    assert angles(field(inside_out, name), field(mesh, name)).max() < 1e-9
    mixed = mesh.faces.copy()
    mixed[::3] = mixed[::3, ::-1]
    found = field(Mesh(mesh.vertices, mixed, mesh.vertex_normals, mesh.uv), name)
    found[::3] = found[::3, ::-1]
    assert angles(found, field(mesh, name)).max() < 1e-9


def test_a_seam_of_uv_does_not_show_in_principal_directions() -> None:
    mesh = torus(16)
    closed = Mesh(*welded(mesh))
    assert angles(field(closed, "principal"), field(mesh, "principal")).max() < 1e-9


def welded(mesh: Mesh) -> tuple[Array, npt.NDArray[np.int64]]:
    vertices, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    return vertices, place.reshape(-1)[mesh.faces]


def test_a_chart_and_its_mirror_image_meet_without_a_seam() -> None:
    x, y = (a.ravel() for a in np.mgrid[-1:1:9j, -1:1:9j])
    sheared = np.stack([np.abs(x), y + 0.0], axis=1)  # both halves have the same texture
    mesh = Mesh(np.stack([x, y, 0 * x], axis=1), grid(8, 8), uv=sheared)
    assert angles(field(mesh, "uv"), np.array([1.0, 0.0, 0.0])).max() < 1e-12


def test_signs_agree_within_faces() -> None:
    for tangents in (field(torus(12), "principal"), field(torus(12), "uv")):
        dots = np.einsum("kax,kbx->kab", tangents, tangents)
        assert dots.min() > 0.0
    rng = np.random.default_rng(3)
    lines = rng.normal(size=(200, 1, 3)) + 0.3 * rng.normal(size=(200, 3, 3))  # near one line in a face
    lines /= np.linalg.norm(lines, axis=-1, keepdims=True)
    lines = lines[(np.einsum("kax,kbx->kab", lines, lines) > 0.0).all(axis=(1, 2))]
    assert len(lines) > 50
    flipped = aligned(lines * rng.choice([-1.0, 1.0], (len(lines), 3, 1)))
    ratio = np.sum(flipped * lines, axis=-1)
    np.testing.assert_allclose(ratio, np.repeat(ratio[:, :1], 3, axis=1), atol=1e-12)
    np.testing.assert_allclose(np.abs(ratio), 1.0, atol=1e-12)


@pytest.mark.parametrize("material", [brdf.Banks(0.5), brdf.KajiyaKay(8), brdf.KajiyaKay(8, cone="mirror")])
def test_materials_about_the_tangent_do_not_know_its_sign(material: brdf.BRDF) -> None:
    rm = prefilter(Environment.daylight(size=32), material, orders=(12, 4), size=32, layout="cube")
    rng = np.random.default_rng(6)
    n, v, t = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in rng.normal(size=(3, 500, 3)))
    t = orthogonalised(t, n)
    n, v, t = (np.float32(w) for w in (n, v, t))
    there, back = rm.radiance(n, v, t), rm.radiance(n, v, -t)
    np.testing.assert_allclose(back, there, atol=1e-5 * np.abs(there).max())  # float32, 4 + 1 maps


# --- where nothing is defined ---------------------------------------------------------------------


def test_on_spheres_and_planes_principal_tangents_run_around_the_vertical() -> None:
    sphere = icosphere(3)
    expected = tangents_around((0.0, 0.0, 1.0), sphere.vertex_normals)[sphere.faces]
    away = np.abs(sphere.vertices[sphere.faces][..., 2]) < 0.9
    # What its triangles add to the weight is under a third of what is needed: sin(2 phi) < 1/3 / (1 - 1/3).
    assert angles(field(sphere, "principal"), expected)[away].max() < np.radians(15.0)
    rng = np.random.default_rng(7)
    y, z = (a.ravel() + 0.05 * rng.random(81) for a in np.mgrid[-1:1:9j, -1:1:9j])
    wall = Mesh(np.stack([0 * y, y, z], axis=1), grid(8, 8))
    np.testing.assert_allclose(angles(field(wall, "principal"), np.array([0.0, 1.0, 0.0])), 0.0, atol=1e-9)
    floor = field(Mesh(wall.vertices[:, [1, 2, 0]], wall.faces), "principal")
    assert angles(floor, floor[0, 0]).max() < 1e-9  # one direction, though no axis says which


def test_lines_are_carried_into_flat_regions_beside_curved_ones() -> None:
    def surface(
        u: Array, v: Array
    ) -> Array:  # half a tube about a level axis, with a flat strip on each side
        s = 4.0 * v - 2.0
        a = np.clip(s, -1.0, 1.0) * np.pi / 2.0
        beyond = np.clip(np.abs(s) - 1.0, 0.0, 0.2)
        y, z = np.sin(a), np.cos(a) - beyond
        return np.stack([4.0 * u - 2.0, y, z], axis=1)

    mesh = parametrised(40, surface, 1)
    found = field(mesh, "principal")
    assert angles(found, np.array([1.0, 0.0, 0.0])).min() > np.radians(80.0)


def test_degenerate_uv_fall_back_to_the_vertical() -> None:
    mesh = torus(8)
    expected = tangents_around((0.0, 0.0, 1.0), mesh.vertex_normals)[mesh.faces]
    for uv in (np.zeros((len(mesh.vertices), 2)), np.tile(mesh.vertices[:, :1], (1, 2))):
        tangents = field(replace(mesh, uv=uv), "uv")
        require_unit_tangents(mesh, tangents)
        assert angles(tangents, expected).max() < 1e-12


@pytest.mark.parametrize("name", ["uv", "principal"])
def test_spoilt_meshes_have_finite_unit_tangents(name: str) -> None:
    whole, rng = torus(8), np.random.default_rng(8)
    assert whole.uv is not None
    vertices = np.concatenate([whole.vertices, [[9.0, 9.0, 9.0]], whole.vertices[:1], np.zeros((1, 3))])
    uv = np.concatenate([whole.uv, rng.random((3, 2))])
    last = len(vertices) - 1
    spoilt = [[0, 0, 1], [5, 5, 5], [0, last - 1, 3], [2, last, 2]]
    sliver = [[0, 1, 2], [10, 11, 12]]
    folded = np.concatenate([whole.faces, whole.faces[:9], whole.faces[3:7, ::-1]])  # twice, and its back
    for faces in (np.concatenate([whole.faces, spoilt, sliver]), folded, np.array(spoilt)):
        mesh = Mesh(vertices, faces, uv=uv)
        require_unit_tangents(mesh, field(mesh, name))
    for _ in range(20):  # random triangles
        mesh = Mesh(
            rng.integers(-2, 3, (12, 3)).astype(float), rng.integers(0, 12, (30, 3)), uv=rng.random((12, 2))
        )
        require_unit_tangents(mesh, field(mesh, name))


@pytest.mark.parametrize("subdivisions", [0, 2])
def test_umbilics_have_finite_unit_tangents(subdivisions: int) -> None:
    for axes in ((1.0, 1.0, 1.0), (1.0, 1.0, 0.5), (1.0, 0.8, 0.5)):
        mesh = icosphere(subdivisions, axes)
        require_unit_tangents(mesh, field(mesh, "principal"))


# --- meshes, hits, pictures -----------------------------------------------------------------------


def test_a_mesh_without_uv_says_so_and_what_to_do(tmp_path: Path) -> None:
    file = tmp_path / "bare.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ValueError, match=r"bare\.obj: no texture coordinates: take axis or principal"):
        Mesh.read(file).with_tangents("uv")
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    with pytest.raises(ValueError, match=r"^the mesh: no texture coordinates"):
        mesh.with_tangents("uv")
    with pytest.raises(ValueError, match="tangents must be one of axis, uv, principal, got 'u'"):
        mesh.with_tangents("u")


def test_the_axis_takes_a_field_away_and_placing_turns_it() -> None:
    mesh = torus(8).with_tangents("principal")
    assert mesh.with_tangents("axis").tangents is None
    placed = mesh.placed((1.0, 2.0, 3.0), 0.5, turn=30.0)
    again = torus(8).placed((1.0, 2.0, 3.0), 0.5, turn=30.0).with_tangents("principal")
    assert placed.tangents is not None
    assert again.tangents is not None
    assert angles(placed.tangents, again.tangents).max() < 1e-9


def rays(count: int) -> tuple[Array, Array]:
    """From all sides towards the torus."""
    rng = np.random.default_rng(9)
    origins = rng.normal(size=(count, 3))
    origins *= 4.0 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = around_the_vertical(origins) * rng.uniform(-1, 1, (count, 1)) - origins
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.mark.parametrize(("name", "expected"), [("uv", around_the_vertical), ("principal", around_the_tube)])
def test_hits_have_interpolated_tangents(name: str, expected: Callable[[Array], Array]) -> None:
    mesh = torus(48).with_tangents(name)
    origins, directions = rays(500)
    hits = mesh.intersect(origins, directions)
    seen = np.isfinite(hits.distances)
    assert seen.sum() > 100
    assert hits.tangents is not None
    tangents, normals = hits.tangents[seen], hits.normals[seen]
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(np.sum(tangents * normals, axis=1), 0.0, atol=1e-12)
    places = origins[seen] + hits.distances[seen, None] * directions[seen]
    assert angles(tangents, expected(places)).max() < edge_length(mesh) / TUBE
    assert torus(8).intersect(origins, directions).tangents is None
    assert Sphere().intersect(origins, directions).tangents is None


def test_where_nothing_is_left_of_a_tangent_it_runs_around_the_axis() -> None:
    normals = np.array([[1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]])
    tangents = np.array([[-2.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    found = orthogonalised(tangents, normals)
    np.testing.assert_allclose(found, tangents_around((0.0, 0.0, 1.0), normals), atol=1e-12)


class Lines:
    """A material that shows the line of its tangents: T T^T, of which three entries."""

    def radiance(
        self,
        normals: npt.NDArray[np.float32],
        views: npt.NDArray[np.float32],
        tangents: npt.NDArray[np.float32] | None = None,
    ) -> npt.NDArray[np.float32]:
        assert tangents is not None
        np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1.0, atol=1e-6)
        np.testing.assert_allclose(np.sum(tangents * normals, axis=1), 0.0, atol=1e-6)
        return tangents * np.roll(tangents, 1, axis=1)


@pytest.mark.parametrize("shading", ["sample", "pixel"])
def test_signs_of_tangents_do_not_show_in_a_picture(shading: str) -> None:
    mesh, camera = torus(24).with_tangents("principal"), Camera((4.0, 2.0, 1.5), fov=32.0)
    assert mesh.tangents is not None
    signs = np.random.default_rng(10).choice([-1.0, 1.0], (len(mesh.faces), 1, 1))
    pictures = [
        render([Object(each, Lines())], camera, (48, 48), samples=3, shading=shading)
        for each in (mesh, replace(mesh, tangents=signs * mesh.tangents))
    ]
    np.testing.assert_allclose(pictures[0].radiance, pictures[1].radiance, atol=1e-6)
    assert np.ptp(pictures[0].radiance) > 0.5


def test_shading_once_a_pixel_agrees_with_shading_each_sample() -> None:
    mesh, camera = torus(24).with_tangents("uv"), Camera((4.0, 2.0, 1.5), fov=32.0)
    each, once = (
        render([Object(mesh, Lines())], camera, (64, 64), samples=3, shading=shading).radiance
        for shading in ("sample", "pixel")
    )
    # A pixel is 0.04 wide: tangents within it differ by so much over the radius 1, far from silhouettes.
    assert np.median(np.abs(each - once)) < 0.04**2
    assert np.mean(np.abs(each - once)) < 0.04
