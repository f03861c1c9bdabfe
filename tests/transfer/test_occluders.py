"""Rays of matrix radiance transfer: against a ray caster of numpy in float64, and against closed forms."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shrm.transfer.rays.directions import local_directions
from shrm.transfer.rays.occluders import Hits, Occluders
from shrm.transfer.tangent_frames import vertex_frames
from support.transfer_meshes import (
    Mesh,
    ball,
    bumpy,
    grid,
    moved,
    random_rotation,
    room,
    together,
    with_points,
)
from support.transfer_oracle import first_hits


def cast(mesh: Mesh, d: np.ndarray, these: slice = slice(None)) -> tuple[np.ndarray, Hits]:
    vertices, faces, normals = mesh
    visible, hits = Occluders(vertices, faces, normals).cast(these, vertex_frames(normals)[these], d)
    assert hits is not None
    assert len(hits) == np.count_nonzero(~visible)
    return visible, hits


# ---- Directions


@pytest.mark.parametrize(("count", "D"), [(16, 8), (17, 16), (64, 32), (4096, 2048), (4100, 2056)])
def test_directions_fill_bytes_and_the_hemisphere(count, D):
    d = local_directions(count)
    assert d.shape == (D, 3)
    assert d[:, 2].min() > 0
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-15)
    np.testing.assert_allclose(2 * np.pi / D * d[:, 2].sum(), np.pi, atol=1e-12)


def test_directions_measure_solid_angles_far_better_than_random_ones():
    axes = Rotation.random(2000, rng=np.random.default_rng(1)).as_matrix()[:, 2]
    d = local_directions()
    measured = 2 * np.pi * (d @ axes.T > 0).mean(axis=0)
    part = 1 - np.arccos(axes[:, 2]) / np.pi  # of the hemisphere
    random = 2 * np.pi * np.sqrt(part * (1 - part) / len(d))
    assert np.sqrt(((measured - 2 * np.pi * part) ** 2).mean()) < np.sqrt((random**2).mean()) / 7


@pytest.mark.parametrize("count", [15, 0, -1, 65537, 4096.0, True, "4096"])
def test_bad_counts_are_refused(count):
    with pytest.raises((TypeError, ValueError), match=r"^count must be [^\n]*$"):
        local_directions(count)


# ---- Rays


def test_rays_meet_what_the_oracle_meets():
    rng, d = np.random.default_rng(2), local_directions(96)
    frames = Rotation.random(60, rng=rng).as_matrix()
    mesh, points = with_points(bumpy(3), rng.uniform(-2, 2, (60, 3)), frames[:, :, 2])
    vertices, faces, _ = mesh
    towards = np.einsum("bij,dj->bdi", frames, d).reshape(-1, 3)
    origins = np.repeat(vertices[points], len(d), axis=0)
    t, face = first_hits(origins, towards, mesh)
    normals = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )

    visible, hits = Occluders(vertices, faces).cast(points, frames, d)
    blocked = np.flatnonzero(~visible)
    # A ray that runs within rounding of an edge may go either way: 2e-7 around 480 edges, 1 in 1e4 of space
    agree = visible.ravel() == (face < 0)
    assert np.count_nonzero(~agree) <= 1
    both = agree[blocked]
    behind = (normals[face[blocked]] * towards[blocked]).sum(axis=1) > 0
    same = hits.face[both] == np.where(behind, -1, face[blocked])[both]
    assert np.count_nonzero(~same) <= 1
    assert 0.2 < behind.mean() < 0.8
    at = vertices[faces[face[blocked]]]
    place = at[:, 0] + hits.u[:, None] * (at[:, 1] - at[:, 0]) + hits.v[:, None] * (at[:, 2] - at[:, 0])
    error = np.linalg.norm(place - origins[blocked] - t[blocked, None] * towards[blocked], axis=1)
    assert np.median(error) < 1.5 * 2.0**-18 * 1.4  # the step from the vertex, of half the mesh's side
    assert np.quantile(error, 0.99) < 1e-4  # grazing rays multiply it


def test_vertices_of_a_mesh_with_hollows_see_what_the_oracle_sees():
    mesh, d = bumpy(4), local_directions(96)
    vertices, _, normals = mesh
    visible, _ = cast(mesh, d)
    towards = np.einsum("bij,dj->bdi", vertex_frames(normals), d).reshape(-1, 3)
    t, _ = first_hits(np.repeat(vertices + 1e-6 * normals, len(d), axis=0), towards, mesh)
    assert 0.4 < visible.mean() < 0.9
    assert np.count_nonzero(visible.ravel() != np.isinf(t)) <= 1e-3 * visible.size


@pytest.mark.parametrize("scale", [1e-30, 1e-3, 1.0, 1e30])
@pytest.mark.parametrize("offset", [0.0, 3.0])
def test_flat_and_round_surfaces_see_everything(scale, offset):
    d = local_directions(1024)
    for seed, mesh in enumerate([grid(12, [-1, -1, 0], [2, 0, 0], [0, 2, 0]), ball(3)]):
        visible, _ = cast(moved(mesh, random_rotation(seed), offset * scale, scale), d)
        assert visible.all()


def test_a_disk_blocks_its_solid_angle():
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rim = np.stack([0.6 * np.cos(turn), 0.6 * np.sin(turn), 0 * turn + 0.8], axis=1)
    faces = np.stack([np.zeros(400, int), 1 + np.arange(400), 1 + np.roll(np.arange(400), -1)], axis=1)
    disk = (np.r_[[[0, 0, 0.8]], rim], faces, np.tile([0, 0, -1.0], (401, 1)))
    mesh, point = with_points(disk, np.zeros((1, 3)), np.array([[0.28, 0.0, 0.96]]))
    d = local_directions(16384)
    visible, hits = cast(mesh, d, point)
    # Cells that the outline of 2 pi .6 crosses are counted in whole or not: as if by tossing coins
    cell = 2 * np.pi / len(d)
    tolerance = 3 * cell * np.sqrt(2 * np.pi * 0.6 / np.sqrt(cell)) / 2
    assert cell * np.count_nonzero(~visible) == pytest.approx(2 * np.pi * (1 - 0.8), abs=tolerance)
    assert cell * (~visible[0] * d[:, 2]).sum() == pytest.approx(np.pi * 0.36 * 0.96, abs=tolerance)
    assert (hits.face >= 0).all()


def test_a_plane_blocks_the_half_space_behind_it():
    plane = grid(1, [0.5, -1e3, -1e3], [0, 0, 2e3], [0, 2e3, 0])  # at x = .5, seen from x < .5
    mesh, point = with_points(plane, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    visible, _ = cast(mesh, local_directions(), point)
    d = local_directions() @ vertex_frames([[0.0, 0.0, 1.0]])[0].T
    assert (visible[0] == (d[:, 0] < 1e-3)).all()


@pytest.mark.parametrize("seed", range(3))
def test_nothing_leaks_at_split_edges_of_a_room(seed):
    mesh = moved(room(3), random_rotation(seed), 5.0, 3.0)
    visible, hits = cast(mesh, local_directions(1024))
    assert not visible.any()
    assert (hits.face >= 0).all()


def test_nothing_leaks_at_the_foot_of_a_box():
    box = room(2)
    box = box[0] - [0.5, 0.5, 0], box[1][:, ::-1], -box[2]  # from outside, standing on z = 0
    mesh = together(grid(4, [-5, -5, 0], [10, 0, 0], [0, 10, 0]), box)
    vertices, _, normals = mesh
    sides = (abs(normals[:, 2]) < 0.5) & (vertices[:, 2] < 0.9)
    visible, hits = cast(mesh, local_directions(1024))
    towards = np.einsum("bij,dj->bdi", vertex_frames(normals), local_directions(1024))
    down = (towards[..., 2] < -0.3) & sides[:, None]  # within the floor's extent
    assert not visible[down].any()
    front = np.zeros_like(visible)
    front[~visible] = hits.face >= 0
    assert front[down].all()


def test_what_is_met_from_behind_carries_no_light():
    vertices, faces, normals = ball(2)
    frames, d = vertex_frames(-normals), local_directions(64)
    for outside, carries in ((normals, False), (-normals, True)):  # normals say which side is shaded,
        visible, hits = Occluders(vertices, faces[:, ::-1], outside).cast(slice(None), frames, d)
        assert not visible.any()
        assert hits is not None
        assert ((hits.face >= 0) == carries).all()
    visible, hits = Occluders(vertices, faces).cast(
        slice(None), frames, d
    )  # without them the order of corners
    assert not visible.any()
    assert hits is not None
    assert (hits.face == -1).all()


def test_broken_meshes_are_cast_all_the_same():
    vertices, faces, normals = ball(2)
    k = len(vertices)
    extra = np.array([vertices[0], [0, 0, 0], [1e300, 0, -1e300], 0.5 * (vertices[0] + vertices[1])])
    flat = [[0, 0, 1], [2, 2, 2], [0, 1, k + 3], [k, 0, k]]  # without area
    double = faces[:5]
    inside = [[0, 1, k + 1]]  # a third face at an edge
    broken = np.r_[vertices, extra], np.r_[faces, flat, double, inside], np.r_[normals, np.zeros((4, 3))]
    d = local_directions(128)
    visible, _ = cast(broken, d)
    good, _ = cast((vertices, faces, normals), d)
    assert good.all()
    assert visible[:k].all()
    assert not visible[k + 1].any()  # at the center
    assert visible[k + 2].all()  # without a normal: z is the world's, and far below
    nothing, _ = cast((vertices, np.array(flat)[:2], normals), d)
    assert nothing.all()


def test_threads_and_hits_change_nothing(monkeypatch):
    vertices, faces, normals = bumpy(5)
    frames, d = vertex_frames(normals), local_directions(4096)
    occluders = Occluders(vertices, faces, normals)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    visible, hits = occluders.cast(slice(None), frames, d)
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    again, same = occluders.cast(slice(None), frames, d)
    alone, nothing = occluders.cast(slice(None), frames, d, hits=False)
    assert nothing is None
    assert (visible == again).all()
    assert (visible == alone).all()
    assert hits is not None
    assert same is not None
    assert all((getattr(hits, name) == getattr(same, name)).all() for name in ("face", "u", "v"))
