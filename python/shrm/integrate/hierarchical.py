"""Prefiltering by descent in a pyramid of the environment: fast where lobes are sharp.

[KVHS00] section 5.1 with the light taken into account. The pyramid is a quadtree over the two paraboloids of
[HS98]. Its nodes hold power, radiance times solid angle, at their centroid; a lobe is compared between a node
and its children, and only where their difference would change the reflected light are they entered.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.files import PathLike
from shrm.integrate import file
from shrm.integrate.angular_lobes import half_width
from shrm.integrate.descent_lobes import LobeDescent, descent_from_arrays, lobe_descent
from shrm.integrate.queries import DEFAULT_SIZE, LARGEST_SIZE, lobes_of, pixels_of, queries
from shrm.integrate.saved_arrays import number as saved_number
from shrm.integrate.threshold import Frames, frames_at, map_texels, predicted_error, threshold_for
from shrm.lobes.reflection import Layout, Reflection, map_layout
from shrm.validation import number, positive, whole_number


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
        Relative RMS error asked for, against the sum over all texels, in (0, 1); default .01. It is taken
        over the maps of all views together: where most of the reflected light is at grazing views or comes
        from the horizon (microfacets of f0 = 0), a single map, or all, may have several times as much. The
        threshold is found from some blocks of texels of maps of random views.
    threshold : float, optional
        Given in place of a tolerance: by how much the light of a node may change, its brightness times the
        difference of the lobe between it and its parent, relative to the mean reflected light. 0 visits every
        texel.
    size : int, optional
        Rows of the maps for "latlong" (default 128), or the edge of a face for "cube" (default 64).
    layout : {"latlong", "cube"}
        Layout of the maps.

    Returns
    -------
    HierarchicalReflection

    Warns
    -----
    UserWarning
        If no threshold is given, and a lobe is so narrow that it falls between the texels.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    pixels = pixels_of(env)
    layout = map_layout(layout)
    edge = DEFAULT_SIZE[layout] if size is None else whole_number("size", size, 1, LARGEST_SIZE)

    # Either a tolerance or a threshold
    if tolerance is not None and threshold is not None:
        raise ValueError("tolerance and threshold are two ways to say one thing: give one of them")
    if threshold is None:
        tolerance = 0.01 if tolerance is None else positive("tolerance", tolerance, 1.0)
    else:
        threshold = number("threshold", threshold, 0.0)

    lobes = [lobe_descent(lobe) for lobe in lobes_of(brdf)]
    if not lobes:
        raise ValueError("brdf must have at least one lobe, got none")
    pyramid = _core.Pyramid(pixels)
    if tolerance is None:
        thresholds, errors = [float(threshold or 0.0)] * len(lobes), None
    else:
        _warn_of_narrow_lobes(pixels, brdf)
        searched = [threshold_for(lobe, pyramid, edge, tolerance) for lobe in lobes]
        thresholds, errors = [value for value, _ in searched], [error for _, error in searched]
    return HierarchicalReflection(
        pixels, pyramid, lobes, thresholds, edge, layout, brdf=brdf.name, errors=errors
    )


BETWEEN_TEXELS = 0.125
"""Distances of texels, which count as points, that half of a lobe must reach not to fall between them."""


def _warn_of_narrow_lobes(pixels: Float32Array, brdf: BRDF) -> None:
    """Warn if lobes fall between the points of a light; zonal ones are warned of by their tables."""
    H, W, _ = pixels.shape
    spacing = max(np.pi / H, 2 * np.pi / W)
    narrowest = min((half_width(lobe) for lobe in lobes_of(brdf) if lobe.kind != "zonal"), default=np.inf)
    if narrowest < BETWEEN_TEXELS * spacing:
        warnings.warn(
            f"a lobe {narrowest:.1g} rad wide falls between the texels, which count as points: they are"
            f" {spacing:.1g} rad apart",
            stacklevel=3,
        )


class HierarchicalReflection(Reflection):
    """Reflected radiance of one environment under one material, by descent.

    Made by `prefilter_hierarchical`.

    Attributes
    ----------
    brdf : str
        The material's name.
    threshold : tuple of float
        Threshold of each lobe.
    evaluations : float
        Evaluations of the lobes for each target, in the last call.
    """

    def __init__(
        self,
        pixels: Float32Array,
        pyramid: _core.Pyramid,
        lobes: Sequence[LobeDescent],
        threshold: Sequence[float],
        size: int,
        layout: Layout,
        *,
        brdf: str,
        errors: Sequence[float] | None = None,
    ) -> None:
        self._pixels, self._pyramid = pixels, pyramid
        self._lobes = tuple(lobes)
        self._size, self._layout = size, layout
        self._errors = None if errors is None else tuple(errors)
        self.brdf = brdf
        self.threshold = tuple(threshold)
        self.evaluations = 0.0

    @cached_property
    def _texels(self) -> tuple[tuple[int, ...], npt.NDArray[np.intp], FloatArray]:
        """The maps' texels, as `map_texels` has them."""
        return map_texels(self.layout, self.size)

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

    @property
    def table_error(self) -> float:
        """The largest relative RMS error of the lobes' tables."""
        return max(lobe.table_error for lobe in self._lobes)

    @property
    def error(self) -> float:
        """The predicted relative RMS error of the reflected radiance, against the sum over all texels.

        The largest over the lobes, whose light adds up and does not cancel: that of its threshold, measured
        in a sample of maps (`shrm.integrate.threshold`), and that of its table beside it.
        """
        if self._errors is None:
            self._errors = tuple(
                predicted_error(lobe, self._pyramid, self.size, threshold)
                for lobe, threshold in zip(self._lobes, self.threshold, strict=True)
            )
        return max(
            float(np.hypot(error, lobe.table_error))
            for error, lobe in zip(self._errors, self._lobes, strict=True)
        )

    def __getstate__(self) -> dict[str, object]:
        """Return what is pickled: the pyramid is made again."""
        return {name: value for name, value in self.__dict__.items() if name != "_pyramid"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._pyramid = _core.Pyramid(self._pixels)

    def __repr__(self) -> str:
        thresholds = ", ".join(f"{threshold:.2g}" for threshold in self.threshold)
        centers = ", ".join(self.centers)
        return f"<HierarchicalReflection about {centers}: threshold={thresholds} {self.layout} {self.size}>"

    def update(self, env: Environment) -> None:
        """Take another light, of any size; thresholds stay.

        Raises
        ------
        TypeError, ValueError
            If it is none.
        """
        self._pixels = pixels_of(env)
        self._pyramid = _core.Pyramid(self._pixels)
        self._errors = None

    def radiance(
        self, normals: npt.ArrayLike, views: npt.ArrayLike, tangents: npt.ArrayLike | None = None
    ) -> Float32Array:
        """Return the reflected radiance, each query integrated.

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
        shape, order, targets = self._texels
        v = np.broadcast_to(view, targets.shape)
        self.evaluations = 0.0
        for lobe, threshold in zip(self._lobes, self.threshold, strict=True):
            pixels = np.empty(targets.shape, np.float32)
            pixels[order] = self._reflected(lobe, frames_at(lobe, targets, v), threshold)
            yield pixels.reshape(shape)

    def _reflected(self, lobe: LobeDescent, frames: Frames, threshold: float) -> Float32Array:
        """Return the radiance of one lobe at frames, and count its evaluations."""
        radiance, evaluations = lobe.radiance(self._pyramid, *frames, threshold)
        self.evaluations += evaluations
        return radiance

    # ---- Files

    def save(self, path: PathLike) -> None:
        """Write an OpenEXR file with the light and the tables of lobes (`shrm.integrate.file`).

        The predicted error is in it if it is known, and found again otherwise.

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """
        lobes = []
        for k, lobe in enumerate(self._lobes):
            numbers = {"table error": lobe.table_error, "threshold": self.threshold[k]}
            if self._errors is not None:
                numbers["error"] = self._errors[k]
            arrays = {**lobe.to_arrays(), **{name: np.asarray(value) for name, value in numbers.items()}}
            lobes.append(file.SavedLobe(lobe.kind, lobe.center, arrays))
        file.write(
            path,
            file.SavedIntegration(
                "hierarchical", self.brdf, self._pixels, self.layout, self.size, tuple(lobes), {}
            ),
        )

    @classmethod
    def load(cls, path: PathLike) -> HierarchicalReflection:
        """Read what `save` wrote.

        Raises
        ------
        shrm.ImageError
            If it cannot be read, is damaged, or holds something else.
        """
        saved = file.read(path, "hierarchical", ())
        with file.refusing_damage(path):
            arrays = [lobe.arrays for lobe in saved.lobes]
            known = all("error" in of_lobe for of_lobe in arrays)
            return cls(
                saved.pixels,
                _core.Pyramid(saved.pixels),
                [descent_from_arrays(lobe.kind, lobe.center, lobe.arrays) for lobe in saved.lobes],
                [saved_number(of_lobe, "threshold") for of_lobe in arrays],
                saved.size,
                saved.layout,
                brdf=saved.brdf,
                errors=[saved_number(of_lobe, "error") for of_lobe in arrays] if known else None,
            )
