"""Reflected light by direct integration over the environment: the rival and the judge.

`prefilter_angular` is prefiltering as it was done before frequency space, in C++; `integrate` is the plain
sum in float64 numpy, without a table, for whoever wants an answer to trust. Neither uses spherical harmonics.
Both hold the environment constant over each texel.

The method and its cost (eq. 10, against eq. 9 in frequency space) are those of [RH02] sections 6 and 7.4,
table 3 and appendix D.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.files import PathLike
from shrm.integrate import file
from shrm.integrate.angular_lobes import (
    INTEGRALS,
    LARGEST_CUT,
    LARGEST_SUBSAMPLES,
    LobeIntegral,
    RadialIntegral,
    lobe_integral,
    picture_of,
    resolving,
)
from shrm.integrate.queries import DEFAULT_SIZE, LARGEST_SIZE, lobes_of, map_directions, pixels_of, queries
from shrm.integrate.sampled_frames import drawn_directions
from shrm.lobes.directions import above_horizon, local_frames
from shrm.lobes.reflection import Layout, Reflection, map_layout
from shrm.validation import fraction, number, one_of, positive, whole_number

JUDGED_NODES, JUDGED_FRAMES = 1e9, (48, 512)
"""Nodes visited to predict an error, about, and the fewest and most frames that they are shared among."""

_CHUNK = 16384
"""Directions asked of a lobe at once by `integrate`: arrays of 400 kB."""


# ---- The exact answer


def integrate(
    env: Environment,
    brdf: BRDF,
    normals: npt.ArrayLike,
    views: npt.ArrayLike,
    tangents: npt.ArrayLike | None = None,
    *,
    subsamples: int = 1,
) -> FloatArray:
    """Sum the reflected radiance over texels in float64, the BRDF itself evaluated at every one.

    Slow, some 1e7 texels per second, and simple enough to be read and believed.

    Parameters
    ----------
    env : Environment
        Its pixels (H, W, 3) are held constant over each texel.
    brdf : BRDF
        The material.
    normals, views, tangents : (n, 3) array_like
        Unit vectors in the world frame; views point from the surface to the eye, and one view (3,) may serve
        all normals. Tangents are needed for lobes about the tangent and for anisotropic ones, whose frames
        have x along the tangent's part square to the normal; others ignore them.
    subsamples : int
        Each texel is sampled by subsamples^2 Gauss nodes, in [1, 16].

    Returns
    -------
    (n, 3) float64
        Radiance. Where N.V < 0, -N takes the place of N about the reflection, which it leaves as it is; about
        the lobe or the normal the view is brought back to the horizon.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    # Arguments
    pixels = pixels_of(env)
    lobes = lobes_of(brdf)
    anisotropic = any(lobe.kind == "anisotropic" for lobe in lobes)
    n, v, t = queries([lobe.center for lobe in lobes], normals, views, tangents, anisotropic=anisotropic)
    nodes, power = _nodes(pixels, whole_number("subsamples", subsamples, 1, LARGEST_SUBSAMPLES))

    # Each lobe in the frame of each query, over the nodes of the light in chunks
    result = np.zeros((len(n), 3))
    for lobe in lobes:
        kind = lobe.kind
        axes, eyes = (t, v) if lobe.center == "tangent" else (n, v)
        if kind in ("isotropic", "anisotropic"):
            axes, eyes = above_horizon(lobe.center, n, v)
        for k, frame in enumerate(local_frames(axes, t if kind == "anisotropic" else eyes)):
            wo = np.tile(eyes[k] @ frame, (_CHUNK, 1))
            for start in range(0, len(nodes), _CHUNK):
                wi = nodes[start : start + _CHUNK] @ frame
                rho = lobe.transfer(wi, wo[: len(wi)])
                light = power[start : start + _CHUNK]
                # [RH02] eq. 1 in the form of eq. 2; the view comes from the world's frame, eq. 3
                result[k] += rho @ light if rho.ndim == 1 else np.einsum("nc,nc->c", rho, light)
    return result


def _nodes(pixels: Float32Array, k: int) -> tuple[FloatArray, FloatArray]:
    """Return directions (H W k k, 3) and radiance times solid angle, of the texels that are not black."""
    # Gauss nodes in theta, with the solid angles of the rows exact, and in phi
    H, W, _ = pixels.shape
    x, w = np.polynomial.legendre.leggauss(k)
    theta = np.pi / H * (np.arange(H)[:, None] + (1 + x) / 2)
    weight = w * np.sin(theta)
    edges = np.cos(np.pi / H * np.arange(H + 1))
    weight *= ((edges[:-1] - edges[1:]) * 2 * np.pi / W / weight.sum(axis=1))[:, None]
    phi = np.pi - 2 * np.pi / W * (np.arange(W)[:, None] + (1 + x) / 2)

    # Their products in the texels that are not black
    i, j = np.nonzero(np.any(pixels != 0, axis=2))
    t, p = theta[i][:, :, None], phi[j][:, None, :]
    directions = np.stack(
        np.broadcast_arrays(np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)), axis=-1
    )
    area = weight[i][:, :, None] * (w / 2)
    power = area[..., None] * pixels[i, j].astype(np.float64)[:, None, None, :]
    return directions.reshape(-1, 3), power.reshape(-1, 3)


# ---- Prefiltering


def prefilter_angular(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float | None = None,
    cutoff: float | None = None,
    size: int | None = None,
    layout: Layout = "latlong",
    center: Center | None = None,
    subsamples: int | None = None,
    symmetry: bool = True,
) -> AngularReflection:
    """Prepare direct integration of an environment under a material.

    Nothing is integrated yet: the result's `radiance` integrates each query, its `maps_at_view` whole maps.

    Parameters
    ----------
    env : Environment
        Its pixels (H, W, 3) are held constant over each texel.
    brdf : BRDF
        The material.
    tolerance : float, optional
        Relative RMS error of the reflected radiance that is asked for, in (0, 1): lobes are cut as far as it
        allows. Without it and without a cutoff nothing is cut.
    cutoff : float, optional
        In its place: the fraction of each lobe's integral that is cut at its rim, in [0, 1): the sum visits
        only the cap (about a tangent, the band) that holds the rest [RH02 appendix D]. 0, the default, visits
        all, but for texels where a radial lobe is less than 1e-12 of its maximum.
    size : int, optional
        Rows of the maps for "latlong" (twice as many columns; default 128), or the edge of a face for "cube"
        (default 64).
    layout : {"latlong", "cube"}
        Layout of the maps.
    center : {"lobe", "reflection", "normal"}, optional
        Direction that the maps of isotropic lobes are indexed by, in place of the lobe's own. Radiance does
        not depend on it.
    subsamples : int, optional
        Each texel is sampled by subsamples^2 Gauss nodes, in [1, 16]. Default: as many as put nodes closer
        than a quarter of the narrowest lobe's width, at least 2, the texels themselves cut where 16 do not
        suffice; error about 1e-3 or less, or a warning.
    symmetry : bool
        Share work where it is the same: for lat-long maps of radial lobes, the weights of the texels are
        found once for each row of the map and slid along it; for lobes of the half angle, the half vectors
        are found once for the pixels that have one view, where there are enough of them and the table fits a
        cache. False finds angle and lobe anew for every pair of a pixel and a texel, which is the
        prefiltering that [RH02] section 7.4 compares with. The maps are the same.

    Returns
    -------
    AngularReflection

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    pixels = pixels_of(env)
    cutoff = _cutoff(tolerance, cutoff)
    layout = map_layout(layout)
    if center is not None:
        one_of("center", center, ("lobe", "reflection", "normal"))
    edge = DEFAULT_SIZE[layout] if size is None else whole_number("size", size, 1, LARGEST_SIZE)
    if subsamples is not None:
        subsamples = whole_number("subsamples", subsamples, 1, LARGEST_SUBSAMPLES)
    if not isinstance(symmetry, bool):
        raise TypeError(f"symmetry must be True or False, got {symmetry!r}")
    parts = [lobe_integral(lobe, cutoff, center, symmetry) for lobe in lobes_of(brdf)]
    if not parts:
        raise ValueError("brdf must have at least one lobe, got none")
    cut = 1
    if subsamples is None:
        cut, subsamples = resolving(pixels.shape, min(part.width for part in parts))
    return AngularReflection(
        pixels,
        parts,
        edge,
        layout,
        subsamples=subsamples,
        cut=cut,
        symmetry=symmetry,
        cutoff=cutoff,
        brdf=brdf.name,
    )


CUTOFF_OF_TOLERANCE = 0.75
"""Cutoff per tolerance: cutting a fraction of a lobe's integral changes the maps of natural light by up to
1.3 times that fraction, relative RMS."""


def _cutoff(tolerance: float | None, cutoff: float | None) -> float:
    """Return the fraction of lobes that is cut, which may be given by a tolerance."""
    if tolerance is None:
        return fraction("cutoff", 0.0 if cutoff is None else cutoff)
    if cutoff is not None:
        raise ValueError("tolerance and cutoff are two ways to say one thing: give one of them")
    return CUTOFF_OF_TOLERANCE * positive("tolerance", tolerance, 1.0)


class AngularReflection(Reflection):
    """Reflected radiance of one environment under one material, by direct integration.

    Made by `prefilter_angular`.

    Attributes
    ----------
    brdf : str
        The material's name.
    cutoff : float
        Fraction of each lobe's integral that is cut.
    subsamples : int
        Nodes along each side of a texel.
    """

    def __init__(
        self,
        pixels: Float32Array,
        parts: Sequence[LobeIntegral],
        size: int,
        layout: Layout,
        *,
        subsamples: int,
        cut: int,
        symmetry: bool,
        cutoff: float,
        brdf: str,
        error: float | None = None,
    ) -> None:
        self._pixels, self._cut = pixels, cut
        self._picture = picture_of(pixels.repeat(cut, axis=0).repeat(cut, axis=1), subsamples)
        self._parts = tuple(parts)
        self._symmetry = symmetry
        self._error = error
        self._radial_maps: dict[int, Float32Array] = {}
        self.brdf = brdf
        self.cutoff = cutoff
        self.subsamples = subsamples
        self._size = size
        self._layout = layout

    @property
    def table_error(self) -> float:
        """The largest relative RMS error of the lobes' tables.

        The sum itself runs in float32 along rows and in float64 across.
        """
        return max(part.table_error for part in self._parts)

    @cached_property
    def _directions(self) -> FloatArray:
        """The directions of the maps' texels."""
        return map_directions(self.layout, self.size)

    @property
    def error(self) -> float:
        """The predicted relative RMS error of the reflected radiance.

        The largest over the lobes, whose light adds up and does not cancel: what the cut and the nodes do,
        measured at frames drawn at random against the uncut lobe at twice the nodes to a side, and the error
        of its table beside it. About a fifth is the uncertainty of the frames drawn.
        """
        if self._error is None:
            of_lobes = [np.hypot(self._cut_error(part), part.table_error) for part in self._parts]
            self._error = float(max(of_lobes))
        return self._error

    def _cut_error(self, part: LobeIntegral) -> float:
        """Measure the error of the cut and the nodes of a lobe's integral, relative RMS, at random frames."""
        random = np.random.default_rng(2002)
        subsamples = min(2 * self.subsamples, LARGEST_SUBSAMPLES)
        nodes = self._picture["planes"].shape[1] * self._picture["planes"].shape[2] * subsamples**2
        C, weight = drawn_directions(self._pixels, int(np.clip(JUDGED_NODES / nodes, *JUDGED_FRAMES)), random)

        # Views as random frames have them, from any side
        azimuth, theta_o = 2 * np.pi * random.random(len(C)), part.theta_o(random.random(len(C)))
        local = [np.sin(theta_o) * np.cos(azimuth), np.sin(theta_o) * np.sin(azimuth), np.cos(theta_o)]
        v = np.einsum("nxk,kn->nx", local_frames(C, C), np.stack(local))
        n = np.ascontiguousarray(part.normals(C, v))

        # Against the uncut lobe at twice the nodes
        exact = part.uncut().radiance({**self._picture, "subsamples": subsamples}, n, v, C).astype(np.float64)
        difference = part.radiance(self._picture, n, v, C) - exact
        energy = weight @ (exact**2).sum(axis=1)
        return float(np.sqrt(weight @ (difference**2).sum(axis=1) / energy)) if energy > 0 else 0.0

    def __repr__(self) -> str:
        centers = ", ".join(self.centers)
        return f"<AngularReflection about {centers}: cutoff={self.cutoff:g} {self.layout} {self.size}>"

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
        return tuple(part.center for part in self._parts)

    def radiance(
        self, normals: npt.ArrayLike, views: npt.ArrayLike, tangents: npt.ArrayLike | None = None
    ) -> Float32Array:
        """Return the reflected radiance, each query integrated.

        Parameters
        ----------
        normals, views, tangents : (n, 3) array_like
            As in `integrate`.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        n, v, t = queries(self.centers, normals, views, tangents)
        result = np.zeros((len(n), 3), dtype=np.float32)
        for part in self._parts:
            result += part.radiance(self._picture, n, v, t)
        return result

    def lobe_maps(self, view: FloatArray) -> Iterator[Float32Array]:
        """Yield the map of each lobe; see `shrm.lobes.reflection.Reflection`."""
        for k, part in enumerate(self._parts):
            yield self._radial_map(k, part) if isinstance(part, RadialIntegral) else self._map(part, view)

    def _radial_map(self, k: int, part: RadialIntegral) -> Float32Array:
        """Return the map of a radial lobe, the same for all views: it is computed once."""
        if k not in self._radial_maps:
            if self.layout == "latlong":
                self._radial_maps[k] = part.map(self._picture, self.size, 2 * self.size, self._symmetry)
            else:
                C = self._directions
                flat = part.about(self._picture, np.ascontiguousarray(C.reshape(-1, 3)))
                self._radial_maps[k] = flat.reshape(C.shape)
        return self._radial_maps[k].copy()

    def _map(self, part: LobeIntegral, view: FloatArray) -> Float32Array:
        """Integrate the map of any other lobe for a view."""
        C = np.ascontiguousarray(self._directions.reshape(-1, 3))
        views = np.ascontiguousarray(np.broadcast_to(view, C.shape))
        normals = part.normals(C, views)
        return part.radiance(self._picture, normals, views, C).reshape(self._directions.shape)

    # ---- Files

    def save(self, path: PathLike) -> None:
        """Write an OpenEXR file with the light and the tables of lobes (`shrm.integrate.file`).

        The predicted error is in it if it was asked for before, and found again otherwise.

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """
        lobes = tuple(file.SavedLobe(part.kind, part.center, part.to_arrays()) for part in self._parts)
        numbers = {
            "cutoff": self.cutoff,
            "subsamples": self.subsamples,
            "cut": self._cut,
            "symmetry": self._symmetry,
            **({} if self._error is None else {"error": self._error}),
        }
        file.write(
            path,
            file.SavedIntegration("angular", self.brdf, self._pixels, self.layout, self.size, lobes, numbers),
        )

    @classmethod
    def load(cls, path: PathLike) -> AngularReflection:
        """Read what `save` wrote.

        Raises
        ------
        shrm.ImageError
            If it cannot be read, is damaged, or holds something else.
        """
        saved = file.read(path, "angular", ("cutoff", "subsamples", "cut", "symmetry", "error"))
        with file.refusing_damage(path):
            numbers = saved.numbers
            largest_cut = max(1, LARGEST_CUT // max(saved.pixels.shape))
            return cls(
                saved.pixels,
                [INTEGRALS[lobe.kind].from_arrays(lobe.center, lobe.arrays) for lobe in saved.lobes],
                saved.size,
                saved.layout,
                subsamples=whole_number("subsamples", int(numbers["subsamples"]), 1, LARGEST_SUBSAMPLES),
                cut=whole_number("cut", int(numbers["cut"]), 1, largest_cut),
                symmetry=bool(whole_number("symmetry", int(numbers["symmetry"]), 0, 1)),
                cutoff=fraction("cutoff", numbers["cutoff"]),
                brdf=saved.brdf,
                error=number("error", numbers["error"], 0.0) if "error" in numbers else None,
            )
