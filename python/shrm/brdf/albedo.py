"""The directional albedo of a material, by float64 quadrature of its transfer function.

    a(theta_v) = integral of rho_hat(L, V) over all L

It is what a white furnace shows: the radiance reflected to V under an environment of radiance 1
everywhere. (The integral is over the sphere; rho_hat is zero below the horizon where the model has
one.)

Each lobe is integrated in polar coordinates about its own axis, with Gauss-Legendre panels that
shrink geometrically towards the places where lobes peak and break at the places where they end:

    radial      about C: one integral over theta_i, panels halving towards 0 and pi/2
    zonal       about C: one integral over theta_i, panels halving towards 0, theta_o and pi - theta_o
    isotropic   about R: panels halve towards theta = 0; the range of phi at each theta is the
                part above the horizon, known in closed form, with panels halving towards its ends
    anisotropic about N: panels of theta and phi halve towards R, in theta up to the horizon; a narrow one
                over the slopes of half vectors, in steps that grow with them

The number of nodes per panel is doubled until the result keeps to 1e-8, and panels are halved more often
where that does not suffice: a narrow lobe is a thousand times as long as wide at grazing views.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache, partial

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.brdf.cosine_power import profile_at_angles
from shrm.brdf.lobe import AnisotropicLobe, IsotropicLobe, Lobe, RadialLobe, ZonalLobe
from shrm.brdf.material import BRDF, require_brdf
from shrm.brdf.peaks import LADDER, peak_width, with_support
from shrm.validation import number, real_array

_HALVINGS = 22
"""Halvings of the panels towards a peak: the smallest, pi / 2^22, is below the narrowest lobe allowed."""

_MORE = 12
"""Further halvings where these do not suffice: for such a lobe seen a thousandth of a radian from grazing."""

_HALVINGS_2D = 12
"""Halvings where panels halve in two dimensions at once, to 7e-4 radians: nodes grow with the square."""

_SMALLEST_SLOPE = 1.5e-3
"""Slope of half vectors that panels in two dimensions resolve: narrower peaks have nodes of their own."""

_LARGEST_SLOPE = 1e3
"""Slope of half vectors at which these nodes end, a thousandth of a radian from the horizon."""

_HALVINGS_AZIMUTH = 9
"""Halvings of the panels of azimuth towards both ends."""

_TOLERANCE = 1e-8
"""Relative change on doubling the nodes below which an integral is taken: a hundredth of what is promised."""


def directional_albedo(brdf: BRDF, cos_theta_v: npt.ArrayLike, phi_v: float = 0.0) -> FloatArray:
    """Integrate a material's transfer function over all light directions.

    Parameters
    ----------
    brdf : BRDF
        A material whose lobes share a frame.
    cos_theta_v : (n,) array_like
        N.V in [0, 1]; for a material about the tangent T.V in [-1, 1].
    phi_v : float
        Azimuth of V from the tangent, radians: only anisotropic lobes depend on it.

    Returns
    -------
    (n, channels) float64
        To 1e-6 for the built-in models, 1e-4 for anisotropic ones; a warning says where the quadrature did
        not settle to 1e-6.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as above.
    """
    require_brdf(brdf)
    cosines = real_array("cos_theta_v", cos_theta_v)
    lowest = 0.0 if brdf.frame == "normal" else -1.0
    if cosines.ndim != 1 or np.any((cosines < lowest) | (cosines > 1.0)):
        raise ValueError(
            f"cos_theta_v must have the shape (n,) and lie in [{lowest:g}, 1], got shape {cosines.shape} "
            f"from {cosines.min(initial=1.0):g} to {cosines.max(initial=0.0):g}"
        )
    azimuth = number("phi_v", phi_v)
    result = np.zeros((len(cosines), brdf.channels))
    for lobe in brdf.lobes:
        for row, cosine in enumerate(cosines):
            result[row] += _settled(lobe, float(cosine), azimuth)
    return result


def _settled(lobe: Lobe, cos_theta_v: float, phi_v: float) -> FloatArray:
    """Integrate a lobe, (1,) or (3,), with as many nodes as it takes."""
    integral = _integral_of(lobe, phi_v)
    for more in (0, _MORE):
        coarse = integral(lobe, cos_theta_v, 6, more)
        for nodes in (12, 24, 48):
            fine = integral(lobe, cos_theta_v, nodes, more)
            change = float(np.max(np.abs(fine - coarse) / np.maximum(1.0, np.abs(fine))))
            if change < _TOLERANCE:
                return fine
            coarse = fine
        if change <= 1e-6:
            break
    else:
        warnings.warn(
            f"directional albedo at cosine {cos_theta_v:g} is only known to {change:.1e}",
            RuntimeWarning,
            stacklevel=3,
        )
    return coarse


def _integral_of(lobe: Lobe, phi_v: float) -> Callable[[Lobe, float, int, int], FloatArray]:
    """Return the quadrature for a kind of lobe: of lobe, cosine, nodes per panel, halvings besides."""
    if isinstance(lobe, RadialLobe):
        return _radial
    if isinstance(lobe, AnisotropicLobe):
        return partial(_anisotropic, phi_v=phi_v)
    return _zonal if isinstance(lobe, ZonalLobe) else _isotropic


def _radial(lobe: Lobe, cos_theta_v: float, nodes: int, more: int) -> FloatArray:
    assert isinstance(lobe, RadialLobe)
    right = np.pi / 2  # where a profile in cos(theta_i) ends, as a power of it
    edges = [_halving(0.0, right, more), right - _halving(0.0, right), right + _halving(0.0, right)]
    theta, weight = _gauss(np.unique(np.concatenate(edges).clip(0.0, np.pi)), nodes)
    return _weighted(2.0 * np.pi * np.sin(theta) * weight, profile_at_angles(lobe.profile, theta))


def _zonal(lobe: Lobe, cos_theta_v: float, nodes: int, more: int) -> FloatArray:
    assert isinstance(lobe, ZonalLobe)
    theta_o = float(lobe.theta_o(np.arccos(np.array(cos_theta_v))))
    # A profile may be cut off at any angle: many even panels besides the graded ones.
    edges = [np.linspace(0.0, np.pi, 4097)]
    for peak in {theta_o, np.pi - theta_o, 0.0}:
        edges += [peak - _halving(0.0, np.pi, more), peak + _halving(0.0, np.pi, more)]
        edges.append(np.array([peak - np.pi / 2, peak + np.pi / 2]))
    breaks = np.unique(np.concatenate(edges))
    breaks = breaks[(breaks >= 0.0) & (breaks <= np.pi)]
    if more:
        breaks = np.unique(with_support(lobe.profile, np.array([theta_o]), breaks[None]))
    theta, weight = _gauss(breaks, nodes)
    values = lobe.profile(theta, np.full_like(theta, theta_o))
    return _weighted(2.0 * np.pi * np.sin(theta) * weight, values)


def _isotropic(lobe: Lobe, cos_theta_v: float, nodes: int, more: int) -> FloatArray:
    assert isinstance(lobe, IsotropicLobe)
    sin_v = np.sqrt((1.0 - cos_theta_v) * (1.0 + cos_theta_v))
    elevation = np.arctan2(cos_theta_v, sin_v)  # of R above the horizon
    end = np.pi - elevation  # of the hemisphere, as seen from R; all azimuths are in it up to `elevation`

    # Nodes in theta, the angle from R
    edges = [
        _halving(0.0, np.pi / 2, more),
        elevation - _halving(0.0, elevation)[-12:],  # the range of phi has square roots at both ends
        elevation + _halving(0.0, end - elevation)[-12:],
        end - _halving(0.0, end - elevation)[-12:],
        np.array([elevation, end]),
    ]
    theta, theta_weight = _gauss(np.unique(np.concatenate(edges).clip(0.0, end)), nodes)

    # Nodes in phi: in the frame of R, N is at angle theta_v, azimuth 0, and N.L > 0 where cos(phi) > limit.
    with np.errstate(divide="ignore", over="ignore"):
        limit = -np.divide(cos_theta_v, sin_v) / np.tan(theta)
    widest = (
        np.arccos(np.clip(limit, -1.0, 1.0)) if sin_v > 0.0 else np.where(np.cos(theta) > 0.0, np.pi, 0.0)
    )
    half = _halving(0.0, 0.5)[-_HALVINGS_AZIMUTH - more :]
    part, part_weight = _gauss(np.unique(np.concatenate([[0.0], half, 1.0 - half, [1.0]])), nodes)
    phi = widest[:, None] * part

    # L in the frame of N, where R = (-sin_v, 0, cos_v) and the axis of azimuth 0 leads from R towards N
    sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None]
    x, y, z = sine * np.cos(phi), sine * np.sin(phi), cosine + 0.0 * phi
    wi = np.stack([cos_theta_v * x - sin_v * z, y, sin_v * x + cos_theta_v * z], axis=-1).reshape(-1, 3)
    wo = np.broadcast_to([sin_v, 0.0, cos_theta_v], wi.shape)
    weight = 2.0 * (theta_weight * np.sin(theta) * widest)[:, None] * part_weight  # 2: phi and -phi
    return _weighted(weight.ravel(), lobe.transfer(wi, np.ascontiguousarray(wo)))


def _anisotropic(lobe: Lobe, cos_theta_v: float, nodes: int, more: int, *, phi_v: float) -> FloatArray:
    view = _direction(cos_theta_v, phi_v)
    widths = _slope_widths(lobe, view)
    if min(widths) < _SMALLEST_SLOPE:
        return _over_slopes(lobe, view, widths, 2 * nodes)
    sin_v = np.sqrt((1.0 - cos_theta_v) * (1.0 + cos_theta_v))
    theta_v = np.arctan2(sin_v, cos_theta_v)

    # Nodes in theta, broken at theta_v, where [AS00]'s max(N.L, N.V) has a kink, and at the horizon
    below, above = (
        theta_v - _halving(0.0, theta_v)[-_HALVINGS_2D:],
        theta_v + _halving(0.0, np.pi / 2 - theta_v),
    )
    theta, theta_weight = _gauss(
        np.unique(np.concatenate([[0.0], below, above[-_HALVINGS_2D:], [theta_v]])), nodes
    )
    half = _halving(0.0, np.pi)[-_HALVINGS_2D:]
    phi, phi_weight = _gauss(np.concatenate([-half[::-1], [0.0], half]), nodes)
    phi = phi + (phi_v + np.pi)  # from the azimuth of R

    # L and V in the frame of N
    sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None] + 0.0 * phi
    wi = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1).reshape(-1, 3)
    weight = (theta_weight * np.sin(theta))[:, None] * phi_weight
    return _weighted(weight.ravel(), lobe.transfer(wi, np.tile(view, (len(wi), 1))))


def _direction(cosine: float, phi: float) -> FloatArray:
    """Return the unit vector (3,) of that cosine and azimuth."""
    sine = np.sqrt((1.0 - cosine) * (1.0 + cosine))
    return np.array([sine * np.cos(phi), sine * np.sin(phi), cosine])


def _over_slopes(lobe: Lobe, view: FloatArray, widths: tuple[float, float], steps: int) -> FloatArray:
    """Integrate over half vectors (x, y, 1) / length, trapezoidal in u: x = width sinh(u), and so in y."""
    ends = [float(np.arcsinh(_LARGEST_SLOPE / width)) for width in widths]
    u, v = (end * np.linspace(-1.0, 1.0, 2 * steps * int(np.ceil(end)) // 4 + 1) for end in ends)
    x, y = np.meshgrid(widths[0] * np.sinh(u), widths[1] * np.sinh(v), indexing="ij")
    area = np.outer(widths[0] * np.cosh(u) * (u[1] - u[0]), widths[1] * np.cosh(v) * (v[1] - v[0]))
    wi, weight = _mirrored(np.stack([x.ravel(), y.ravel()], axis=1), view)
    return _weighted(weight * area.ravel(), lobe.transfer(wi, np.tile(view, (len(wi), 1))))


def _mirrored(slopes: FloatArray, view: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return lights (n, 3) for a view and slopes of half vectors (n, 2), and solid angles by d(slopes)."""
    length2 = 1.0 + slopes[:, 0] ** 2 + slopes[:, 1] ** 2
    h = np.concatenate([slopes, np.ones((len(slopes), 1))], axis=1) / np.sqrt(length2)[:, None]
    cos_d = h @ view
    # d(omega_i) = 4 V.H d(omega_h), d(omega_h) = cos^3(theta_h) d(slopes)
    return 2.0 * cos_d[:, None] * h - view, 4.0 * np.maximum(cos_d, 0.0) * length2**-1.5


def _slope_widths(lobe: Lobe, view: FloatArray) -> tuple[float, float]:
    """Return slopes along the tangent and across within which a lobe keeps 2/3, at most 1."""

    def width(axis: int) -> float:
        slopes = np.zeros((len(LADDER), 2))
        slopes[:, axis] = LADDER
        paths = [_mirrored(sign * slopes, view)[0] for sign in (-1.0, 1.0)]
        values = lobe.transfer(np.concatenate(paths), np.tile(view, (2 * len(LADDER), 1)))
        return min(peak_width(values.reshape(2, len(LADDER), -1).swapaxes(0, 1)), 1.0)

    return width(0), width(1)


def _weighted(weight: FloatArray, values: FloatArray) -> FloatArray:
    """Sum values (n,) or (n, 3) with weights (n,), to (1,) or (3,)."""
    return weight @ (values if values.ndim == 2 else values[:, None])


def _halving(start: float, end: float, more: int = 0) -> FloatArray:
    """Return edges from start to end, each interval from start half of the next, `more` than usual."""
    return start + (end - start) * np.concatenate([[0.0], 0.5 ** np.arange(_HALVINGS + more, -1, -1)])


def _gauss(breaks: FloatArray, nodes: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights of Gauss-Legendre quadrature on every interval between the breaks."""
    x, w = _legendre(nodes)
    width = np.diff(breaks)[:, None]
    points = breaks[:-1, None] + width * (0.5 * (x + 1.0))
    return points.ravel(), (0.5 * width * w).ravel()


@cache
def _legendre(nodes: int) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(nodes)
    return x, w
