"""What the mouse does to the eye and the light, without a window."""

import numpy as np
import pytest
from shrm.render import Camera
from shrm.viewer.gpu.geometry import bounds, clip_from_world
from shrm.viewer.window.orbit import Orbit, turned_light

WIDTH, HEIGHT = 640, 480


def seen_at(camera: Camera, point: np.ndarray) -> np.ndarray:
    columns, rows = camera.project(point[None], (HEIGHT, WIDTH))
    return np.array([columns[0], rows[0]])


def test_orbiting_keeps_distance_and_target() -> None:
    rng = np.random.default_rng(1)
    orbit = Orbit(distance=4.0, target=(1.0, -2.0, 0.5))
    for dx, dy in rng.uniform(-300, 300, (50, 2)):
        orbit = orbit.orbited(dx, dy)
        eye = np.asarray(orbit.camera.position)
        assert np.linalg.norm(eye - orbit.target) == pytest.approx(4.0)
        assert -180.0 <= orbit.azimuth < 180.0
        assert abs(orbit.elevation) < 90.0


@pytest.mark.parametrize(("dx", "dy"), [(30.0, 0.0), (0.0, 30.0), (-20.0, 10.0)])
def test_the_front_of_the_object_follows_an_orbiting_pointer(dx: float, dy: float) -> None:
    before = Orbit(azimuth=25.0, elevation=5.0)
    front = np.asarray(before.target) - before.camera.forward
    moved = seen_at(before.orbited(dx, dy).camera, front) - seen_at(before.camera, front)
    assert moved @ (dx, dy) > 0.9 * np.linalg.norm(moved) * np.hypot(dx, dy)


def test_a_pan_keeps_the_target_s_point_under_the_pointer() -> None:
    before = Orbit(azimuth=-70.0, elevation=20.0, distance=3.0, target=(0.3, 0.2, 0.1))
    point = np.asarray(before.target)
    after = before.panned(40.0, -25.0, HEIGHT)
    assert seen_at(after.camera, point) - seen_at(before.camera, point) == pytest.approx([40.0, -25.0])


def test_zooming_in_and_out_returns() -> None:
    orbit = Orbit(distance=3.0)
    assert orbit.zoomed(2.0).distance < 3.0
    assert orbit.zoomed(2.0).zoomed(-2.0).distance == pytest.approx(3.0)
    assert 0.0 < orbit.zoomed(1e6).distance < orbit.zoomed(-1e6).distance < np.inf


@pytest.mark.parametrize("aspect", [0.4, 1.0, 2.5])
def test_fitted_balls_are_inside_the_picture_and_one_is_near_its_edge(aspect: float) -> None:
    from shrm.render import Sphere

    spheres = [Sphere((0.0, y, 0.2 * y), 0.5 + 0.1 * y) for y in (-2.0, 0.0, 3.0)]
    fitted = Orbit(azimuth=15.0, elevation=30.0).fitted([bounds(s) for s in spheres], aspect)
    rng = np.random.default_rng(2)
    on_sphere = rng.normal(size=(4000, 3))
    on_sphere /= np.linalg.norm(on_sphere, axis=1, keepdims=True)
    points = np.concatenate([np.asarray(s.center) + s.radius * on_sphere for s in spheres])
    clip = np.c_[points, np.ones(len(points))] @ clip_from_world(fitted.camera, aspect, (0, 0), spheres).T
    reach = np.abs(clip[:, :2] / clip[:, 3:]).max()
    assert 0.75 < reach < 1.0


def test_fitting_nothing_changes_nothing() -> None:
    assert Orbit().fitted([], 1.0) == Orbit()


@pytest.mark.parametrize(("dx", "dy"), [(30.0, 0.0), (0.0, 30.0), (-20.0, 10.0)])
def test_the_light_behind_the_objects_follows_the_pointer(dx: float, dy: float) -> None:
    camera = Orbit(azimuth=40.0, elevation=0.0).camera
    R = turned_light(np.eye(3), dx, dy, camera)
    ahead = np.asarray(camera.position) + 1e6 * camera.forward
    moved = seen_at(camera, np.asarray(camera.position) + 1e6 * (R @ camera.forward)) - seen_at(camera, ahead)
    assert moved @ (dx, dy) > 0.9 * np.linalg.norm(moved) * np.hypot(dx, dy)


def test_the_light_s_turn_stays_a_rotation() -> None:
    rng = np.random.default_rng(3)
    R, orbit = np.eye(3), Orbit()
    for dx, dy in rng.uniform(-50, 50, (2000, 2)):
        R = turned_light(R, dx, dy, orbit.camera)
    assert pytest.approx(np.eye(3), abs=1e-12) == R.T @ R
    assert np.linalg.det(R) == pytest.approx(1.0)
