"""The object of the results of [LK03]: its mesh, the visibility of its vertices, and its transfer.

Rays are cast once and kept in a temporary folder, for all materials and all ways from rays to tents.
"""

from __future__ import annotations

import shutil
import warnings
import weakref
from functools import cached_property, lru_cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import numpy.typing as npt
from shrm.arrays import BoolArray, Float32Array
from shrm.brdf import BRDF, Lambert
from shrm.render import Mesh
from shrm.transfer.matrices.product import Route, accumulate, harmonics, product, rotated
from shrm.transfer.precompute import precompute
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.rays.directions import local_directions
from shrm.transfer.rays.visibility import Visibility
from shrm.transfer.tangent_frames import vertex_frames

from shrm_papers.grid_meshes import knot
from shrm_papers.result import Settings

n = 5
"""Order of the light: 25 coefficients [LK03 section 7]."""

DIRECTIONS, QUICK = 4096, 512
"""Rays over the sphere, of which half are cast from each vertex; fewer in quick runs."""

KNOT = "a knot"
"""The name of the object without a mesh."""


class Subject:
    """An object that shadows itself.

    Parameters
    ----------
    mesh : Mesh
        The mesh in the coordinates of the light, z up.
    name : str
        Its name in titles.
    directions : int
        Rays over the sphere.

    Attributes
    ----------
    frames : (V, 3, 3) float64
        Rotations global_from_local; tangents run around the vertical.
    rays : (D, 3) float64
        Local directions of the rays.
    """

    def __init__(self, mesh: Mesh, name: str, directions: int) -> None:
        self.mesh, self.name, self.directions = mesh, name, directions
        self._folder = Path(mkdtemp(prefix="shrm-reproduce-"))
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        self._tangents = np.cross([0.0, 0.0, 1.0], mesh.vertex_normals)
        self.frames = vertex_frames(mesh.vertex_normals, self._tangents)
        self.rays = local_directions(directions)

    @property
    def size(self) -> int:
        """V, the number of vertices."""
        return len(self.mesh.vertices)

    @cached_property
    def visibility(self) -> Visibility:
        """The rays of the vertices that meet nothing."""
        # The folder in which `precompute` looks for them, so that no ray is cast twice
        folder = self._folder / "rays"
        visibility = Visibility(
            folder, self.mesh.vertices, self.mesh.faces.astype(np.int32), self.frames, self.rays
        )
        visibility.compute()
        return visibility

    def visible(self, at: npt.NDArray[np.integer[Any]]) -> BoolArray:
        """Return which rays of some vertices, given in ascending order, meet nothing: (k, D)."""
        size = self.visibility.block
        parts = [
            self.visibility[block].visible[at[at // size == block] - block * size]
            for block in np.unique(at // size)
        ]
        return np.concatenate(parts)

    @cached_property
    def transfer(self) -> Float32Array:
        """T_p of all vertices, (V, n^2, n^2): light to transferred light, in global coordinates."""
        # Transferred light depends neither on the material nor on the tents.
        inner = product(Lambert(1.0), 2, n, self.rays, Route(inner=n)).inner
        assert inner is not None
        Y = harmonics(self.rays, n).astype(np.float32)
        T = np.empty((self.size, n * n, n * n), np.float32)
        for block in self.visibility:
            frames = self.frames[block.vertices]
            local = rotated(accumulate(inner, block.visible, Y), frames)  # R_p T_p
            T[block.vertices] = np.swapaxes(rotated(np.swapaxes(local, 1, 2), frames), 1, 2)
        return T

    def precomputed(self, material: BRDF, **options: Any) -> RadianceTransfer:
        """Return the transfer of the object, unshadowed and shadowed; see `shrm.transfer.precompute`.

        Uncompressed matrices stay on disk until the next call.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # an accuracy that is not reached is in the results
            return precompute(
                self.mesh,
                material,
                tangents=self._tangents,
                order=n,
                directions=self.directions,
                work=self._folder,
                **options,
            )


def subject_of(settings: Settings) -> Subject:
    """Return the object of a run: the mesh of the settings, or a knot."""
    return _read(settings.mesh, settings.quick)


@lru_cache(maxsize=1)
def _read(path: Path | None, quick: bool) -> Subject:
    if path is None:
        mesh, name = knot(64, 12) if quick else knot(), KNOT
    else:
        mesh, name = Mesh.read(path), path.stem
    return Subject(mesh.placed(radius=1.0), name, QUICK if quick else DIRECTIONS)


def note(subject: Subject) -> str:
    """Return the note on the object of a result."""
    size = f"The object: {subject.name}, {subject.size} vertices, {len(subject.rays)} rays from each."
    return size if subject.name != KNOT else f"{size} [LK03] show a bird and a head: give a mesh with --mesh."
