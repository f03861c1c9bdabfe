"""Pictures: geometry against exact formulas, light against materials whose answer is known."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pytest
from shrm.render import (
    Camera,
    Mesh,
    Object,
    Sphere,
    environment_lookup,
    render,
    row_camera,
    tangents_around,
    texture_lookup,
)
from support.pictures import Normals, icosphere

Float32 = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Picture:
    """An environment that is only a picture."""

    pixels: Float32


class Constant:
    """A Lambert surface in a white furnace: the same radiance everywhere."""

    def radiance(self, normals: Float32, views: Float32, tangents: Float32 | None = None) -> Float32:
        return np.full(normals.shape, 0.5, np.float32)


class Mirror:
    """A mirror, looking straight into the picture."""

    def __init__(self, pixels: Float32) -> None:
        self.pixels = pixels

    def radiance(self, normals: Float32, views: Float32, tangents: Float32 | None = None) -> Float32:
        n, v = normals.astype(np.float64), views.astype(np.float64)
        return environment_lookup(self.pixels, 2.0 * np.sum(n * v, axis=1, keepdims=True) * n - v)


def directions_of(H: int, W: int) -> npt.NDArray[np.float64]:
    """Centers of the texels, (H, W, 3), by the convention's formula."""
    theta = ((np.arange(H) + 0.5) * np.pi / H)[:, None]
    phi = np.pi - 2.0 * np.pi * (np.arange(W) + 0.5) / W
    return np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0.0 * phi], axis=2
    )


def smooth_picture(H: int, W: int) -> Float32:
    x, y, z = np.moveaxis(directions_of(H, W), 2, 0)
    return np.stack([1.0 + x, 1.0 + y * z, 1.0 + z + 0.5 * x * y], axis=2).astype(np.float32)


def rotation(seed: int) -> npt.NDArray[np.float64]:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.linalg.det(q)


# --- look-ups -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("H", "W"), [(1, 1), (2, 3), (8, 15), (8, 16)])
def test_texel_centers_are_looked_up_exactly(H: int, W: int) -> None:
    pixels = np.random.default_rng(1).random((H, W, 3), np.float32)
    found = environment_lookup(pixels, directions_of(H, W).reshape(-1, 3))
    np.testing.assert_allclose(found.reshape(H, W, 3), pixels, atol=1e-5)


@pytest.mark.parametrize(("H", "W"), [(1, 4), (8, 15)])
def test_the_lookup_is_continuous_across_the_seam_and_the_poles(H: int, W: int) -> None:
    pixels = np.random.default_rng(2).random((H, W, 3), np.float32)
    seam = np.array([[-1.0, 1e-9, 0.3], [-1.0, -1e-9, 0.3]]) / np.hypot(1.0, 0.3)
    a, b = environment_lookup(pixels, seam)
    np.testing.assert_allclose(a, b, atol=1e-6)
    phi = np.linspace(0.0, 6.0, 7)
    for z, row in ((1.0, 0), (-1.0, -1)):
        ring = np.stack([1e-7 * np.cos(phi), 1e-7 * np.sin(phi), np.full(7, z)], axis=1)
        np.testing.assert_allclose(
            environment_lookup(pixels, ring), np.tile(pixels[row].mean(axis=0), (7, 1)), atol=1e-5
        )


def test_a_texture_starts_at_its_upper_left_corner() -> None:
    texture = np.arange(6, dtype=np.float32).reshape(2, 3, 1)
    u, v = (np.array([0.5, 1.5, 2.5]) / 3.0, np.array([0.75, 0.25]))
    uv = np.stack(np.meshgrid(u, v), axis=2).reshape(-1, 2)
    np.testing.assert_allclose(texture_lookup(texture, uv).ravel(), np.arange(6), atol=1e-6)


# --- pictures -------------------------------------------------------------------------------------


def test_coverage_of_an_orthographic_disc_is_its_area() -> None:
    camera = Camera((-5.0, 0.0, 0.0), height=4.0)
    picture = render([Object(Sphere(), Constant())], camera, (64, 64), samples=4)
    # A lattice of 256 x 256 points counts a disc's area to about the lattice's step: 1/256.
    assert picture.coverage.mean() == pytest.approx(np.pi / 16.0, rel=4e-3)
    np.testing.assert_allclose(picture.radiance[..., 0], 0.5 * picture.coverage, atol=1e-6)


def test_a_white_furnace_is_constant() -> None:
    camera = Camera((-5.0, 0.0, 0.0), fov=20.0)
    furnace = Picture(np.full((8, 16, 3), 0.5, np.float32))
    picture = render([Object(Sphere(), Constant())], camera, (32, 48), background=furnace)
    np.testing.assert_allclose(picture.radiance, 0.5, atol=1e-6)


def test_the_background_is_the_picture_unmirrored() -> None:
    """Looking along +x: the center of the picture ahead, its left part on the left, its top above."""
    pixels = smooth_picture(64, 128)
    picture = render(
        [],
        Camera((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), fov=60.0),
        (65, 65),
        background=Picture(pixels),
        samples=1,
    )
    # Bilinear interpolation of functions of degree 2 on 64 rows: (pi/64)^2/8 x 2nd derivative (4).
    np.testing.assert_allclose(picture.radiance[32, 32], [2.0, 1.0, 1.0], atol=2e-3)
    left = np.array([1.0, np.tan(np.pi / 6.0) * 64.0 / 65.0, 0.0])
    left /= np.linalg.norm(left)
    np.testing.assert_allclose(picture.radiance[32, 0, 2], 1.0 + 0.5 * left[0] * left[1], atol=2e-3)
    assert picture.radiance[0, 32, 2] > picture.radiance[64, 32, 2]


def test_a_mirror_shows_the_world_behind_the_camera() -> None:
    """The sphere's center shows what lies behind the eye; its left edge, what is to the left."""
    pixels = smooth_picture(128, 256)
    picture = render(
        [Object(Sphere(), Mirror(pixels))], Camera((-9.0, 0.0, 0.0), height=2.0), (129, 129), samples=1
    )
    for (row, column), direction in {(64, 64): (-1, 0, 0), (64, 18): (0, 1, 0), (18, 64): (0, 0, 1)}.items():
        # At 45 degrees from the center, (1 - 1/sqrt2) of the radius from the edge, R is sideways.
        x, y, z = direction
        np.testing.assert_allclose(
            picture.radiance[row, column], [1.0 + x, 1.0 + y * z, 1.0 + z + 0.5 * x * y], atol=0.03
        )


@pytest.mark.parametrize("viewer", ["near", "distant"])
def test_turning_everything_turns_nothing(viewer: str) -> None:
    """Light, object and camera turned together: the same picture (the camera's up turns about z)."""
    pixels, angle = smooth_picture(64, 128), 2.0 * np.pi * 32 / 128
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    position, mesh = np.array([-4.0, 0.5, 1.5]), icosphere(2)
    turned_pixels = np.ascontiguousarray(np.roll(pixels, -32, axis=1))  # +phi is to the left
    pictures = [
        render(
            [Object(shape, Mirror(light))],
            Camera(tuple(eye)),
            (40, 40),
            viewer=viewer,
            background=Picture(light),
        )
        for shape, light, eye in (
            (mesh, pixels, position),
            (Mesh(mesh.vertices @ turn.T, mesh.faces), turned_pixels, turn @ position),
        )
    ]
    inside = (pictures[0].coverage == 1.0) & (pictures[1].coverage == 1.0)
    np.testing.assert_allclose(pictures[0].radiance[inside], pictures[1].radiance[inside], atol=2e-4)


def test_a_distant_viewer_has_one_view() -> None:
    class Views:
        def radiance(self, normals: Float32, views: Float32, tangents: Float32 | None = None) -> Float32:
            return views

    camera = Camera((-3.0, 0.0, 0.0), fov=60.0)
    distant = render([Object(Sphere(), Views())], camera, (32, 32), samples=1, viewer="distant")
    seen = distant.radiance[distant.coverage == 1.0]
    np.testing.assert_array_equal(seen, np.tile(np.float32([-1, 0, 0]), (len(seen), 1)))
    near = render([Object(Sphere(), Views())], camera, (32, 32), samples=1)
    assert np.ptp(near.radiance[near.coverage == 1.0], axis=0).max() > 0.3


def test_shading_by_pixel_asks_less_and_shows_the_same() -> None:
    class Counting(Normals):
        asked = 0

        def radiance(self, normals: Float32, views: Float32, tangents: Float32 | None = None) -> Float32:
            Counting.asked += len(normals)
            return normals

    camera = Camera((-5.0, 1.0, 2.0), fov=28.0)
    fine = render([Object(Sphere(), Counting())], camera, (64, 64), samples=3)
    per_sample, Counting.asked = Counting.asked, 0
    coarse = render([Object(Sphere(), Counting())], camera, (64, 64), samples=3, shading="pixel")
    assert Counting.asked == np.count_nonzero(coarse.coverage)
    assert per_sample > 8 * Counting.asked
    np.testing.assert_array_equal(fine.coverage, coarse.coverage)
    # The mean of unit vectors within an angle d of each other is shorter than 1 by d^2/8 at most.
    inside = fine.coverage == 1.0
    assert np.median(np.abs(fine.radiance - coarse.radiance)[inside]) < 1e-3


def test_the_nearer_object_is_seen() -> None:
    near, far = Object(Sphere((-2.0, 0, 0), 0.5), Constant()), Object(Sphere(), Normals())
    camera = Camera((-8.0, 0, 0), height=2.0)
    for order in ([near, far], [far, near]):
        center = render(order, camera, (9, 9), samples=1).radiance[4, 4]
        np.testing.assert_array_equal(center, np.float32([0.5, 0.5, 0.5]))


def test_a_texture_multiplies_the_reflected_light() -> None:
    texture = np.zeros((4, 8, 3), np.float32)
    texture[:, :4] = [1.0, 0.5, 0.25]  # u < 1/2: the sphere's half y < 0
    picture = render(
        [Object(Sphere(), Constant(), texture)], Camera((9.0, 0, 0), height=2.0), (64, 64), samples=1
    )
    np.testing.assert_allclose(picture.radiance[32, 16], [0.5, 0.25, 0.125])  # seen from +x, -y is left
    np.testing.assert_array_equal(picture.radiance[32, 48], 0.0)


def test_tangents_are_tangent_and_of_unit_length_even_on_the_axis() -> None:
    normals = np.vstack([np.random.default_rng(4).normal(size=(100, 3)), [[0, 0, 1], [0, 0, -1]]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    tangents = tangents_around((0.0, 0.0, 1.0), normals)
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(np.sum(tangents * normals, axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(tangents[:100, 2], 0.0, atol=1e-12)


def test_looking_straight_down_works() -> None:
    picture = render([Object(Sphere(), Normals())], Camera((0, 0, 5.0)), (9, 9), samples=1)
    np.testing.assert_allclose(picture.radiance[4, 4], [0, 0, 1], atol=1e-6)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (7, 3), (3, 7)])
def test_pictures_of_any_size_show_the_middle(width: int, height: int) -> None:
    camera = Camera((-8.0, 0, 0), height=2.0 * height)  # a pixel is as wide as the sphere
    picture = render([Object(Sphere(), Constant())], camera, (height, width), samples=32)
    assert picture.radiance.shape == (height, width, 3)
    # The rim crosses 128 of 1024 samples; each is off by 0.3, or together by sqrt(128) 0.3 / 1024 = 0.003.
    assert picture.coverage[height // 2, width // 2] == pytest.approx(np.pi / 4.0, abs=0.01)
    assert picture.coverage.sum() == picture.coverage[height // 2, width // 2]
    np.testing.assert_allclose(picture.radiance, 0.5 * np.repeat(picture.coverage[..., None], 3, axis=2))


def test_bands_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    objects, camera = [Object(Sphere(), Normals())], Camera((-4.0, 1.0, 1.0))
    whole = render(objects, camera, (31, 20))
    monkeypatch.setattr("shrm.render.picture.RAYS_AT_ONCE", 200)
    done: list[float] = []
    banded = render(objects, camera, (31, 20), progress=done.append)
    np.testing.assert_array_equal(whole.radiance, banded.radiance)
    assert done == sorted(done)
    assert done[-1] == 1.0


@pytest.mark.parametrize(
    ("changed", "name"),
    [
        ({"shape": (8, 0)}, "shape"),
        ({"samples": 0}, "samples"),
        ({"viewer": "far"}, "viewer"),
        ({"shading": "x"}, "shading"),
    ],
)
def test_pictures_are_checked_at_the_door(changed: dict[str, object], name: str) -> None:
    arguments = {"shape": (8, 8), **changed}
    with pytest.raises(ValueError, match=name):
        render([], Camera((1.0, 0, 0)), **arguments)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"position": (0.0, 0.0, 0.0)}, "position"),
        ({"position": (np.nan, 0.0, 0.0)}, "position"),
        ({"position": (1.0, 0.0, 0.0), "fov": 180.0}, "fov"),
        ({"position": (1.0, 0.0, 0.0), "height": 0.0}, "height"),
    ],
)
def test_cameras_are_checked_at_the_door(arguments: dict[str, object], name: str) -> None:
    with pytest.raises(ValueError, match=name):
        Camera(**arguments)


@pytest.mark.parametrize("height", [None, 3.0])
def test_projection_is_the_inverse_of_rays(height: float | None) -> None:
    camera = Camera((-4.0, 1.0, 2.0), (0.5, 0.2, 0.0), fov=50.0, height=height)
    rng = np.random.default_rng(5)
    columns, rows = rng.uniform(0.0, 60.0, 20), rng.uniform(0.0, 40.0, 20)
    origins, directions = camera.rays(columns, rows, (40, 60))
    points = origins + rng.uniform(1.0, 9.0, (20, 1)) * directions
    np.testing.assert_allclose(camera.project(points, (40, 60)), [columns, rows], atol=1e-9)


@pytest.mark.parametrize("aspect", [0.5, 1.0, 6.0])
def test_a_row_is_in_the_picture(aspect: float) -> None:
    width, height = (int(40 * aspect), 40) if aspect >= 1.0 else (40, int(40 / aspect))
    camera, centers = row_camera(4, aspect, azimuth=70.0, elevation=20.0)
    picture = render([Object(Sphere(center), Constant()) for center in centers], camera, (height, width))
    for edge in (picture.coverage[0], picture.coverage[-1], picture.coverage[:, 0], picture.coverage[:, -1]):
        assert not edge.any()
    columns = camera.project(centers, (height, width))[0]
    assert np.all(np.diff(columns) > 0.0)  # from left to right
