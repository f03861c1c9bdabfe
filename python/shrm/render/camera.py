"""The camera: from positions in the picture to rays in the world."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.validation import positive, real_array

Vector = tuple[float, float, float]

Viewer = Literal["near", "distant"]
"""Whether each point has its own view vector, or all have the camera's."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera, or an orthographic one.

    Parameters
    ----------
    position, target : 3 floats
        Where the eye is and what is in the center of the picture; world frame, z up.
    fov : float
        Vertical field of view in degrees, 0 < fov < 180. Unused by an orthographic camera.
    height : float, optional
        Height of the picture in the world's unit; given, the camera is orthographic.

    Raises
    ------
    TypeError, ValueError
        If the camera looks nowhere (position equals target), or fov or height is out of range.
    """

    position: Vector
    target: Vector = (0.0, 0.0, 0.0)
    fov: float = 30.0
    height: float | None = None

    def __post_init__(self) -> None:
        position, target = (real_array(name, getattr(self, name), (3,)) for name in ("position", "target"))
        if not (target - position).any():
            raise ValueError(f"target must be another point than position, got {self.target} for both")
        positive("fov", self.fov, below=180.0)
        if self.height is not None:
            positive("height", self.height)

    @property
    def forward(self) -> FloatArray:
        """Unit vector from the eye to the target, (3,)."""
        offset = np.subtract(self.target, self.position).astype(np.float64)
        return np.asarray(offset / np.linalg.norm(offset))

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right of the picture, to its top, and forward: rows of (3, 3)."""
        forward = self.forward
        overhead = abs(forward[2]) > 1.0 - 1e-9  # looking straight up or down: +x is up in the picture
        right = np.cross(forward, (1.0, 0.0, 0.0) if overhead else (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward), forward])

    def zoomed(self, factor: float) -> Camera:
        """Return the camera from where it is, to which everything is larger by a factor above 0."""
        reach = math.tan(math.radians(self.fov) / 2.0) / factor
        height = None if self.height is None else self.height / factor
        return replace(self, fov=math.degrees(2.0 * math.atan(reach)), height=height)

    def rays(
        self, columns: FloatArray, rows: FloatArray, shape: tuple[int, int]
    ) -> tuple[FloatArray, FloatArray]:
        """Return rays through points of a picture.

        Parameters
        ----------
        columns, rows : (n,) float64
            Points in pixels: column 0, row 0 is the upper left corner, column W, row H the lower right.
        shape : (H, W)
            Rows and columns of the picture; pixels are square.

        Returns
        -------
        origins, directions : (n, 3) float64
            Directions are unit vectors.
        """
        # Places in the picture, in units of half its height, from its middle to the right and up.
        H, W = shape
        right, up, forward = self.axes
        x = ((2.0 * columns - W) / H)[:, None]
        y = ((H - 2.0 * rows) / H)[:, None]

        position = np.asarray(self.position, np.float64)
        if self.height is not None:
            origins = position + 0.5 * self.height * (x * right + y * up)
            return origins, np.broadcast_to(forward, origins.shape)
        reach = np.tan(np.radians(self.fov) / 2.0)
        directions = forward + reach * (x * right + y * up)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        return np.broadcast_to(position, directions.shape), directions

    def project(self, points: npt.ArrayLike, shape: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
        """Return where points in front of the camera appear: the inverse of `rays`.

        Parameters
        ----------
        points : (n, 3) array_like
        shape : (H, W)
            Rows and columns of the picture.

        Returns
        -------
        columns, rows : (n,) float64
            In pixels.
        """
        H, W = shape
        x, y, depth = self.axes @ (np.asarray(points, np.float64) - np.asarray(self.position)).T
        reach = 0.5 * self.height if self.height is not None else depth * np.tan(np.radians(self.fov) / 2.0)
        return 0.5 * (W + H * x / reach), 0.5 * (H - H * y / reach)
