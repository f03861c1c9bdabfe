"""Samples and flops of prefiltering, counted for both sides of [RH02] tables 4 and 5.

A multiply-add is two flops, a root's inverse one.
"""

from __future__ import annotations

import numpy as np
from shrm.arrays import FloatArray
from shrm.environment.layouts import directions

CHANNELS = 3

FLOPS_OF_WEIGHT = 8
"""A radial lobe's weight of a texel for a pixel: a multiply-add for the angle, three for the lobe's cubic."""

FLOPS_OF_SUM = 2 * CHANNELS
"""A weight times a texel, added: a multiply-add for each channel."""

FLOPS_OF_HALF_VECTOR = 13
"""L + V 4, its square 4, the root's inverse 1, three products and g 4."""

FLOPS_OF_HALF_ANGLE = 15
"""A lobe's weight from half vector and normal: three differences and their square 9, the lobe's cubic 6."""

COUNTED_PIXELS = 512
"""Pixels whose samples are counted one by one, for a mean."""


def outer_angle(s: float, epsilon: float) -> float:
    """Return theta_i*, within which all but epsilon of the lobe's integral lies [RH02 appendix D]."""
    return float(np.arccos(epsilon ** (1 / (s + 1))))


def samples(H: int, within: float) -> int:
    """Count the pairs of texels of an H x 2 H lat-long grid that lie `within` radians of each other."""
    W = 2 * H
    theta = (np.arange(H) + 0.5) * np.pi / H
    cos_phi = np.cos(2 * np.pi / W * np.arange(W))
    nearer = np.cos(within)
    # Every column of centers is the first one turned.
    pairs_of_column = sum(
        int(
            np.count_nonzero(
                cos_t * np.cos(theta)[:, None] + sin_t * np.sin(theta)[:, None] * cos_phi >= nearer
            )
        )
        for cos_t, sin_t in zip(np.cos(theta), np.sin(theta), strict=True)
    )
    return W * pairs_of_column


def angular_flops(H: int, s: float, epsilon: float, symmetry: bool) -> float:
    """Count the flops of direct integration; by symmetry, weights are found for one center of each row."""
    n = samples(H, outer_angle(s, epsilon))
    return n * (FLOPS_OF_SUM + FLOPS_OF_WEIGHT / (2 * H if symmetry else 1))


def frequency_flops(H: int, F: int) -> float:
    """Count the flops of analysis and synthesis, two to each multiply-add of their matrix products."""
    return 2 * transform_flops(H, F)


def transform_flops(H: int, F: int) -> float:
    """Count the flops of one transform of a picture of H x 2 H, two to each multiply-add of its products.

    Rings are folded to a quarter, rows paired with those below the equator [RH02 section 6.1]: 2 F + 1 sums
    over phi for each row, then H / 2 rows for each coefficient. Folding itself is not counted.
    """
    return 2 * CHANNELS * (H * (2 * F + 1) * (H / 2) + (F + 1) ** 2 * (H / 2))


def shrm_flops(H: int, F: int, P: int) -> float:
    """Count the flops from light to a SHRM: analysis, and (P + 1)^2 maps of degrees up to F + P."""
    return transform_flops(H, F) + sum((2 * p + 1) * transform_flops(H, F + p) for p in range(P + 1))


def view_flops(H: int, P: int) -> float:
    """Count the flops of the map for one view [RH02 eq. 12]."""
    return 2 * CHANNELS * (P + 1) ** 2 * (2 * H * H)


def half_angle_flops(samples: float, tabulated: bool) -> float:
    """Count the flops of integrating a lobe of the half angle, half vectors tabulated or computed anew."""
    return samples * (FLOPS_OF_SUM + FLOPS_OF_HALF_ANGLE + (0 if tabulated else FLOPS_OF_HALF_VECTOR))


def samples_in_caps(H: int, axes: FloatArray, outer: FloatArray) -> float:
    """Estimate the mean number of texels of an H x 2 H lat-long grid that caps hold.

    axes (n, 3) are their middles, outer (n,) their angles; `COUNTED_PIXELS` of them are counted.
    """
    texels = directions("latlong", H, 2 * H).reshape(-1, 3)
    counted = np.random.default_rng(0).permutation(len(axes))[:COUNTED_PIXELS]
    inside = axes[counted] @ texels.T >= np.cos(outer[counted])[:, None]
    return float(inside.sum() / len(counted))
