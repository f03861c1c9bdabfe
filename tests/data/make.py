"""Makes the two environments beside this file: `python tests/data/make.py`.

sun.hdr is a low sun in haze, from the package's daylight: bright enough to be hard, and not so bright that
means over some hundred frames depend on the few that meet it. lamps.hdr is a room with three lamps in its
ceiling, seen from within: nearly all of its energy is in a few texels. Both have 64 x 128 texels. Files are
RGBE: a value is off by at most 1/128 of its texel's largest channel, and `tests/environment/test_data.py`
compares them with what is made anew.
"""

from pathlib import Path

import numpy as np
from shrm import Environment
from shrm.environment.layouts import directions

FOLDER = Path(__file__).parent
H, W = 64, 128

# The room, in meters from the eye: x to the window, y to the left, z up.
LOWEST, HIGHEST = np.array([-3.0, -2.0, -1.2]), np.array([4.0, 2.5, 1.5])
WALLS = np.array([0.6, 0.5, 0.4])  # albedo
# Each lamp: the corner of smallest x and y, its sides along x and y, and its radiance.
LAMPS = (
    (np.array([1.0, 0.5]), np.array([0.3, 0.3]), np.array([90.0, 75.0, 50.0])),
    (np.array([-1.5, -1.2]), np.array([0.2, 0.6]), np.array([60.0, 65.0, 75.0])),
    (np.array([2.8, -1.0]), np.array([0.1, 0.1]), np.array([800.0, 500.0, 200.0])),
)


def irradiance(points: np.ndarray, normals: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return that of a polygon of radiance 1 that is wholly above the points' horizons, by Lambert's formula.

    E = 1/2 sum over the edges of (angle that the edge subtends) (normal of edge and point) . N

    Parameters
    ----------
    points, normals : (n, 3)
    corners : (k, 3)
        Counterclockwise, as the points see them.
    """
    towards = corners - points[:, None]
    towards /= np.linalg.norm(towards, axis=2, keepdims=True)
    following = np.roll(towards, -1, axis=1)
    across = np.cross(following, towards)
    length = np.linalg.norm(across, axis=2)
    angle = np.arctan2(length, (towards * following).sum(axis=2))
    facing = np.einsum("nkc,nc->nk", across, normals) / np.maximum(length, 1e-12)
    return 0.5 * (angle * facing).sum(axis=1)


def room() -> np.ndarray:
    """Return the radiance (H, W, 3) of the lamps, and of the walls that they light, once and evenly again."""
    d = directions("latlong", H, W).reshape(-1, 3)
    # The wall that each ray meets.
    with np.errstate(divide="ignore"):
        distance = np.where(d > 0, HIGHEST / d, LOWEST / d)
    axis = np.argmin(distance, axis=1)
    points = d * distance.min(axis=1)[:, None]
    normals = -np.eye(3)[axis] * np.sign(d[np.arange(len(d)), axis])[:, None]
    is_ceiling = normals[:, 2] < -0.5

    # Light that comes straight from the lamps; the ceiling sees none of it.
    direct = np.zeros((len(d), 3))
    for corner, sides, radiance in LAMPS:
        square = corner + sides * np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
        corners = np.column_stack([square, np.full(4, HIGHEST[2])])
        E = np.where(is_ceiling, 0.0, irradiance(points, normals, corners))
        direct += np.maximum(E, 0)[:, None] * radiance

    # What is reflected again and again is taken as even: an integrating sphere of these walls.
    power = sum(np.pi * sides.prod() * radiance for _, sides, radiance in LAMPS)
    x, y, z = HIGHEST - LOWEST
    again = power * WALLS / (1 - WALLS) / (2 * (x * y + y * z + z * x))
    pixels = WALLS / np.pi * (direct + again)

    # The lamps themselves.
    for corner, sides, radiance in LAMPS:
        inside = is_ceiling & ((points[:, :2] >= corner) & (points[:, :2] <= corner + sides)).all(axis=1)
        pixels[inside] = radiance
    return pixels.reshape(H, W, 3).astype(np.float32)


def environments() -> dict[str, Environment]:
    """Return what the files hold, by their names."""
    return {
        "sun.hdr": Environment.daylight(sun_elevation=8.0, sun_azimuth=140.0, turbidity=8.0, size=H),
        "lamps.hdr": Environment(room()),
    }


if __name__ == "__main__":
    for name, env in environments().items():
        env.write(FOLDER / name)
