"""The predicted cost of prefiltering by each method, and the cheapest method for a tolerance.

In frequency space the cost grows with the degree, C_f = O(F S^2) [RH02 eq. 9]; by integration it falls with
the lobe's solid angle, C_a = O(W S^4) [RH02 eq. 10], W ~ 1 / F^2. Below a crossover s* of exponents
frequency space is cheaper, above it integration. A descent in a pyramid of the light evaluates a lobe about
equally often for each texel of a map, whatever lobe and light are [KVHS00 section 5.1]: it costs less than
integration where the light has many texels, and a table and a search for its threshold more.

The rates are seconds of one thread at 128 x 64 to 512 x 256 texels of light (`rates.csv`, with machine and
commit; `bench/cost_rates.py` measures them); where another machine is faster, it is so for all methods, and
their ratio decides.
"""

from __future__ import annotations

import csv
import math
import warnings
from functools import cache
from pathlib import Path
from typing import Literal

from shrm.brdf import BRDF
from shrm.environment import Environment, require_environment
from shrm.frequency.orders import F_MAX, P_MAX, Orders, ToleranceWarning, choose
from shrm.integrate.angular import CUTOFF_OF_TOLERANCE
from shrm.integrate.angular_lobes import half_width, share_visited
from shrm.integrate.queries import DEFAULT_SIZE
from shrm.lobes.reflection import Layout, map_layout
from shrm.validation import whole_number

_COLORED = 2.0
"""Time of a lobe of three channels relative to that of a lobe of one."""

_RING_WIDTH = 0.05
"""Half the width of a ring, radians, below which a descent evaluates it in inverse proportion more often."""

_SEARCHED_MAPS, _SEARCHED_TEXELS = 3.0, 2e4
"""Cost of the search for a threshold: that of so many maps, and of so many texels besides."""

_TEXELS_TO_A_WIDTH = 1.5
"""Texels of the light in a lobe's half width from which on they may count as points."""


@cache
def rates() -> dict[str, float]:
    """Return the seconds of each step by name, as `rates.csv` beside this module says."""
    lines = (Path(__file__).parent / "rates.csv").read_text().splitlines()
    table = csv.DictReader(line for line in lines if not line.startswith("#"))
    return {row["name"]: float(row["seconds"]) for row in table}


Method = Literal["frequency", "angular", "hierarchical"]


def cheapest(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float = 0.05,
    size: int | None = None,
    layout: Layout = "latlong",
    views: int = 1,
    points: int = 0,
    F_max: int = F_MAX,
    P_max: int = P_MAX,
) -> Method:
    """Return the method of prefiltering that costs least, of those that are predicted to reach a tolerance.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material, its lobes about the centers that they will have.
    tolerance : float
        Relative RMS error of the reflected radiance that is asked for, in (0, 1).
    size : int, optional
        Rows of a lat-long map (default 128), or of a cube's face (default 64).
    layout : {"latlong", "cube"}
        The grid of the maps.
    views : int
        Number of views for which a map is made.
    points : int
        Number of points at which `radiance` is asked for, each with a view of its own. Above 0, maps for
        views are not made, and `views` means nothing.
    F_max, P_max : int
        Caps on the orders in frequency space; what needs more is left to the integrators.

    Returns
    -------
    {"frequency", "angular", "hierarchical"}
        The method of `shrm.prefilter`, `shrm.prefilter_angular` or `shrm.prefilter_hierarchical`.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type or out of its range.

    Examples
    --------
    >>> import shrm
    >>> shrm.cheapest(shrm.Environment.daylight(size=64), shrm.brdf.Lambert(0.5))
    'frequency'
    """
    require_environment(env)
    layout = map_layout(layout)
    edge = DEFAULT_SIZE[layout] if size is None else whole_number("size", size, 2, 8192)
    whole_number("views", views, 1)
    whole_number("points", points, 0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        chosen = choose(env, brdf, tolerance=tolerance, F_max=F_max, P_max=P_max)
    H, W, _ = env.pixels.shape
    texels = edge * edge * (2 if layout == "latlong" else 6)
    work = (H * W, brdf, texels, layout, views)
    seconds: dict[Method, float] = {"angular": angular_seconds(*work, tolerance, points)}
    if not chosen.limited_by:
        seconds["frequency"] = frequency_seconds(*work, chosen, points)
    if min(map(half_width, brdf.lobes)) >= _TEXELS_TO_A_WIDTH * max(math.pi / H, 2 * math.pi / W):
        seconds["hierarchical"] = hierarchical_seconds(*work, points)
    return min(seconds, key=lambda method: seconds[method])


def frequency_seconds(
    light_texels: int,
    brdf: BRDF,
    texels: int,
    layout: Layout,
    views: int,
    orders: Orders,
    points: int = 0,
) -> float:
    """Predict the time in frequency space: analysis, synthesis and a sum for each view [RH02 eq. 9].

    With points, in place of the sums for views, a look-up in all maps for each point.
    """
    rate = rates()
    seconds = rate["call"] + light_texels * (rate["analysis"] + rate["analysis by degree"] * orders.F)
    for lobe, of_lobe in zip(brdf.lobes, orders.lobes, strict=True):
        global_form = lobe.kind == "isotropic"
        per_texel = 3 * ((of_lobe.P + 1) ** 2 if global_form else of_lobe.P + 1)
        values = texels * per_texel
        J = of_lobe.F + (of_lobe.P if global_form else 0)
        if layout == "cube":
            per_value = rate["synthesis of cubes"] * (J + 1) ** 2
        else:
            per_value = rate["synthesis"] + rate["synthesis by degree"] * J
        seconds += values * (per_value + (0 if points else rate["view"] * views))
        seconds += points * (rate["point"] + rate["point by value"] * per_texel)
    return seconds


def angular_seconds(
    light_texels: int,
    brdf: BRDF,
    texels: int,
    layout: Layout,
    views: int,
    tolerance: float,
    points: int = 0,
) -> float:
    """Predict the time by integration: tables, and each texel of a map against those of the light in its cap.

    The cap is the one that holds all but the tolerance of the lobe's integral [RH02 appendix D]. With points,
    these are integrated in place of the texels of maps.
    """
    rate = rates()
    seconds = rate["call"]
    for lobe in brdf.lobes:
        kind = lobe.kind
        visited = light_texels * share_visited(lobe, CUTOFF_OF_TOLERANCE * tolerance)
        by_symmetry = kind == "radial" and layout == "latlong" and not points
        queried = points or texels * (1 if kind == "radial" else views)
        per_pair = rate[f"pair {kind}"] * (_COLORED if lobe.channels == 3 and kind == "isotropic" else 1.0)
        per_query = visited * rate["pair by symmetry"] if by_symmetry else visited * per_pair + rate["query"]
        seconds += rate[f"table {kind}"] + queried * per_query
    return seconds


def hierarchical_seconds(
    light_texels: int, brdf: BRDF, texels: int, layout: Layout, views: int, points: int = 0
) -> float:
    """Predict the time of a descent: the pyramid, tables, the search for a threshold, and each map.

    With points, these in place of the texels of maps.
    """
    rate = rates()
    seconds = rate["call"] + light_texels * rate["pyramid"]
    for lobe in brdf.lobes:
        kind = lobe.kind
        queried = points or texels * (1 if kind == "radial" else views)
        per_texel = rate[f"descent {kind}"] * (_COLORED if lobe.channels == 3 else 1.0)
        if kind == "zonal":  # a ring is entered all along
            per_texel *= max(1.0, _RING_WIDTH / half_width(lobe))
        seconds += rate[f"table {kind}"] + (_SEARCHED_MAPS * texels + _SEARCHED_TEXELS + queried) * per_texel
    return seconds
