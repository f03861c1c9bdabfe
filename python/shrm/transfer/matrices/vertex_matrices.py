"""The matrices A_p of all vertices [LK03 section 4.4], computed block by block into a folder.

    A_p = Q (V_p o Y) R_p + Q L_p        L_p: radiance that the object itself sends along the d_k

What is kept for a vertex are rows over the light: those of the tents; or, where one material makes them from
harmonics, the fewer of these, X_p, with A_p = P X_p.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray, RealArray
from shrm.transfer.described import Described
from shrm.transfer.matrices.materials import Materials
from shrm.transfer.matrices.product import Product, accumulate, harmonics, rotated
from shrm.transfer.rays.bounces import incident
from shrm.transfer.rays.stored import stored
from shrm.transfer.rays.visibility import Block, Visibility, digest

Progress = Callable[[int, int], None]
"""Called with the vertices that are finished and their number."""

_REFLECTED = 16
"""Vertices whose reflected light is one array: D C n^2 numbers of each."""

_VERTICES = 512
"""Vertices of a part where nothing hides the light."""


@dataclass(frozen=True, eq=False, repr=False)
class Factors(Described):
    """Factors of matrices as they are kept: A_p = outer rows_p, or the rows themselves.

    Attributes
    ----------
    tents, channels : int
        M^2 and C.
    rows : (V, r, n^2) float32
        r is M^2 C without outer.
    outer : (M^2 C, r) float32 or None
    """

    tents: int
    channels: int
    rows: Float32Array
    outer: Float32Array | None = None

    def matrices(self, path: Path) -> Float32Array:
        """Return A, (V, M^2, C, n^2): on disk, multiplied into a file if need be."""
        V, _, n2 = self.rows.shape
        shape = (V, self.tents, self.channels, n2)
        outer = self.outer
        if outer is None:
            return self.rows.reshape(shape)
        return stored(
            path,
            {"digest": digest(outer, self.rows)},
            (V, len(outer), n2),
            _parts(V),
            lambda part: np.matmul(outer, self.rows[part]),
            lambda done, total: None,
        ).reshape(shape)


class Matrices(Described):
    """Matrices of the vertices of a mesh, computed into a folder.

    Parameters
    ----------
    frames : (V, 3, 3) float64
    materials : Materials
    products : sequence of Product
        One for each material, all with the same tents.
    channels : int
        C of the matrices, 1 or 3.
    n : int
        Order of the light.
    folder : path
        Where results are kept.
    """

    shown = ("frames", "materials", "channels", "n", "folder")

    def __init__(
        self,
        frames: FloatArray,
        materials: Materials,
        products: Sequence[Product],
        channels: int,
        n: int,
        folder: Path,
    ) -> None:
        self.frames, self.materials, self.products = frames, materials, products
        self.channels, self.n, self.folder = channels, n, folder
        self.tents = products[0].basis.size

    def unshadowed(self, progress: Progress) -> Factors:
        """Return B R_p: nothing hides the light, and T is the identity."""
        # One material: R_p are the rows, and B makes tents of them
        if self._single:
            rows = self._stored(
                "unshadowed",
                self.n**2,
                _parts(len(self.frames)),
                lambda part: rotated(np.eye(self.n**2), self.frames[part]),
                progress,
            )
            outer = self._as_channels(self.products[0].unshadowed[None])[0]
            return Factors(self.tents, self.channels, rows, np.ascontiguousarray(outer, np.float32))

        # Several: the sum of their B, each times its share
        def make(part: slice) -> Float32Array:
            total = np.zeros((part.stop - part.start, self.tents * self.channels, self.n**2), np.float32)
            for product, share in self._shares(part):
                local = self._as_channels(product.unshadowed[None].astype(np.float32))
                total += share * local
            return rotated(total, self.frames[part])

        count = self.tents * self.channels
        rows = self._stored("unshadowed", count, _parts(len(self.frames)), make, progress)
        return Factors(self.tents, self.channels, rows)

    def shadowed(self, visibility: Visibility, leaving: Float32Array | None, progress: Progress) -> Factors:
        """Return the matrices past the rest of the object, with the light that it sends if that is given.

        Parameters
        ----------
        visibility : Visibility
            Computed; with hits if `leaving` is given.
        leaving : (V, 1 or 3, n^2) float32 or None
            See `shrm.transfer.rays.bounces.leaving`.
        progress : callable
        """
        first = self.products[0]
        Y = harmonics(visibility.directions, self.n).astype(np.float32)
        by_harmonics = self._single and (leaving is None or leaving.shape[1] == 1)
        inner = first.inner if by_harmonics else None

        def make(part: slice) -> Float32Array:
            block = visibility[part.start // visibility.block]

            # One material by way of harmonics: X_p are the rows
            if inner is not None:
                rows = accumulate(inner, block.visible, Y, self.frames[part])
                if leaving is not None:
                    _reflect(rows[:, :, None], inner[:, None], block, visibility, leaving)
                return rows

            # Else tents, of several materials the sum
            total = np.zeros((len(block.visible), self.tents * self.channels, self.n**2), np.float32)
            for product, share in self._shares(part):
                rows = accumulate(product.rays, block.visible, Y, self.frames[part])
                rows = self._as_channels(rows)
                if leaving is not None:
                    by_channel = rows.reshape(len(rows), self.tents, self.channels, -1)
                    rays = product.rays.reshape(self.tents, product.channels, -1)
                    _reflect(by_channel, rays, block, visibility, leaving)
                total += share * rows
            return total

        # Parts are the blocks of visibility, in which rays were cast
        parts = [
            slice(k, min(k + visibility.block, len(self.frames)))
            for k in range(0, len(self.frames), visibility.block)
        ]
        name = "shadowed" if leaving is None else "interreflected"
        extra = () if leaving is None else (leaving,)
        count = self.tents * self.channels if inner is None else len(inner)
        seen = (visibility.directions, visibility.vertices, visibility.faces)
        rows = self._stored(name, count, parts, make, progress, *seen, *extra)
        if inner is None:
            return Factors(self.tents, self.channels, rows)

        # What makes tents of the harmonics
        outer = first.outer
        assert outer is not None
        outer = self._as_channels(outer[None])[0]
        return Factors(self.tents, self.channels, rows, np.ascontiguousarray(outer))

    @property
    def _single(self) -> bool:
        """Whether one material is everywhere."""
        return self.materials.shares is None

    def _shares(self, part: slice) -> Iterator[tuple[Product, Float32Array | float]]:
        """Yield the products of materials that vertices of a part have, and the shares, (vertices, 1, 1)."""
        if self.materials.shares is None:
            yield self.products[0], 1.0
            return
        for product, share in zip(self.products, self.materials.shares[part].T, strict=True):
            if share.any():
                yield product, share[:, None, None]

    def _as_channels(self, rows: RealArray) -> Float32Array:
        """Return rows (k, M^2 C', columns), where C' is C or 1, as (k, M^2 C, columns)."""
        if rows.shape[1] == self.tents * self.channels:
            return np.asarray(rows)
        return np.repeat(rows, self.channels, axis=1)

    def _stored(
        self,
        name: str,
        rows: int,
        parts: Sequence[slice],
        make: Callable[[slice], Float32Array],
        progress: Progress,
        *depends: npt.NDArray[Any],
    ) -> Float32Array:
        """Return rows (V, rows, n^2) kept under a name; those that depend on the same are not made again."""
        arrays: list[npt.NDArray[Any]] = [
            self.frames,
            *(product.rays for product in self.products),
            *(product.unshadowed for product in self.products),
            *depends,
        ]
        if self.materials.shares is not None:
            arrays.append(self.materials.shares)
        sizes = {"n": self.n, "channels": self.channels, "route": str(self.products[0].route)}
        about = {**sizes, "digest": digest(*arrays)}
        shape = (len(self.frames), rows, self.n**2)
        return stored(self.folder / name, about, shape, parts, make, progress)


def _reflect(
    rows: Float32Array, rays: Float32Array, block: Block, visibility: Visibility, leaving: Float32Array
) -> None:
    """Add Q L_p to rows (vertices, r, C, n^2), in place; rays (r, C or 1, D)."""
    for part in block.parts(_REFLECTED):
        X = incident(part, visibility.faces, leaving)  # (vertices, D, C or 1, n^2)
        at = slice(part.first - block.first, part.first - block.first + len(X))
        for c in range(rows.shape[2]):
            Q = np.ascontiguousarray(rays[:, min(c, rays.shape[1] - 1)])
            rows[at, :, c] += Q @ np.ascontiguousarray(X[:, :, min(c, X.shape[2] - 1)])


def _parts(vertices: int) -> list[slice]:
    """Return the parts of so many vertices where nothing hides the light."""
    return [slice(k, min(k + _VERTICES, vertices)) for k in range(0, vertices, _VERTICES)]
