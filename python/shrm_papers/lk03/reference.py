"""The radiance of an object's vertices summed ray by ray, without tents or harmonics in between [LK03]."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.brdf import BRDF
from shrm.transfer.lighting import Lighting
from shrm.transfer.matrices.accuracy import relative_snr
from shrm.transfer.matrices.product import harmonics, rotated, view_rows
from shrm.transfer.rays.directions import local_directions
from shrm.transfer.tangent_frames import local_coefficients

from shrm_papers.lk03.subject import Subject, n

VERTICES, VIEWS = 96, 32
"""Vertices and views at which methods are judged."""

_LOWEST = 1e-3
"""Smallest cosine of a view; views below are raised to it."""

_BLOCK = 64
"""Vertices whose rays are summed at once: a few tens of megabytes."""

_FINER = 4
"""Factor on the number of rays where nothing hides the light, and none need be cast."""


class Reference:
    """Radiance of some vertices towards distant viewers, for each harmonic of the light.

    Parameters
    ----------
    subject : Subject
        The object.
    material : BRDF
        A material of one channel.
    vertices, views : int
        Numbers of vertices of faces, and of views from all around, that are drawn by a fixed seed. A vertex
        is judged by the views above its horizon.

    Attributes
    ----------
    at : (k,) int
        Indices of the vertices, ascending.
    views : (v, 3) float64
        Unit vectors to the viewers.
    seen : (k, v) bool
        Which viewers are above the horizon of which vertices.
    """

    def __init__(
        self, subject: Subject, material: BRDF, vertices: int = VERTICES, views: int = VIEWS
    ) -> None:
        rng = np.random.default_rng(20030428)
        of_faces = np.unique(subject.mesh.faces)
        self.at = np.sort(rng.choice(of_faces, min(vertices, len(of_faces)), replace=False))
        self.views = rng.normal(size=(views, 3))
        self.views /= np.linalg.norm(self.views, axis=1, keepdims=True)
        self._frames, self._subject = subject.frames[self.at], subject
        local = np.einsum("pca,vc->pva", self._frames, self.views)
        self.seen = local[:, :, 2] > _LOWEST
        self._rays = view_rows(material, local[self.seen], n, subject.rays)  # (pairs, D)
        self._Y = harmonics(subject.rays, n).astype(np.float32)

    def rows(self, shadowed: bool) -> Float32Array:
        """Return the radiance of each pair of a vertex and a view above it, (pairs, n^2)."""
        vertex, _ = np.nonzero(self.seen)
        rays = self._rays
        if shadowed:
            rays = rays * self._subject.visible(self.at)[vertex]
        return rotated((rays @ self._Y)[:, None], self._frames[vertex])[:, 0]

    def snr(self, lighting: Lighting, shadowed: bool) -> float:
        """Return the relative SNR of a method in dB, for white light and all pairs of vertices and views.

        Parameters
        ----------
        lighting : Lighting
            The method for these vertices alone, with one channel.
        shadowed : bool
        """
        radiance = np.empty((*self.seen.shape, n * n), np.float32)
        for v, view in enumerate(self.views):
            # Three harmonics at once, one in each color
            for first in range(0, n * n, 3):
                count = min(3, n * n - first)
                light = np.zeros((n * n, 3))
                light[first + np.arange(count), np.arange(count)] = 1.0
                radiance[:, v, first : first + count] = lighting.radiance(light, view=view)[:, :count]
        return relative_snr(self.rows(shadowed), radiance[self.seen])


def radiance(
    subject: Subject,
    material: BRDF,
    light: npt.ArrayLike,
    eye: npt.ArrayLike,
    shadowed: bool,
    at: IntArray,
) -> Float32Array:
    """Return the radiance of some vertices towards an eye, summed over rays; the others stay black.

    Parameters
    ----------
    subject : Subject
        The object.
    material : BRDF
        A material of one channel.
    light : (n^2, 3) array_like
        Coefficients of the light.
    eye : (3,) array_like
        Position of the eye.
    shadowed : bool
        True if the object shadows itself.
    at : (k,) int
        Indices of the vertices, ascending.

    Returns
    -------
    (V, 3) float32
    """
    rays = subject.rays if shadowed else local_directions(_FINER * subject.directions)
    Y = harmonics(rays, n)
    views = local_views(subject, eye)
    result = np.zeros((subject.size, 3), np.float32)
    for start in range(0, len(at), _BLOCK):
        block = at[start : start + _BLOCK]
        wi, wo = np.tile(rays, (len(block), 1)), np.repeat(views[block], len(rays), axis=0)
        reflected = material.transfer(wi, wo).reshape(len(block), len(rays))
        if shadowed:
            reflected = np.where(subject.visible(block), reflected, 0.0)
        local = local_coefficients(light, subject.frames[block])
        result[block] = 2 * np.pi / len(rays) * np.einsum("kj,kjc->kc", reflected @ Y, local)
    return result


def local_views(subject: Subject, eye: npt.ArrayLike) -> FloatArray:
    """Return the views of an eye in the frames of all vertices, (V, 3); those below are raised."""
    views = np.einsum("pca,pc->pa", subject.frames, np.asarray(eye) - subject.mesh.vertices)
    across = np.linalg.norm(views[:, :2], axis=1)
    views[:, 2] = np.maximum(views[:, 2], _LOWEST * across)
    return np.asarray(views / np.linalg.norm(views, axis=1, keepdims=True))
