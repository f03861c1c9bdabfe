"""Tables of functions of one angle: cubics over the logarithm of sin^2(theta/2).

Such a table is read without a root, and spends its segments where a lobe is sharp. The angular width of a
lobe follows [RH02] appendix D: it is that of the integral of rho_hat, not of its square.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.cosine_power import profile_at, profile_at_angles
from shrm.brdf.peaks import NARROW, peak_of_profile

Profile = Callable[[FloatArray], FloatArray]

SUFFICIENT_ERROR = 1e-5
"""Relative RMS error below which a table grows no further: far below that of the sums it is used in."""

NODES = 65536
"""Intervals in sin(theta/2) at whose ends integrals and errors are taken: 3e-5 radians wide at the peak."""

REGISTER_SEGMENTS = 32
"""Segments of a table that the C++ core keeps in registers, which is fastest."""

IN_REGISTERS = ((8, 4), (4, 8), (16, 2))
"""Octaves of z and segments in each, of tables kept in registers: all are tried."""

IN_CACHE = ((8, 16), (8, 64), (16, 256), (16, 1024))
"""Octaves of z and segments in each, of tables read from a cache: tried in turn until the error suffices."""

NEGLIGIBLE = 1e-12
"""Fraction of a profile's largest value below which it is taken for 0: far below float32's rounding."""


@dataclass(frozen=True)
class RadialTable:
    """u(theta) as cubics of z = 1 + scale sin^2(theta/2), segments equally many to each octave of z.

    Attributes
    ----------
    values : (C, 4, segments) float32
        Coefficients of z^0 ... z^3; if there are more than 32 segments, of x instead of z, which goes from 1
        to 2 along each. The segment of z is (bits of z as float32) >> shift modulo segments, a power of two;
        the last is 0, and begins at the support.
    shift : int
        Low bits of z that do not select the segment.
    scale : float
        Factor of sin^2(theta/2) in z.
    support : float
        Angle beyond which u is 0, radians.
    outer : float
        Angle within which all but the tolerance of the integral of |u| lies, radians; pi for tolerance 0.
    width : float
        Angle within which half of that integral lies, radians.
    integral : float
        Integral of |u| over the sphere, of the largest channel.
    error : float
        Relative root mean square error over the sphere, of cubics evaluated in float32.
    """

    values: Float32Array
    shift: int
    scale: float
    support: float
    outer: float
    width: float
    integral: float
    error: float


def radial_table(profile: Profile, tolerance: float) -> RadialTable:
    """Tabulate a profile of cos(theta)."""

    def of_square(q: FloatArray) -> FloatArray:  # q = sin^2(theta/2)
        return channels_last(profile_at(profile, 1 - 2 * q, q))

    # Angles and integral of the profile, by sin(theta) d(theta) = 4 s ds
    s, share = half_sines(profile)
    u = of_square(s**2)
    outer, width = (np.pi if part == 0 else _angle_within(s, u, part) for part in (tolerance, 0.5))
    integral = float((8 * np.pi * np.abs(u) * (s * share)[:, None]).mean(axis=0).max())
    end = _support(of_square, s, u)
    support = float(np.pi) if end > 1 else float(2 * np.arcsin(np.sqrt(end)))

    # The best of the tables for registers, or the first in a cache that is exact enough
    best: RadialTable | None = None
    for octaves, each in (*IN_REGISTERS, *IN_CACHE):
        if best is not None and (best.error <= SUFFICIENT_ERROR and (octaves, each) not in IN_REGISTERS):
            break
        values, scale = _cubics(of_square, end, octaves, each)
        shift = 24 - each.bit_length()
        error = relative_rms(_radial_at(values, shift, scale, s**2), u, (s * share)[:, None])
        if best is None or error < best.error:
            best = RadialTable(values, shift, scale, support, outer, width, integral, error)
    assert best is not None
    return best


def _support(of_square: Profile, s: FloatArray, u: FloatArray) -> float:
    """Find sin^2(theta/2) beyond which a profile is negligible, by bisection; just above 1 if it never is."""
    least = NEGLIGIBLE * float(np.abs(u).max())
    above = np.nonzero(np.any(np.abs(u) > least, axis=1))[0]
    k = int(above[-1]) if len(above) else 1
    if k == len(s) - 1:
        return 1 + 1e-5
    low, high = s[k] ** 2, s[k + 1] ** 2
    for _ in range(50):
        middle = 0.5 * (low + high)
        if np.any(np.abs(of_square(np.array([middle]))) > least):
            low = middle
        else:
            high = middle
    return float(high)


def _cubics(of_square: Profile, end: float, octaves: int, each: int) -> tuple[Float32Array, float]:
    """Fit the cubics of a profile of sin^2(theta/2): coefficients (C, 4, segments) and the scale of z."""
    # Segments of z
    edges = (2.0 ** np.arange(octaves)[:, None] * (1 + np.arange(each) / each)).ravel()
    scale = (edges[-1] - 1) / end  # the last segment is 0
    low, high = edges[:-1, None], edges[1:, None]

    # Interpolation at Chebyshev's nodes in each
    x = 1.5 + 0.5 * np.cos((np.arange(4) + 0.5) * np.pi / 4)
    z = low + (high - low) * (x - 1)
    q = np.clip((z - 1) / scale, 0, min(end, 1))
    u = of_square(q.ravel()).reshape(*z.shape, -1)
    variable = z if octaves * each == REGISTER_SEGMENTS else np.broadcast_to(x, z.shape)
    coefficients = np.linalg.solve(variable[:, :, None] ** np.arange(4), u).astype(np.float32)

    # Stored where the bits of z point to: its exponent is 127 at z = 1
    table = np.zeros((octaves * each, *coefficients.shape[1:]), dtype=np.float32)
    table[(127 * each + np.arange(len(coefficients))) % len(table)] = coefficients
    return np.ascontiguousarray(table.transpose(2, 1, 0)), float(scale)


def _radial_at(values: Float32Array, shift: int, scale: float, q: FloatArray) -> FloatArray:
    """Evaluate a table at q = sin^2(theta/2) as the integrator does, (n, C)."""
    segments = values.shape[2]
    last = ((127 << (23 - shift)) + segments - 1) << shift
    z = (1 + scale * q).astype(np.float32)
    bits = z.view(np.int32)
    c = values[:, :, (np.minimum(bits, last) >> shift) % segments]
    x = (
        z
        if segments == REGISTER_SEGMENTS
        else ((bits << (23 - shift)) & 0x7FFFFF | 0x3F800000).view(np.float32)
    )
    return np.asarray((((c[:, 3] * x + c[:, 2]) * x + c[:, 1]) * x + c[:, 0]).T, dtype=np.float64)


def half_sines(profile: Profile) -> tuple[FloatArray, FloatArray]:
    """Return sin(theta/2) from 0 to 1 at which a profile is looked at, and the density of 1 / `NODES` there.

    They are uniform, of the density 1, for all but narrow lobes: for these dense about the center, with as
    many to each octave of angles outside the peak.
    """
    x, peak = np.arange(NODES + 1) / NODES, peak_of_profile(partial(profile_at_angles, profile))
    if peak >= NARROW:
        return x, np.ones_like(x)
    width = 0.5 * peak
    end = np.arcsinh(1 / width)
    return np.minimum(width * np.sinh(end * x), 1.0), width * end * np.cosh(end * x)


def integral_within(profile: Profile) -> tuple[FloatArray, FloatArray]:
    """Return angles from 0 to pi, radians, and the part of the integral of |u| that lies within each.

    A lobe that is 0 counts as one that is constant.
    """
    s, _ = half_sines(profile)
    energy = _energy_within(s, channels_last(profile_at(profile, 1 - 2 * s**2, s**2)))
    return 2 * np.arcsin(s), energy / energy[-1] if energy[-1] > 0 else s**2


def _angle_within(s: FloatArray, u: FloatArray, left_out: float) -> float:
    """Return theta_i* of [RH02] appendix D, radians, by quadrature for any profile."""
    energy = _energy_within(s, u)
    if energy[-1] == 0:
        return float(np.pi)
    k = np.searchsorted(energy, (1 - left_out) * energy[-1])
    return float(2 * np.arcsin(s[min(k, len(s) - 1)]))


def _energy_within(s: FloatArray, u: FloatArray) -> FloatArray:
    """Integrate |u| up to each angle, in any unit; sin(theta) d(theta) = 4 s ds."""
    density = np.abs(u).sum(axis=1) * s
    return np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) * np.diff(s))])


# ---- Arrays


def channels_last(values: FloatArray) -> FloatArray:
    """Return (n,) or (n, 3) values as (n, 1) or (n, 3) float64."""
    values = np.asarray(values, dtype=np.float64)
    return values[:, None] if values.ndim == 1 else values


def relative_rms(actual: FloatArray, exact: FloatArray, weight: FloatArray) -> float:
    """Return the root mean square of a difference relative to that of the exact values; 0 if these are 0."""
    total = float(np.sum(weight * exact**2))
    return float(np.sqrt(np.sum(weight * (actual - exact) ** 2) / total)) if total > 0 else 0.0
