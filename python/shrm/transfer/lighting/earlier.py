"""The methods before matrix radiance transfer, which multiply light by a vertex's whole transfer matrix.

T_p, n^2 x n^2, takes light to transferred light, both in global coordinates: shadows and interreflections
[LK03 section 3.1]. Where nothing shadows it is the identity, and need not be given.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF, RadialLobe, require_brdf
from shrm.frequency.analysis import analyse
from shrm.transfer.brdf_matrix import rows
from shrm.transfer.lighting.surface import (
    BLOCK,
    MOST_ORDER,
    Eye,
    Lighting,
    Surface,
    order_of,
    require_channels,
    tents_of,
)
from shrm.transfer.tangent_frames import band_rotations
from shrm.validation import StoredArray, float32_array, one_of, stored_array, whole_number

Axis = Literal["reflection", "normal"]

MOST_SAMPLES = 512
"""Samples along the side of the largest parabolic map."""

ROTATION_ROOM = 16
"""Floats of a vector of the widest instruction set, which the core reads beyond the last rotation."""


class Diffuse(Lighting):
    """Products of a row for each vertex with light: diffuse materials [SKS02]. The eye does not matter.

    Parameters
    ----------
    transfer : (V, C, n^2) array
        Outgoing radiance from light in global coordinates; n in [1, 10], C 1 or 3, float32 or float16. Where
        nothing shadows, `Convolution` about the normal needs none.

    Raises
    ------
    TypeError, ValueError
        If it is not that.
    """

    shown = ("transfer",)

    def __init__(self, transfer: npt.ArrayLike) -> None:
        self.transfer = stored_array("transfer", transfer, ("V", "C", "n^2"))
        self.size, channels, terms = self.transfer.shape
        self.n = order_of("transfer", terms)
        require_channels("transfer", channels)

    def radiance(
        self,
        light: npt.ArrayLike,
        *,
        eye: npt.ArrayLike | None = None,
        view: npt.ArrayLike | None = None,
        out: Float32Array | None = None,
    ) -> Float32Array:
        """Return the radiance of every vertex, see `Lighting.radiance`; `eye` and `view` may be left out."""
        if eye is None and view is None:
            view = (0.0, 0.0, 1.0)
        return super().radiance(light, eye=eye, view=view, out=out)

    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        _core.light_rows(rows=self.transfer, light=light, radiance=radiance)


class Projection(Lighting):
    """Products of the material's row at the view with transferred light [KSS02]: b(view) R_p T_p light.

    The product is taken from the left, so that a vertex costs a row for each channel of the material, not a
    column for each of the light.

    Parameters
    ----------
    vertices : (V, 3) array_like
    frames : (V, 3, 3) array_like
        Rotations global_from_local: columns x = tangent, y, z = normal.
    rows : (S, S, C, n^2) or (M^2, C, n^2) array
        The material: a parabolic map of its rows, see `parabolic_map`; or its coefficients in tents, see
        `shrm.transfer.brdf_matrix.project_on_tents`, which without a transfer are matrix radiance transfer.
    transfer : (V, n^2, n^2) array, optional
        T_p, float32 or float16. Without it nothing shadows, and frames alone are stored.
    prerotated : bool
        Whether R_p T_p is multiplied beforehand, which takes the memory of another T; or R_p is stored, and
        applied to the row each time.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    shown = ("rows", "parabolic", "transfer")

    def __init__(
        self,
        vertices: npt.ArrayLike,
        frames: npt.ArrayLike,
        rows: npt.ArrayLike,
        transfer: npt.ArrayLike | None = None,
        *,
        prerotated: bool = False,
    ) -> None:
        if prerotated and transfer is None:
            raise ValueError("transfer must be given where it is prerotated, got None")

        self.surface = Surface(vertices, frames)
        self.size = self.surface.size

        # The material: a parabolic map, or tents, whose square is its side
        parabolic = np.ndim(rows) == 4
        shape = ("S", len(np.asarray(rows)), "C", "n^2") if parabolic else ("M^2", "C", "n^2")
        samples = float32_array("rows", rows, shape, empty=False)
        if not parabolic:
            M = tents_of("rows", len(samples))
            samples = samples.reshape(M, M, *samples.shape[1:])
        self.rows = samples
        side, _, channels, terms = self.rows.shape
        whole_number("the side of rows", side, 2, MOST_SAMPLES)
        require_channels("rows", channels)
        self.n = order_of("rows", terms)
        self.parabolic = parabolic

        # Rotations, in the transfer or beside it
        self.transfer = _checked_transfer(transfer, self.size, self.n)
        self._rotations: Float32Array | None = None
        if prerotated:
            assert self.transfer is not None
            self.transfer = _rotated(self.transfer, self.surface.frames, self.n)
        else:
            bands = band_rotations(_orthonormal(self.surface.frames), self.n)
            flat = np.concatenate([band.reshape(self.size, -1) for band in bands], axis=1)
            self._rotations = np.zeros(flat.size + ROTATION_ROOM, dtype=np.float32)
            self._rotations[: flat.size] = flat.reshape(-1)

    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        _core.light_projected(
            surface=self.surface.core,
            samples=self.rows,
            parabolic=self.parabolic,
            rotations=self._rotations,
            transfer=self.transfer,
            light=light,
            eye=eye.at,
            distant=eye.distant,
            radiance=radiance,
        )


class Convolution(Lighting):
    """A lobe that is symmetric about an axis, as a convolution of transferred light [SKS02].

    sum_lm Lambda_l rho_l (T_p light)_lm Y_lm(axis): the axis is the reflection of the view, as of Phong's
    lobe, or the normal, as of Lambert's. In global coordinates it is one direction; nothing else need be
    rotated.

    Parameters
    ----------
    vertices : (V, 3) array_like
    frames : (V, 3, 3) array_like
        Rotations global_from_local: columns x = tangent, y, z = normal.
    kernel : (n,) or (n, C) array_like
        Lambda_l rho_l, see `zonal_kernel`; n in [1, 10], C 1 or 3.
    transfer : (V, n^2, n^2) array, optional
        T_p, float32 or float16. Without it nothing shadows, and frames alone are stored.
    axis : {"reflection", "normal"}

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    shown = ("kernel", "axis", "transfer")

    def __init__(
        self,
        vertices: npt.ArrayLike,
        frames: npt.ArrayLike,
        kernel: npt.ArrayLike,
        transfer: npt.ArrayLike | None = None,
        *,
        axis: Axis = "reflection",
    ) -> None:
        self.surface = Surface(vertices, frames)
        self.size = self.surface.size
        columns = np.asarray(kernel)[:, None] if np.ndim(kernel) == 1 else kernel
        self.kernel = float32_array("kernel", columns, ("n", "C"), empty=False)
        self.n = whole_number("the number of degrees of kernel", len(self.kernel), 1, MOST_ORDER)
        require_channels("kernel", self.kernel.shape[1])
        self.transfer = _checked_transfer(transfer, self.size, self.n)
        self.axis = one_of("axis", axis, get_args(Axis))

    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        _core.light_convolved(
            surface=self.surface.core,
            kernel=self.kernel,
            about_normal=self.axis == "normal",
            transfer=self.transfer,
            light=light,
            eye=eye.at,
            distant=eye.distant,
            radiance=radiance,
        )


def zonal_kernel(brdf: BRDF, n: int) -> FloatArray:
    """Return Lambda_l rho_l of a material of one radial lobe, such as Phong's and Lambert's.

    Parameters
    ----------
    brdf : BRDF
    n : int
        Degrees 0 to n - 1, n in [1, 10].

    Returns
    -------
    (n, C) float64
        The lobe's eigenvalues: light of degree l alone is reflected as so many times itself at the axis.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    require_brdf(brdf)
    n = whole_number("n", n, 1, MOST_ORDER)
    if len(brdf.lobes) != 1 or not isinstance(brdf.lobes[0], RadialLobe):
        raise ValueError(f"brdf must have one lobe, symmetric about its axis, got {brdf.name}")
    rho = analyse(brdf.lobes[0], n - 1, 0).coefficients(n - 1, 0)[:, 0, 0]
    # Lambda_l rho_l, of which rho_l00 = sqrt(4 pi) rho_l [RH02 appendix C]
    return np.asarray(rho / np.sqrt(2 * np.arange(n)[:, None] + 1))


def parabolic_map(brdf: BRDF, n: int, side: int = 64) -> Float32Array:
    """Return a material's rows at the views of a parabolic map [KSS02], [HS98].

    Parameters
    ----------
    brdf : BRDF
        The material, see `shrm.transfer.brdf_matrix.rows`.
    n : int
        Order of the light, in [1, 10].
    side : int
        Samples along each side, 2 to 512.

    Returns
    -------
    (side, side, C, n^2) float32
        Sample (j, i) has (x, y) / (1 + z) at i and j, from -1 to 1, evenly. Those beyond the horizon have the
        row of the horizon before them.

    Warns
    -----
    RuntimeWarning
        If the quadrature does not settle, see `shrm.transfer.brdf_matrix.rows`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    side = whole_number("side", side, 2, MOST_SAMPLES)
    n = whole_number("n", n, 1, MOST_ORDER)

    # Views at the samples: those beyond the horizon are brought to it
    along = np.linspace(-1, 1, side)
    a, b = np.meshgrid(along, along)  # columns are x
    scale = np.maximum(np.hypot(a, b), 1.0)
    a, b = a / scale, b / scale
    squared = a * a + b * b
    views = np.stack([2 * a, 2 * b, np.maximum(1 - squared, 0.0)], axis=-1) / (1 + squared)[..., None]

    # Rows there, channels after the samples
    at_views = rows(brdf, views.reshape(-1, 3), n)
    channels = at_views if at_views.ndim == 3 else at_views[None]
    return np.ascontiguousarray(np.moveaxis(channels, 0, 1).reshape(side, side, -1, n * n), dtype=np.float32)


def _checked_transfer(transfer: npt.ArrayLike | None, V: int, n: int) -> StoredArray | None:
    """Return T_p, (V, n^2, n^2), if it is given."""
    return None if transfer is None else stored_array("transfer", transfer, (V, n * n, n * n))


def _rotated(transfer: StoredArray, frames: Float32Array, n: int) -> StoredArray:
    """Return R_p T_p, in the type of T_p."""
    result = np.empty_like(transfer, subok=False)
    for start in range(0, len(transfer), BLOCK):
        at = slice(start, start + BLOCK)
        for l, band in enumerate(band_rotations(_orthonormal(frames[at]), n)):
            degree = slice(l * l, (l + 1) ** 2)
            result[at, degree] = band @ transfer[at, degree]
    return result


def _orthonormal(frames: Float32Array) -> FloatArray:
    """Return frames of float32 in float64, orthogonal to its last digits."""
    U, _, Vt = np.linalg.svd(frames.astype(np.float64))
    return np.asarray(U @ Vt)
