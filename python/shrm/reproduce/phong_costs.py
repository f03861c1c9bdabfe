"""What prefiltering with Phong's lobe takes, counted: samples and flops of both sides of [RH02] table 4.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
"""

from __future__ import annotations

import numpy as np

CHANNELS = 3
FLOPS_OF_WEIGHT = 8  # of one texel seen from one centre: a multiply-add for the angle, three for the lobe
FLOPS_OF_SUM = 2 * CHANNELS  # a multiply-add for each channel


def outer_angle(s: float, epsilon: float) -> float:
    """Return theta_i*, within which all but epsilon of the lobe's integral lies [RH02 appendix D]."""
    return float(np.arccos(epsilon ** (1 / (s + 1))))


def samples(H: int, within: float) -> int:
    """Count the pairs of texels of an H x 2 H lat-long grid that lie `within` radians of each other."""
    W = 2 * H
    theta = (np.arange(H) + 0.5) * np.pi / H
    cos_phi = np.cos(2 * np.pi / W * np.arange(W))
    nearer = np.cos(within)
    # Every column of centres is the first one turned.
    of_column = sum(
        int(
            np.count_nonzero(
                cos_t * np.cos(theta)[:, None] + sin_t * np.sin(theta)[:, None] * cos_phi >= nearer
            )
        )
        for cos_t, sin_t in zip(np.cos(theta), np.sin(theta), strict=True)
    )
    return W * of_column


def angular_flops(H: int, s: float, epsilon: float, symmetry: bool) -> float:
    """Count the flops of direct integration; by symmetry, weights are found for one centre of each row."""
    n = samples(H, outer_angle(s, epsilon))
    return n * (FLOPS_OF_SUM + FLOPS_OF_WEIGHT / (2 * H if symmetry else 1))


def frequency_flops(H: int, F: int) -> float:
    """Count the flops of analysis and synthesis, two to each multiply-add of their matrix products.

    Rings are folded to a quarter, rows paired with those below the equator [RH02 section 6.1]: 2 F + 1 sums
    over phi for each row, then H / 2 rows for each coefficient. Folding itself is not counted.
    """
    W = 2 * H
    one_way = H * (2 * F + 1) * (W / 4) + (F + 1) ** 2 * (H / 2)
    return 2 * 2 * CHANNELS * one_way
