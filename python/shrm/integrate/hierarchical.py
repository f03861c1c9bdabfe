"""Prefiltering by descent in a pyramid of the environment: fast where lobes are sharp.

[KVHS00] section 5.1 with the light taken into account. The pyramid is a quadtree over the two paraboloids of
[HS98]. Its nodes hold power, radiance times solid angle, at their centroid; a lobe is compared between a node
and its children, and only where their difference would change the reflected light are they entered.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.integrate.descent_lobes import LEFT_OUT, LobeDescent, lobe_descent
from shrm.integrate.queries import DEFAULT_SIZE, lobes_of, map_directions, pixels_of, queries
from shrm.lobes.directions import local_frames
from shrm.lobes.reflection import Layout, Reflection
from shrm.validation import fraction, number, one_of, whole_number

SAMPLED_BLOCKS, SAMPLED_RADIAL = 64, 256
"""Blocks of maps from which a threshold is found for an error; of the one map that a radial lobe has."""
EXACT = 1e-2
"""A threshold, in errors wanted, that leaves next to none: the sum over all texels would take long."""
FINE = 1e-3
"""A threshold whose maps are compared with those of LEFT_OUT."""
LARGEST_THRESHOLD, SMALLEST_THRESHOLD = 10.0, 1e-9
SEARCHED_ROWS = (64, 256)
"""Of the maps from which a threshold is found, at least and at most."""
MARGIN = 0.8
"""Of the error wanted, what the blocks may have: they are a sample."""


def prefilter_hierarchical(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float | None = None,
    threshold: float | None = None,
    size: int | None = None,
    layout: Layout = "latlong",
) -> HierarchicalReflection:
    """Prepare hierarchical prefiltering of an environment under a material.

    Parameters
    ----------
    env : Environment
        Its texels (H, W, 3) count as points of their power at their centers, as in
        ``prefilter_angular(subsamples=1)``.
    brdf : BRDF
        The material. Lobes of one shape, such as Phong's, cost least.
    tolerance : float, optional
        Relative RMS error asked for, against the sum over all texels, in (0, 1); default .01. It is one over
        the maps of all views together: where most of what is reflected is at grazing views or from light at
        the horizon (microfacets of f0 = 0), a single map, or all, may have several times as much. The
        threshold is found from some blocks of texels of maps of random views.
    threshold : float, optional
        In its place: by how much the light of a node may change, its brightness times the difference of the
        lobe between it and its parent, in parts of the mean reflected light. 0 visits every texel.
    size : int, optional
        Rows of the maps for "latlong" (default 128), or the edge of a face for "cube" (default 64).
    layout : {"latlong", "cube"}
        Layout of the maps.

    Returns
    -------
    HierarchicalReflection

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    pixels = pixels_of(env)
    one_of("layout", layout, DEFAULT_SIZE)
    edge = DEFAULT_SIZE[layout] if size is None else whole_number("size", size, 1, 16384)
    if tolerance is not None and threshold is not None:
        raise ValueError("tolerance and threshold are two ways to say one thing: give one of them")
    if threshold is None:
        tolerance = 0.01 if tolerance is None else fraction("tolerance", tolerance)
        if tolerance == 0:
            raise ValueError(f"tolerance must be above 0 and below 1, got {tolerance!r}")
    else:
        threshold = number("threshold", threshold, 0.0)
    lobes = [lobe_descent(lobe) for lobe in lobes_of(brdf)]
    if not lobes:
        raise ValueError("brdf has no lobes, but needs at least one")
    return HierarchicalReflection(pixels, lobes, edge, layout, tolerance, threshold)


class HierarchicalReflection(Reflection):
    """Reflected radiance of one environment under one material, by descent.

    Made by `prefilter_hierarchical`.

    Attributes
    ----------
    threshold : tuple of float
        For each lobe.
    evaluations : float
        Of a lobe for each target, in the last call.
    """

    def __init__(
        self,
        pixels: Float32Array,
        lobes: Sequence[LobeDescent],
        size: int,
        layout: Layout,
        tolerance: float | None,
        threshold: float | None,
    ) -> None:
        self._size, self._layout = size, layout
        self.evaluations = 0.0
        self._pyramid = _core.Pyramid(pixels)
        self._shape, self._order, self._targets = map_texels(layout, size)
        self._lobes = tuple(lobes)
        if threshold is None:
            assert tolerance is not None
            rows = int(np.clip(size, *SEARCHED_ROWS))
            self.threshold = tuple(self._threshold(lobe, tolerance, rows) for lobe in self._lobes)
        else:
            self.threshold = (float(threshold),) * len(self._lobes)
        self.evaluations = 0.0

    @property
    def size(self) -> int:
        """Rows of a lat-long map, or the edge of a cube's face."""
        return self._size

    @property
    def layout(self) -> Layout:
        """The grid of the maps."""
        return self._layout

    @property
    def centers(self) -> tuple[Center, ...]:
        """The center of each lobe's map."""
        return tuple(lobe.center for lobe in self._lobes)

    def update(self, env: Environment) -> None:
        """Take another light, of any size; thresholds stay.

        Raises
        ------
        TypeError, ValueError
            If it is none.
        """
        self._pyramid = _core.Pyramid(pixels_of(env))

    def radiance(
        self, normals: npt.ArrayLike, views: npt.ArrayLike, tangents: npt.ArrayLike | None = None
    ) -> Float32Array:
        """Return the reflected radiance, each query integrated; neighbours in space had best be neighbours.

        Parameters
        ----------
        normals, views, tangents : (n, 3) array_like
            As in `shrm.integrate.angular.integrate`.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        n, v, t = queries(self.centers, normals, views, tangents)
        result = np.zeros((len(n), 3), np.float32)
        self.evaluations = 0.0
        for lobe, threshold in zip(self._lobes, self.threshold, strict=True):
            result += self._reflected(lobe, (n, v, t), threshold)
        return result

    def lobe_maps(self, view: FloatArray) -> Iterator[Float32Array]:
        """Yield the map of each lobe; see `shrm.lobes.reflection.Reflection`."""
        v = np.broadcast_to(view, self._targets.shape)
        self.evaluations = 0.0
        for lobe, threshold in zip(self._lobes, self.threshold, strict=True):
            pixels = np.empty(self._targets.shape, np.float32)
            pixels[self._order] = self._reflected(lobe, _frames(lobe, self._targets, v), threshold)
            yield pixels.reshape(self._shape)

    def _reflected(self, lobe: LobeDescent, frames: Frames, threshold: float) -> Float32Array:
        found, evaluations = lobe.radiance(self._pyramid, *frames, threshold)
        self.evaluations += evaluations
        return found

    def _threshold(self, lobe: LobeDescent, tolerance: float, rows: int) -> float:
        """The largest threshold, to a tenth, whose error is within what is wanted: in a sample of maps.

        They are lat-long, of as many rows.
        """
        shape, order, targets = map_texels("latlong", rows)
        block, count = _core.HIERARCHICAL_BLOCK, len(order)
        random = np.random.default_rng(2000)
        # Each block of texels as one view sees it, which its first texel has at a frame drawn at random.
        first = np.ascontiguousarray(targets[::block])
        aside, azimuth = local_frames(first, first), 2 * np.pi * random.random(len(first))
        theta_o = lobe.theta_o(random.random(len(first)))
        local = np.stack(
            [np.sin(theta_o) * np.cos(azimuth), np.sin(theta_o) * np.sin(azimuth), np.cos(theta_o)], axis=1
        )
        views = np.einsum("nxk,nk->nx", aside, local)
        frames = _frames(lobe, targets, views.repeat(block, axis=0)[:count])
        area = np.sin(np.pi * (np.arange(rows) + 0.5) / rows).repeat(shape[1])[order, None]

        def of_blocks(pixels: FloatArray) -> FloatArray:
            return np.asarray(np.add.reduceat((area * pixels**2).sum(axis=1), np.arange(0, count, block)))

        # Blocks by what two thresholds say of their errors, by their energy, and evenly.
        fine, coarse = (self._reflected(lobe, frames, at).astype(np.float64) for at in (FINE, LEFT_OUT))
        energy, difference = of_blocks(fine), of_blocks(fine - coarse)
        total = energy.sum()
        if total == 0:
            return 1.0
        chance = 0.5 * energy / total + 0.5 / len(energy)
        if difference.any():
            chance = 0.5 * chance + 0.5 * difference / difference.sum()
        sampled = SAMPLED_BLOCKS if lobe.depends_on_view else SAMPLED_RADIAL
        drawn = random.choice(len(energy), sampled, p=chance / chance.sum())
        places = drawn[:, None] * block + np.arange(block)
        inside = places < count
        places = np.minimum(places, count - 1)
        weight = inside * area[places, 0] / (sampled * chance[drawn])[:, None] / total
        n, v, t = (np.ascontiguousarray(d[places.ravel()]) for d in frames)
        exact = self._reflected(lobe, (n, v, t), EXACT * tolerance).astype(np.float64)

        def off(threshold: float) -> float:
            square = ((self._reflected(lobe, (n, v, t), threshold) - exact) ** 2).sum(axis=1)
            return float(np.sqrt((weight.ravel() * square).sum()))

        low, high = 0.0, LARGEST_THRESHOLD
        while high > 1.1 * low and high > SMALLEST_THRESHOLD:
            middle = np.sqrt(low * high) if low > 0 else high / 4.0
            low, high = (middle, high) if off(middle) <= MARGIN * tolerance else (low, middle)
        return float(low)


Frames = tuple[FloatArray, FloatArray, FloatArray]
"""Normals, views and tangents, each (n, 3)."""


def _frames(lobe: LobeDescent, centers: FloatArray, views: FloatArray) -> Frames:
    """Frames in which the lobe has its center at texels of a map."""
    return np.ascontiguousarray(lobe.normals(centers, views)), np.ascontiguousarray(views), centers


def map_texels(layout: Layout, size: int) -> tuple[tuple[int, ...], npt.NDArray[np.intp], FloatArray]:
    """Shape of a map, the places of its texels block by block, and their directions in that order."""
    C = map_directions(layout, size)
    order = _by_blocks(C.shape[:-1])
    return C.shape, order, np.ascontiguousarray(C.reshape(-1, 3)[order])


def _by_blocks(shape: tuple[int, ...]) -> npt.NDArray[np.intp]:
    """Places of the texels of a map, block by block of neighbours, each of as many as descend together."""
    side = int(np.sqrt(_core.HIERARCHICAL_BLOCK))
    H, W = shape[-2:]
    rows, columns = np.arange(H) // side, np.arange(W) // side
    within = (np.arange(H) % side)[:, None] * side + (np.arange(W) % side)[None]
    tile = rows[:, None] * (columns[-1] + 1) + columns[None]
    one = np.argsort((tile * side**2 + within).ravel(), kind="stable")
    faces = int(np.prod(shape[:-2], dtype=int))
    return (np.arange(faces)[:, None] * (H * W) + one[None]).ravel()
