"""Frames at vertices, and harmonics turned into them: against the oracle, the other rotation, group laws."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shrm import sh
from shrm.transfer.tangent_frames import band_rotations, local_coefficients, vertex_frames
from support import oracles
from support.directions import sphere


def rotations(k: int, seed: int) -> np.ndarray:
    """Random ones, and those at which Euler angles are singular."""
    R = Rotation.random(k, rng=np.random.default_rng(seed)).as_matrix()
    R[0], R[1], R[2] = np.eye(3), np.diag([1, -1, -1]), np.diag([-1, -1, 1])
    return R


def block_diagonal(bands: tuple[np.ndarray, ...]) -> np.ndarray:
    n = len(bands)
    D = np.zeros((len(bands[0]), n * n, n * n))
    for l, band in enumerate(bands):
        D[:, l * l : (l + 1) ** 2, l * l : (l + 1) ** 2] = band
    return D


@pytest.mark.parametrize("n", [1, 2, 5, 11, 20])
def test_it_is_the_rotation_of_sh(n):
    frames, c = rotations(40, 1), np.random.default_rng(2).normal(size=(n * n, 3))
    local = local_coefficients(c, frames)
    for frame, actual in zip(frames, local, strict=True):
        # L_local(w) = L(frame w), and sh.rotate(c, R) is L(R^T w)
        np.testing.assert_allclose(actual, sh.rotate(c, frame.T), atol=1e-12)


def test_it_is_the_oracles_rotation():
    frames, c = rotations(8, 3), np.random.default_rng(4).normal(size=(25, 2))
    for frame, actual in zip(frames, local_coefficients(c, frames), strict=True):
        np.testing.assert_allclose(actual, oracles.rotated_coefficients(c, frame.T), atol=1e-12)


def test_the_function_stays_where_it_is():
    n, frames = 6, rotations(5, 5)
    c = np.random.default_rng(6).normal(size=(n * n, 1))
    w = sphere(50, 7)
    for frame, local in zip(frames, local_coefficients(c, frames), strict=True):
        there = oracles.real_harmonics(n - 1, w) @ c
        here = oracles.real_harmonics(n - 1, w @ frame) @ local  # frame^T w, in local coordinates
        np.testing.assert_allclose(here, there, atol=1e-12)


def test_rotations_are_orthogonal_and_compose():
    n, A, B = 8, rotations(30, 8), rotations(30, 9)
    a, b, ab = (block_diagonal(band_rotations(frames, n)) for frames in (A, B, A @ B))
    np.testing.assert_allclose(a @ np.swapaxes(a, 1, 2), np.tile(np.eye(n * n), (30, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(b @ a, ab, atol=1e-12)  # into A, then from there into B
    inverse = block_diagonal(band_rotations(np.swapaxes(A, 1, 2), n))
    np.testing.assert_allclose(inverse, np.swapaxes(a, 1, 2), atol=1e-12)


def test_each_frame_may_have_its_own_function_and_blocks_do_not_matter():
    frames = rotations(5000, 10)  # more than are evaluated together
    c = np.random.default_rng(11).normal(size=(5000, 4, 2))
    local = local_coefficients(c, frames)
    for k in (0, 4095, 4096, 4999):
        np.testing.assert_allclose(local[k], sh.rotate(c[k], frames[k].T), atol=1e-13)


def test_no_frames_are_no_rotations():
    assert local_coefficients(np.zeros((0, 4, 2)), np.zeros((0, 3, 3))).shape == (0, 4, 2)
    assert [band.shape for band in band_rotations(np.zeros((0, 3, 3)), 3)] == [
        (0, 1, 1),
        (0, 3, 3),
        (0, 5, 5),
    ]


# Frames


def assert_rotations(frames: np.ndarray) -> None:
    np.testing.assert_allclose(
        np.swapaxes(frames, 1, 2) @ frames, np.tile(np.eye(3), (len(frames), 1, 1)), atol=1e-15
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1, rtol=1e-14)


def test_frames_follow_normals_and_tangents():
    lengths = np.geomspace(1e-200, 1e200, 200)[:, None]
    n, t = sphere(200, 12), sphere(200, 13)
    frames = vertex_frames(lengths * n, lengths[::-1] * t)
    assert_rotations(frames)
    np.testing.assert_allclose(frames[:, :, 2], n, atol=1e-15)
    # x is in the plane of t and n, on t's side
    np.testing.assert_allclose(np.einsum("kc,kc->k", frames[:, :, 1], t), 0, atol=1e-14)
    assert np.all(np.einsum("kc,kc->k", frames[:, :, 0], t) > 0)


def test_frames_without_a_normal_or_a_tangent_are_rotations_too():
    n = np.array(
        [[0, 0, 0], [0, 0, 1], [0, 0, -2], [1, 1, 1], [0, 1, 0], [0, 0, 0], [1, 1e-9, 0]], dtype=float
    )
    t = np.array(
        [[1, 0, 0], [0, 0, 5], [0, 0, 0], [-1, -1, -1], [0, 1, 1e-9], [0, 0, 0], [1, 0, 0]], dtype=float
    )
    for frames in (vertex_frames(n, t), vertex_frames(n)):
        assert_rotations(frames)
        np.testing.assert_allclose(frames[[0, 5], :, 2], [[0, 0, 1], [0, 0, 1]])
        np.testing.assert_allclose(frames[1:5, :, 2], n[1:5] / np.linalg.norm(n[1:5], axis=1)[:, None])
    np.testing.assert_allclose(vertex_frames(n, t)[0], np.eye(3))


def test_nearly_parallel_tangents_still_give_exact_rotations():
    n = sphere(300, 14)
    assert_rotations(vertex_frames(n, n + 1e-5 * sphere(300, 15)))


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda: vertex_frames(np.ones(3)), ValueError, r"normals must have the shape \(k, 3\)"),
        (lambda: vertex_frames(np.ones((2, 3)), np.ones((3, 3))), ValueError, "tangents must have the shape"),
        (lambda: vertex_frames([[np.nan, 0, 1]]), ValueError, "normals must be finite"),
        (lambda: band_rotations(np.eye(3), 2), ValueError, r"frames must have the shape \(k, 3, 3\)"),
        (lambda: band_rotations([2 * np.eye(3)], 2), ValueError, "frames must be rotations"),
        (lambda: band_rotations([-np.eye(3)], 2), ValueError, "frames must be rotations"),
        (lambda: band_rotations([np.eye(3)], 33), ValueError, "n must be in"),
        (lambda: local_coefficients(np.ones((5, 1)), [np.eye(3)]), ValueError, "rows"),
        (
            lambda: local_coefficients(np.ones((2, 4, 1)), [np.eye(3)]),
            ValueError,
            r"or \(1, n\^2, channels\)",
        ),
    ],
)
def test_what_does_not_fit_is_refused_by_name(call, error, text):
    with pytest.raises(error, match=text):
        call()
