"""What the vertices of an object send out, summed ray by ray: neither tents nor harmonics in between.

References
----------
[LK03]  J. Lehtinen, J. Kautz. Matrix Radiance Transfer. I3D 2003.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from shrm.brdf import BRDF
from shrm.reproduce.transfer_subject import Subject, n
from shrm.tangent_frames import local_coefficients
from shrm.transfer.accuracy import relative_snr
from shrm.transfer.directions import local_directions
from shrm.transfer.lighting import Lighting
from shrm.transfer.product import harmonics, rotated, view_rows

Float32Array = npt.NDArray[np.float32]
FloatArray = npt.NDArray[np.float64]

VERTICES, VIEWS = 96, 32
"""Where methods are judged."""

_LOWEST = 1e-3
"""Cosine of views that are taken for those at and below the horizon."""

_TOGETHER = 64
"""Vertices whose rays are summed at once."""

_FINER = 4
"""How many times as many rays are summed where nothing hides the light, and none need be cast."""


class Reference:
    """Radiance of some vertices towards distant viewers, for each harmonic of the light.

    Parameters
    ----------
    subject : Subject
    material : BRDF
        Of one channel.
    vertices, views : int
        How many are drawn, seeded: vertices of faces, and views from all around; those from above the
        vertex count.

    Attributes
    ----------
    at : (k,) int
        The vertices, in ascending order.
    """

    def __init__(
        self, subject: Subject, material: BRDF, vertices: int = VERTICES, views: int = VIEWS
    ) -> None:
        rng = np.random.default_rng(20030428)
        of_faces = np.unique(subject.mesh.faces)
        self.at = np.sort(rng.choice(of_faces, min(vertices, len(of_faces)), replace=False))
        self._views = rng.normal(size=(views, 3))
        self._views /= np.linalg.norm(self._views, axis=1, keepdims=True)
        self._frames, self._subject = subject.frames[self.at], subject
        local = np.einsum("pca,vc->pva", self._frames, self._views)
        self._seen = local[:, :, 2] > _LOWEST  # (vertices, views)
        self._rays = view_rows(material, local[self._seen], n, subject.rays)  # (pairs, D)
        self._Y = harmonics(subject.rays, n).astype(np.float32)

    def rows(self, shadowed: bool) -> Float32Array:
        """Return radiance of each pair of a vertex and a view that it sees, (pairs, n^2)."""
        vertex, _ = np.nonzero(self._seen)
        rays = self._rays
        if shadowed:
            rays = rays * self._subject.visible(self.at)[vertex]
        return rotated((rays @ self._Y)[:, None], self._frames[vertex])[:, 0]

    def snr(self, lighting: Lighting, shadowed: bool) -> float:
        """Return the relative SNR of a method, in dB: the mean over white light, vertices and views.

        Parameters
        ----------
        lighting : Lighting
            Of these vertices alone, with one channel.
        shadowed : bool
        """
        found = np.empty((*self._seen.shape, n * n), np.float32)
        for v, view in enumerate(self._views):
            for first in range(0, n * n, 3):  # one harmonic for each of the three colours
                count = min(3, n * n - first)
                light = np.zeros((n * n, 3))
                light[first + np.arange(count), np.arange(count)] = 1.0
                found[:, v, first : first + count] = lighting.radiance(light, view=view)[:, :count]
        return relative_snr(self.rows(shadowed), found[self._seen])


def radiance(
    subject: Subject, material: BRDF, light: npt.ArrayLike, eye: npt.ArrayLike, shadowed: bool
) -> Float32Array:
    """Return the radiance (V, 3) of all vertices towards an eye, under light (n^2, 3).

    Sums over rays; vertices that look away from the eye are left black.
    """
    rays = subject.rays if shadowed else local_directions(_FINER * subject.directions)
    Y = harmonics(rays, n)
    towards = np.asarray(eye) - subject.mesh.vertices
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    views = np.einsum("pca,pc->pa", subject.frames, towards)
    # Of a face that is seen some corner may look away
    looking = np.flatnonzero(views[:, 2] > -0.3)
    views[:, 2] = np.maximum(views[:, 2], _LOWEST)
    views /= np.linalg.norm(views, axis=1, keepdims=True)
    result = np.zeros((subject.size, 3), np.float32)
    for start in range(0, len(looking), _TOGETHER):
        at = looking[start : start + _TOGETHER]
        wi, wo = np.tile(rays, (len(at), 1)), np.repeat(views[at], len(rays), axis=0)
        reflected = material.transfer(wi, wo).reshape(len(at), len(rays))
        if shadowed:
            reflected = np.where(subject.visible(at), reflected, 0.0)
        gathered = reflected @ Y  # (k, n^2)
        local = local_coefficients(light, subject.frames[at])
        result[at] = 2 * np.pi / len(rays) * np.einsum("kj,kjc->kc", gathered, local)
    return result
