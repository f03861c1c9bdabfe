"""What all ways of lighting an object share: vertices and frames, the light, the eye, and their checks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.transfer.described import Described
from shrm.transfer.directional_basis import DirectionalBasis
from shrm.validation import float32_array, require_array, require_rotations, unit_vectors

MOST_ORDER = 10
"""The largest order n of light, degrees 0 to n - 1."""

MOST_TENTS = 33
"""The largest number of tents along a side, M."""

FRAME_TOLERANCE = 1e-5
"""How far frames may be from orthogonal: a hundred roundings of float32."""

BLOCK = 1024
"""Vertices that are taken together where numpy would make large arrays of all."""


@dataclass(frozen=True, eq=False, repr=False)
class Eye(Described):
    """Place from which an object is seen.

    Attributes
    ----------
    at : (3,) float32
        A position, or the unit vector from the object to a distant viewer.
    distant : bool
    """

    at: Float32Array
    distant: bool

    @classmethod
    def checked(cls, eye: npt.ArrayLike | None, view: npt.ArrayLike | None) -> Eye:
        """Return the one of `eye` and `view` that is given; TypeError, ValueError if not one alone is."""
        if (eye is None) == (view is None):
            raise ValueError(f"eye or view must be given, got {'neither' if eye is None else 'both'}")
        if view is not None:
            return cls(unit_vectors("view", view, 1)[0].astype(np.float32), True)
        assert eye is not None
        return cls(float32_array("eye", eye, (3,)), False)


class Lighting(Described, ABC):
    """A way to light the vertices of an object.

    Attributes
    ----------
    n : int
        Order of the light, degrees 0 to n - 1.
    size : int
        V, the number of vertices.
    """

    n: int
    size: int

    def radiance(
        self,
        light: npt.ArrayLike,
        *,
        eye: npt.ArrayLike | None = None,
        view: npt.ArrayLike | None = None,
        out: Float32Array | None = None,
    ) -> Float32Array:
        """Return the radiance of every vertex towards the eye.

        Parameters
        ----------
        light : (n^2, 3) array_like
            Coefficients of incident radiance in global coordinates, in the real basis of `shrm.sh`.
        eye : (3,) array_like, optional
            The position of a near viewer. A vertex that lies there takes it to be above.
        view : (3,) array_like, optional
            The unit vector to a distant viewer; in place of `eye`.
        out : (V, 3) float32 array, optional
            Array in C order that takes the result.

        Returns
        -------
        (V, 3) float32
            `out`, if given. Vertices that face away are lit as if they were seen from their horizon.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described, or not one of `eye` and `view` is given.
        """
        return self._radiance(light, Eye.checked(eye, view), out)

    def _radiance(self, light: npt.ArrayLike, eye: Eye, out: Float32Array | None) -> Float32Array:
        """Check the light and the result's place, and light the vertices."""
        coefficients = float32_array("light", light, (self.n**2, 3))
        if out is None:
            out = np.empty((self.size, 3), dtype=np.float32)
        require_array("out", out, (self.size, 3), np.float32, writeable=True)
        self._light(coefficients, eye, out)
        return out

    @abstractmethod
    def _light(self, light: Float32Array, eye: Eye, radiance: Float32Array) -> None:
        """Fill radiance (V, 3) for light (n^2, 3), both in C order."""


class Surface(Described):
    """Vertices with their frames.

    Parameters
    ----------
    vertices : (V, 3) array_like
    frames : (V, 3, 3) array_like
        Rotations global_from_local, orthogonal to 1e-5: columns x = tangent, y, z = normal.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """

    shown = ("vertices", "frames")

    def __init__(self, vertices: npt.ArrayLike, frames: npt.ArrayLike) -> None:
        self.vertices = float32_array("vertices", vertices, ("V", 3), empty=False)
        self.frames = float32_array("frames", frames, (self.size, 3, 3))
        require_rotations("frames", self.frames, FRAME_TOLERANCE)
        self.core = _core.TransferSurface(vertices=self.vertices, frames=self.frames)

    def __reduce__(self) -> tuple[type[Surface], tuple[object, ...]]:
        """Return how a pickle makes it again: what the core holds is no part of it."""
        return type(self), (self.vertices, self.frames)

    @property
    def size(self) -> int:
        """V, the number of vertices."""
        return len(self.vertices)

    def tents(self, eye: Eye, M: int) -> tuple[IntArray, FloatArray]:
        """Return the tents that are not zero at the local views (V, 4), and their values there."""
        towards = eye.at.astype(np.float64) - (0 if eye.distant else self.vertices)
        local = np.einsum("vij,vi->vj", self.frames, np.broadcast_to(towards, self.vertices.shape))
        length = np.linalg.norm(local, axis=1, keepdims=True)
        above = np.array([0.0, 0.0, 1.0])
        directions = np.where(length > 0, local / np.where(length > 0, length, 1.0), above)
        return DirectionalBasis(M).tents(directions)


def order_of(name: str, terms: int) -> int:
    """Return n of n^2 coefficients of light; ValueError if there is none in [1, 10]."""
    return _root(name, terms, "n^2 coefficients of light, n", 1, MOST_ORDER)


def tents_of(name: str, tents: int) -> int:
    """Return M of M^2 tents; ValueError if there is none in [2, 33]."""
    return _root(name, tents, "M^2 tents, M", 2, MOST_TENTS)


def require_channels(name: str, channels: int) -> None:
    """Refuse other numbers of channels than 1 and 3."""
    if channels not in (1, 3):
        raise ValueError(f"{name} must have 1 or 3 channels, got {channels}")


def _root(name: str, square: int, what: str, least: int, most: int) -> int:
    """Return the root of a square number; refuse what has none in [least, most]."""
    root = round(float(np.sqrt(square)))
    if root**2 != square or not least <= root <= most:
        raise ValueError(f"{name} must have {what} in [{least}, {most}], got {square}")
    return root
