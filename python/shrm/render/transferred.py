"""Objects with transfer in the world: lit through `shrm.transfer`, drawn as meshes with radiance at vertices.

Transfer is precomputed in the object's own coordinates. Where the object stands turned, its light is turned
back, in frequency space, and the eye is carried into its coordinates [LK03 section 4].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.arrays import FloatArray
from shrm.files import PathLike
from shrm.frequency.expansion import degree_window
from shrm.frequency.request import Window
from shrm.render.camera import Camera, Vector, Viewer
from shrm.render.mesh import Mesh
from shrm.render.placement import Placement
from shrm.render.vertex_radiance import VertexRadiance
from shrm.transfer.file import MAGIC
from shrm.transfer.lighting import Lighting
from shrm.transfer.radiance_transfer import RadianceTransfer

SUFFIX = ".shrt"


@dataclass(frozen=True, eq=False)
class TransferredMesh:
    """An object with transfer that stands in the world.

    Parameters
    ----------
    transfer : RadianceTransfer
    placement : Placement
        From the transfer's coordinates to the world's.
    """

    transfer: RadianceTransfer
    placement: Placement

    def __repr__(self) -> str:
        """Say the material, how many vertices there are, and where they stand."""
        transfer = self.transfer
        return f"<TransferredMesh {transfer.material}: {len(transfer.vertices)} vertices, {self.placement!r}>"

    @classmethod
    def placed(
        cls,
        transfer: RadianceTransfer,
        center: Vector = (0.0, 0.0, 0.0),
        radius: float = 1.0,
        turn: float = 0.0,
    ) -> TransferredMesh:
        """Stand the object in a cube, as `Mesh.placed` does."""
        return cls(transfer, _mesh(transfer).placement(center, radius, turn))

    @cached_property
    def mesh(self) -> Mesh:
        """The mesh in the world."""
        return _mesh(self.transfer).moved(self.placement)

    def light(
        self, coefficients: npt.ArrayLike, rotation: npt.ArrayLike, window: Window | None = None
    ) -> FloatArray:
        """Turn light, then into the object's coordinates.

        Parameters
        ----------
        coefficients : (k, 3) array_like
            Of the environment, k >= n^2 in the real basis of `shrm.sh`; those of higher degrees are left out.
        rotation : (3, 3) array_like
            L'(w) = L(R^T w).
        window : {"hann", "lanczos"}, optional
            See `low_degrees`.

        Returns
        -------
        (n^2, 3) float64
        """
        low = low_degrees(coefficients, self.transfer.n, window)
        return sh.rotate(low, self.placement.R.T @ np.asarray(rotation, np.float64))

    def lit(
        self,
        lighting: Lighting,
        light: npt.ArrayLike,
        camera: Camera,
        viewer: Viewer = "near",
    ) -> VertexRadiance:
        """Light the vertices.

        Parameters
        ----------
        lighting : shrm.transfer.lighting.Lighting
            `RadianceTransfer.lighting` of the transfer.
        light : (n^2, 3) array_like
            See `light`.
        camera : Camera
        viewer : {"near", "distant"}
            Whether each vertex has its own view vector or all have the camera's; an orthographic camera is
            distant in either case.

        Returns
        -------
        VertexRadiance
        """
        if viewer == "distant" or camera.height is not None:
            return VertexRadiance(lighting.radiance(light, view=-camera.forward @ self.placement.R))
        eye = self.placement.object_from_world(np.asarray(camera.position, np.float64))
        return VertexRadiance(lighting.radiance(light, eye=eye))


def low_degrees(coefficients: npt.ArrayLike, n: int, window: Window | None = None) -> FloatArray:
    """Return the coefficients (n^2, 3) of degrees 0 to n - 1, of (k, 3) with k >= n^2.

    A window weighs the degrees, so that beside a sun light does not ring: it is less than nothing there
    without one.
    """
    weights = np.repeat(degree_window(window, n - 1), 2 * np.arange(n) + 1)
    return weights[:, None] * np.asarray(coefficients, np.float64)[: n * n]


def is_transfer(path: PathLike) -> bool:
    """Return whether a file is an object with transfer: by its first bytes, or by a name that says so."""
    if Path(path).suffix.lower() == SUFFIX:
        return True  # what is wrong with it, opening it says
    try:
        with open(path, "rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def _mesh(transfer: RadianceTransfer) -> Mesh:
    """Return the mesh in the transfer's coordinates, with the tangents that its frames have."""
    frames, faces = np.asarray(transfer.frames, np.float64), np.asarray(transfer.faces, np.int64)
    tangents = frames[:, :, 0][faces]
    against = np.einsum("fkx,fx->fk", tangents, tangents[:, 0]) < 0.0  # the signs agree within a face
    return Mesh(
        np.asarray(transfer.vertices, np.float64),
        faces,
        frames[:, :, 2],
        None if transfer.uv is None else np.asarray(transfer.uv, np.float64),
        np.where(against[:, :, None], -tangents, tangents),
    )
