"""Directions that lobes are seen by: central directions, frames, the horizon, and directions spread evenly.

All take and return unit vectors, (n, 3) float64, in the world frame; nothing is checked.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf.lobe import Center
from shrm.lobes.center import gamma_table


def central_directions(center: Center, n: FloatArray, v: FloatArray, t: FloatArray) -> FloatArray:
    """Return C, (n, 3), of lobes about R, N or T."""
    if center == "reflection":
        return reflection(n, v)
    return n if center == "normal" else t


def normals_at(center: Center, gamma: FloatArray, centers: FloatArray, v: FloatArray) -> FloatArray:
    """Return normals (n, 3) whose centers, seen from v, are `centers`; gamma (257,) is for lobe centers."""
    if center == "normal":
        return centers
    if center == "reflection":
        return bisector(centers, v)
    # theta_o = theta_v + gamma(theta_v) is monotone: read it backwards.
    theta_v = np.linspace(0, np.pi / 2, len(gamma))
    theta_o = np.maximum.accumulate(theta_v + gamma)
    x, angle = across(v, centers)
    angle = np.interp(angle, theta_o, theta_v)
    return np.asarray(np.cos(angle)[:, None] * v + np.sin(angle)[:, None] * x)


def normals_of(
    center: Center,
    transfer: Callable[[FloatArray, FloatArray], FloatArray],
    centers: FloatArray,
    v: FloatArray,
) -> FloatArray:
    """Return normals (n, 3) of an isotropic lobe whose centers, seen from v, are `centers`."""
    gamma = gamma_table("lobe", transfer) if center == "lobe" else np.zeros(0)
    return normals_at(center, gamma, centers, v)


def across(z: FloatArray, towards: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors (n, 3) square to z, in the plane of z and `towards`, and the angles (n,) from z.

    Where z and `towards` are parallel, any vector square to z is returned.
    """
    cosine = np.einsum("nc,nc->n", towards, z)
    x = towards - cosine[:, None] * z
    sine = np.sqrt(np.einsum("nc,nc->n", x, x))
    angle = np.arctan2(sine, cosine)  # accurate when small
    parallel = sine < 1e-7
    if parallel.any():
        x[parallel] = np.cross(z[parallel], np.eye(3)[np.argmin(np.abs(z[parallel]), axis=1)])
        sine[parallel] = np.linalg.norm(x[parallel], axis=1)
    x /= sine[:, None]
    return x, angle


def local_frames(z: FloatArray, towards: FloatArray) -> FloatArray:
    """Return frames (n, 3, 3) with columns x, y, z, x in the plane of z and `towards` as `across` has it."""
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    x, _ = across(z, towards)
    return np.stack([x, np.cross(z, x), z], axis=2)


def reflection(n: FloatArray, v: FloatArray) -> FloatArray:
    """Return R = 2 (N.V) N - V, (n, 3)."""
    return np.asarray(2 * np.einsum("nc,nc->n", n, v)[:, None] * n - v)


def bisector(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return unit vectors (n, 3) midway between a and b: for R and V, the normal. Square to opposite ones."""
    sum_ = a + b
    length = np.sqrt(np.einsum("nc,nc->n", sum_, sum_))
    opposite = length < 1e-7
    if opposite.any():
        sum_[opposite], length[opposite] = across(b[opposite], a[opposite])[0], 1.0
    sum_ /= length[:, None]
    return sum_


def above_horizon(center: Center, n: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return N and V, (n, 3) each, with views below the horizon of N replaced as reflection maps have them.

    About the reflection -N takes the place of N, which leaves R as it is; about the lobe or the normal V is
    brought back to the horizon.
    """
    cosine = np.einsum("nc,nc->n", n, v)
    below = cosine < 0
    if not below.any():
        return n, v
    if center == "reflection":
        return np.where(below[:, None], -n, n), v
    level = v[below] - cosine[below, None] * n[below]
    level /= np.maximum(np.linalg.norm(level, axis=1, keepdims=True), 1e-12)
    v = v.copy()
    v[below] = level
    return n, v
