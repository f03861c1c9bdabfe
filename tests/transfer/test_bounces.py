"""Irradiance and diffuse interreflection: against closed forms, a path tracer, and the law of energy."""

from pathlib import Path

import numpy as np
import pytest
from shrm.transfer.rays.bounces import gathered, incident, irradiance, leaving, seen_vertices
from shrm.transfer.rays.directions import local_directions
from shrm.transfer.rays.visibility import Visibility
from shrm.transfer.tangent_frames import vertex_frames
from support import oracles
from support.transfer_meshes import Mesh, ball, bowl, bumpy, grid, moved, random_rotation, room, together

Rectangles = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # corners, sides twice, normals

WHITE = np.sqrt(4 * np.pi)  # the coefficient of Y_00 of radiance 1


def computed(folder: Path, mesh: Mesh, count: int = 4096, *, hits: bool = True) -> Visibility:
    vertices, faces, normals = mesh
    visibility = Visibility(
        folder, vertices, faces, vertex_frames(normals), local_directions(count), hits=hits, block=100
    )
    visibility.compute()
    return visibility


def solid_angle_error(D: int) -> float:
    """Of a shape whose outline is a great circle: cells that it crosses count or not, as coins do."""
    cell = 2 * np.pi / D
    return 3 * cell * np.sqrt(np.pi / np.sqrt(cell)) / 2


# ---- Light that arrives without a detour


def test_a_convex_surface_has_the_irradiance_of_its_normal(tmp_path):
    mesh = moved(ball(2), random_rotation(1))
    E = irradiance(computed(tmp_path, mesh, hits=False), 5)
    # Lambert's cosine as a convolution [RH01]: pi, 2 pi/3, pi/4, 0, -pi/24 for degrees 0 to 4
    band = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4, 0, -np.pi / 24], [1, 3, 5, 7, 9])
    np.testing.assert_allclose(E, band * oracles.real_harmonics(4, mesh[2]), atol=1e-3)
    np.testing.assert_allclose(E[:, 0] * WHITE, np.pi, atol=1e-12)


def test_irradiance_turns_with_the_mesh(tmp_path):
    R, mesh = random_rotation(2), bumpy(3)
    vertices, faces, normals = mesh
    frames = vertex_frames(normals)
    straight = Visibility(tmp_path / "a", vertices, faces, frames, local_directions(512))
    turned = Visibility(tmp_path / "b", vertices @ R.T, faces, R @ frames, local_directions(512))
    straight.compute()
    turned.compute()
    light = np.random.default_rng(4).normal(size=(16, 1))
    before = irradiance(straight, 4) @ light
    after = irradiance(turned, 4) @ oracles.rotated_coefficients(light, R)
    # All but a few rays along edges see the same
    assert np.quantile(abs(after - before), 0.95) < 1e-6


def test_a_wall_takes_the_half_of_the_sky(tmp_path):
    """Infinite in effect: the irradiance at the foot of a high wall, by the cosine, is half."""
    wall = grid(1, [0, -1e3, 0], [0, 2e3, 0], [0, 0, 1e3])
    floor = grid(2, [0.001, -1, 0], [1, 0, 0], [0, 2, 0])
    visibility = computed(tmp_path, together(wall, floor), hits=False)
    foot = 4 + np.flatnonzero(floor[0][:, 0] < 0.01)
    E = irradiance(visibility, 1)[foot, 0] * WHITE
    np.testing.assert_allclose(E, np.pi / 2, atol=solid_angle_error(2048))


# ---- Energy


@pytest.mark.parametrize("mesh", [room(3), bowl(6), ball(2), bumpy(5)], ids=["room", "bowl", "ball", "bumpy"])
def test_amid_radiance_1_everywhere_irradiance_is_pi(tmp_path, mesh):
    """What is not sky is mesh: the furnace. Bumpy normals may look through faces: there light may be lost."""
    visibility = computed(tmp_path, mesh, 512)
    E = irradiance(visibility, 1)[:, 0] * WHITE + gathered(visibility, np.ones((len(mesh[0]), 1, 1)))[:, 0, 0]
    assert E.max() < np.pi + 1e-5
    behind = np.zeros(len(E))
    for block in visibility:
        row, direction = np.nonzero(~block.visible)
        lost = block.hits.face < 0
        cosine = visibility.directions[direction[lost], 2]
        behind[block.vertices] = 2 * np.pi / 256 * np.bincount(row[lost], cosine, len(block.visible))
    np.testing.assert_allclose(E + behind, np.pi, atol=1e-5)


def test_a_closed_room_is_dark(tmp_path):
    visibility = computed(tmp_path, room(3), 512)
    assert not leaving(visibility, 3, 1.0, 5).any()


def test_a_convex_object_lights_nothing(tmp_path):
    visibility = computed(tmp_path, ball(2), 512)
    E, L = irradiance(visibility, 3), leaving(visibility, 3, 0.7, 4)
    np.testing.assert_allclose(L[:, 0], 0.7 / np.pi * E, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("albedo", [0.3, 0.9])
def test_a_bowl_under_white_light_is_half_an_integrating_sphere(tmp_path, albedo):
    """From any point of a sphere, any part of it fills, by the cosine, its share of the area.

    So the opening gives pi/2 of irradiance, and each bounce returns albedo/2 of the last.
    """
    k = 8
    visibility = computed(tmp_path, bowl(k))
    # The opening is a polygon of 8 k sides, the rays a sample
    tolerance = solid_angle_error(2048) + np.pi / 2 * (2 * np.pi / (8 * k)) ** 2 / 6
    for bounces in (1, 2, 3, 60):
        L = leaving(visibility, 2, albedo, bounces)
        E = np.pi / 2 * (1 - (albedo / 2) ** bounces) / (1 - albedo / 2)
        np.testing.assert_allclose(L[:, 0, 0] * WHITE, albedo / np.pi * E, atol=albedo * tolerance)
        # and on average the errors cancel
        assert (L[:, 0, 0] * WHITE).mean() == pytest.approx(albedo / np.pi * E, rel=5e-3)


# ---- The same by brute force


def traced_irradiance(
    start: np.ndarray,
    normal: np.ndarray,
    rectangles: Rectangles,
    light: np.ndarray,
    albedo: float,
    bounces: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error of the irradiance of light reflected at most 0, 1, ... times: a path tracer."""
    rng, count = np.random.default_rng(8), 100_000
    corners, sides, others, normals = rectangles
    P, N = np.tile(start, (count, 1)), np.tile(normal, (count, 1))
    weight, found = np.ones(count), np.zeros(count)
    mean, error = np.empty((2, bounces + 1))
    for bounce in range(bounces + 1):
        # By the cosine about the normal: a point of the unit sphere that touches there
        w = rng.normal(size=P.shape)
        w = N + w / np.linalg.norm(w, axis=1, keepdims=True)
        w /= np.linalg.norm(w, axis=1, keepdims=True)
        t, hit = np.full(len(P), np.inf), np.full(len(P), -1)
        for k, (corner, a, b, n) in enumerate(zip(corners, sides, others, normals, strict=True)):
            with np.errstate(divide="ignore", invalid="ignore"):
                distance = ((corner - P) @ n) / (w @ n)
                at = P + distance[:, None] * w - corner
            inside = (at @ a >= 0) & (at @ a <= a @ a) & (at @ b >= 0) & (at @ b <= b @ b)
            nearer = inside & (distance > 1e-9) & (distance < t)
            t[nearer], hit[nearer] = distance[nearer], k
        alive = np.flatnonzero(weight)
        sky = hit < 0
        found[alive[sky]] = weight[alive[sky]] * (oracles.real_harmonics(2, w[sky]) @ light)
        weight[alive[sky]] = 0
        P, N = P[~sky] + t[~sky, None] * w[~sky], normals[hit[~sky]]
        weight *= albedo
        mean[bounce], error[bounce] = np.pi * found.mean(), np.pi * found.std() / np.sqrt(count)
    return mean, error


@pytest.mark.slow
def test_bounces_are_those_of_a_path_tracer(tmp_path):
    """A floor and two walls at a corner, each with its own vertices where they meet."""
    x, y, z = np.eye(3)
    k, origin = 12, [0.0, 0.0, 0.0]
    mesh = together(grid(k, origin, x, y), grid(k, origin, y, z), grid(k, origin, z, x))
    rectangles = (np.zeros((3, 3)), np.array([x, y, z]), np.array([y, z, x]), np.array([z, x, y]))
    light = np.random.default_rng(9).normal(size=9) + 4 * (np.arange(9) == 0)
    visibility = computed(tmp_path, mesh)
    E = [irradiance(visibility, 3) @ light]
    for bounces in (1, 2, 3):
        E.append(E[0] + gathered(visibility, leaving(visibility, 3, 0.9, bounces))[:, 0] @ light)
    for at in ([1, 1, 0], [0.25, 0.25, 0], [1 / 12, 0.5, 0], [0.75, 0, 0.25]):
        index = int(np.flatnonzero((abs(mesh[0] - at) < 1e-9).all(axis=1))[0])
        expected, error = traced_irradiance(mesh[0][index], mesh[2][index], rectangles, light, 0.9, 3)
        # Linear interpolation at a step of 1/12 near a corner, and 2048 rays: 1 in 200
        assert (abs([row[index] for row in E] - expected) < 4 * error + expected / 200).all()


# ---- Colors, sums, shapes


def test_channels_and_vertices_have_their_own_albedo(tmp_path):
    visibility = computed(tmp_path, bowl(2), 256)
    V = len(visibility.vertices)
    red, green, blue = (leaving(visibility, 2, albedo, 3) for albedo in (0.8, 0.5, 0.0))
    rgb = leaving(visibility, 2, [0.8, 0.5, 0.0], 3)
    assert red.shape == (V, 1, 4)
    assert rgb.shape == (V, 3, 4)
    assert rgb.dtype == np.float32
    np.testing.assert_allclose(rgb, np.concatenate([red, green, blue], axis=1), atol=1e-7)
    assert not blue.any()
    for same in ([0.8] * 3, np.full(V, 0.8), np.full((V, 3), 0.8)):
        np.testing.assert_allclose(leaving(visibility, 2, same, 3), red, atol=1e-7)
    np.testing.assert_allclose(leaving(visibility, 2, np.tile([0.8, 0.5, 0.0], (V, 1)), 3), rgb, atol=1e-7)
    dark = np.where(np.arange(V) == 7, 0.0, 0.8)
    assert not leaving(visibility, 2, dark, 3)[7].any()
    assert leaving(visibility, 2, dark, 3)[8].any()


def test_bounces_add_up(tmp_path):
    """A longer series is a shorter one put into the equation once more."""
    visibility = computed(tmp_path, bowl(3), 512)
    E = irradiance(visibility, 3)[:, None]
    steps: list[tuple[int, int]] = []
    four = leaving(visibility, 3, 0.6, 4, lambda done, total: steps.append((done, total)))
    assert steps == [(1, 4), (2, 4), (3, 4), (4, 4)]
    three = leaving(visibility, 3, 0.6, 3)
    np.testing.assert_allclose(four, 0.6 / np.pi * (E + gathered(visibility, three)), atol=1e-6)


@pytest.mark.parametrize("channels", [1, 3])
def test_incident_radiance_adds_up_to_the_irradiance(tmp_path, channels):
    visibility = computed(tmp_path, bumpy(10), 256)
    rng = np.random.default_rng(11)
    L = rng.normal(size=(len(visibility.vertices), channels, 4)).astype(np.float32)
    E, d = gathered(visibility, L), visibility.directions
    for block in visibility:
        radiance = incident(block, visibility.faces, L)
        assert radiance.shape == (*block.visible.shape, channels, 4)
        assert not radiance[block.visible].any()
        summed = 2 * np.pi / len(d) * np.einsum("bdcn,d->bcn", radiance.astype(np.float64), d[:, 2])
        np.testing.assert_allclose(summed, E[block.vertices], atol=1e-6)
        row, direction, vertex, weight = seen_vertices(block, visibility.faces)
        seen = np.zeros(block.visible.shape, bool)
        seen[row, direction] = True
        assert not radiance[~seen].any()
        np.testing.assert_allclose(weight.sum(axis=1), 1, atol=1e-6)
        assert vertex.max() < len(L)


def test_radiance_is_interpolated_where_the_ray_ends(tmp_path):
    """With radiance that says where it comes from."""
    mesh = bumpy(12)
    visibility = computed(tmp_path, mesh, 256)
    L = np.concatenate([np.ones((len(mesh[0]), 1)), mesh[0]], axis=1)[:, None].astype(np.float32)
    for block in visibility:
        row, direction, _, _ = seen_vertices(block, visibility.faces)
        one, place = np.split(incident(block, visibility.faces, L)[row, direction, 0], [1], axis=1)
        np.testing.assert_allclose(one, 1, atol=1e-6)
        frames = visibility.frames[block.vertices][row]
        towards = np.einsum("hij,hj->hi", frames, visibility.directions[direction])
        along = place - mesh[0][block.vertices][row]
        # The step from the vertex, 2^-18 of half the mesh's side, and u and v in steps of 1/65535 are within
        # 3e-5; a plane that is met at a small angle moves the place by the ray's rounding over the cosine.
        corners = mesh[0][mesh[1][block.hits.face[block.hits.face >= 0]]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        cosine = np.abs((normal * towards).sum(axis=1))
        off = np.linalg.norm(np.cross(along, towards), axis=1)
        assert (off < 3e-5 + 4 * 2.0**-23 / cosine).all()
        assert (along * towards).sum(axis=1).min() > -5e-5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"albedo": 1.01}, r"albedo must be in \[0, 1\], got 1.01 to 1.01"),
        ({"albedo": [0.5, -0.1, 0.2]}, r"albedo must be in \[0, 1\]"),
        ({"albedo": np.nan}, "albedo must be finite"),
        (
            {"albedo": [0.5, 0.5]},
            r"albedo must have the shape \(\) or \(3,\) or \(25,\) or \(25, 3\), got \(2,\)",
        ),
        ({"albedo": "white"}, "albedo must be an array"),
    ],
)
def test_bad_input_is_refused(tmp_path, change, message):
    visibility = computed(tmp_path, grid(4, [0, 0, 0], [1, 0, 0], [0, 1, 0]), 64)
    with pytest.raises((TypeError, ValueError), match=f"^{message}[^\n]*$"):
        leaving(visibility, **{"n": 2, "albedo": 0.5, "bounces": 1, **change})


def test_bounces_need_hits(tmp_path):
    visibility = computed(tmp_path, grid(4, [0, 0, 0], [1, 0, 0], [0, 1, 0]), 64, hits=False)
    L = np.zeros((25, 1, 4), np.float32)
    for call in (
        lambda: leaving(visibility, 2, 0.5, 1),
        lambda: gathered(visibility, L),
        lambda: incident(visibility[0], visibility.faces, L),
    ):
        with pytest.raises(ValueError, match=r"^visibility must have hits"):
            call()
