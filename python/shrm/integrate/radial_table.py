"""Tables of functions of one angle: cubics over the logarithm of sin^2(theta/2).

That needs no root, and spends its segments where a lobe is sharp. The angular width of a lobe follows
Ramamoorthi & Hanrahan, "Frequency Space Environment Map Rendering", ACM TOG 21(3), 2002 ([RH02]), appendix D:
the integral of rho_hat, not of its square.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from shrm.arrays import Float32Array, FloatArray

Profile = Callable[[FloatArray], FloatArray]

# Tables grow until their error, at so many angles, is below this, or they are as large as a cache.
WANTED_ERROR = 1e-5
NODES = 65536

# Octaves of z and the segments in each. C++ keeps 32 segments in registers.
HELD_SEGMENTS = 32
HELD = ((8, 4), (4, 8), (16, 2))
LOOKED_UP = ((8, 16), (8, 64), (16, 256), (16, 1024))

NEGLIGIBLE = 1e-12
"""Values of a profile below this part of its largest are taken for 0: far below float32's rounding."""


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
        Bits of z that do not tell the segment.
    scale : float
        Of z.
    support : float
        Angle beyond which u is 0.
    outer : float
        Angle within which all but the tolerance of the integral of |u| lies, pi for tolerance 0.
    width : float
        Angle within which half of it lies.
    integral : float
        Of |u| over the sphere, of the largest channel.
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
        return channels_last(profile(1 - 2 * q))

    s = np.arange(NODES + 1) / NODES
    u = of_square(s**2)
    outer, width = (np.pi if part == 0 else _angle_within(s, u, part) for part in (tolerance, 0.5))
    # sin(theta) d(theta) = 4 s ds
    integral = float((8 * np.pi * np.abs(u) * s[:, None]).mean(axis=0).max())
    end = _support(of_square, s, u)
    support = float(np.pi) if end > 1 else float(2 * np.arcsin(np.sqrt(end)))
    best: RadialTable | None = None
    for octaves, each in (*HELD, *LOOKED_UP):
        if best is not None and (best.error <= WANTED_ERROR and (octaves, each) not in HELD):
            break
        values, scale = _cubics(of_square, end, octaves, each)
        shift = 24 - each.bit_length()
        error = relative_rms(_radial_at(values, shift, scale, s**2), u, s[:, None])
        if best is None or error < best.error:
            best = RadialTable(values, shift, scale, support, outer, width, integral, error)
    assert best is not None
    return best


def _support(of_square: Profile, s: FloatArray, u: FloatArray) -> float:
    """sin^2(theta/2) beyond which a profile is nothing, by bisection; just above 1 if there is none."""
    least = NEGLIGIBLE * float(np.abs(u).max())
    there = np.nonzero(np.any(np.abs(u) > least, axis=1))[0]
    k = int(there[-1]) if len(there) else 1
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
    """Coefficients (C, 4, segments) and the scale."""
    edges = (2.0 ** np.arange(octaves)[:, None] * (1 + np.arange(each) / each)).ravel()
    scale = (edges[-1] - 1) / end  # the last segment is 0
    low, high = edges[:-1, None], edges[1:, None]
    # interpolation at Chebyshev's nodes
    x = 1.5 + 0.5 * np.cos((np.arange(4) + 0.5) * np.pi / 4)
    z = low + (high - low) * (x - 1)
    q = np.clip((z - 1) / scale, 0, min(end, 1))
    u = of_square(q.ravel()).reshape(*z.shape, -1)
    variable = z if octaves * each == HELD_SEGMENTS else np.broadcast_to(x, z.shape)
    coefficients = np.linalg.solve(variable[:, :, None] ** np.arange(4), u).astype(np.float32)
    table = np.zeros((octaves * each, *coefficients.shape[1:]), dtype=np.float32)
    # where the bits of a float point to: its exponent is 127 at z = 1
    table[(127 * each + np.arange(len(coefficients))) % len(table)] = coefficients
    return np.ascontiguousarray(table.transpose(2, 1, 0)), float(scale)


def _radial_at(values: Float32Array, shift: int, scale: float, q: FloatArray) -> FloatArray:
    """What the integrator computes, (n, C)."""
    segments = values.shape[2]
    last = ((127 << (23 - shift)) + segments - 1) << shift
    z = (1 + scale * q).astype(np.float32)
    bits = z.view(np.int32)
    c = values[:, :, (np.minimum(bits, last) >> shift) % segments]
    x = z if segments == HELD_SEGMENTS else ((bits << (23 - shift)) & 0x7FFFFF | 0x3F800000).view(np.float32)
    return np.asarray((((c[:, 3] * x + c[:, 2]) * x + c[:, 1]) * x + c[:, 0]).T, dtype=np.float64)


def integral_within(profile: Profile) -> tuple[FloatArray, FloatArray]:
    """Angles from 0 to pi, and the part of the integral of |u| that lies within each."""
    s = np.arange(NODES + 1) / NODES
    energy = _energy_within(s, channels_last(profile(1 - 2 * s**2)))
    return 2 * np.arcsin(s), energy / energy[-1] if energy[-1] > 0 else np.ones_like(s)


def _angle_within(s: FloatArray, u: FloatArray, left_out: float) -> float:
    # theta_i* of [RH02] appendix D, by quadrature for any profile
    energy = _energy_within(s, u)
    if energy[-1] == 0:
        return float(np.pi)
    k = np.searchsorted(energy, (1 - left_out) * energy[-1])
    return float(2 * np.arcsin(s[min(k, len(s) - 1)]))


def _energy_within(s: FloatArray, u: FloatArray) -> FloatArray:
    """The integral of |u| up to each angle, in any unit; sin(theta) d(theta) = 4 s ds."""
    density = np.abs(u).sum(axis=1) * s
    return np.concatenate([[0], np.cumsum(density[1:] + density[:-1])])


# ---- Arrays


def channels_last(values: FloatArray) -> FloatArray:
    """(n,) or (n, 3) as (n, 1) or (n, 3)."""
    values = np.asarray(values, dtype=np.float64)
    return values[:, None] if values.ndim == 1 else values


def relative_rms(actual: FloatArray, exact: FloatArray, weight: FloatArray) -> float:
    """Root mean square of a difference by that of the exact values, 0 if they are."""
    total = float(np.sum(weight * exact**2))
    return float(np.sqrt(np.sum(weight * (actual - exact) ** 2) / total)) if total > 0 else 0.0
