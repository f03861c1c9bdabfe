"""The directional basis of matrix radiance transfer: tents over the hemisphere, and the change to them.

Radiance that leaves a surface is expanded in M x M piecewise bilinear tents g_j on the unit square, index
j M + i, which the concentric map carries to the hemisphere about the normal +z [LK03 section 4.3], [SC97]: at
any direction four of them are not zero. An expansion in spherical harmonics of order m, degrees 0 to m - 1,
becomes one in tents by orthogonal projection:

    l^g = G^-1 C l        G_ji = int g_i g_j        C_ji = int Y_i g_j                  [LK03 eqs. 7, 8]
    |L - L^g|^2 = l^T E l        E = S - C^T G^-1 C        S = int Y Y^T                [LK03 eq. 10]

All integrals are over the hemisphere, so S is not the identity. The map preserves area: G is the Kronecker
product 2 pi G1 (x) G1 of the tridiagonal Gram matrix of the tents of one dimension.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from shrm import _core, sh
from shrm.arrays import FloatArray, IntArray
from shrm.lobes.quadrature import columns, unit_gauss
from shrm.validation import real_array, unit_vectors, whole_number

MOST_TENTS = 128
"""The largest M that bases are made for."""

MOST_ORDER = 32
"""The largest order m of spherical harmonics."""


@dataclass(frozen=True)
class DirectionalBasis:
    """M x M piecewise bilinear tents over the hemisphere about +z [LK03 section 4.3].

    Directions below the horizon are brought to it.

    Parameters
    ----------
    M : int
        Tents along each side of the square, 2 to 128.

    Raises
    ------
    TypeError, ValueError
        If M is no whole number in its range.

    Examples
    --------
    >>> basis = DirectionalBasis(11)
    >>> basis.change_of_basis(8).shape
    (121, 64)
    """

    M: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "M", whole_number("M", self.M, 2, MOST_TENTS))

    @property
    def size(self) -> int:
        """M^2, the number of tents."""
        return self.M**2

    # ---- Directions

    def tents(self, directions: npt.ArrayLike) -> tuple[IntArray, FloatArray]:
        """Return the tents that are not zero at each direction, and their values there.

        Parameters
        ----------
        directions : (n, 3) array_like
            Unit vectors in the frame with z = normal.

        Returns
        -------
        indices : (n, 4) int64
        weights : (n, 4) float64
            Values at least 0; each row sums to 1.
        """
        return _core.tents(directions=unit_vectors("directions", directions), M=self.M)

    def evaluate(self, coefficients: npt.ArrayLike, directions: npt.ArrayLike) -> FloatArray:
        """Evaluate an expansion: sum_j g_j(w) l_j [LK03 eq. 9].

        Parameters
        ----------
        coefficients : (M^2,) or (M^2, channels) array_like
        directions : (n, 3) array_like
            Unit vectors.

        Returns
        -------
        (n, channels) float64
        """
        rows = self._rows("coefficients", coefficients, self.size)
        at = unit_vectors("directions", directions)
        return _core.evaluate_tents(coefficients=rows, directions=at, M=self.M)

    def accumulate(self, values: npt.ArrayLike, directions: npt.ArrayLike) -> FloatArray:
        """Sum values into tents, sum_n g_j(w_n) f_n: the adjoint of `evaluate`.

        With values f(w_n) times the weights of a quadrature these are the integrals of f g_j, whose `solve`
        is the projection of f.

        Parameters
        ----------
        values : (n,) or (n, channels) array_like
        directions : (n, 3) array_like
            Unit vectors.

        Returns
        -------
        (M^2, channels) float64
        """
        at = unit_vectors("directions", directions)
        rows = self._rows("values", values, len(at))
        return _core.accumulate_tents(values=rows, directions=at, M=self.M)

    # ---- Projection

    def gram(self) -> FloatArray:
        """Return the Gram matrix G, (M^2, M^2) float64, exactly [LK03 eq. 7]."""
        G1 = gram_of_one_dimension(self.M)
        return np.asarray(2 * np.pi * np.kron(G1, G1))

    def solve(self, right: npt.ArrayLike) -> FloatArray:
        """Return G^-1 times integrals against the tents, one dimension of the square after the other.

        Parameters
        ----------
        right : (M^2,) or (M^2, channels) array_like

        Returns
        -------
        (M^2, channels) float64
        """
        M, rows = self.M, self._rows("right", right, self.size)
        G1 = gram_of_one_dimension(M)
        along_v = np.linalg.solve(G1, rows.reshape(M, -1))  # (j, i channels)
        along_u = np.linalg.solve(G1, along_v.reshape(M, M, -1))  # each j: (i, channels)
        return np.asarray(along_u.reshape(self.size, -1) / (2 * np.pi))

    def quadrature(self, points: int) -> tuple[FloatArray, FloatArray]:
        """Return nodes over the hemisphere for functions times tents: Gauss in four triangles of every cell.

        Cells are cut along both diagonals, where the concentric map has kinks. Triangles that meet the
        pole, where the map is singular, have it as their collapsed vertex [D82].

        Parameters
        ----------
        points : int
            Along each side of a triangle, 1 to 64.

        Returns
        -------
        directions : (4 (M-1)^2 points^2, 3) float64
        weights : (4 (M-1)^2 points^2,) float64
            Steradians; they sum to 2 pi.
        """
        positions, weights = _square_quadrature(self.M, whole_number("points", points, 1, 64))
        return _core.hemisphere_from_square(positions=positions), weights

    def change_of_basis(self, m: int) -> FloatArray:
        """Return C, (M^2, m^2) float64: the integrals of tents times harmonics [LK03 eq. 7].

        Parameters
        ----------
        m : int
            Order of the harmonics, degrees 0 to m - 1, in [1, 32]; the real basis of `shrm.sh`.
        """
        return _change_of_basis(self.M, whole_number("m", m, 1, MOST_ORDER)).copy()

    def project(self, function: Callable[[FloatArray], FloatArray], points: int = 10) -> FloatArray:
        """Project a function of direction on the tents, orthogonally [LK03 appendix A].

        Parameters
        ----------
        function : callable
            Directions (n, 3) float64, above the horizon, to (n,) or (n, channels).
        points : int
            Nodes along each side of the triangles of `quadrature`.

        Returns
        -------
        (M^2, channels) float64
        """
        directions, weights = self.quadrature(points)
        values = columns(real_array("values of the function", function(directions)))
        return self.solve(self.accumulate(values * weights[:, None], directions))

    def project_coefficients(self, coefficients: npt.ArrayLike) -> FloatArray:
        """Return G^-1 C l, an expansion in harmonics projected on the tents [LK03 eq. 8].

        Parameters
        ----------
        coefficients : (m^2,) or (m^2, channels) array_like
            Coefficients in the real basis of `shrm.sh`.

        Returns
        -------
        (M^2, channels) float64
        """
        array = real_array("coefficients", coefficients, ("m^2",), ("m^2", "channels"), empty=False)
        rows = array[:, None] if array.ndim == 1 else array
        return self.solve(self.change_of_basis(sh.degree_of(rows) + 1) @ rows)

    def coarser(self, M: int) -> FloatArray:
        """Return the matrix that projects expansions in these tents on fewer, orthogonally and exactly.

        The concentric map preserves area, so that the integrals of products of tents of two spacings are
        2 pi X (x) X with those X of one dimension, and the projection is G1^-1 X (x) G1^-1 X
        [LK03 appendix A].

        Parameters
        ----------
        M : int
            Tents along each side of the coarser basis, 2 to this one's M.

        Returns
        -------
        (M'^2, M^2) float64
            Coefficients in the coarser basis from those in this one.

        Raises
        ------
        TypeError, ValueError
            If M is no whole number in its range.
        """
        M = whole_number("M", M, 2, self.M)
        along = np.linalg.solve(gram_of_one_dimension(M), _products_of_one_dimension(M, self.M))
        return np.asarray(np.kron(along, along))

    # ---- Its error

    def error_matrix(self, m: int) -> FloatArray:
        """Return E, (m^2, m^2) float64: l^T E l is the squared error of projecting l [LK03 eq. 10]."""
        C = self.change_of_basis(m)
        return np.asarray(hemispherical_gram(m) - C.T @ self.solve(C))

    def average_psnr(self, m: int) -> float:
        """Return the average PSNR of projecting random expansions of norm 1, in dB [LK03 section 5].

        E{l^T E l} = tr(E) / m^2 for l uniform on the sphere of m^2 dimensions, so it is 10 log10(m^2 / tr E).
        ([LK03] eq. 11 has this with the other sign.) Infinite for m = 1: tents hold constants exactly.
        """
        mean = float(np.trace(self.error_matrix(m))) / m**2
        return -10 * np.log10(mean) if mean > _ROUNDING else np.inf

    def _rows(self, name: str, value: npt.ArrayLike, count: int) -> FloatArray:
        """Return an array (count,) or (count, channels) as (count, channels) in C order."""
        array = real_array(name, value, (count,), (count, "channels"))
        return np.ascontiguousarray(array[:, None] if array.ndim == 1 else array)


_ROUNDING = 1e-14
"""Mean squared error below which a projection is exact but for rounding."""


def hemispherical_gram(m: int) -> FloatArray:
    """Return S = int Y Y^T over the hemisphere about +z, (m^2, m^2) float64, exactly.

    Parameters
    ----------
    m : int
        Order of the harmonics, degrees 0 to m - 1, in [1, 32].
    """
    m = whole_number("m", m, 1, MOST_ORDER)
    # Polynomials of degree 2m - 2 in z, and frequencies up to 2m - 2 in phi
    directions, weights = hemisphere_quadrature(2 * m, 2 * m)
    Y = sh.evaluate(np.eye(m * m), directions)
    return np.asarray(Y.T @ (weights[:, None] * Y))


def hemisphere_quadrature(rings: int, azimuths: int) -> tuple[FloatArray, FloatArray]:
    """Return directions (n, 3) on rings above the horizon, denser towards it, and weights (n,), steradians.

    Gauss nodes in the root of z on [0, 1], exact for polynomials of degree `rings` - 1 in z, times equal
    steps of phi, exact for frequencies below `azimuths`.
    """
    root, weight = unit_gauss(rings)
    z, weight = root * root, 2 * root * weight
    phi = 2 * np.pi / azimuths * (np.arange(azimuths) + 0.5)
    sine = np.sqrt(1 - z * z)[:, None]
    directions = np.stack(np.broadcast_arrays(sine * np.cos(phi), sine * np.sin(phi), z[:, None]), axis=-1)
    return directions.reshape(-1, 3), np.repeat(2 * np.pi / azimuths * weight, azimuths)


def gram_of_one_dimension(M: int) -> FloatArray:
    """Return G1 (M, M), G = 2 pi G1 (x) G1: h/6 [1 4 1], h = 1 / (M - 1); h/3 at the ends."""
    diagonal = np.full(M, 4.0)
    diagonal[[0, -1]] = 2.0
    neighbours = np.ones(M - 1)
    return (np.diag(diagonal) + np.diag(neighbours, 1) + np.diag(neighbours, -1)) / (6 * (M - 1))


def _products_of_one_dimension(coarse: int, fine: int) -> FloatArray:
    """Return integrals (coarse, fine) of products of tents of two spacings: Gauss between all nodes."""
    edges = np.union1d(np.linspace(0, 1, coarse), np.linspace(0, 1, fine))
    x, w = unit_gauss(2)  # exact for the squares between two nodes
    positions = (edges[:-1, None] + np.diff(edges)[:, None] * x).ravel()
    weights = (np.diff(edges)[:, None] * w).ravel()
    tents, other = (
        np.maximum(0, 1 - np.abs((M - 1) * positions - np.arange(M)[:, None])) for M in (coarse, fine)
    )
    return np.asarray((tents * weights) @ other.T)


def _square_quadrature(M: int, points: int) -> tuple[FloatArray, FloatArray]:
    """Return positions (n, 2) on the unit square, and weights (n,) that sum to 2 pi."""
    # The triangles of the cells, cut along both diagonals
    edges = np.linspace(0, 1, M)
    low = np.stack(np.meshgrid(edges[:-1], edges[:-1], indexing="xy"), axis=-1).reshape(-1, 1, 2)
    h = edges[1]
    corners = low + h * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    middles = np.broadcast_to(low + h / 2, corners.shape)
    triangles = np.stack([corners, np.roll(corners, -1, axis=1), middles], axis=2).reshape(-1, 3, 2)

    # The vertex nearest to the pole first: there all s coincide
    nearest = np.argsort(((triangles - 0.5) ** 2).sum(axis=2), axis=1, kind="stable")
    A, B, C = np.moveaxis(np.take_along_axis(triangles, nearest[..., None], axis=1), 1, 0)[:, :, None]

    # Gauss nodes in each
    x, w = unit_gauss(points)
    r, s = (grid.reshape(-1, 1) for grid in np.meshgrid(x, x, indexing="ij"))
    positions = A + r * (B - A) + r * s * (C - B)  # [D82]
    weights = r.ravel() * np.outer(w, w).ravel() * (h * h / 2)  # twice the area of a triangle is h^2 / 2
    return positions.reshape(-1, 2), 2 * np.pi * np.tile(weights, len(triangles))


@lru_cache(maxsize=8)
def _change_of_basis(M: int, m: int) -> FloatArray:
    """Return C, (M^2, m^2), see `DirectionalBasis.change_of_basis`; to be read only."""
    basis = DirectionalBasis(M)
    directions, weights = basis.quadrature(_points(m))
    return basis.accumulate(weights[:, None] * sh.evaluate(np.eye(m * m), directions), directions)


def _points(m: int) -> int:
    """Return how many Gauss points suit harmonics of order m, in cells of any size."""
    return 8 + m
