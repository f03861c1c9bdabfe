"""Conversions between reflection maps and the explicit sets of maps of earlier methods [RH02 appendix C].

A SHRM gives Cabral's twelve icosahedral maps, Kautz and McCool's three-dimensional texture and an explicit
set for a grid of views; and any explicit set of maps gives a SHRM, whose coefficients are fitted to it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from shrm import _core, sh
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center
from shrm.frequency.part import CoefficientMaps, Part, zonal_harmonics
from shrm.frequency.reflection_map import ReflectionMap, require_no_residual
from shrm.lobes.center import gamma_table
from shrm.lobes.reflection import Reflection
from shrm.prefiltered.icosahedron import icosahedron
from shrm.validation import one_of, real_array, unit_vectors, whole_number


def grid_views(T: int) -> FloatArray:
    """Return T x T views in the lat-long convention of environments.

    Parameters
    ----------
    T : int
        Rows and columns, 1 to 256.

    Returns
    -------
    (T, T, 3) float64
        Unit vectors.

    Raises
    ------
    TypeError, ValueError
        If T is not a whole number in its range.
    """
    whole_number("T", T, 1, 256)
    theta = (np.arange(T) + 0.5) * np.pi / T
    phi = np.pi - 2 * np.pi * (np.arange(T) + 0.5) / T
    sine = np.sin(theta)[:, None]
    return np.stack(
        [sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(np.cos(theta)[:, None], (T, T))], axis=-1
    )


def maps_at_views(reflection: Reflection, views: npt.ArrayLike) -> Float32Array:
    """Return an explicit set: one reflection map for each view [RH02 eq. 12].

    Parameters
    ----------
    reflection : Reflection
        A reflection of a material with one center.
    views : (n, 3) array_like
        Unit vectors towards the eye, world frame.

    Returns
    -------
    (n, H, W, 3) float32, or (n, 6, N, N, 3) for cubes

    Raises
    ------
    TypeError, ValueError
        If views are not unit vectors, or the material has lobes about several centers.
    """
    return np.stack([reflection.at_view(view) for view in unit_vectors("views", views)])


def icosahedral_maps(reflection: Reflection) -> Float32Array:
    """Return Cabral's twelve maps [CON99]: those of `maps_at_views` at the vertices of `icosahedron`."""
    return maps_at_views(reflection, icosahedron())


def reflection_maps(reflection: Reflection, T: int) -> Float32Array:
    """Return an explicit T x T set of maps, for the views of `grid_views`.

    In frequency space, views on a grid let the sum over p be shared by all azimuths: O(P) for each texel of
    each map [RH02 appendix C].

    Parameters
    ----------
    reflection : Reflection
        A reflection of a material with one center.
    T : int
        Rows and columns of the grid of views, 1 to 256.

    Returns
    -------
    (T, T, H, W, 3) float32, or (T, T, 6, N, N, 3) for cubes

    Raises
    ------
    TypeError, ValueError
        If T is out of its range, or the material has lobes about several centers.
    """
    views = grid_views(T).reshape(-1, 3)
    if isinstance(reflection, ReflectionMap) and _has_one_global_part(reflection):
        rings = np.asarray(reflection.parts[0].rings, dtype=np.float32)
        maps = _core.explicit_maps(rings=rings, cube=reflection.layout == "cube", T=T)
        return np.maximum(maps, 0, out=maps) if reflection.clamp else maps
    maps = maps_at_views(reflection, views)
    return maps.reshape(T, T, *maps.shape[1:])


def _has_one_global_part(rm: ReflectionMap) -> bool:
    """Return whether a map is one part in the global form, without a residual."""
    return len(rm.parts) == 1 and not rm.parts[0].zonal and rm.residual is None


def three_dimensional_texture(rm: ReflectionMap, T: int) -> Float32Array:
    """Return Kautz and McCool's texture [KM00]: radiance over (theta_o, alpha, beta), no azimuth.

    B(alpha, beta, theta_o) = sum_p B_p0(alpha, beta) Y_p0(theta_o), with B_p0 of the local form
    [RH02 appendix C].

    Parameters
    ----------
    rm : ReflectionMap
        A map of a material of one lobe.
    T : int
        Layers, at theta_o = (t + 1/2) pi / T, 1 to 4096.

    Returns
    -------
    (T, H, W, 3) float32, or (T, 6, N, N, 3) for cubes

    Raises
    ------
    TypeError, ValueError
        If T is out of its range, the material has several lobes, or the map a residual.
    """
    whole_number("T", T, 1, 4096)
    require_no_residual(rm, "the texture")
    if len(rm.parts) != 1:
        raise ValueError(f"{rm.brdf} has {len(rm.parts)} lobes: the texture holds one")
    part = rm.parts[0]
    zonal = part.maps if part.zonal else _azimuthal_mean(part)
    theta_o = (np.arange(T) + 0.5) * np.pi / T
    return np.tensordot(zonal_harmonics(part.P, np.cos(theta_o)), zonal, axes=(1, 0)).astype(np.float32)


def without_azimuth(rm: ReflectionMap) -> ReflectionMap:
    """Return a map without the azimuth of the view about C: the terms q = 0 of the local form.

    Kautz and McCool's approximation [KM00]: each lobe is a function of theta_i and theta_o alone, radially
    symmetric about C for every view [RH02 footnote 7]. It takes P + 1 maps, for Y_p0(theta_o) [RH02 eq. 6].

    Parameters
    ----------
    rm : ReflectionMap
        A map that `shrm.prefilter` made: maps fitted to pictures have no local form.

    Returns
    -------
    ReflectionMap
        A map on the same grid. Its `error` is not known, and nan.

    Raises
    ------
    ValueError
        If the maps were fitted to pictures, or have a residual.
    """
    if not isinstance(rm, ReflectionMap):
        raise TypeError(f"rm must be a ReflectionMap, got {type(rm).__name__}")
    parts = rm.expanded_parts()
    require_no_residual(rm, "a map without azimuth")
    return replace(rm, parts=tuple(map(_radial, parts)), prediction=float("nan"))


def _radial(part: Part) -> Part:
    """Return a part with the terms q = 0 alone."""
    if part.zonal:
        return part
    radial = replace(part, zonal=True).resized(part.size, part.layout)
    return radial.as_half() if part.rings.dtype == np.float16 else radial


def fit(
    maps: npt.ArrayLike,
    views: npt.ArrayLike,
    P: int,
    center: Center = "reflection",
    name: str = "explicit set",
) -> ReflectionMap:
    """Return the SHRM that fits an explicit set of reflection maps, by least squares over its views.

    Parameters
    ----------
    maps : (n, H, 2 H, 3) array_like
        Lat-long maps over the central direction, H even, one for each view.
    views : (n, 3) array_like
        Unit vectors towards the eye, world frame; at least (P+1)^2 that determine the fit.
    P : int
        Largest order of the view.
    center : {"reflection", "normal", "tangent"}
        The central direction by which the maps are looked up.
    name : str
        The material's name.

    Returns
    -------
    ReflectionMap
        Its `error` is the relative RMS of the fit at the given views.

    Raises
    ------
    TypeError, ValueError
        If shapes do not fit, views are not unit vectors or do not determine the coefficients.
    """
    V = unit_vectors("views", views)
    pixels = lat_long_pictures(maps, len(V))
    one_of("center", center, ("reflection", "normal", "tangent"))
    whole_number("P", P, 0, 24)

    # Least squares for all texels at once, if the views determine the coefficients
    Y = sh.evaluate(np.eye((P + 1) ** 2), V)
    if np.linalg.matrix_rank(Y, rtol=1e-6) < (P + 1) ** 2:
        raise ValueError(f"{len(V)} views do not determine the {(P + 1) ** 2} coefficients of P = {P}")
    flat = pixels.reshape(len(V), -1)
    coefficients = np.linalg.lstsq(Y, flat, rcond=None)[0]
    energy = float((flat**2).sum())
    error = float(np.sqrt(((Y @ coefficients - flat) ** 2).sum() / energy)) if energy > 0 else 0.0

    rings = coefficients.reshape(-1, *pixels.shape[1:]).transpose(1, 0, 3, 2)
    part = CoefficientMaps(
        center=center,
        gamma=gamma_table(center),
        layout="latlong",
        rings=np.ascontiguousarray(rings, dtype=np.float32),
        zonal=False,
    )
    return ReflectionMap((part,), name, "fit", None, False, error)


def lat_long_pictures(maps: npt.ArrayLike, count: int) -> FloatArray:
    """Return pictures as (count, H, 2 H, 3) float64, H even; raise TypeError or ValueError for others."""
    pixels = real_array("maps", maps)
    _, H, W, channels = pixels.shape if pixels.ndim == 4 else (0, 0, 0, 0)
    if len(pixels) != count or channels != 3 or W != 2 * H:
        raise ValueError(f"maps must have the shape ({count}, H, 2 H, 3), got {pixels.shape}")
    if H % 2:
        raise ValueError(f"maps must have an even number of rows, got {H}")
    return pixels


def _azimuthal_mean(part: CoefficientMaps) -> FloatArray:
    """Return B_p0 of the local form, (P+1, ...), for all p.

    B_p0 = sqrt(4 pi / (2p+1)) sum_q B~_pq Y_pq(C), [RH02] eq. 8 inverted at s = 0.
    """
    maps = part.maps.astype(np.float64)
    C = part.directions().reshape(-1, 3)
    Y = sh.evaluate(np.eye(maps.shape[0]), C).T.reshape(maps.shape[:-1])
    means = []
    for p in range(part.P + 1):
        rows = slice(p * p, (p + 1) * (p + 1))
        means.append(np.sqrt(4 * np.pi / (2 * p + 1)) * (maps[rows] * Y[rows, ..., None]).sum(axis=0))
    return np.stack(means)
