"""The threshold of a descent for an error, and the error of a threshold: measured in a sample of maps.

The maps are lat-long; each block of neighboring texels, which descend together, is seen by a view of its own
drawn at random. Blocks are drawn by what they hold of the light and of the error. What counts as exact is a
descent with next to no threshold: the sum over all texels would take long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.integrate.descent_lobes import LARGEST_OUTSIDE, LobeDescent
from shrm.integrate.queries import map_directions
from shrm.lobes.directions import local_frames
from shrm.lobes.reflection import Layout

SAMPLED_BLOCKS, SAMPLED_RADIAL = 64, 256
"""Blocks sampled from the maps of a lobe that changes with the view, and of one that does not."""

EXACT_PART = 1e-2
"""Threshold of maps that count as exact, relative to the tolerance, or to the threshold that is judged."""

FINE_THRESHOLD = 1e-3
"""Threshold whose maps, compared with those of LARGEST_OUTSIDE, tell in which blocks errors are likely."""

LARGEST_THRESHOLD, SMALLEST_THRESHOLD = 10.0, 1e-9
"""Bounds of the search for a threshold, relative to the mean reflected light."""

FEWEST_ROWS, MOST_ROWS = 64, 256
"""Bounds on the rows of the sampled maps, whatever the size asked for."""

SAMPLED_SHARE = 0.8
"""Fraction of a tolerance that the error of the sample may take: a sample may miss some of the error."""

Frames = tuple[FloatArray, FloatArray, FloatArray]
"""Normals, views and tangents, each (n, 3)."""


@dataclass(frozen=True, eq=False)
class DescentSample:
    """Blocks of a lobe's maps, with their exact values.

    Attributes
    ----------
    lobe : LobeDescent
        The lobe.
    pyramid : Pyramid
        The light.
    frames : Frames
        Normals, views and tangents of the texels drawn.
    weight : (n,) float64
        Weights that make a sum of squares over the frames that over the maps, relative to the light they
        reflect.
    exact : (n, 3) float64
        Radiance of the texels by a descent with next to no threshold.
    """

    lobe: LobeDescent
    pyramid: _core.Pyramid
    frames: Frames
    weight: FloatArray
    exact: FloatArray

    @classmethod
    def drawn(
        cls, lobe: LobeDescent, pyramid: _core.Pyramid, rows: int, exact: float
    ) -> DescentSample | None:
        """Draw blocks of maps of so many rows; None if they are dark. `exact` is the finest threshold."""
        shape, order, targets = map_texels("latlong", int(np.clip(rows, FEWEST_ROWS, MOST_ROWS)))
        rows, block, count = shape[0], _core.HIERARCHICAL_BLOCK, len(order)
        random = np.random.default_rng(2000)

        # Each block of texels as one view sees it, which its first texel has at a frame drawn at random.
        first = np.ascontiguousarray(targets[::block])
        aside, azimuth = local_frames(first, first), 2 * np.pi * random.random(len(first))
        theta_o = lobe.theta_o(random.random(len(first)))
        local = np.stack(
            [np.sin(theta_o) * np.cos(azimuth), np.sin(theta_o) * np.sin(azimuth), np.cos(theta_o)], axis=1
        )
        views = np.einsum("nxk,nk->nx", aside, local)
        frames = frames_at(lobe, targets, views.repeat(block, axis=0)[:count])
        area = np.sin(np.pi * (np.arange(rows) + 0.5) / rows).repeat(shape[1])[order, None]

        def of_blocks(pixels: FloatArray) -> FloatArray:
            return np.asarray(np.add.reduceat((area * pixels**2).sum(axis=1), np.arange(0, count, block)))

        # Blocks by what two thresholds say of their errors, by their energy, and evenly.
        fine, coarse = (
            lobe.radiance(pyramid, *frames, threshold)[0].astype(np.float64)
            for threshold in (FINE_THRESHOLD, LARGEST_OUTSIDE)
        )
        energy, difference = of_blocks(fine), of_blocks(fine - coarse)
        total = energy.sum()
        if total == 0:
            return None
        chance = 0.5 * energy / total + 0.5 / len(energy)
        if difference.any():
            chance = 0.5 * chance + 0.5 * difference / difference.sum()
        sampled = SAMPLED_BLOCKS if lobe.depends_on_view else SAMPLED_RADIAL
        drawn = random.choice(len(energy), sampled, p=chance / chance.sum())

        # The frames of the blocks that were drawn; the last block may have fewer.
        places = drawn[:, None] * block + np.arange(block)
        inside = places < count
        places = np.minimum(places, count - 1)
        weight = inside * area[places, 0] / (sampled * chance[drawn])[:, None] / total
        n, v, t = (np.ascontiguousarray(d[places.ravel()]) for d in frames)
        values = lobe.radiance(pyramid, n, v, t, exact)[0].astype(np.float64)
        return cls(lobe, pyramid, (n, v, t), weight.ravel(), values)

    def error(self, threshold: float) -> float:
        """Return the relative RMS error of a threshold, in the sample."""
        radiance: Float32Array = self.lobe.radiance(self.pyramid, *self.frames, threshold)[0]
        square = ((radiance - self.exact) ** 2).sum(axis=1)
        return float(np.sqrt((self.weight * square).sum()))


def threshold_for(
    lobe: LobeDescent, pyramid: _core.Pyramid, rows: int, tolerance: float
) -> tuple[float, float]:
    """Return the largest threshold, to a tenth, that meets a tolerance, and the error predicted for it."""
    sample = DescentSample.drawn(lobe, pyramid, rows, EXACT_PART * tolerance)
    if sample is None:
        return 1.0, 0.0

    # Bisection of the logarithm, once a threshold is known that meets the tolerance
    low, high, error = 0.0, LARGEST_THRESHOLD, 0.0
    while high > 1.1 * low and high > SMALLEST_THRESHOLD:
        middle = np.sqrt(low * high) if low > 0 else high / 4.0
        sampled = sample.error(middle)
        if sampled <= SAMPLED_SHARE * tolerance:
            low, error = middle, sampled
        else:
            high = middle
    return float(low), error / SAMPLED_SHARE


def predicted_error(lobe: LobeDescent, pyramid: _core.Pyramid, rows: int, threshold: float) -> float:
    """Return the error predicted for a threshold."""
    if threshold == 0:
        return 0.0
    sample = DescentSample.drawn(lobe, pyramid, rows, EXACT_PART * threshold)
    return 0.0 if sample is None else sample.error(threshold) / SAMPLED_SHARE


def frames_at(lobe: LobeDescent, centers: FloatArray, views: FloatArray) -> Frames:
    """Return the frames in which a lobe has its center at texels of a map."""
    return np.ascontiguousarray(lobe.normals(centers, views)), np.ascontiguousarray(views), centers


def map_texels(layout: Layout, size: int) -> tuple[tuple[int, ...], npt.NDArray[np.intp], FloatArray]:
    """Return a map's shape, the places of its texels block by block, and their directions in that order."""
    C = map_directions(layout, size)
    order = _by_blocks(C.shape[:-1])
    return C.shape, order, np.ascontiguousarray(C.reshape(-1, 3)[order])


def _by_blocks(shape: tuple[int, ...]) -> npt.NDArray[np.intp]:
    """Return the places of a map's texels, block by block of the neighbors that descend together."""
    # A key for each texel of a face: its block, then its place in that
    side = int(np.sqrt(_core.HIERARCHICAL_BLOCK))
    H, W = shape[-2:]
    rows, columns = np.arange(H) // side, np.arange(W) // side
    within = (np.arange(H) % side)[:, None] * side + (np.arange(W) % side)[None]
    block = rows[:, None] * (columns[-1] + 1) + columns[None]
    of_face = np.argsort((block * side**2 + within).ravel(), kind="stable")

    # The same order in all faces, one after another
    faces = int(np.prod(shape[:-2], dtype=int))
    return (np.arange(faces)[:, None] * (H * W) + of_face[None]).ravel()
