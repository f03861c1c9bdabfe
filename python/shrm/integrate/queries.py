"""Arguments of all integrators: the light's picture, directions of queries, and grids of maps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF, require_brdf
from shrm.brdf.lobe import Center, Lobe
from shrm.environment import Environment, layouts, require_environment
from shrm.lobes.reflection import Layout
from shrm.validation import unit_vectors

DEFAULT_SIZE: dict[Layout, int] = {"latlong": 128, "cube": 64}
"""Rows of a lat-long map, and of a cube's face, by default."""

LARGEST_SIZE = 16384
"""Most rows of a map, or of a cube's face."""

CENTERS: dict[str, tuple[Center, ...]] = {
    "radial": ("reflection", "normal"),
    "zonal": ("reflection", "normal", "tangent"),
    "isotropic": ("lobe", "reflection", "normal"),
}
"""Centers that lobes of each kind may have."""


def map_directions(layout: Layout, size: int) -> FloatArray:
    """Return the directions of texels: (size, 2 size, 3), or (6, size, size, 3) as `strip` has them."""
    if layout == "latlong":
        return layouts.directions("latlong", size, 2 * size)
    return layouts.directions("strip", 6 * size, size).reshape(6, size, size, 3)


def pixels_of(env: Environment) -> Float32Array:
    """Return the picture of an environment, (H, W, 3).

    Raises
    ------
    TypeError
        If it is no Environment.
    """
    require_environment(env)
    return env.pixels


def lobes_of(brdf: BRDF) -> tuple[Lobe, ...]:
    """Return the lobes of a material.

    Raises
    ------
    TypeError
        If it is no material.
    """
    require_brdf(brdf)
    return brdf.lobes


def queries(
    centers: Sequence[Center],
    normals: npt.ArrayLike,
    views: npt.ArrayLike,
    tangents: npt.ArrayLike | None,
    *,
    anisotropic: bool = False,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Check the directions of queries; normals stand in for tangents that no lobe needs.

    Parameters
    ----------
    centers : sequence of {"lobe", "reflection", "normal", "tangent"}
        Centers of the lobes.
    normals : (n, 3) array_like
        Unit vectors.
    views : (n, 3) or (3,) array_like
        Unit vectors to the eye; one for all normals if the viewer is distant.
    tangents : (n, 3) array_like, optional
        Unit vectors.
    anisotropic : bool
        True if a lobe depends on the tangent though it is not about it.

    Returns
    -------
    normals, views, tangents : (n, 3) float64

    Raises
    ------
    TypeError, ValueError
        If they are not unit vectors of these shapes, or tangents are missing.
    """
    n = unit_vectors("normals", normals)
    v = unit_vectors("views", views, len(n))
    if tangents is not None:
        return n, v, unit_vectors("tangents", tangents, len(n))
    if anisotropic or "tangent" in centers:
        raise ValueError(
            "tangents must have the shape (n, 3) for a lobe about the tangent or an anisotropic one, got None"
        )
    return n, v, n
