"""What prefiltering costs by each method, predicted, and which is the cheaper at a wanted error.

In frequency space the cost grows with the degree, C_f = O(F S^2) [RH02 eq. 9]; by integration it falls with
the lobe's solid angle, C_a = O(W S^4) [RH02 eq. 10], W ~ 1 / F^2. Below the crossover s* of exponents the
one is to be preferred, above it the other.

The rates are seconds of one thread, measured at 256 x 128 texels by `shrm reproduce table-4` and `bench/`;
where another machine is faster, it is so for both methods, and their ratio decides.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
"""

from __future__ import annotations

import warnings
from typing import Literal

import numpy as np

from shrm.brdf import BRDF
from shrm.environment import Environment
from shrm.orders import Orders, ToleranceWarning, choose
from shrm.rings import Layout

ANGULAR_SHARE = 0.75
"""Of a wanted error, what may be cut from a lobe's integral: the error of the maps is up to 1.3 of it."""

_CALL = 4e-4
_ANALYSIS, _ANALYSIS_BY_F = 6e-10, 2.6e-11  # per texel of the light
_SYNTHESIS, _SYNTHESIS_BY_J = 6e-11, 5e-12  # per value of a lat-long map
_CUBE = 2e-12  # per value of a cube map and coefficient
_VIEW = 4.5e-11  # per value of a map, for each view

_TABLES = {"radial": 8e-3, "zonal": 4e-2, "isotropic": 1.2e-1}
_BY_SYMMETRY = 3.5e-11  # per pair of texels, radial lobes on lat-long maps
_SAMPLE = {"radial": 1.8e-10, "zonal": 1.5e-9, "isotropic": 3.5e-9}  # per pair of texels
_QUERY = 4e-7  # per texel of a map


def cheaper(
    env: Environment,
    brdf: BRDF,
    tolerance: float,
    *,
    size: int,
    layout: Layout,
    views: int,
    F_max: int,
    P_max: int,
) -> Literal["frequency", "angular"]:
    """Return the cheaper of the methods that reach a tolerance.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material, its lobes about the centres they will have.
    tolerance : float
        Relative RMS error of the reflected light. What frequency space cannot reach within the caps is left
        to integration.
    size, layout
        The maps.
    views : int
        For how many views a map is wanted.
    F_max, P_max : int
        Caps on the orders.

    Returns
    -------
    {"frequency", "angular"}

    Raises
    ------
    TypeError, ValueError
        As `shrm.orders.choose`.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        chosen = choose(brdf, tolerance, "light", env, F_max=F_max, P_max=P_max)
    if chosen.limited_by:
        return "angular"
    H, W, _ = env.pixels.shape
    texels = size * size * (2 if layout == "latlong" else 6)
    in_frequency = frequency_seconds(H * W, brdf, chosen, texels, layout, views)
    by_angle = angular_seconds(H * W, brdf, chosen, texels, layout, views)
    return "frequency" if in_frequency <= by_angle else "angular"


def frequency_seconds(
    light_texels: int, brdf: BRDF, orders: Orders, texels: int, layout: Layout, views: int
) -> float:
    """Predict the time in frequency space: analysis, synthesis and a sum for each view [RH02 eq. 9]."""
    seconds = _CALL + light_texels * (_ANALYSIS + _ANALYSIS_BY_F * orders.F)
    for lobe, of_lobe in zip(brdf.lobes, orders.lobes, strict=True):
        global_form = lobe.kind == "isotropic"
        values = 3 * texels * ((of_lobe.P + 1) ** 2 if global_form else of_lobe.P + 1)
        J = of_lobe.F + (of_lobe.P if global_form else 0)
        per_value = _CUBE * (J + 1) ** 2 if layout == "cube" else _SYNTHESIS + _SYNTHESIS_BY_J * J
        seconds += values * (per_value + _VIEW * views)
    return seconds


def angular_seconds(
    light_texels: int, brdf: BRDF, orders: Orders, texels: int, layout: Layout, views: int
) -> float:
    """Predict the time by integration: tables, and each texel of a map against those of the light in its cap.

    The cap's share of the sphere is taken from the lobe's degree: cos^s has all but eps of its integral
    in the share -ln(eps) / (2 s) of the sphere about its axis, and all but eps' of its energy up to F^2 =
    -s ln(eps') [RH02 appendix D]; for eps = .05 and eps' = .01 the share is 7 / F^2.
    """
    seconds = _CALL
    for lobe, of_lobe in zip(brdf.lobes, orders.lobes, strict=True):
        kind = lobe.kind
        pairs = texels * light_texels * float(np.clip(7 / max(of_lobe.F, 1) ** 2, 0, 0.5))
        by_symmetry = kind == "radial" and layout == "latlong"
        maps = 1 if kind == "radial" else views
        per_map = pairs * (_BY_SYMMETRY if by_symmetry else _SAMPLE[kind])
        seconds += _TABLES[kind] + maps * (per_map + (0 if by_symmetry else _QUERY * texels))
    return seconds
