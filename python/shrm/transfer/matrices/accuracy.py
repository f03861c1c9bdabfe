"""How accurate outgoing radiance is, measured at some vertices; and the fewest tents that will do.

The error of tents, of harmonics between and of the rays' number depends on the material and on what hides
the light: no formula knows it. So some vertices see the light along many more rays, and reflect it towards
some views without any expansion. The relative SNR of what a product has there is 10 log10 of the energy over
that of the error, both summed over random light of order n, the views and the vertices.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from shrm import _core
from shrm.arrays import BoolArray, Float32Array, FloatArray, RealArray
from shrm.brdf import BRDF
from shrm.transfer.described import Described
from shrm.transfer.matrices.product import Product, Route, accumulate, harmonics, product, view_rows
from shrm.vectors import GOLDEN_RATIO

TENTS = (3, 5, 7, 9, 11, 13, 15, 17, 21, 25)
"""Numbers M among which `chosen` looks for the smallest."""

MARGIN = 1.0
"""Decibels by which the SNR at the sample has to exceed the accuracy: other vertices may have less."""

_VIEWS = 256
"""Views towards which vertices of the sample reflect light."""


@dataclass(frozen=True, eq=False, repr=False)
class Sample(Described):
    """Sample of vertices, and what hides the light there.

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


def relative_snr(expected: RealArray, actual: RealArray) -> float:
    """Return 10 log10(|expected|^2 / |expected - actual|^2), infinite if they are the same."""
    lost = float(np.sum((np.asarray(expected, np.float64) - actual) ** 2))
    energy = float(np.sum(np.asarray(expected, np.float64) ** 2))
    return 10 * np.log10(energy / lost) if lost > 0 and energy > 0 else np.inf


def reference(brdf: BRDF, n: int, sample: Sample) -> Float32Array:
    """Return radiance towards `views` for each harmonic of the light, (vertices, views C, n^2)."""
    Y = harmonics(sample.fine_directions, n).astype(np.float32)
    return accumulate(view_rows(brdf, views(), n, sample.fine_directions), sample.fine_visible, Y)


def measured(product: Product, expected: Float32Array, sample: Sample) -> float:
    """Return the relative SNR of a product against `reference`, in dB."""
    Y = harmonics(sample.directions, round(np.sqrt(expected.shape[2]))).astype(np.float32)
    A = accumulate(product.rays, sample.visible, Y)
    tents = np.moveaxis(A.reshape(len(A), product.basis.size, -1), 1, 0)
    radiance = product.basis.evaluate(tents.reshape(len(tents), -1), views())
    by_vertex = np.moveaxis(radiance.reshape(len(radiance), len(A), -1, expected.shape[2]), 1, 0)
    return relative_snr(expected, by_vertex.reshape(expected.shape))


def chosen(
    brdfs: Sequence[BRDF],
    n: int,
    sample: Sample,
    accuracy: float,
    *,
    M: int | None = None,
    route: Route | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[int, Route, float]:
    """Return the fewest tents M, the route and its accuracy in dB that suit all materials.

    Parameters
    ----------
    brdfs : sequence of BRDF
    n : int
        Order of the light.
    sample : Sample
    accuracy : float
        SNR that is asked for, in dB. If nothing reaches it, what comes nearest is returned.
    M, route
        Given ones are kept. Without a route it is the shortest that will do: inner order n, then 8 if n is
        smaller, both with views of order 8, then none.
    progress : callable
        Called with the number of tents tried and to be tried.
    """
    expected = [reference(brdf, n, sample) for brdf in brdfs]
    enough = accuracy + MARGIN

    def worst(M: int, route: Route) -> float:
        """Return the SNR of the material that has the least."""
        products = (product(brdf, M, n, sample.directions, route, points=2) for brdf in brdfs)
        return min(measured(*pair, sample) for pair in zip(products, expected, strict=True))

    # Of the routes that are tried the first is the most accurate. More tents are more accurate and take
    # longer: from the middle on upwards, or downwards as long as they will do.
    routes = (route,) if route else (Route(), *(Route(order, m=8) for order in sorted({n, max(n, 8)})))
    tried = TENTS if M is None else (M,)
    start = len(tried) // 2 - 1 if M is None else 0
    snr = {start: worst(tried[start], routes[0])}
    progress(1, len(tried))
    step = -1 if snr[start] >= enough else 1
    k = start
    while 0 <= k + step < len(tried):
        k += step
        snr[k] = worst(tried[k], routes[0])
        progress(len(snr), len(tried))
        if (snr[k] >= enough) == (step > 0):
            break

    # The fewest tents that will do, and the first of the cheaper routes that will do with them
    will_do = [k for k in snr if snr[k] >= enough]
    k = min(will_do) if will_do else max(snr, key=lambda k: snr[k])
    for shorter in routes[1:]:
        of_shorter = worst(tried[k], shorter)
        if of_shorter >= enough:
            progress(len(tried), len(tried))
            return tried[k], shorter, of_shorter
    progress(len(tried), len(tried))
    return tried[k], routes[0], snr[k]


def views() -> FloatArray:
    """Return views (256, 3) of equal solid angles above the horizon: the golden ratio's lattice."""
    k = np.arange(_VIEWS)
    positions = np.stack([(k + 0.5) / _VIEWS, (k * GOLDEN_RATIO + 0.25) % 1], axis=1)
    return _core.hemisphere_from_square(positions=positions)
