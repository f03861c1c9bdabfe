"""Prefiltering in frequency space: from an environment and a material to a reflection map.

The three steps of [RH02] appendix C: coefficients of light and material, their product, synthesis. The
global form is synthesised at once, as an ordinary band-limited function (see
`cpp/shrm/reflection/map_coefficients.hpp`).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from shrm.frequency.expansion import Expansion, expansion_for, require_memory
from shrm.frequency.interpolation import interpolation_error, map_spectrum, measured_interpolation_error
from shrm.frequency.orders import ToleranceWarning
from shrm.frequency.part import Part
from shrm.frequency.prediction import Prediction, Truncation
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.request import Request, takes
from shrm.frequency.split_orders import CORE_SHARE
from shrm.integrate.queries import DEFAULT_SIZE
from shrm.integrate.residual import Residual, residual_for
from shrm.lobes.reflection import map_names

_SIZES = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024)
"""Sizes that are chosen from: powers of two, and one and a half times these."""

_SIZES_TRIED = 4
"""Most sizes that are tried: the first suffices except where the fit over the views is ill-conditioned."""

_BETWEEN_TEXELS = 0.1
"""Fraction of the truncation error that interpolation may add, in quadrature: half a percent of the whole."""

_LEAST_ERROR = 1e-3
"""Truncation error that takes the place of smaller ones there: finer maps would not be seen."""


@takes(Request)
def prefilter(request: Request) -> ReflectionMap:
    """Prefilter an environment with a material.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material, of one lobe or several.
    tolerance : float
        The error allowed, in (0, 1); by default the relative RMS of the reflected radiance.
    orders : (F, P), optional
        Use these orders instead. Radial lobes have P = 0 whatever is asked for.
    criterion : {"light", "brdf", "minimum", "bound"}
        What the error measures, see `shrm.orders`.
    size : int, optional
        Rows of a lat-long map (even, its width is twice that), or of a cube's face. By default chosen so that
        cubic interpolation adds less than a tenth of the predicted error.
    layout : {"latlong", "cube"}
        The grid of the maps; "strip" is another name for "cube".
    center : {"lobe", "reflection", "normal"}, optional
        Put the lobes that are not exactly symmetric about this center; "reflection" is the paper's.
    F_max, P_max : int
        Caps on the orders that a tolerance may take.
    window : {"hann", "lanczos"}, optional
        Damp the high degrees against ringing; counted in the predicted error by the criteria `light` and
        `brdf`.
    clamp : bool
        Set negative radiance to zero when the map is read.
    half : bool
        Keep the maps as half floats: half the memory, half the time of `at_view`, 5e-4 of relative rounding.
        The coefficients stay in full precision; files hold the rounded maps as 32-bit floats.
    residual : "auto", optional
        Split off the cores of lobes that the orders, given or within the caps, cannot hold at the tolerance;
        they are integrated, or looked up, whenever the map is read (`shrm.integrate.residual`). The maps are
        then 128 rows, or 64 of a face, at least. For the criterion `light` without a window; lobes about the
        tangent stay whole.

    Returns
    -------
    ReflectionMap

    Warns
    -----
    ToleranceWarning
        If the tolerance cannot be met within the caps; with a residual, if it is not met even so.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type or out of its range, a residual does not go with others, the maps
        would take more than 4 GiB, or, as half floats, hold values beyond 65504.
    """
    return reflection_map(request, expansion_for(request))


def reflection_map(request: Request, expansion: Expansion) -> ReflectionMap:
    """Return the reflection map of an expansion that was made for a request."""
    require_memory(expansion, request.size, request.layout)
    truncation = Truncation(request.env, expansion)
    parts = _sampled(request, expansion, truncation)
    residual, cores_error = _residual(request, expansion, truncation, parts)
    if request.half:
        parts = tuple(part.as_half() for part in parts)
    return ReflectionMap(
        parts,
        expansion.material.name,
        request.criterion,
        request.window,
        request.clamp,
        Prediction(truncation, parts, cores_error),
        residual,
    )


def _sampled(request: Request, expansion: Expansion, truncation: Truncation) -> tuple[Part, ...]:
    """Return the maps of the lobes, of the size asked for, or of one whose texels lie close enough."""
    parts, layout = expansion.parts(request.env), request.layout
    if request.size is not None:
        return tuple(part.resized(request.size, layout) for part in parts)

    # The error allowed to interpolation, relative to what is expanded, and sizes whose spectra promise it
    allowed = _BETWEEN_TEXELS * max(truncation.error, _LEAST_ERROR) / truncation.smooth_share
    least = DEFAULT_SIZE[layout] if expansion.has_cores else 0
    spectra = [map_spectrum(part) for part in parts]
    fine = [s for s in _SIZES if s >= least and interpolation_error(spectra, s, layout) <= allowed]

    # The first of them whose look-ups keep the promise, or the last that is tried
    *smaller, largest = fine[:_SIZES_TRIED] or _SIZES[-1:]
    for size in smaller:
        sampled = tuple(part.resized(size, layout) for part in parts)
        if measured_interpolation_error(sampled) <= allowed:
            return sampled
    return tuple(part.resized(largest, layout) for part in parts)


def _residual(
    request: Request, expansion: Expansion, truncation: Truncation, parts: Sequence[Part]
) -> tuple[Residual | None, float]:
    """Return the residual that an expansion asks for, and its error relative to all that is reflected."""
    # The lobes that have a core
    if expansion.cores is None:
        return None, 0.0
    names = map_names([part.center for part in parts])
    cores = [
        (name, core, part.center, part.gamma)
        for name, core, part in zip(names, expansion.cores, parts, strict=True)
        if core is not None
    ]

    # Their integrators, within a share of the tolerance
    residual, error = None, 0.0
    if cores:
        allowed = (CORE_SHARE * request.tolerance) ** 2 * truncation.energy
        residual, squared = residual_for(request.env.pixels, cores, parts[0].layout, parts[0].size, allowed)
        error = float(np.sqrt(squared / truncation.energy)) if truncation.energy > 0 else 0.0

    reached = float(np.hypot(truncation.error, error))
    if reached > request.tolerance:
        warnings.warn(
            f"{expansion.material.name}: tolerance {request.tolerance:g} is not met with a residual: "
            f"the error is {reached:.3g}",
            ToleranceWarning,
            stacklevel=5,
        )
    return residual, error
