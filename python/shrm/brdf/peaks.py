"""Finding peaks of lobes that are too narrow for ordinary nodes.

Ordinary nodes begin about a thousandth of a radian from the center. A lobe that changes within that angle is
sampled along a ladder of angles that shrink towards the center, and gets nodes from its own width on.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shrm.arrays import BoolArray, FloatArray

NARROW = 1e-3
"""Angle from the center within which ordinary lobes are flat, radians."""

LADDER = 512 * NARROW * 0.5 ** np.arange(43.0)
"""Angles at which peaks are looked for, radians: to 1e-13, far below any lobe that float64 can hold."""

NARROW_RING = 0.064
"""Angle in place of `NARROW` for lobes about a tangent, whose nodes are spread evenly, radians."""

_RISE = 1.5
"""Least factor by which a lobe rises from the side of a peak to its top."""

_MUCH_NARROWER = 0.125
"""Fraction of the angle that holds half of a lobe's energy below which a peak gets panels of its own."""

_BISECTIONS = 45
"""Steps of bisection that find an end of a profile to float64's rounding."""

_FAINT = 1e-3
"""Fraction of the highest peak that others must reach: the tails of lobes rise steeply, too."""


def peak_width(values: FloatArray) -> float:
    """Return the angle within which the narrowest peak keeps 2/3 of its height; infinity if there is none.

    Parameters
    ----------
    values : (43, ...) float64
        Of a lobe at the angles of `LADDER` from its center, along several paths.
    """
    size = np.abs(values).reshape(len(LADDER), -1)
    top = np.maximum.accumulate(size[::-1], axis=0)[::-1]  # within each angle
    rises = (top > _RISE * size) & (top > _FAINT * top.max())
    if not rises.any():
        return np.inf
    side = int(np.flatnonzero(rises.any(axis=1))[-1])
    return float(LADDER[min(side + 1, len(LADDER) - 1)])


def narrower(half: float, peak: float) -> float:
    """Return the width to begin panels with: half of a lobe's energy, or of a peak that holds less than that.

    Both are angles in radians; the first does not tell lobes from each other that are narrower than `NARROW`.
    """
    if peak < NARROW:
        return min(half, peak)
    width = float(np.clip(half, NARROW, 0.8))
    return peak if peak < _MUCH_NARROWER * width else width


def peak_about_rings(
    profile: Callable[[FloatArray, FloatArray], FloatArray], theta_o: FloatArray, rings: FloatArray
) -> float:
    """Return the width of the narrowest peak of a profile of theta_i, theta_o about some rings theta_i.

    Rings are (views, n), for each of the views theta_o (views,).
    """
    sides = []
    for side in (-LADDER, LADDER):
        angle_i = np.pi - np.abs(np.pi - np.abs(rings + side[:, None, None]))
        angle_o = np.broadcast_to(theta_o[:, None], angle_i.shape)
        sides.append(np.abs(profile(angle_i.ravel(), angle_o.ravel())).reshape(*angle_i.shape, -1))
    return peak_width(np.maximum(*sides))  # a flank is no peak: peaks fall on both sides


def with_support(
    profile: Callable[[FloatArray, FloatArray], FloatArray], theta_o: FloatArray, edges: FloatArray
) -> FloatArray:
    """Return edges of panels of theta_i, (views, n), with more of them where a profile comes to its end.

    Between two edges where it is 0 and not 0 the place is found by bisection, for each of the views theta_o.
    """

    def there(theta_i: FloatArray) -> BoolArray:
        angle_o = np.broadcast_to(theta_o[:, None], theta_i.shape)
        values = profile(theta_i.ravel(), angle_o.ravel()).reshape(*theta_i.shape, -1)
        return np.asarray(np.any(values != 0.0, axis=-1))

    inside = there(edges)
    low, high = edges[:, :-1].copy(), edges[:, 1:].copy()
    ends = (inside[:, 1:] != inside[:, :-1]).any(axis=0)
    if not ends.any():
        return edges
    low, high, at_low = low[:, ends], high[:, ends], inside[:, :-1][:, ends]
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        same = there(middle) == at_low
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.sort(np.concatenate([edges, high], axis=1), axis=1)


def peak_about_reflection(transfer: Callable[[FloatArray, FloatArray], FloatArray]) -> float:
    """Return the width of a lobe's peak about R, for views up to 45 degrees; see `peak_width`.

    `transfer` is rho_hat(wi, wo), (n, 3) unit vectors in the frame of the normal to (n,) or (n, 3).
    """
    lights, views = [], []
    for theta_v in (0.0, np.pi / 4):
        sine, cosine = np.sin(theta_v), np.cos(theta_v)
        for phi in (0.0, np.pi / 2, np.pi):
            x, y, z = np.sin(LADDER) * np.cos(phi), np.sin(LADDER) * np.sin(phi), np.cos(LADDER)
            # R = (-sin, 0, cos)
            lights.append(np.stack([cosine * x - sine * z, y, sine * x + cosine * z], axis=1))
            views.append(np.tile([sine, 0.0, cosine], (len(LADDER), 1)))
    values = transfer(np.concatenate(lights), np.concatenate(views))
    ahead, aside, behind = np.abs(values).reshape(2, 3, len(LADDER), -1).swapaxes(0, 1)
    # a flank is no peak: in the plane of N and V a peak falls on both sides
    return peak_width(np.concatenate([np.maximum(ahead, behind), aside]).swapaxes(0, 1))


def peak_of_profile(profile: Callable[[FloatArray], FloatArray]) -> float:
    """Return the width of the peak at theta = 0 of a profile of theta, radians; see `peak_width`."""
    return peak_width(profile(LADDER))
