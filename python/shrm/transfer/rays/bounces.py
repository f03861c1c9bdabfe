"""Diffuse interreflection: the light that a mesh's vertices send each other, as transfer of the light around.

Everything is linear in the coefficients of the light in global coordinates, and kept as rows of n^2 numbers:
irradiance E_p, and the radiance that leaves a vertex, which is the same in every direction.

    E_p^0 = 2 pi / D sum_k cos theta_k V_pk Y(R_p d_k)             light that arrives without a detour
    L_p   = albedo_p / pi E_p                                      radiance that leaves
    E_p   = E_p^0 + 2 pi / D sum_k cos theta_k (1 - V_pk) L(where the ray ends)

V_pk is 1 where the ray of vertex p in the local direction d_k meets nothing; L on a face is interpolated
between its corners, and 0 on its back. Each bounce puts the last L into the right-hand side once more; with
albedos below 1 this converges as their powers do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.arrays import Float32Array, FloatArray, Int32Array, RealArray
from shrm.transfer.rays.visibility import Block, Visibility
from shrm.transfer.tangent_frames import band_rotations
from shrm.validation import real_array

Progress = Callable[[int, int], None]
"""Called with the bounces that are finished and their number."""

MOST_BOUNCES = 1000
"""The most bounces that can be asked for: an albedo of .99 has then left 4e-5 of the light."""

_NO_HITS = "visibility must have hits, got one without: give hits=True where it is computed"

_ROWS = 32
"""Vertices whose rays are added up together: what they see of the mesh stays small."""


def irradiance(visibility: Visibility, n: int) -> FloatArray:
    """Return the transfer from light to irradiance without interreflection: E^0.

    Parameters
    ----------
    visibility : Visibility
        Computed.
    n : int
        Order of the light, degrees 0 to n - 1, 1 to 10.

    Returns
    -------
    (V, n^2) float64
        Rows over the light's coefficients in global coordinates.

    Raises
    ------
    ValueError
        If the visibility is not computed, or damaged.
    """
    d = visibility.directions
    weighted = sh.evaluate(np.eye(n * n), d) * _cosines(d)[:, None]  # (D, n^2)
    E = np.empty((len(visibility.vertices), n * n))
    for block in visibility:
        local = block.visible.astype(np.float64) @ weighted
        # Y_l(R d) = Y_l(d) D_l, so rows over local coefficients become rows over global ones
        for l, turn in enumerate(band_rotations(visibility.frames[block.vertices], n)):
            band = slice(l * l, (l + 1) ** 2)
            E[block.vertices, band] = np.einsum("bi,bij->bj", local[:, band], turn)
    return E


def leaving(
    visibility: Visibility,
    n: int,
    albedo: npt.ArrayLike,
    bounces: int,
    progress: Progress | None = None,
) -> Float32Array:
    """Return the transfer from light to the radiance that leaves every vertex towards the others.

    What arrives from there at a vertex has been reflected 1 to `bounces` times; see `incident`.

    Parameters
    ----------
    visibility : Visibility
        Computed, with hits.
    n : int
        Order of the light, degrees 0 to n - 1, 1 to 10.
    albedo : float, (3,), (V,) or (V, 3) array_like
        Albedo of the whole mesh, for each channel, for each vertex or both, in [0, 1]. Three numbers are
        channels even if there are three vertices.
    bounces : int
        1 to 1000.
    progress : callable, optional
        Called with the bounces done and their number.

    Returns
    -------
    (V, C, n^2) float32
        Rows over the light's coefficients in global coordinates; C = 3 if albedos differ between channels,
        else 1.

    Raises
    ------
    TypeError, ValueError
        If the albedo is not as described, or the visibility has no hits, or is not computed or damaged.
    """
    if not visibility.hits:
        raise ValueError(_NO_HITS)
    reflected = albedos(albedo, len(visibility.vertices))[:, :, None] / np.pi
    E = irradiance(visibility, n)[:, None, :]  # the same for every channel
    L: FloatArray = reflected * E
    for done in range(1, bounces):
        if progress is not None:
            progress(done, bounces)
        L = reflected * (E + gathered(visibility, L))
    if progress is not None:
        progress(bounces, bounces)
    return L.astype(np.float32)


def gathered(visibility: Visibility, leaving: RealArray) -> FloatArray:
    """Return the irradiance that vertices have of the radiance that leaves them all.

    Parameters
    ----------
    visibility : Visibility
        Computed, with hits.
    leaving : (V, C, n^2)

    Returns
    -------
    (V, C, n^2) float64

    Raises
    ------
    ValueError
        If the visibility has no hits, or is not computed or damaged.
    """
    L = np.asarray(leaving, np.float64).reshape(len(leaving), -1)
    E = np.zeros_like(L)
    cosines = _cosines(visibility.directions)
    place = np.zeros(len(L), np.intp)
    for block_on_disk in visibility:
        for block in block_on_disk.parts(_ROWS):
            row, direction, vertex, weight = seen_vertices(block, visibility.faces)

            # The weights as a matrix over the vertices that these rays end at; neighbors see much the same
            met = np.zeros(len(L), np.bool_)
            met[vertex] = True
            distinct = np.flatnonzero(met)
            place[distinct] = np.arange(len(distinct))
            entries = row[:, None] * len(distinct) + place[vertex]
            values = weight * cosines[direction, None]
            shape = (len(block.visible), len(distinct))
            matrix = np.bincount(entries.ravel(), values.ravel(), shape[0] * shape[1]).reshape(shape)
            E[block.vertices] = matrix @ L[distinct]
    return E.reshape(leaving.shape)


def seen_vertices(
    block: Block, faces: Int32Array
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Int32Array, Float32Array]:
    """Return what the rays of a block see of the mesh, as rows of a sparse matrix over the vertices.

    Parameters
    ----------
    block : Block
        Vertices and their rays, with hits.
    faces : (T, 3) int32

    Returns
    -------
    row : (H,) int
        The row in the block of each ray that meets the front of a face, in the order of rows and directions.
    direction : (H,) int
        The ray's direction.
    vertex : (H, 3) int32
        The corners of the face.
    weight : (H, 3) float32
        The corners' weights where the ray ends; they sum to 1.

    Raises
    ------
    ValueError
        If the block has no hits.
    """
    if block.hits is None:
        raise ValueError(_NO_HITS)
    row, direction = np.nonzero(~block.visible)
    front = block.hits.face >= 0
    u, v = block.hits.u[front], block.hits.v[front]
    return row[front], direction[front], faces[block.hits.face[front]], np.stack([1 - u - v, u, v], axis=1)


def incident(block: Block, faces: Int32Array, leaving: Float32Array) -> Float32Array:
    """Return the radiance that the mesh itself sends to the vertices of a block.

    Take few vertices at a time (`Block.parts`): one has D C n^2 numbers.

    Parameters
    ----------
    block : Block
        Vertices and their rays, with hits.
    faces : (T, 3) int32
    leaving : (V, C, n^2) float32

    Returns
    -------
    (B, D, C, n^2) float32
        Rows over the light's coefficients in global coordinates; 0 where no front of a face is met.

    Raises
    ------
    ValueError
        If the block has no hits.
    """
    shape = (*block.visible.shape, *leaving.shape[1:])
    incoming = np.zeros(shape, np.float32)
    row, direction, vertex, weight = seen_vertices(block, faces)
    L = leaving.reshape(len(leaving), -1)
    radiance = weight[:, :1] * L[vertex[:, 0]]
    for k in (1, 2):
        radiance += weight[:, k : k + 1] * L[vertex[:, k]]
    incoming[row, direction] = radiance.reshape(-1, *shape[2:])
    return incoming


def _cosines(directions: FloatArray) -> FloatArray:
    """Return the weights 2 pi / D cos theta of the directions (D,), which sum to pi."""
    return np.asarray(2 * np.pi / len(directions) * directions[:, 2])


def albedos(albedo: npt.ArrayLike, count: int) -> FloatArray:
    """Return albedos (V or 1, C), see `leaving`; refuse what they cannot be."""
    array = real_array("albedo", albedo, (), (3,), (count,), (count, 3))
    if array.shape == (3,):
        array = array[None]
    elif array.ndim < 2:
        array = array.reshape(-1, 1)
    if not (array.min() >= 0 and array.max() <= 1):
        raise ValueError(f"albedo must be in [0, 1], got {array.min():g} to {array.max():g}")
    return array[:, :1] if (array == array[:, :1]).all() else array
