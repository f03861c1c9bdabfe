"""Filters of radial lobes for dual-paraboloid maps: kernels in texture space, and taps on the sphere.

The kernels are those of [KVHS00] section 5.2. A lobe is nothing from the angle alpha on, where it falls below
a part `clamp` of its maximum. In a paraboloid of radius R texels, where the angle theta from the axis is at
R tan(theta / 2), a cap of alpha about the center, d = 0, is a disc of the radius

    r_s = R tan(alpha / 2),

and a cap about the rim, d = 1, reaches from there towards the center by

    r_l = R (1 - tan(pi / 4 - alpha / 2)),

which for small alpha is twice as far. Sizes are 2 ceil(r): with R = 256 and clamp = .1 they are those of the
paper's table, all ten, and so are the shrink factors. (R = 256 is half of its faces' 512 texels, as if their
border of 64 were beyond these.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.cosine_power import profile_at, profile_at_angles
from shrm.integrate.radial_table import NODES, Profile, channels_last, half_sines, integral_within
from shrm.vectors import golden_azimuths

Which = Literal["small", "large"]


@dataclass(frozen=True)
class TextureFilter:
    """A filter in the texture space of a paraboloid [KVHS00 section 5.2].

    Attributes
    ----------
    which : {"small", "large"}
        For the center of a face, or for its rim.
    radius : float
        In radii of the disc.
    size : int
        Across, in texels of the map: even.
    shrink : int
        By how much map and filter are shrunk, a power of two.
    """

    which: Which
    radius: float
    size: int
    shrink: int


def texture_filters(
    profile: Profile, size: int, clamp: float, largest_kernel: int
) -> tuple[TextureFilter, TextureFilter]:
    """Return the small and the large filter of a lobe.

    Parameters
    ----------
    profile : callable
        Of cos(theta), one channel or three.
    size : int
        Texels across the disc.
    clamp : float
        In (0, 1): the part of the lobe's maximum below which it is left out.
    largest_kernel : int
        Texels across, to which shrinking must bring a filter.

    Raises
    ------
    ValueError
        If the lobe is above the clamp at 90 degrees: no filter in texture space has room for it.
    """
    alpha = clamp_angle(profile, clamp)
    if alpha >= math.pi / 2:
        raise ValueError(
            f"lobe must fall to {clamp:g} of its maximum within 90 degrees to fit into a face, got one that "
            "does not: raise clamp, or use the exact filter"
        )
    small, large = math.tan(alpha / 2), 1.0 - math.tan(math.pi / 4 - alpha / 2)
    return _filter("small", small, size, largest_kernel), _filter("large", large, size, largest_kernel)


def _filter(which: Which, radius: float, size: int, largest_kernel: int) -> TextureFilter:
    across, shrink = 2 * math.ceil(radius * size / 2), 1
    while across > largest_kernel * shrink:
        shrink *= 2
    return TextureFilter(which, radius, across, shrink)


def clamp_angle(profile: Profile, clamp: float) -> float:
    """Return the angle from which on all channels are below a part of the maximum; 0 if the lobe is black."""

    def height(theta: FloatArray) -> FloatArray:
        return np.asarray(np.abs(channels_last(profile_at_angles(profile, theta))).max(axis=1))

    theta = 2 * np.arcsin(half_sines(profile)[0])
    values = height(theta)
    if values.max() == 0.0:
        return 0.0
    least = clamp * values.max()
    k = int(np.flatnonzero(values >= least)[-1])
    if k == NODES:
        return math.pi
    low, high = float(theta[k]), float(theta[k + 1])
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if height(np.array([middle]))[0] >= least else (low, middle)
    return high


def texture_kernel(profile: Profile, filter: TextureFilter, texel: float) -> Float32Array:
    """Sample a lobe into a kernel [KVHS00 section 5.2, step 7] that sums to the lobe's integral.

    Parameters
    ----------
    profile : callable
        Of cos(theta), one channel or three.
    filter : TextureFilter
    texel : float
        Edge of the shrunk map's texels, in radii of the disc.

    Returns
    -------
    (k, k, 3) float32
        k odd.
    """
    reach = int(filter.radius / texel)
    steps = np.arange(-reach, reach + 1) * texel
    distance = np.hypot(*np.meshgrid(steps, steps))
    # The angle that a distance is at d = 0, and towards the center at d = 1: r_s and r_l backwards.
    at_rim = filter.which == "large"
    theta = np.pi / 2 - 2 * np.arctan(1 - distance) if at_rim else 2 * np.arctan(distance)
    values = channels_last(profile_at_angles(profile, theta.ravel()))
    values[distance.ravel() > filter.radius] = 0.0
    total = values.sum(axis=0)
    kernel = np.where(total != 0, values / np.where(total != 0, total, 1), 0.0) * integral(profile)
    return np.broadcast_to(kernel, (len(kernel), 3)).reshape(*distance.shape, 3).astype(np.float32)


def integral(profile: Profile) -> FloatArray:
    """Return the integral of a lobe over the sphere, (1,) or (3,)."""
    return np.asarray(_within(profile)[-1])


def _within(profile: Profile) -> FloatArray:
    """The integral of each channel up to the angles of `integral_within`, (n, C); sin t dt = 4 s ds."""
    s, _ = half_sines(profile)
    density = 8 * np.pi * channels_last(profile_at(profile, 1 - 2 * s**2, s**2)) * s[:, None]
    steps = 0.5 * (density[1:] + density[:-1]) * np.diff(s)[:, None]
    return np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])


def taps(profile: Profile, count: int) -> Float32Array:
    """Return directions that share a lobe, by importance: each stands for 1 / count of its integral.

    Angles from the center are the medians of rings of equal energy, azimuths turn by the golden ratio.
    The solid angle of a tap is 1 / (count p), p its probability density: light is averaged over as much.

    Parameters
    ----------
    profile : callable
        Of cos(theta), one channel or three.
    count : int

    Returns
    -------
    (2, count, 4) float32
        First x, y, z about the center z and log2 of the root of the solid angle; then the three channels'
        weights, which sum to the lobe's integrals, and 0.
    """
    angles, share = integral_within(profile)
    parts = (np.arange(count) + 0.5) / count
    theta, edges = np.interp(parts, share, angles), np.arange(count + 1) / count
    phi = -golden_azimuths(count)
    of_channels = _within(profile)
    weights = np.diff([np.interp(edges, share, channel) for channel in of_channels.T], axis=1).T
    energy = float(np.abs(of_channels[-1]).sum())
    density = np.abs(channels_last(profile_at_angles(profile, theta))).sum(axis=1) / (
        energy if energy > 0 else 1.0
    )
    result = np.zeros((2, count, 4))
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    result[0, :, :3] = np.stack([x, y, np.cos(theta)], axis=1)
    result[0, :, 3] = -0.5 * np.log2(
        np.maximum(count * density, 1.0 / (4.0 * np.pi))
    )  # the sphere at the most
    result[1, :, :3] = weights
    return result.astype(np.float32)
