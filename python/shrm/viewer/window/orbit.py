"""What the mouse does to the eye and to the light: orbit, pan, zoom, fit, turn. Plain numbers, no window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shrm.arrays import FloatArray
from shrm.render.camera import Camera, Vector
from shrm.render.placement import about_vertical
from shrm.validation import number

DEGREES_PER_PIXEL = 0.4
"""Turn of the eye or of the light for a drag over one pixel."""
DEGREES_PER_SECOND = 30.0
"""Speed of light that rotates by itself: once round in 12 seconds."""
ZOOM = 0.88
"""Factor of the distance for one step of the wheel."""
STEEPEST = 89.0
"""Largest elevation in degrees: beyond 90 the picture's up would flip."""
NEAREST, FARTHEST = 1e-4, 1e6
"""Limits of the distance, in the world's unit: within them float32 has digits to spare."""
MARGIN = 1.15
"""Factor of a ball's radius, so that it does not touch the picture's edge."""


@dataclass(frozen=True)
class Orbit:
    """An eye on a sphere around what it looks at.

    Attributes
    ----------
    azimuth, elevation : float
        Where the eye looks, in degrees, as `shrm render --view`: azimuth 0 along +x, 90 along +y; elevation
        is how far down.
    distance : float
        From the eye to the target, in the world's unit.
    target : 3 floats
        What is in the middle of the picture.
    fov : float
        Vertical field of view in degrees.
    """

    azimuth: float = 0.0
    elevation: float = 10.0
    distance: float = 5.0
    target: Vector = (0.0, 0.0, 0.0)
    fov: float = 30.0

    def __post_init__(self) -> None:
        if len(self.target) != 3 or not np.all(np.abs(self.target) <= FARTHEST):
            raise ValueError(f"target must be three numbers within {FARTHEST:g}, got {self.target!r}")
        for name, low, high in (
            ("azimuth", -1e6, 1e6),
            ("elevation", -90.0, 90.0),
            ("distance", NEAREST, FARTHEST),
            ("fov", 1e-3, 179.0),
        ):
            number(name, getattr(self, name), low, high)

    @property
    def camera(self) -> Camera:
        """The camera."""
        phi, down = math.radians(self.azimuth), math.radians(self.elevation)
        forward = (math.cos(phi) * math.cos(down), math.sin(phi) * math.cos(down), -math.sin(down))
        x, y, z = (t - self.distance * f for t, f in zip(self.target, forward, strict=True))
        return Camera((x, y, z), self.target, fov=self.fov)

    def orbited(self, dx: float, dy: float) -> Orbit:
        """Return the eye moved by a drag of (dx, dy) pixels, x to the right, y down: the object follows."""
        azimuth = (self.azimuth - DEGREES_PER_PIXEL * dx + 180.0) % 360.0 - 180.0
        elevation = float(np.clip(self.elevation + DEGREES_PER_PIXEL * dy, -STEEPEST, STEEPEST))
        return replace(self, azimuth=azimuth, elevation=elevation)

    def panned(self, dx: float, dy: float, height: int) -> Orbit:
        """Return the target moved so that its point stays under a pointer that moves by (dx, dy) pixels.

        `height` is that of the picture in pixels.
        """
        unit = 2.0 * self.distance * math.tan(math.radians(self.fov) / 2.0) / height
        right, up, _ = self.camera.axes
        x, y, z = (float(c) for c in np.asarray(self.target) - unit * dx * right + unit * dy * up)
        return replace(self, target=(x, y, z))

    def zoomed(self, steps: float) -> Orbit:
        """Return the eye nearer by so many steps of the wheel."""
        return replace(
            self,
            distance=float(np.clip(self.distance * ZOOM ** np.clip(steps, -100, 100), NEAREST, FARTHEST)),
        )

    def fitted(self, balls: Sequence[tuple[FloatArray, float]], aspect: float) -> Orbit:
        """Return the eye from where it looks now at such a distance that balls fill the picture.

        Parameters
        ----------
        balls : sequence of (center (3,), radius)
            See `shrm.viewer.gpu.geometry.bounds`.
        aspect : float
            Width of the picture by its height.
        """
        if not balls:
            return self
        centers = np.array([c for c, _ in balls])
        radii = np.array([r for _, r in balls])
        low, high = (centers - radii[:, None]).min(axis=0), (centers + radii[:, None]).max(axis=0)
        middle = 0.5 * (low + high)
        x, y, z = (float(c) for c in middle)
        tangent = math.tan(math.radians(self.fov) / 2.0)
        right, up, forward = replace(self, target=(x, y, z)).camera.axes
        # A ball at depth z beside the axis by a is inside the edge's plane if a + r / cos <= z tan.
        needs = []
        for axis, reach in ((right, tangent * aspect), (up, tangent)):
            aside = np.abs((centers - middle) @ axis) + MARGIN * radii * math.hypot(1.0, reach)
            needs.append(float((aside / reach - (centers - middle) @ forward).max()))
        return replace(self, target=(x, y, z), distance=float(np.clip(max(needs), NEAREST, FARTHEST)))


def turned_light(rotation: FloatArray, dx: float, dy: float, camera: Camera) -> FloatArray:
    """Return the light's rotation after a drag of (dx, dy) pixels: what is seen behind follows the pointer.

    Parameters
    ----------
    rotation : (3, 3) float64
        L'(w) = L(R^T w).
    dx, dy : float
        To the right and down: about the vertical, and about the picture's horizontal.
    camera : Camera

    Returns
    -------
    (3, 3) float64
        A rotation again, whatever the number of drags.
    """
    # What is behind the objects moves to the right as the light turns clockwise, seen from above.
    about_z = about_vertical(-DEGREES_PER_PIXEL * dx)
    about_right = _about(camera.axes[0], math.radians(-DEGREES_PER_PIXEL * dy))
    return _orthogonal(about_right @ about_z @ rotation)


def spun_light(rotation: FloatArray, seconds: float) -> FloatArray:
    """Return the light's rotation (3, 3) after it has turned about the vertical by itself for some time."""
    return _orthogonal(about_vertical(DEGREES_PER_SECOND * seconds) @ rotation)


def _orthogonal(matrix: FloatArray) -> FloatArray:
    """The rotation next to a matrix that is one but for rounding."""
    u, _, vt = np.linalg.svd(matrix)
    return np.asarray(u @ vt)


def _about(axis: FloatArray, angle: float) -> FloatArray:
    """Rotation by an angle about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross)
