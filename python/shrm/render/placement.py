"""Where an object stands: the similarity from its own coordinates to the world's, and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.validation import positive, real_array, rotation


def about_vertical(degrees: float) -> FloatArray:
    """Return the rotation (3, 3) about +z that carries +x towards +y."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Placement:
    """A rotation, a scale and a movement: x in the object is scale R x + offset in the world.

    Parameters
    ----------
    R : (3, 3) array_like
        Rotation world_from_object.
    scale : float
        Above 0.
    offset : (3,) array_like

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    R: FloatArray
    scale: float
    offset: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "R", rotation("R", self.R))
        positive("scale", self.scale)
        object.__setattr__(self, "offset", real_array("offset", self.offset, (3,)))

    def __repr__(self) -> str:
        """Say the scale and the offset; of the rotation, its angle."""
        angle = np.degrees(np.arccos(np.clip(0.5 * (np.trace(self.R) - 1.0), -1.0, 1.0)))
        x, y, z = self.offset
        offset = f"({x:.3g}, {y:.3g}, {z:.3g})"
        return f"<Placement: turned by {angle:.3g} degrees, scale {self.scale:.3g}, offset {offset}>"

    def world_from_object(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) or (3,) of the object in the world."""
        return np.asarray(self.offset + self.scale * (points @ self.R.T))

    def object_from_world(self, points: FloatArray) -> FloatArray:
        """Return points (n, 3) or (3,) of the world in the object's coordinates."""
        return np.asarray((points - self.offset) @ self.R / self.scale)
