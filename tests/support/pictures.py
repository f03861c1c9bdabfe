"""A material that shows where it is seen from, and a mesh whose surface is known."""

import numpy as np
import numpy.typing as npt
from shrm.render import Mesh

Float32 = npt.NDArray[np.float32]


class Normals:
    """A material that shows the normal."""

    def radiance(self, normals: Float32, views: Float32, tangents: Float32 | None = None) -> Float32:
        return normals


def icosphere(subdivisions: int, axes: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    """A sphere of radius 1, or an ellipsoid of these half axes."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions)
    return Mesh(np.array(mesh.vertices) * axes, np.array(mesh.faces, np.int64))
