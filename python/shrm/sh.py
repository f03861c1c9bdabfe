"""Spherical harmonics: analysis, synthesis, evaluation and rotation.

Coefficients are in the real orthonormal basis, index l(l+1)+m: sqrt2 Re Y_lm for m > 0, Y_l0, sqrt2 Im
Y_l|m| for m < 0, with the Condon-Shortley phase; one column for each channel. Pictures are lat-long, row 0
at +z, the center looking along +x, nothing mirrored when seen from inside.

Everything is separable: F-degree coefficients of an S x 2S picture take O(F S^2) operations [RH02 section
6.1].
"""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.validation import (
    flag,
    picture_shape,
    real_array,
    require_array,
    rotation,
    unit_vectors,
    whole_number,
)

__all__ = ["MAX_DEGREE", "Plan", "analysis", "basis_size", "degree_of", "evaluate", "rotate", "synthesis"]

MAX_DEGREE = 1000
"""Largest degree that is taken: the recurrences are tested up to it."""


def analysis(pixels: npt.ArrayLike, F: int) -> FloatArray:
    """Transform samples at the texel centers to coefficients.

    The quadrature is Fejer's first rule: exact, and the inverse of `synthesis`, for functions of degree D
    <= F if D + F < H and D + F < W. For a *picture*, whose texels are areas, see
    `Environment.coefficients`.

    Parameters
    ----------
    pixels : (H, W) or (H, W, channels) array_like
        Samples, converted to float32.
    F : int
        Largest degree, 0 <= F <= 1000.

    Returns
    -------
    ((F+1)^2, channels) float64

    Raises
    ------
    TypeError, ValueError
        If pixels has another shape, is not real or not finite, or F is no whole number in its range.
    """
    return _core.analysis(pixels=_picture(pixels), F=whole_number("F", F, 0, MAX_DEGREE), areas=False)


def synthesis(coefficients: npt.ArrayLike, shape: tuple[int, int]) -> Float32Array:
    """Evaluate coefficients at the texel centers of a lat-long picture.

    Parameters
    ----------
    coefficients : ((F+1)^2,) or ((F+1)^2, channels) array_like
        Real-basis coefficients.
    shape : (H, W)
        Rows and columns of the picture, 1 to 65536 each.

    Returns
    -------
    (H, W, channels) float32

    Raises
    ------
    TypeError, ValueError
        If coefficients has another shape, is not real or not finite, or `shape` is no pair of whole numbers
        in their range.
    """
    H, W = picture_shape("shape", shape)
    rings = _core.synthesis(coefficients=_coefficients(coefficients), H=H, W=W)
    return np.ascontiguousarray(rings.transpose(0, 2, 1))


def evaluate(coefficients: npt.ArrayLike, directions: npt.ArrayLike) -> FloatArray:
    """Evaluate coefficients at any directions, in float64.

    Parameters
    ----------
    coefficients : ((F+1)^2,) or ((F+1)^2, channels) array_like
        Real-basis coefficients.
    directions : (n, 3) array_like
        Unit vectors.

    Returns
    -------
    (n, channels) float64

    Raises
    ------
    TypeError, ValueError
        If a shape does not fit, or the directions are not unit vectors (to 1e-4).
    """
    vectors = unit_vectors("directions", directions)
    return _core.evaluate(coefficients=_coefficients(coefficients), directions=vectors)


def rotate(coefficients: npt.ArrayLike, R: npt.ArrayLike) -> FloatArray:
    """Return the coefficients of the rotated function L'(w) = L(R^T w).

    Parameters
    ----------
    coefficients : ((F+1)^2,) or ((F+1)^2, channels) array_like
        Real-basis coefficients.
    R : (3, 3) array_like
        A rotation: orthogonal to 1e-6, determinant 1.

    Returns
    -------
    ((F+1)^2, channels) float64

    Raises
    ------
    TypeError, ValueError
        If coefficients has another shape, or R is no rotation.
    """
    return _core.rotate(coefficients=_coefficients(coefficients), R=rotation("R", R))


class Plan:
    """Analysis and synthesis of many pictures of one shape.

    Its tables are made once; with `out` given, a call allocates no arrays but those of a check for numbers
    that are not finite. Threads may share a plan: each waits for its turn.

    Parameters
    ----------
    shape : (H, W)
        Rows and columns of the pictures, 1 to 65536 each.
    F : int
        Largest degree, 0 to 1000.
    channels : int
        Channels of the pictures, 1 to 4096.
    areas : bool
        True if texels are areas, as in `Environment.coefficients`; False if they are samples at their
        centers, as in `analysis`.

    Raises
    ------
    TypeError, ValueError
        If a size is no whole number in its range, or areas no bool.

    Examples
    --------
    >>> import numpy as np
    >>> plan = Plan((64, 128), F=10)
    >>> coefficients = plan.analysis(np.ones((64, 128, 3), dtype=np.float32))
    >>> coefficients.shape
    (121, 3)
    """

    def __init__(self, shape: tuple[int, int], F: int, channels: int = 3, *, areas: bool = False) -> None:
        self.shape = picture_shape("shape", shape)
        self.F = whole_number("F", F, 0, MAX_DEGREE)
        self.channels = whole_number("channels", channels, 1, 4096)
        self.areas = flag("areas", areas)

    def analysis(self, pixels: Float32Array, out: FloatArray | None = None) -> FloatArray:
        """Return the coefficients of a picture.

        Parameters
        ----------
        pixels : (H, W, channels) float32 array
            In C order.
        out : ((F+1)^2, channels) float64 array, optional
            In C order; takes the result.

        Returns
        -------
        ((F+1)^2, channels) float64
            `out`, if given.

        Raises
        ------
        TypeError, ValueError
            If an array has another shape, type or order, or pixels are not finite, or too large to be added
            up in float32; `out` is then undefined.
        """
        require_array("pixels", pixels, (*self.shape, self.channels), np.float32)
        shape = (basis_size(self.F), self.channels)
        if out is None:
            out = np.empty(shape)
        require_array("out", out, shape, np.float64, writeable=True)
        self._analysis.run(pixels, out)
        if not np.isfinite(out).all():  # one texel that is not finite reaches every coefficient
            reason = "be finite" if not np.isfinite(pixels).all() else "have sums that are finite in float32"
            raise ValueError(f"pixels must {reason}")
        return out

    def synthesis(self, coefficients: FloatArray, out: Float32Array | None = None) -> Float32Array:
        """Return the values at the texel centers, ring by ring and planar.

        Parameters
        ----------
        coefficients : ((F+1)^2, channels) float64 array
            In C order.
        out : (H, channels, W) float32 array, optional
            In C order; takes the result.

        Returns
        -------
        (H, channels, W) float32
            `out`, if given.

        Raises
        ------
        TypeError, ValueError
            If an array has another shape, type or order, or coefficients are not finite.
        """
        require_array("coefficients", coefficients, (basis_size(self.F), self.channels), np.float64)
        if not np.isfinite(coefficients).all():
            raise ValueError("coefficients must be finite")
        H, W = self.shape
        shape = (H, self.channels, W)
        if out is None:
            out = np.empty(shape, dtype=np.float32)
        require_array("out", out, shape, np.float32, writeable=True)
        self._synthesis.run(coefficients, out)
        return out

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what is pickled: the tables are made again."""
        return partial(type(self), areas=self.areas), (self.shape, self.F, self.channels)

    def __repr__(self) -> str:
        H, W = self.shape
        texels = "areas" if self.areas else "samples"
        return f"<Plan of {H} x {W} {texels}, F={self.F}, {self.channels} channels>"

    @cached_property
    def _analysis(self) -> _core.Analysis:
        H, W = self.shape
        return _core.Analysis(H=H, W=W, channels=self.channels, F=self.F, areas=self.areas)

    @cached_property
    def _synthesis(self) -> _core.Synthesis:
        H, W = self.shape
        return _core.Synthesis(H=H, W=W, channels=self.channels, F=self.F)


def basis_size(F: int) -> int:
    """Return (F+1)^2, the number of basis functions up to degree F."""
    return (F + 1) ** 2


def degree_of(coefficients: npt.NDArray[np.generic]) -> int:
    """Return F of an array with (F+1)^2 rows; ValueError if their number is no square."""
    F = round(float(np.sqrt(len(coefficients)))) - 1
    if F < 0 or basis_size(F) != len(coefficients):
        raise ValueError(f"coefficients must have (F+1)^2 rows, got {len(coefficients)}")
    return F


def _picture(pixels: npt.ArrayLike) -> Float32Array:
    """Return samples as (H, W, channels) float32; TypeError or ValueError if they are not real and finite."""
    # Large pictures of float32 are not taken through float64.
    is_float32 = type(pixels) is np.ndarray and pixels.dtype == np.float32
    array = np.asarray(pixels) if is_float32 and np.isfinite(pixels).all() else real_array("pixels", pixels)
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or 0 in array.shape:
        raise ValueError(f"pixels must have the shape (H, W) or (H, W, channels), got {np.shape(pixels)}")
    return np.ascontiguousarray(array, dtype=np.float32)


def _coefficients(coefficients: npt.ArrayLike) -> FloatArray:
    """Return coefficients as ((F+1)^2, channels) float64; TypeError or ValueError if they are none."""
    array = real_array("coefficients", coefficients)
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or 0 in array.shape:
        raise ValueError(
            f"coefficients must have the shape ((F+1)^2, channels), got {np.shape(coefficients)}"
        )
    if degree_of(array) > MAX_DEGREE:
        raise ValueError(f"coefficients must have degrees up to {MAX_DEGREE} at most, got {degree_of(array)}")
    return np.ascontiguousarray(array)
