"""BRDFs as matrices from incident to outgoing radiance, both in spherical harmonics [LK03 section 4.2].

Directions are in the frame x = tangent, z = normal. A material's row at a view V, with n^2 coefficients in
the real basis of `shrm.sh`, degrees 0 to n - 1, is its projection over the lights above the horizon,

    b_j(V) = int rho_hat(L, V) Y_j(L) dL                                        [LK03 eq. 3, views first]

so that light l of order n is reflected as sum_j b_j(V) l_j: exactly, however much of the lobe lies beyond
order n. The matrix B of the double projection [WAT92], m^2 x n^2, expands the rows in harmonics of the view:

    b_j(V) ~ sum_i Y_i(V) B_ij        outgoing radiance: B l                    [LK03 eqs. 4 to 6]

Rows exist above the horizon alone. How they are continued to the whole sphere, which is nobody's business
there, decides how well the expansion holds above:

    least-squares    as suits the expansion best: B = (S + ridge 1)^-1 int Y b, S = int Y Y^T, both integrals
                     over the hemisphere. S has a condition number of 3.5e9 at m = 8: the ridge keeps B small
    even             mirrored at the horizon; suits rows that reach it without a slope, as Lambert's
    zero             by zero
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from shrm import sh
from shrm.arrays import FloatArray
from shrm.brdf import BRDF, Lobe, require_brdf
from shrm.lobes.center import gamma_at, lobe_center
from shrm.lobes.quadrature import columns, horizon_quadrature, light_and_view
from shrm.transfer.described import Described
from shrm.transfer.directional_basis import (
    MOST_ORDER,
    DirectionalBasis,
    hemisphere_quadrature,
    hemispherical_gram,
)
from shrm.validation import one_of, require_instance, unit_vectors, whole_number

Extension = Literal["least-squares", "even", "zero"]

RIDGE = 1e-3
"""Ridge of the least squares, beside the 1 that an orthonormal basis has on the diagonal of S."""

QUADRATURE_ERROR = 1e-4
"""Error of a row by its quadrature that is accepted, over the RMS of rows."""


@dataclass(frozen=True, eq=False, repr=False)
class BRDFMatrix(Described):
    """A material as a matrix from incident to outgoing radiance; made by `project`.

    Attributes
    ----------
    coefficients : (m^2, n^2) or (3, m^2, n^2) float64
        B; three for a material whose channels differ.
    extension : {"least-squares", "even", "zero"}
        How rows were continued below the horizon.
    window_above : int or None
        The degree of the view above which a window was applied.
    snr : float
        What the expansion in the view keeps: the relative SNR, in dB, of reflected radiance over the views
        above the horizon, for random white light of order n; channels pooled. Infinite if nothing is lost.
    quadrature_error : float
        Largest difference of a row from that by twice the nodes in each dimension, among some views, over the
        RMS of the rows.
    """

    coefficients: FloatArray
    extension: Extension
    window_above: int | None
    snr: float
    quadrature_error: float


def project(
    brdf: BRDF,
    m: int,
    n: int,
    *,
    extension: Extension = "least-squares",
    window_above: int | None = None,
) -> BRDFMatrix:
    """Project a material on spherical harmonics of the view and of the light [LK03 section 4.2], [WAT92].

    Parameters
    ----------
    brdf : BRDF
        The material, anisotropic ones too. Lobes about the tangent take it as x; light below the horizon is
        left out of every lobe.
    m, n : int
        Orders of the view and of the light, degrees 0 to m - 1 and 0 to n - 1, in [1, 32].
    extension : {"least-squares", "even", "zero"}
        How the rows are continued below the horizon.
    window_above : int, optional
        Degrees of the view above this one are damped by Hann's cosine, which would be 0 at degree m, against
        ringing ([LK03 section 7]: above 5, of m = 8). It costs least squares some 8 dB, the others 1 to 2.

    Returns
    -------
    BRDFMatrix

    Warns
    -----
    RuntimeWarning
        If the quadrature does not settle to 1e-4: the lobe is too sharp.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    require_brdf(brdf)
    m, n = whole_number("m", m, 1, MOST_ORDER), whole_number("n", n, 1, MOST_ORDER)
    one_of("extension", extension, get_args(Extension))

    # The window
    damping = np.ones(m * m)
    if window_above is not None:
        damping = _window(m, whole_number("window_above", window_above, 0, m - 1))

    # Rows at the views of a quadrature
    views, weights, sampled, error = _over_hemisphere(brdf, m, n)
    _warn_of(brdf, error)
    values = np.moveaxis(sampled, 0, 1).reshape(len(views), -1)  # (views, channels n^2)

    # Their expansion, and what it leaves
    Y = sh.evaluate(np.eye(m * m), views)
    integrals = Y.T @ (weights[:, None] * values)
    B = damping[:, None] * _extended(integrals, m, extension)
    lost, energy = (float((weights @ part**2).sum()) for part in (values - Y @ B, values))
    snr = 10 * np.log10(energy / lost) if lost > 0 else np.inf
    coefficients = np.moveaxis(B.reshape(m * m, len(sampled), n * n), 1, 0)
    return BRDFMatrix(_squeezed(coefficients), extension, window_above, float(snr), error)


def rows(brdf: BRDF, views: npt.ArrayLike, n: int) -> FloatArray:
    """Return a material's coefficients for the light at given views: no expansion in the view.

    Parameters
    ----------
    brdf : BRDF
        The material, see `project`.
    views : (k, 3) array_like
        Unit vectors above the horizon, z >= 0.
    n : int
        Order of the light, degrees 0 to n - 1, in [1, 32].

    Returns
    -------
    (k, n^2) or (3, k, n^2) float64
        Rows, to some 1e-4 of their RMS; within a degree of the horizon, to some 1e-3.

    Warns
    -----
    RuntimeWarning
        If the quadrature does not settle, see `project`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    require_brdf(brdf)
    at = unit_vectors("views", views)
    if len(at) == 0:
        raise ValueError("views must be at least one, got none")
    if np.any(at[:, 2] < 0):
        raise ValueError(f"views must be above the horizon, got {int(np.sum(at[:, 2] < 0))} with z < 0")
    sampled, error = _sampled(brdf, at, whole_number("n", n, 1, MOST_ORDER))
    _warn_of(brdf, error)
    return _squeezed(sampled)


def project_on_tents(brdf: BRDF, basis: DirectionalBasis, n: int, points: int = 4) -> FloatArray:
    """Project a material straight on the tents of the directional basis, G^-1 int g(V) b(V)^T dV.

    What [LK03 section 4.3] get by way of harmonics of the view, G^-1 C B, without what those leave out.

    Parameters
    ----------
    brdf : BRDF
        The material, see `project`.
    basis : DirectionalBasis
        The tents.
    n : int
        Order of the light, degrees 0 to n - 1, in [1, 32].
    points : int
        Points of the quadrature over the views, see `DirectionalBasis.quadrature`.

    Returns
    -------
    (M^2, n^2) or (3, M^2, n^2) float64

    Warns
    -----
    RuntimeWarning
        If the quadrature does not settle, see `project`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    require_instance("basis", basis, DirectionalBasis)
    views, weights = basis.quadrature(points)
    sampled = rows(brdf, views, n)
    channels = sampled if sampled.ndim == 3 else sampled[None]
    tents = [basis.solve(basis.accumulate(weights[:, None] * channel, views)) for channel in channels]
    return _squeezed(np.stack(tents))


# ---- The view


@lru_cache(maxsize=8)
def _over_hemisphere(brdf: BRDF, m: int, n: int) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Return views (k, 3), weights (k,), rows (channels, k, n^2) and their error, for all extensions."""
    # Isotropic rows have frequencies below n about the normal; 20 more are for anisotropy.
    views, weights = hemisphere_quadrature(20 + m, 20 + m + n)
    return views, weights, *_sampled(brdf, views, n)


def _extended(integrals: FloatArray, m: int, extension: Extension) -> FloatArray:
    """Return B (m^2, columns) from the integrals of harmonics times rows over the hemisphere."""
    if extension == "least-squares":
        return np.asarray(np.linalg.solve(hemispherical_gram(m) + RIDGE * np.eye(m * m), integrals))
    if extension == "even":
        l, order = _degrees(m)
        # Y_lm (-1)^(l+m) is its mirror image at the horizon
        return np.where((l + order) % 2 == 0, 2.0, 0.0)[:, None] * integrals
    return integrals


def _window(m: int, above: int) -> FloatArray:
    """Return weights (m^2,) of harmonics: 1 to the degree `above`, then Hann's cosine."""
    l, _ = _degrees(m)
    return np.where(l > above, (1 + np.cos(np.pi * (l - above) / (m - above))) / 2, 1.0)


def _degrees(m: int) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return degrees and orders of the harmonics up to order m, (m^2,) each, at index l(l+1)+m."""
    l = np.repeat(np.arange(m), 2 * np.arange(m) + 1)
    return l, np.arange(m * m) - l * (l + 1)


# ---- The light


def _sampled(brdf: BRDF, views: FloatArray, n: int) -> tuple[FloatArray, float]:
    """Return rows (channels, k, n^2), and the largest relative error of a lobe's."""
    integrals = [_LobeRows(lobe, n) for lobe in brdf.lobes]
    error = max(integral.error for integral in integrals)
    total = np.zeros((brdf.channels, len(views), n * n))
    for integral in integrals:
        total += integral(views)  # a gray lobe adds to every channel
    return total, error


class _LobeRows:
    """The integrals of one lobe against harmonics of the light, by nodes that suit its sharpness.

    Nodes lie about the mean direction of the lobe, in panels that double in size from its width on, exact
    about the horizon. They are found for V at azimuth 0, where V and the mean direction are in the plane
    y = 0, and the lobe is turned by the azimuth of V.
    """

    def __init__(self, lobe: Lobe, n: int) -> None:
        self.lobe, self.n = lobe, n
        # Others keep their rows, but for a rotation, when the view turns about the normal.
        self.turns = lobe.kind == "anisotropic" or lobe.center == "tangent"
        self.mirrored = self.turns and _is_mirrored(lobe)
        azimuths = (0.0, np.pi / 4, np.pi / 2) if self.turns else (0.0,)
        centers = [lobe_center(partial(self._transfer, phi=phi)) for phi in azimuths]
        self.gamma = np.mean([gamma for gamma, _ in centers], axis=0)
        self.width = min(width for _, width in centers)
        self.nodes, self.error = self._settled()

    def __call__(self, views: FloatArray) -> FloatArray:
        """Return rows (channels, k, n^2) at views (k, 3)."""
        theta = np.arctan2(np.hypot(views[:, 0], views[:, 1]), views[:, 2])
        phi = np.arctan2(views[:, 1], views[:, 0])
        if self.mirrored:  # views of a quadrature are in fours: one of them is enough
            return self._folded(views)
        if self.turns:
            return _rotated_about_z(self._rows(theta, phi, self.nodes), phi)
        unique, ring = np.unique(theta, return_inverse=True)
        return _rotated_about_z(self._rows(unique, 0 * unique, self.nodes)[:, ring], phi)

    def _folded(self, views: FloatArray) -> FloatArray:
        """Return rows of a lobe that is its own mirror image in x and in y: evaluated in one quadrant."""
        distinct, which = np.unique(np.abs(views).round(_DIGITS), axis=0, return_inverse=True)
        x, y, z = distinct.T
        theta, phi = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
        in_quadrant = _rotated_about_z(self._rows(theta, phi, self.nodes), phi)[:, which.ravel()]
        # x to -x takes phi to pi - phi: cos(m phi) by (-1)^m, sin(m phi) by -(-1)^m. y to -y: phi to -phi
        order, sines = _degrees(self.n)[1] % 2 == 1, _degrees(self.n)[1] < 0
        in_x, in_y = np.where(order ^ sines, -1.0, 1.0), np.where(sines, -1.0, 1.0)
        signs = np.where(views[:, :1] < 0, in_x, 1.0) * np.where(views[:, 1:2] < 0, in_y, 1.0)
        return np.asarray(in_quadrant * signs)

    def _settled(self) -> tuple[tuple[int, int], float]:
        """Return nodes of each panel and azimuths, and what twice as many change at a view, over the RMS."""
        theta, phi = (
            grid.ravel() for grid in np.meshgrid(_SAMPLED, [0.0, 0.6, 1.2, 1.5] if self.turns else [0.0])
        )
        coarse = self._rows(theta, phi, _NODES[0])
        for level in range(1, len(_NODES)):
            fine = self._rows(theta, phi, _NODES[level])
            mean_square = (fine**2).sum() / len(theta)
            squared = ((fine - coarse) ** 2).sum(axis=(0, 2)).max()
            error = float(np.sqrt(squared / mean_square)) if mean_square > 0 else 0.0
            if error <= QUADRATURE_ERROR:
                return _NODES[level - 1], error
            coarse = fine
        return _NODES[-1], error

    def _rows(self, theta_v: FloatArray, phi_v: FloatArray, nodes: tuple[int, int]) -> FloatArray:
        """Return rows (channels, views, n^2) in frames turned by phi_v about the normal: V at azimuth 0."""
        theta_v = np.minimum(theta_v, _GRAZING)
        blocks = [slice(start, start + _BLOCK) for start in range(0, len(theta_v), _BLOCK)]
        return np.concatenate([self._block(theta_v[at], phi_v[at], nodes) for at in blocks], axis=1)

    def _block(self, theta_v: FloatArray, phi_v: FloatArray, nodes: tuple[int, int]) -> FloatArray:
        """Return the rows of `_rows` for some views, few enough for the memory of their nodes."""
        least, K = nodes
        gamma = gamma_at(self.gamma, theta_v)
        rule = horizon_quadrature(gamma, self.width, 2 * self.n, K, least)
        weight = rule.weight_theta[:, None, :] * rule.arc[:, None, :] * rule.weight_share[:, None]
        wi, wo = light_and_view(theta_v, gamma, rule, slice(None))
        Y = sh.evaluate(np.eye(self.n**2), wi).reshape(len(theta_v), -1, self.n**2)

        def weighted(lights: FloatArray) -> FloatArray:  # (channels, views, 1, nodes)
            rho = columns(self._transfer(lights, wo, np.repeat(phi_v, Y.shape[1])))
            values = rho.reshape(*Y.shape[:2], -1) * weight.reshape(*Y.shape[:2], 1)
            return np.moveaxis(values, 2, 0)[:, :, None]

        # The nodes stand for both signs of y, in which harmonics with m < 0 are odd and the others even.
        here = weighted(wi)
        mirrored = weighted(wi * np.array([1.0, -1.0, 1.0])) if self.turns else here
        odd = _degrees(self.n)[1] < 0
        return np.where(odd, (here - mirrored) @ Y, (here + mirrored) @ Y)[:, :, 0]  # [LK03] eq. 3

    def _transfer(self, wi: FloatArray, wo: FloatArray, phi: FloatArray | float) -> FloatArray:
        """Return rho_hat of directions that are turned by phi about the normal first."""
        if not self.turns:
            return self.lobe.transfer(wi, wo)
        cosine, sine = np.cos(phi), np.sin(phi)
        # About the tangent the frame has z = T: x of the frame of the normal
        order = [2, 0, 1] if self.lobe.center == "tangent" else [0, 1, 2]
        turned = []
        for w in (wi, wo):
            components = [cosine * w[:, 0] - sine * w[:, 1], sine * w[:, 0] + cosine * w[:, 1], w[:, 2]]
            turned.append(np.stack([components[order.index(k)] for k in range(3)], axis=1))
        return self.lobe.transfer(*turned)


_NODES = ((10, 16), (20, 32), (40, 64), (80, 128))
"""Nodes of a panel, and azimuths, that are tried: each twice those before."""

_SAMPLED = np.array([0.05, 0.5, 1.0, 1.3, 1.5])
"""Angles of views to the normal, in radians, at which numbers of nodes are compared."""

_GRAZING = np.pi / 2 - 1e-6
"""The largest angle of a view to the normal, in radians: rows at the horizon are those just above."""

_BLOCK = 16
"""Views whose nodes are evaluated together, so that their memory stays small."""

_DIGITS = 12
"""Decimals of the coordinates in which views count as the same: beyond are roundings of a quadrature."""


def _is_mirrored(lobe: Lobe) -> bool:
    """Tell whether a lobe stays the same when both directions, random ones, are mirrored in x, and in y."""
    rng = np.random.default_rng(0)
    wi, wo = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in rng.standard_normal((2, 64, 3)))
    # About the tangent the frame has z = T: x and y of the normal's frame are z and x
    axes = (2, 0) if lobe.center == "tangent" else (0, 1)
    flips = [1 - 2 * np.eye(3)[axis] for axis in axes]
    value = lobe.transfer(wi, wo)
    near = 1e-12 * np.abs(value).max()
    return all(np.abs(lobe.transfer(wi * flip, wo * flip) - value).max() <= near for flip in flips)


def _rotated_about_z(rows: FloatArray, phi: FloatArray) -> FloatArray:
    """Return coefficients (channels, k, n^2) of functions of the light turned by phi (k,) about z."""
    _, m = _degrees(round(np.sqrt(rows.shape[2])))
    mirrored = np.arange(len(m)) - 2 * m  # the index of (l, -m)
    # c cos(m (phi' - phi)) + s sin(m (phi' - phi)), with m of either sign
    return np.asarray(np.cos(phi[:, None] * m) * rows - np.sin(phi[:, None] * m) * rows[..., mirrored])


def _warn_of(brdf: BRDF, error: float) -> None:
    """Warn where the quadrature of a lobe did not settle."""
    if error > QUADRATURE_ERROR:
        warnings.warn(f"{brdf.name}: rows are only known to {error:.1e}", RuntimeWarning, stacklevel=3)


def _squeezed(channels: FloatArray) -> FloatArray:
    """Drop the first axis of arrays (1, ..., ...) of a gray material."""
    return np.ascontiguousarray(channels[0] if len(channels) == 1 else channels)
