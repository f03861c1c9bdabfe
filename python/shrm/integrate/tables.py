"""Tables of lobes for direct integration, and how wide a lobe is.

The C++ integrator sees a BRDF only through these tables. Each is in coordinates in which the function is
smooth: an isotropic lobe as E(theta_h) times a ratio on the box of (view, light, azimuth), whose edge is the
horizon; what depends on one angle as a `shrm.integrate.radial_table`. Each knows its own interpolation error.

The angular width of a lobe follows [RH02] appendix D: that of the integral of rho_hat, not of its square.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from shrm.arrays import BoolArray, Float32Array, FloatArray
from shrm.integrate.radial_table import RadialTable, channels_last, radial_table, relative_rms

Profile2D = Callable[[FloatArray, FloatArray], FloatArray]
Transfer = Callable[[FloatArray, FloatArray], FloatArray]

ZONAL_ROWS, ZONAL_INTERVALS = 1025, 1024
"""Rows in theta_o, and intervals in sin(theta_i / 2), of a zonal table: 4 MB for each channel."""

ENVELOPE_INTERVALS = 4096
"""Intervals in tan(theta_h / 2) of an envelope, which holds the sharpest variation of a lobe."""

VIEW_INTERVALS, LIGHT_INTERVALS, AZIMUTH_INTERVALS = 96, 128, 128
"""Intervals of the ratio of an isotropic table, which is smooth: 6 MB for each channel."""

UNRESOLVED_ERROR = 0.1
"""Relative RMS error above which a zonal table draws a warning."""

HORIZON = 1e-6
"""N.L or N.V of directions that stand for the horizon: there a lobe cut at N.L = 0 still has its value."""


def _padded(values: FloatArray, axis: int) -> FloatArray:
    """Repeat the last node, so that a look-up at the very end may read one beyond it."""
    last = np.take(values, [-1], axis=axis)
    return np.concatenate([values, last], axis=axis)


@dataclass(frozen=True)
class ZonalTable:
    """u(theta_i, theta_o), angles from an axis.

    Attributes
    ----------
    values : (rows, C, intervals + 2) float32
        Rows at theta_o = k pi / (rows - 1); each over s = sin(theta_i/2), node k at s = k / intervals, the
        last one repeated.
    bands : (rows, 2) float64
        Smallest and largest theta_i of the smallest band that holds all but the tolerance, radians.
    width : float
        Half the width of the narrowest band that holds half, radians.
    integral : float
        Integral of |u| over the lights, its mean over the sphere of views, for the largest channel.
    error : float
        Relative root mean square interpolation error over both spheres.
    """

    values: Float32Array
    bands: FloatArray
    width: float
    integral: float
    error: float

    def supports(self, negligible: float) -> FloatArray:
        """Return, (rows, 2), the smallest and the largest theta_i between which u is not negligible, radians.

        Values below `negligible` times the largest of all are; a row that has no others takes the band of the
        nearest that has.
        """
        nodes = 2 * np.arcsin(np.arange(ZONAL_INTERVALS + 1) / ZONAL_INTERVALS)
        size = np.abs(self.values[:, :, :-1]).max(axis=1)
        matters = size > negligible * size.max()
        first, last = matters.argmax(axis=1), len(nodes) - 1 - matters[:, ::-1].argmax(axis=1)
        # u goes to 0 between these nodes and those beside them, where the band ends.
        bands = np.stack(
            [nodes[np.maximum(first - 1, 0)], nodes[np.minimum(last + 1, len(nodes) - 1)]], axis=1
        )
        return _with_neighbors(bands, matters.any(axis=1))


def zonal_table(profile: Profile2D, tolerance: float) -> ZonalTable:
    """Tabulate a profile of theta_i, theta_o, with bands that hold all but `tolerance` of it."""
    # The profile at the nodes, and the bands that hold most of each row
    s = np.arange(ZONAL_INTERVALS + 1) / ZONAL_INTERVALS
    theta_i = 2 * np.arcsin(s)
    theta_o = np.linspace(0, np.pi, ZONAL_ROWS)
    grid_o, grid_i = np.meshgrid(theta_o, theta_i, indexing="ij")
    u = channels_last(profile(grid_i.ravel(), grid_o.ravel())).reshape(ZONAL_ROWS, len(s), -1)
    bands = np.array([_smallest_band(s, row, tolerance) for row in u])
    if tolerance > 0:
        bands = _with_neighbors(bands, np.any(u, axis=(1, 2)))
    half = np.array([_smallest_band(s, row, 0.5) for row in u[:: ZONAL_ROWS // 16]])

    def between(values: FloatArray, axis: int) -> FloatArray:
        return 0.5 * (np.delete(values, -1, axis) + np.delete(values, 0, axis))

    # The interpolation error in the middle of every 8 x 8th cell, weighted by solid angle
    mid_o, mid_s = between(theta_o, 0)[::8], between(s, 0)[::8]
    go, gs = np.meshgrid(mid_o, mid_s, indexing="ij")
    exact = channels_last(profile(2 * np.arcsin(gs.ravel()), go.ravel()))
    linear = between(between(u, 0), 1)[::8, ::8].reshape(exact.shape)
    weight = (np.sin(go) * gs).ravel()[:, None]
    error = relative_rms(linear, exact, weight)
    values = np.ascontiguousarray(_padded(u.transpose(0, 2, 1), axis=2).astype(np.float32))
    if error > UNRESOLVED_ERROR:
        warnings.warn(
            f"a lobe about its center is narrower than what its table resolves: it is off by {error:.0%}",
            stacklevel=2,
        )

    # The integral, by sin(theta) d(theta) = 4 s ds
    over_lights = 8 * np.pi * np.einsum("osc,s->oc", np.abs(u), s) / len(s)
    integral = float(np.average(over_lights, axis=0, weights=np.sin(theta_o)).max())
    return ZonalTable(values, bands, float(np.min(half[:, 1] - half[:, 0]) / 2), integral, error)


def _with_neighbors(bands: FloatArray, has_values: BoolArray) -> FloatArray:
    """Return bands (rows, 2) in which rows without values take the band of the nearest row with some."""
    rows = np.flatnonzero(has_values)
    if not len(rows):
        return np.zeros_like(bands)
    nearest = np.abs(np.arange(len(bands))[:, None] - rows).argmin(axis=1)
    return np.asarray(bands[rows[nearest]])


def _smallest_band(s: FloatArray, u: FloatArray, left_out: float) -> tuple[float, float]:
    """Return the ends, radians, of the band of smallest solid angle that holds all but a part of a row."""
    density = np.abs(u).sum(axis=1) * s
    energy = np.concatenate([[0], np.cumsum(density[1:] + density[:-1])])
    if left_out == 0 or energy[-1] == 0:
        return 0.0, float(np.pi)

    # For each node a band may begin at, the first node where it may end; the smallest of these bands
    first = np.arange(np.searchsorted(energy, left_out * energy[-1], side="right"))
    last = np.searchsorted(energy, energy[first] + (1 - left_out) * energy[-1] * (1 - 1e-12))
    last = np.minimum(last, len(s) - 1)
    k = int(np.argmin(s[last] ** 2 - s[first] ** 2))
    inner = float(2 * np.arcsin(s[first[k]]))
    return inner, float(2 * np.arcsin(s[last[k]]))


@dataclass(frozen=True)
class HalfAngleTable:
    """rho_hat = u(theta_h) where N.L > 0, theta_h the angle between N and the half vector.

    Attributes
    ----------
    radial : RadialTable
        The function u, one channel.
    caps, width, error
        The same as those of an `IsotropicTable`.
    """

    radial: RadialTable
    caps: FloatArray
    width: float
    error: float


def half_angle_table(transfer: Transfer, tolerance: float) -> HalfAngleTable | None:
    """Tabulate a lobe in the frame of its normal if it depends on the half angle alone [RH02 eq. 11]."""

    def profile(cosine: FloatArray) -> FloatArray:  # light and view both along H
        cosine = np.asarray(cosine, dtype=np.float64)
        z = np.maximum(cosine, HORIZON)
        h = np.stack([np.sqrt(1 - np.minimum(z, 1) ** 2), np.zeros_like(z), z], axis=-1)
        return np.where(cosine >= 0, transfer(h, h), 0.0)

    # Compared with the lobe itself over the lights, at every eighth view node
    for cos_v in np.cos(view_nodes()[::8]):
        wi, _ = light_quadrature(cos_v)
        view = view_at(cos_v, len(wi))
        value = np.asarray(transfer(wi, view))
        if value.ndim > 1:
            return None
        h = wi + view
        u = profile(h[:, 2] / np.linalg.norm(h, axis=1))
        if np.abs(value - u).max() > 1e-7 * np.abs(u).max():
            return None

    caps = np.array([cap_at(transfer, cos_v, tolerance) for cos_v in np.cos(view_nodes())])
    radial = radial_table(profile, 0.0)
    width = cap_at(transfer, np.sqrt(0.5), 0.5)[1]
    return HalfAngleTable(radial, caps, width, radial.error)


@dataclass(frozen=True)
class IsotropicTable:
    """rho_hat(view, light) = E(theta_h) * ratio, exactly zero for N.L <= 0.

    Attributes
    ----------
    envelope : (intervals + 2,) float32
        E at tan(theta_h / 2) = k / intervals: the mean of the lobe at that half angle.
    ratio : (views, C, lights + 2, azimuths + 2) float32
        Uniform in 1 - sqrt(1 - theta_v 2/pi) of the view, in sqrt(1 - sqrt(N.L)) of the light (both dense
        towards the horizon) and in (1 - x / (|x| + |y|)) / 2 of the azimuth between them.
    caps : (views, 2) float64
        For each view, the lobe's mean direction as an angle from the normal, away from the view, and the
        angle about it within which all but the tolerance of the lobe's integral lies (pi for tolerance 0).
    width : float
        Angle within which half of the integral lies for a view at 45 degrees, radians.
    integral : float
        Integral of |rho_hat| over the lights, its mean over views of cos^2(theta_v) uniform, for the largest
        channel.
    error : float
        Relative root mean square interpolation error of rho_hat over lights and views.
    """

    envelope: Float32Array
    ratio: Float32Array
    caps: FloatArray
    width: float
    integral: float
    error: float


def isotropic_table(transfer: Transfer, tolerance: float) -> IsotropicTable:
    """Tabulate a lobe in the frame of its normal."""
    envelope = _envelopes(transfer, ENVELOPE_INTERVALS, of_channels=False)
    caps, integral = caps_and_integral(transfer, tolerance)
    table = IsotropicTable(
        envelope=_padded(envelope[0], axis=0).astype(np.float32),
        ratio=_ratio(transfer, envelope),
        caps=caps,
        width=cap_at(transfer, np.sqrt(0.5), 0.5)[1],
        integral=integral,
        error=0.0,
    )
    return replace(table, error=_isotropic_error(table, transfer))


def channel_tables(transfer: Transfer) -> tuple[Float32Array, Float32Array]:
    """Tabulate a lobe that may be narrower than what an `IsotropicTable` resolves.

    The envelope, (channels, intervals + 2), has eight times as many intervals and one row for each channel:
    highlights of different widths have no ratio to their mean that a few hundred directions tell. The ratio
    is of the shape of an `IsotropicTable`'s.
    """
    envelopes = _envelopes(transfer, 8 * ENVELOPE_INTERVALS, of_channels=True)
    envelope = np.ascontiguousarray(_padded(envelopes, axis=1).astype(np.float32))
    return envelope, _ratio(transfer, envelopes)


ENVELOPE_NEGLIGIBLE = 4e-12
"""Fraction of an envelope's largest value below which it is taken for 0: four times the floor it is given."""


def _ratio(transfer: Transfer, envelopes: FloatArray) -> Float32Array:
    """Divide a lobe by its envelopes, (1 or channels, intervals + 1)."""
    light = _light_nodes()
    planes = []
    for cos_v in np.cos(view_nodes()):
        view = view_at(cos_v, len(light))
        enveloped = np.stack([_envelope_at(envelope, light, view) for envelope in envelopes], axis=1)
        # Where the envelope is negligible, as where a material has no measurements, so is the lobe.
        matters = enveloped > ENVELOPE_NEGLIGIBLE * envelopes.max(axis=1)
        value = channels_last(transfer(light, view))
        plane = np.where(matters, value / enveloped, 0.0)
        planes.append(plane.T.reshape(-1, LIGHT_INTERVALS + 1, AZIMUTH_INTERVALS + 1))
    ratio = _padded(_padded(np.array(planes), axis=2), axis=3)
    return np.ascontiguousarray(ratio.astype(np.float32))


def caps_and_integral(transfer: Transfer, tolerance: float) -> tuple[FloatArray, float]:
    """Return the caps and the integral of a lobe, as its `IsotropicTable` has them, without the table."""
    caps = np.array([cap_at(transfer, cos_v, tolerance) for cos_v in np.cos(view_nodes())])
    return caps, _mean_integral(transfer)


def view_place(cos_v: FloatArray) -> FloatArray:
    """Return the place of a view among the view nodes, in [0, VIEW_INTERVALS]."""
    return VIEW_INTERVALS * (1 - np.sqrt(np.arcsin(np.clip(cos_v, 0, 1)) * 2 / np.pi))


def view_nodes() -> FloatArray:
    """Return the angles theta_v of the view nodes, from 0 to the horizon, radians."""
    return np.pi / 2 * (1 - (1 - np.arange(VIEW_INTERVALS + 1) / VIEW_INTERVALS) ** 2)


def light_quadrature(cos_v: float, n_theta: int = 96, n_phi: int = 40) -> tuple[FloatArray, FloatArray]:
    """Return lights above the horizon and their solid angles, dense about the mirror direction.

    Nodes are half vectors, theta_h = t^2 pi/2 with Gauss nodes t; d(omega_i) = 4 (V.H) d(omega_h). Only
    half of the lights, phi in [0, pi], with weights for both halves.
    """
    # Nodes of the half vector
    x, w = _gauss(n_theta)
    t = 0.5 * (1 + x)
    theta = t**2 * np.pi / 2
    w_theta = w * 0.5 * t * np.pi * np.sin(theta)
    y, w_y = _gauss(n_phi)
    phi, w_phi = 0.5 * (1 + y) * np.pi, w_y * np.pi / 2
    a, b = np.meshgrid(theta, phi, indexing="ij")
    h = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=-1).reshape(-1, 3)

    # The lights that it mirrors the view to
    v = view_at(cos_v, 1)[0]
    vh = h @ v
    wi = 2 * vh[:, None] * h - v
    weight = np.outer(w_theta, w_phi).ravel() * 8 * vh
    valid = (vh > 0) & (wi[:, 2] > HORIZON)
    return wi[valid], weight[valid]


@cache
def _gauss(n: int) -> tuple[FloatArray, FloatArray]:
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return nodes, weights


def view_at(cos_v: float, n: int) -> FloatArray:
    """Return a view in the x-z plane n times, (n, 3); just above the horizon if it lies on it."""
    cos_v = max(cos_v, HORIZON)
    return np.tile([np.sqrt(1 - cos_v**2), 0.0, cos_v], (n, 1))


def _light_nodes() -> FloatArray:
    """Return the directions of the light at the nodes of the ratio, light major, azimuth minor."""
    u = np.arange(LIGHT_INTERVALS + 1) / LIGHT_INTERVALS
    cosine = np.maximum((1 - u**2) ** 2, HORIZON)[:, None]
    sine = np.sqrt(1 - cosine**2)
    # x / (|x| + |y|) = 1 - 2 k / intervals on the diamond |x| + |y| = 1.
    x = 1 - 2 * np.arange(AZIMUTH_INTERVALS + 1) / AZIMUTH_INTERVALS
    y = 1 - np.abs(x)
    r = np.hypot(x, y)
    parts = np.broadcast_arrays(sine * x / r, sine * y / r, cosine)
    return np.stack(parts, axis=-1).reshape(-1, 3)


def _envelopes(transfer: Transfer, intervals: int, *, of_channels: bool) -> FloatArray:
    """Return the mean of a lobe at each half angle, (1 or channels, intervals + 1).

    The mean is over L and V at equal heights on both sides of H, and over channels unless `of_channels`. At
    such difference angles (phi_d = 90 degrees) the horizon never cuts in, so the mean is smooth.
    """
    theta_h = 2 * np.arctan(np.arange(intervals + 1) / intervals)
    theta_h = np.minimum(theta_h, np.pi / 2 - HORIZON)
    h = np.stack([np.sin(theta_h), np.zeros_like(theta_h), np.cos(theta_h)], axis=-1)
    mean = np.zeros(1)
    for theta_d in np.linspace(0, np.pi / 2, 12, endpoint=False):
        across = np.array([0.0, np.sin(theta_d), 0.0])
        rho = np.abs(channels_last(transfer(np.cos(theta_d) * h + across, np.cos(theta_d) * h - across)))
        mean = mean + (rho if of_channels else rho.mean(axis=1, keepdims=True)) / 12
    return np.asarray(np.maximum(mean, np.maximum(1e-12 * mean.max(axis=0), np.finfo(np.float32).tiny)).T)


def _envelope_at(envelope: FloatArray, wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Interpolate an envelope at the half angles of directions (n, 3)."""
    h = wi + wo
    across = np.hypot(h[:, 0], h[:, 1])
    half = across / (h[:, 2] + np.hypot(across, h[:, 2]))
    return np.interp(half * (len(envelope) - 1), np.arange(len(envelope)), envelope)


def _mean_angle(wi: FloatArray, energy: FloatArray) -> float:
    """Return the angle of the mean direction from the normal, away from a view at azimuth 0; NaN if black."""
    x, z = energy @ wi[:, 0], energy @ wi[:, 2]
    return float(np.arctan2(-x, z)) if x != 0 or z != 0 else float("nan")


def cap_at(transfer: Transfer, cos_v: float, left_out: float) -> tuple[float, float]:
    """Return a lobe's center for a view, and the angle about it that holds all but a part of its integral."""
    wi, weight = light_quadrature(cos_v)
    energy = weight * np.abs(channels_last(transfer(wi, view_at(cos_v, len(wi))))).sum(axis=1)
    center = _mean_angle(wi, energy)
    if left_out == 0 or not energy.sum() > 0:
        return 0.0, float(np.pi)
    cosine = wi @ np.array([-np.sin(center), 0, np.cos(center)])
    order = np.argsort(-cosine)
    within = np.cumsum(energy[order])
    k = min(int(np.searchsorted(within, (1 - left_out) * within[-1])), len(order) - 1)
    return center, float(np.arccos(np.clip(cosine[order[k]], -1, 1)))


def _mean_integral(transfer: Transfer) -> float:
    """Integrate |rho_hat| over the lights; the mean over views of cos^2(theta_v) uniform, largest channel."""
    of_views = []
    for c2 in (np.arange(8) + 0.5) / 8:
        wi, weight = light_quadrature(np.sqrt(c2))
        of_views.append(weight @ np.abs(channels_last(transfer(wi, view_at(np.sqrt(c2), len(wi))))))
    return float(np.mean(of_views, axis=0).max())


def _isotropic_error(table: IsotropicTable, transfer: Transfer) -> float:
    """Measure a table against its lobe, relative RMS: at views between nodes, at lights where the lobe is."""
    squared_error = total = 0.0
    for c2 in (np.arange(24) + 0.47) / 24:
        wi, weight = light_quadrature(np.sqrt(c2), 61, 31)
        exact = channels_last(transfer(wi, view_at(np.sqrt(c2), len(wi))))
        squared_error += float(weight @ np.sum((_evaluate(table, wi, np.sqrt(c2)) - exact) ** 2, axis=1))
        total += float(weight @ np.sum(exact**2, axis=1))
    return float(np.sqrt(squared_error / total)) if total > 0 else 0.0


def _evaluate(table: IsotropicTable, wi: FloatArray, cos_v: float) -> FloatArray:
    """Evaluate a table for a view as the integrator does, (n, C)."""
    # The ratio: linear in view, light and azimuth
    place = float(view_place(np.asarray(cos_v)))
    k = min(int(place), VIEW_INTERVALS - 1)
    t = place - k
    plane = table.ratio[k] * (1 - t) + table.ratio[k + 1] * t
    xl = LIGHT_INTERVALS * np.sqrt(1 - np.sqrt(wi[:, 2]))
    xa = AZIMUTH_INTERVALS * (0.5 - 0.5 * wi[:, 0] / (np.abs(wi[:, 0]) + np.abs(wi[:, 1]) + 1e-30))
    kl, ka = xl.astype(int), xa.astype(int)
    tl, ta = xl - kl, xa - ka
    low = plane[:, kl, ka] * (1 - ta) + plane[:, kl, ka + 1] * ta
    high = plane[:, kl + 1, ka] * (1 - ta) + plane[:, kl + 1, ka + 1] * ta

    # Times the envelope at the half angle
    e = _envelope_at(table.envelope[:-1].astype(np.float64), wi, view_at(cos_v, len(wi)))
    return np.asarray((e * (low * (1 - tl) + high * tl)).T)
