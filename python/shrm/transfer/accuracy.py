"""How accurate outgoing radiance is, measured at some vertices; and the fewest tents that will do.

The error of tents, of harmonics between and of the rays' number depends on the material and on what hides
the light: no formula knows it. So some vertices see the light along many more rays, and reflect it towards
some views without any expansion. The relative SNR, in dB, of what a product has there is the mean over white
light of order n, over the views above the horizon, and over the vertices.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.brdf import BRDF
from shrm.transfer.product import (
    BoolArray,
    Float32Array,
    Path,
    Product,
    accumulate,
    harmonics,
    product,
    view_rows,
)

FloatArray = npt.NDArray[np.float64]

TENTS = (3, 5, 7, 9, 11, 13, 15, 17, 21, 25)
"""Numbers M that are tried, in this order."""

MARGIN = 1.0
"""In dB, by which the accuracy at the sample has to exceed the one that is asked for."""

_VIEWS = 256


@dataclass(frozen=True, eq=False)
class Sample:
    """Some vertices and what hides the light there.

    Attributes
    ----------
    directions : (D, 3) float64
        The local directions that products know.
    visible : (vertices, D) bool
    fine_directions : (D', 3) float64
        More of them.
    fine_visible : (vertices, D') bool
    """

    directions: FloatArray
    visible: BoolArray
    fine_directions: FloatArray
    fine_visible: BoolArray


def relative_snr(expected: npt.NDArray[np.floating], found: npt.NDArray[np.floating]) -> float:
    """Return 10 log10(|expected|^2 / |expected - found|^2), infinite if they are the same."""
    lost = float(np.sum((np.asarray(expected, np.float64) - found) ** 2))
    whole = float(np.sum(np.asarray(expected, np.float64) ** 2))
    return 10 * np.log10(whole / lost) if lost > 0 and whole > 0 else np.inf


def reference(brdf: BRDF, n: int, sample: Sample) -> Float32Array:
    """Return radiance towards `views` for each harmonic of the light, (vertices, views C, n^2)."""
    Y = harmonics(sample.fine_directions, n).astype(np.float32)
    return accumulate(view_rows(brdf, views(), n, sample.fine_directions), sample.fine_visible, Y)


def measured(made: Product, expected: Float32Array, sample: Sample) -> float:
    """Return the relative SNR of a product against `reference`, in dB."""
    Y = harmonics(sample.directions, round(np.sqrt(expected.shape[2]))).astype(np.float32)
    A = accumulate(made.rays, sample.visible, Y)
    tents = A.reshape(len(A), made.basis.size, -1)
    found = np.stack([made.basis.evaluate(one, views()) for one in tents])
    return relative_snr(expected, found.reshape(expected.shape))


def chosen(
    brdfs: Sequence[BRDF],
    n: int,
    sample: Sample,
    accuracy: float,
    *,
    M: int | None = None,
    path: Path | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[int, Path, float]:
    """Return the fewest tents M, the path and its accuracy in dB that suit all materials.

    Parameters
    ----------
    brdfs : sequence of BRDF
    n : int
        Order of the light.
    sample : Sample
    accuracy : float
        Wanted, in dB. If nothing reaches it, what comes nearest is returned.
    M, path
        Given ones are kept. Without a path it is the shortest that will do: inner order n, inner order 8,
        direct.
    progress : callable
        Called with the number of tents tried and to be tried.
    """
    expected = [reference(brdf, n, sample) for brdf in brdfs]

    def worst(M: int, path: Path, points: int = 2) -> float:
        made = (product(brdf, M, n, sample.directions, path, points) for brdf in brdfs)
        return min(measured(one, rows, sample) for one, rows in zip(made, expected, strict=True))

    paths = (path,) if path else (Path(), *(Path(order, m=8) for order in (n, 8) if order >= n))
    best: tuple[int, Path, float] | None = None
    tried = TENTS if M is None else (M,)
    for k, count in enumerate(tried):
        progress(k, len(tried))
        found = worst(count, paths[0])  # of the paths that are tried the most accurate
        if best is None or found > best[2]:
            best = count, paths[0], found
        if found >= accuracy + MARGIN:
            break
    assert best is not None
    for other in paths[1:]:
        found = worst(best[0], other)
        if found >= accuracy + MARGIN:
            best = best[0], other, found
            break
    progress(len(tried), len(tried))
    return best


def views() -> FloatArray:
    """Views (256, 3) of equal solid angles above the horizon: the golden ratio's lattice on the square."""
    k = np.arange(_VIEWS)
    positions = np.stack([(k + 0.5) / _VIEWS, (k * (np.sqrt(5) - 1) / 2 + 0.25) % 1], axis=1)
    return _core.hemisphere_from_square(positions=positions)
