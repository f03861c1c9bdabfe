"""Where an object stands: the similarity from its own coordinates to the world's, and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray


def about_vertical(degrees: float) -> FloatArray:
    """The rotation (3, 3) about +z that carries +x towards +y."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Placement:
    """A rotation, a scale and a movement: x in the object is scale R x + offset in the world.

    Parameters
    ----------
    R : (3, 3) float64
        Rotation world_from_object.
    scale : float
    offset : (3,) float64
    """

    R: FloatArray
    scale: float
    offset: FloatArray

    def world_from_object(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) or (3,) of the object in the world."""
        return np.asarray(self.offset + self.scale * (points @ self.R.T))

    def object_from_world(self, points: FloatArray) -> FloatArray:
        """Points (n, 3) or (3,) of the world in the object's coordinates."""
        return np.asarray((points - self.offset) @ self.R / self.scale)
