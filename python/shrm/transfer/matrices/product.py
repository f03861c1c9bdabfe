"""From light to outgoing radiance: the matrices A_p of vertices, tents from harmonics [LK03 section 4.4].

All vertices share one set of directions d_k in their local frames, so that what a material makes of light
along them is one matrix. With V_p the visibility and Y the harmonics of the light at d_k, and R_p the
rotation of harmonics into the frame of the vertex,

    A_p = Q (V_p o Y) R_p        Q_tk = 2 pi / D sum_s (G^-1)_ts int g_s(v) rho_hat(d_k, v) dv

where rho_hat is the BRDF times the cosine [LK03 eq. 1]. [LK03 eq. 9] puts harmonics between: with T'_p, its
transfer matrix turned into the vertex's frame, A_p = P T'_p R_p, P = G^-1 C B and T'_p = int Y V_p Y^T. This
is a Q of rank s^2, P (2 pi / D) Y_s^T, where the inner order s is that of the light in the paper. There the
truncation of transferred radiance to order n is the largest error by far for glossy materials with shadows; a
higher inner order costs nothing at run time, and the product without any is more accurate still. The price is
compression: PCA of products with a small P is exact and small.

Without shadows A_p is P R_p with an exact P, [LK03]'s T of the identity. Every Q is corrected, by the least
change, so that it makes the same of light that nothing hides: Q Y = P; by way of harmonics P T, with T that
of the whole hemisphere. Errors of the quadrature over d_k are then those of shadows alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np

from shrm import _core, sh
from shrm.arrays import BoolArray, Float32Array, FloatArray, RealArray
from shrm.brdf import BRDF
from shrm.transfer.brdf_matrix import Extension, project, project_on_tents, rows
from shrm.transfer.described import Described
from shrm.transfer.directional_basis import MOST_ORDER, DirectionalBasis, hemispherical_gram
from shrm.transfer.tangent_frames import band_rotations
from shrm.validation import one_of, whole_number

VIEW_POINTS = 3
"""Points of the quadrature over views, along a side of each triangle: 70 dB and more for lobes of .1 radians,
where 2 have 40."""

_PAIRS = 1 << 20
"""Pairs of directions and views at which a material is evaluated together: 8 MB for each channel."""


@dataclass(frozen=True)
class Route:
    """Route of expansions by which light becomes outgoing radiance.

    Attributes
    ----------
    inner : int or None
        Order s of transferred radiance, 1 to 32; None: none, directions go straight into the tents.
    m : int or None
        Order of outgoing radiance between the material and the tents, 1 to 32; None: none, as there is
        without an inner order.
    extension, window_above
        Expansion of outgoing radiance of order m, see `shrm.transfer.brdf_matrix.project`.

    Raises
    ------
    TypeError, ValueError
        If one is not as described.
    """

    inner: int | None = None
    m: int | None = None
    extension: Extension = "least-squares"
    window_above: int | None = None

    def __post_init__(self) -> None:
        if self.inner is not None:
            whole_number("inner", self.inner, 1, MOST_ORDER)
        one_of("extension", self.extension, get_args(Extension))
        for name, of in (("m", "inner"), ("window_above", "m")):
            if getattr(self, name) is not None and getattr(self, of) is None:
                raise ValueError(f"{name} must be None without {of}, got {getattr(self, name)!r}")
        if self.m is not None:
            m = whole_number("m", self.m, 1, MOST_ORDER)
            if self.window_above is not None:
                whole_number("window_above", self.window_above, 0, m - 1)

    def __str__(self) -> str:
        if self.inner is None:
            return "direct"
        return f"order {self.inner}" + ("" if self.m is None else f", views of order {self.m}")


def published(n: int) -> Route:
    """Return the route of [LK03 section 7]: inner order n, m = 8, a window above degree 5.

    The even extension and the shape of the window are ours: the paper does not say which it has.
    """
    return Route(inner=n, m=8, extension="even", window_above=5)


@dataclass(frozen=True, eq=False, repr=False)
class Product(Described):
    """Product of a material with light along local directions, in tents; made by `product`.

    Attributes
    ----------
    basis : DirectionalBasis
        The tents; rows below are those of (tent, channel), tent by tent.
    channels : int
        C, 1 or 3.
    route : Route
    rays : (M^2 C, D) float32
        Q, from radiance along the rays.
    unshadowed : (M^2 C, n^2) float64
        B, from local light of order n that nothing hides.
    outer : (M^2 C, s^2) float32 or None
        P, by way of harmonics.
    inner : (s^2, D) float32 or None
        The harmonics' share, Q = P times it.
    """

    basis: DirectionalBasis
    channels: int
    route: Route
    rays: Float32Array
    unshadowed: FloatArray
    outer: Float32Array | None = None
    inner: Float32Array | None = None


def product(
    brdf: BRDF, M: int, n: int, directions: FloatArray, route: Route, points: int = VIEW_POINTS
) -> Product:
    """Return the product of a material: Q, and what it consists of.

    Parameters
    ----------
    brdf : BRDF
        The material.
    M, n : int
        Tents along a side; order of the light.
    directions : (D, 3) float64
        Unit vectors of equal solid angles over the hemisphere about +z.
    route : Route
    points : int
        Points of the quadrature over views, along a side of each triangle.

    Returns
    -------
    Product
    """
    basis, Y = DirectionalBasis(M), harmonics(directions, n)
    weight = 2 * np.pi / len(directions)

    # Straight from the directions
    if route.inner is None:
        views, view_weights = basis.quadrature(points)
        B = _tents_by_channels(project_on_tents(brdf, basis, n, points))
        Q = weight * _projected(brdf, basis, views, view_weights, directions)
        return Product(basis, brdf.channels, route, _float32(_corrected(Q, B, Y)), B)

    # By way of harmonics of order s
    s = route.inner
    widest = _outer(brdf, basis, max(s, n), route, points)
    P, B = widest[:, : s * s], widest[:, : n * n]
    T = hemispherical_gram(max(s, n))[: s * s, : n * n]  # of light that nothing hides but the surface
    inner = _corrected(weight * harmonics(directions, s).T, T, Y)
    return Product(
        basis, brdf.channels, route, _float32(P @ inner), B, outer=_float32(P), inner=_float32(inner)
    )


def view_rows(brdf: BRDF, views: FloatArray, n: int, directions: FloatArray) -> Float32Array:
    """Return what reaches given views of radiance along each direction, (views C, D): no tents, no harmonics.

    Corrected as Q is: what nothing hides is exact.
    """
    exact = np.atleast_3d(np.moveaxis(np.reshape(rows(brdf, views, n), (-1, len(views), n * n)), 0, 1))
    sampled = np.moveaxis(_sampled(brdf, views, directions), 0, 1)  # (views, C, D)
    Q = 2 * np.pi / len(directions) * sampled.reshape(-1, len(directions))
    return _float32(_corrected(Q, exact.reshape(len(Q), -1), harmonics(directions, n)))


def harmonics(directions: FloatArray, n: int) -> FloatArray:
    """Return Y, (D, n^2) float64, of order n at directions (D, 3)."""
    return sh.evaluate(np.eye(n * n), directions)


def accumulate(
    rays: Float32Array, visible: BoolArray, Y: Float32Array, frames: FloatArray | None = None
) -> Float32Array:
    """Return Q (V_p o Y) R_p, (vertices, rows, n^2): of light in global coordinates, or local without frames.

    Parameters
    ----------
    rays : (rows, D) float32
        Q.
    visible : (vertices, D) bool
        V_p.
    Y : (D, n^2) float32
    frames : (vertices, 3, 3) float64, optional
    """
    rotations = None
    if frames is not None:
        bands = band_rotations(frames, round(np.sqrt(Y.shape[1])))
        rotations = np.concatenate([D.reshape(len(frames), -1) for D in bands], axis=1, dtype=np.float32)
    return _core.sum_over_visible(rays=rays, harmonics=Y, visible=visible, rotations=rotations)


def rotated(local: RealArray, frames: FloatArray) -> Float32Array:
    """Return A R_p, (vertices, rows, n^2) float32: of light in global coordinates [LK03 eq. 5].

    Parameters
    ----------
    local : (vertices, rows, n^2) or (rows, n^2)
        Matrices of light in local coordinates.
    frames : (vertices, 3, 3) float64
    """
    n = round(np.sqrt(local.shape[-1]))
    result = np.empty((len(frames), *local.shape[-2:]), np.float32)
    for l, D in enumerate(band_rotations(frames, n)):
        band = slice(l * l, (l + 1) ** 2)
        result[:, :, band] = local[..., band] @ D.astype(np.float32)
    return result


# ---- Materials at directions


def _outer(brdf: BRDF, basis: DirectionalBasis, s: int, route: Route, points: int) -> FloatArray:
    """Return P (M^2 C, s^2): tents of outgoing radiance from local light of order s."""
    if route.m is None:
        return _tents_by_channels(project_on_tents(brdf, basis, s, points))
    B = project(brdf, route.m, s, extension=route.extension, window_above=route.window_above).coefficients
    channels = B[None] if B.ndim == 2 else B
    tents = [basis.project_coefficients(channel) for channel in channels]  # [LK03] eq. 8
    return _tents_by_channels(np.stack(tents))


def _tents_by_channels(tents: FloatArray) -> FloatArray:
    """Return tents (M^2, columns) or (C, M^2, columns) as (M^2 C, columns)."""
    channels = tents[None] if tents.ndim == 2 else tents
    return np.moveaxis(channels, 0, 1).reshape(-1, channels.shape[2])


def _projected(
    brdf: BRDF, basis: DirectionalBasis, views: FloatArray, weights: FloatArray, directions: FloatArray
) -> FloatArray:
    """Return G^-1 int g(v) rho_hat(d_k, v) dv, (M^2 C, D)."""
    sums = np.zeros((brdf.channels, basis.size, len(directions)))
    step = max(1, _PAIRS // len(directions))
    for start in range(0, len(views), step):
        at = views[start : start + step]
        values = weights[start : start + step, None] * _sampled(brdf, at, directions)
        for c, channel in enumerate(values):
            sums[c] += basis.accumulate(channel, at)
    return _tents_by_channels(np.stack([basis.solve(channel) for channel in sums]))


def _sampled(brdf: BRDF, views: FloatArray, directions: FloatArray) -> FloatArray:
    """Return rho_hat at every pair, (C, views, D)."""
    wi, wo = np.tile(directions, (len(views), 1)), np.repeat(views, len(directions), axis=0)
    total = np.zeros((brdf.channels, len(wi)))
    for lobe in brdf.lobes:
        # The frame of a lobe about the tangent has z = T, x and y are then y and z of this one
        turned = [w[:, [1, 2, 0]] if lobe.frame == "tangent" else w for w in (wi, wo)]
        total += np.atleast_2d(lobe.transfer(*turned).T)
    return total.reshape(-1, len(views), len(directions))


def _corrected(Q: FloatArray, exact: FloatArray, Y: FloatArray) -> FloatArray:
    """Return the matrix nearest to Q whose product with the harmonics Y (D, n^2) is exact."""
    orthonormal, R = np.linalg.qr(Y)
    return np.asarray(Q + ((exact - Q @ Y) @ np.linalg.pinv(R)) @ orthonormal.T)


def _float32(array: FloatArray) -> Float32Array:
    """Return an array as float32 in C order."""
    return np.ascontiguousarray(array, np.float32)
