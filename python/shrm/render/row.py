"""Objects side by side, and a camera that has them all in the picture."""

from __future__ import annotations

import math

import numpy as np

from shrm.render.camera import Camera, Vector

SPACING = 2.3
"""Distance between the centers of unit spheres: a gap of a third of a radius."""
MARGIN = 0.3
"""Free space around the row, in radii."""

SUN_AZIMUTH = 130.0
"""Degrees from +x towards +y: the sun over the left shoulder of a camera that looks along +x."""


def row_extent(count: int) -> tuple[float, float]:
    """Return the width and height of a row of unit spheres with its margin."""
    return SPACING * (count - 1) + 2.0 * (1.0 + MARGIN), 2.0 * (1.0 + MARGIN)


def row_shape(count: int, diameter: int) -> tuple[int, int]:
    """Return the shape (H, W) of a picture of a row, given the pixels across a sphere."""
    width, height = row_extent(count)
    return round(height * diameter / 2.0), round(width * diameter / 2.0)


def row_camera(
    count: int, aspect: float, azimuth: float = 0.0, elevation: float = 10.0, fov: float = 30.0
) -> tuple[Camera, list[Vector]]:
    """Stand `count` unit spheres in a row through the origin, from left to right in the picture.

    Parameters
    ----------
    count : int
    aspect : float
        Width over height of the picture.
    azimuth, elevation : float
        Degrees: where the camera looks (azimuth 0 is along +x, 90 along +y), and how far down.
    fov : float
        Field of view across the wider side, in degrees.

    Returns
    -------
    camera : Camera
    centers : list of count points
    """
    phi, down = math.radians(azimuth), math.radians(elevation)
    forward = np.array([math.cos(phi) * math.cos(down), math.sin(phi) * math.cos(down), -math.sin(down)])
    right = np.array([math.sin(phi), -math.cos(phi), 0.0])
    width, height = row_extent(count)
    reach = math.tan(math.radians(fov) / 2.0)
    across, upright = reach * min(1.0, aspect), reach * min(1.0, 1.0 / aspect)
    # 1: perspective magnifies the front of the spheres, which is a radius nearer than their centers.
    distance = 1.0 + max(width / (2.0 * across), height / (2.0 * upright))
    x, y, z = (float(coordinate) for coordinate in -distance * forward)
    camera = Camera((x, y, z), fov=math.degrees(2.0 * math.atan(upright)))
    offsets = SPACING * (np.arange(count) - (count - 1) / 2.0)
    return camera, [(float(x), float(y), float(z)) for x, y, z in offsets[:, None] * right]
