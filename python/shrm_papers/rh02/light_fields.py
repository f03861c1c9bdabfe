"""Representations of the reflected light field B(R, V), each with its bytes and its look-up.

All are looked up by the same bilinear interpolation in numpy, so that their times may be compared. R is the
reflected view, by which all maps are indexed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt
from shrm import sh
from shrm.arrays import Float32Array, FloatArray, IntArray, RealArray
from shrm.environment import layouts
from shrm.prefiltered.icosahedron import weights


def corners(H: int, W: int, directions: FloatArray) -> Iterator[tuple[IntArray, Float32Array]]:
    """Yield the four texels (n,) round each direction, and weights (n, 1); H x W lat-long, W even."""
    theta = np.arccos(np.clip(directions[:, 2], -1, 1))
    phi = np.arctan2(directions[:, 1], directions[:, 0])
    y, x = theta * (H / np.pi) - 0.5, (np.pi - phi) * (W / (2 * np.pi)) - 0.5
    top, left = np.floor(y).astype(np.int64), np.floor(x).astype(np.int64)
    down, right = y - top, x - left
    for i, weight_i in ((top, 1 - down), (top + 1, down)):
        beyond = (i < 0) | (i >= H)  # over a pole is the same ring, half a turn away
        row = np.clip(i, 0, H - 1)
        for j, weight_j in ((left, 1 - right), (left + 1, right)):
            column = (j + np.where(beyond, W // 2, 0)) % W
            yield row * W + column, (weight_i * weight_j).astype(np.float32)[:, None]


class LightField(ABC):
    """Stored arrays, and how radiance is read from them."""

    @abstractmethod
    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Return the radiance for reflected views and views, each (n, 3); (n, 3)."""

    @property
    def bytes(self) -> int:
        """Bytes of all stored arrays."""
        stored = [getattr(self, part.name) for part in fields(self)]  # type: ignore[arg-type]
        return sum(array.nbytes for array in stored if isinstance(array, np.ndarray))


@dataclass(frozen=True, eq=False)
class Tabular(LightField):
    """T x T maps over R, one for each view of `shrm.explicit.grid_views`: (T, T, H, W, 3)."""

    maps: Float32Array

    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Look up bilinearly in R and in V: sixteen texels."""
        T, _, H, W, _ = self.maps.shape
        texels = self.maps.reshape(T * T, H * W, 3)
        radiance = np.zeros(R.shape, dtype=np.float32)
        texels_of_R = list(corners(H, W, R))
        for view, weight_v in corners(T, T, V):
            for texel, weight in texels_of_R:
                radiance += (weight_v * weight) * texels[view, texel]
        return radiance


@dataclass(frozen=True, eq=False)
class Icosahedral(LightField):
    """Twelve maps for the views of an icosahedron [CON99]: (12, H, W, 3)."""

    maps: Float32Array

    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Look up bilinearly in R, by barycentric weights in the triangle that holds V."""
        _, H, W, _ = self.maps.shape
        texels = self.maps.reshape(12, H * W, 3)
        shares = weights(V)
        near = np.argsort(shares, axis=1)[:, -3:]
        share = np.take_along_axis(shares, near, axis=1).astype(np.float32)
        radiance = np.zeros(R.shape, dtype=np.float32)
        for texel, weight in corners(H, W, R):
            for k in range(3):
                radiance += (weight * share[:, k : k + 1]) * texels[near[:, k], texel]
        return radiance


@dataclass(frozen=True, eq=False)
class Texture3D(LightField):
    """Maps over R for T angles between R and V, no azimuth: (T, H, W, 3)."""

    maps: Float32Array

    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Look up trilinearly."""
        T, H, W, _ = self.maps.shape
        texels = self.maps.reshape(T, H * W, 3)
        theta_o = np.arccos(np.clip(np.einsum("nk,nk->n", R, V), -1, 1))
        depth = np.clip(theta_o * (T / np.pi) - 0.5, 0, T - 1)
        near = np.minimum(depth.astype(np.int64), T - 2)
        far_share = (depth - near).astype(np.float32)[:, None]
        radiance = np.zeros(R.shape, dtype=np.float32)
        for texel, weight in corners(H, W, R):
            radiance += weight * ((1 - far_share) * texels[near, texel] + far_share * texels[near + 1, texel])
        return radiance


@dataclass(frozen=True, eq=False)
class Quantised(LightField):
    """The table vector-quantised: each texel names a shape over the views, and has its own gain.

    Attributes
    ----------
    code : (H, W) uint8
        Index into the shapes.
    gain : (H, W, 3) float32
        Mean radiance over the views.
    shapes : (codes, T, T, 3) float32
        Radiance over the gain.
    """

    code: npt.NDArray[np.uint8]
    gain: Float32Array
    shapes: Float32Array

    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Look up bilinearly in R and in V."""
        H, W = self.code.shape
        codes, T = self.shapes.shape[:2]
        shapes = self.shapes.reshape(codes, T * T, 3)
        gains, code = self.gain.reshape(H * W, 3), self.code.reshape(H * W)
        radiance = np.zeros(R.shape, dtype=np.float32)
        views = list(corners(T, T, V))
        for texel, weight in corners(H, W, R):
            shape = sum(weight_v * shapes[code[texel], view] for view, weight_v in views)
            radiance += weight * gains[texel] * shape
        return radiance


@dataclass(frozen=True, eq=False)
class Factored(LightField):
    """A sum of products [RH02 eq. 4]: g_a over R, (H, W, terms, 3), and h_a over V, (T, T, terms)."""

    g: Float32Array
    h: Float32Array

    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Look up each factor bilinearly."""
        H, W, terms, _ = self.g.shape
        T = len(self.h)
        g, h = self.g.reshape(H * W, terms, 3), self.h.reshape(T * T, terms)
        of_view = sum(weight * h[view] for view, weight in corners(T, T, V))
        radiance = np.zeros(R.shape, dtype=np.float32)
        for texel, weight in corners(H, W, R):
            radiance += weight * np.einsum("nac,na->nc", g[texel], of_view)
        return radiance


@dataclass(frozen=True, eq=False)
class Coefficients(LightField):
    """Harmonics of R and V both [RH02 eq. 5]; ((F+P+1)^2, (P+1)^2, 3) in the global form."""

    b: Float32Array

    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Sum the series at each R and V."""
        count, terms, _ = self.b.shape
        maps = sh.evaluate(self.b.reshape(count, -1), R).reshape(len(R), terms, 3)
        return np.asarray(np.einsum("nac,na->nc", maps, sh.evaluate(np.eye(terms), V)))


@dataclass(frozen=True, eq=False)
class HarmonicMaps(LightField):
    """The SHRM [RH02 eq. 7]: (P+1)^2 maps over R, each a coefficient of the view; (H, W, (P+1)^2, 3)."""

    maps: Float32Array

    def radiance(self, R: FloatArray, V: FloatArray) -> RealArray:
        """Look up bilinearly in R and sum the series in V."""
        H, W, terms, _ = self.maps.shape
        texels = self.maps.reshape(H * W, terms, 3)
        Y = sh.evaluate(np.eye(terms), V).astype(np.float32)
        radiance = np.zeros(R.shape, dtype=np.float32)
        for texel, weight in corners(H, W, R):
            radiance += weight * np.einsum("nac,na->nc", texels[texel], Y)
        return radiance


# ---- Compression of the table


def factored(table: Float32Array, terms: int) -> Factored:
    """Return the table's best sum of `terms` products, in the mean square over R and V on their spheres."""
    T, _, H, W, _ = table.shape
    # Weighted by the roots of solid angles, squares are integrals over both spheres.
    over_V, over_R = (root_areas(n, m) for n, m in ((T, T), (H, W)))
    weighted = table.reshape(T * T, H * W, 3) * over_V[:, None, None] * over_R[:, None]
    weighted = weighted.reshape(T * T, -1)
    # The left singular vectors are the eigenvectors of the small Gram matrix.
    U = np.linalg.eigh((weighted @ weighted.T).astype(np.float64))[1][:, ::-1][:, :terms]
    g = (U.T.astype(np.float32) @ weighted).reshape(terms, H * W, 3) / over_R[:, None]
    return Factored(
        np.ascontiguousarray(g.transpose(1, 0, 2), dtype=np.float32).reshape(H, W, terms, 3),
        (U / over_V[:, None]).astype(np.float32).reshape(T, T, terms),
    )


def quantised(table: Float32Array, codes: int, rounds: int) -> Quantised:
    """Return the table with its distributions over the views quantised, by k-means from a seeded start."""
    # Each texel's distribution over the views is split into its mean, the gain, and its shape.
    T, _, H, W, _ = table.shape
    area = root_areas(T, T) ** 2
    views = table.reshape(T * T, H * W, 3).transpose(1, 0, 2)
    gain = np.einsum("tvc,v->tc", views, area) / area.sum()
    gain = np.maximum(gain, 1e-6 * gain.max()).astype(np.float32)
    root = np.sqrt(area)[:, None]
    shapes = np.ascontiguousarray(views / gain[:, None, :] * root, dtype=np.float32).reshape(H * W, -1)
    energy = (gain.astype(np.float64) ** 2).sum(axis=1) * root_areas(H, W) ** 2

    # Codes start at texels drawn by amplitude: by energy, a sun alone would take every one.
    rng = np.random.default_rng(1)
    share = np.sqrt(energy)
    book = shapes[rng.choice(H * W, codes, replace=False, p=share / share.sum())].copy()

    # K-means, the error weighted by energy.
    for _ in range(rounds):
        code = nearest(shapes, book)
        for k in np.unique(code):
            inside = code == k
            book[k] = np.average(shapes[inside], axis=0, weights=energy[inside])
    book_of_views = (book.reshape(codes, T * T, 3) / root).astype(np.float32)
    return Quantised(
        nearest(shapes, book).astype(np.uint8).reshape(H, W),
        gain.reshape(H, W, 3),
        book_of_views.reshape(codes, T, T, 3),
    )


def nearest(vectors: Float32Array, book: Float32Array) -> IntArray:
    """Return the index of the closest row of the book for each vector."""
    return np.asarray(((book**2).sum(axis=1) - 2 * vectors @ book.T).argmin(axis=1))


def root_areas(H: int, W: int) -> Float32Array:
    """Return the square roots of the solid angles of an H x W lat-long grid's texels, (H W,)."""
    return np.sqrt(layouts.solid_angles("latlong", H, W)).astype(np.float32).ravel()
