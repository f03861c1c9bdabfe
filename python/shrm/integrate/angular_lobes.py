"""One lobe ready for direct integration: its table, and the directions its integral is indexed by.

The radiance of a query is one call into C++; see `shrm.integrate.tables` for the tables.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

import shrm._core as _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center, Lobe, RadialLobe, ZonalLobe, refuse_anisotropic
from shrm.integrate import tables as lobe_tables
from shrm.integrate.radial_table import RadialTable, integral_within, radial_table
from shrm.lobes.center import lobe_center
from shrm.lobes.directions import above_horizon, across, bisector, central_directions, normals_of
from shrm.validation import one_of


class LobeIntegral(Protocol):
    """A lobe that can be integrated.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        Direction that its maps are indexed by.
    width : float
        Angle that holds half of the lobe's integral.
    error : float
        Relative root mean square error of its table.
    """

    center: Center
    width: float
    error: float

    def radiance(self, picture: dict[str, Any], n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Reflected radiance (n, 3) for normals, views and tangents (n, 3)."""

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Normals (n, 3) whose centers, seen from v, are `centers`; a tangent lobe has none to find."""


def lobe_integral(lobe: Lobe, tolerance: float, center: Center | None, share: bool) -> LobeIntegral:
    """Tabulate a lobe of any kind; `center` replaces an isotropic lobe's own.

    With `share`, queries that have the first one's view read their half vectors from one table (lobes of the
    half angle alone). An anisotropic lobe is refused.
    """
    refuse_anisotropic(lobe)
    if isinstance(lobe, ZonalLobe):
        return ZonalIntegral(lobe.center, lobe.profile, tolerance)
    if isinstance(lobe, RadialLobe):
        return RadialIntegral(lobe.center, lobe.profile, tolerance)
    return IsotropicIntegral(center or lobe.center, lobe.transfer, tolerance, share)


def share_visited(lobe: Lobe, tolerance: float) -> float:
    """Return the share of the sphere that is visited for all but a part of a lobe's integral.

    For isotropic lobes at 45 degrees, for zonal ones the mean over views [RH02 appendix D].
    """
    if isinstance(lobe, RadialLobe):
        angle, within = integral_within(lobe.profile)
        return float(0.5 * (1 - np.cos(np.interp(1 - tolerance, within, angle))))
    if isinstance(lobe, ZonalLobe):
        bands = lobe_tables.zonal_table(for_all_views(lobe.center, lobe.profile), tolerance).bands
        weight = np.sin(np.linspace(0, np.pi, len(bands)))
        return float(np.average(0.5 * (np.cos(bands[:, 0]) - np.cos(bands[:, 1])), weights=weight))
    _, outer = lobe_tables.cap_at(lobe.transfer, float(np.sqrt(0.5)), tolerance)
    return float(0.5 * (1 - np.cos(min(outer, np.pi / 2))))


def half_width(lobe: Lobe) -> float:
    """Return an angle from the center within which half of a lobe is, radians.

    Of a radial lobe's integral; of the square of an isotropic one, for the narrowest view; for zonal ones,
    half the width of the narrowest ring that holds half of it.
    """
    if isinstance(lobe, RadialLobe):
        angle, within = integral_within(lobe.profile)
        return float(np.interp(0.5, within, angle))
    if isinstance(lobe, ZonalLobe):
        return lobe_tables.zonal_table(for_all_views(lobe.center, lobe.profile), 0.5).width
    return lobe_center(lobe.transfer)[1]


class RadialIntegral:
    """A lobe of fixed shape about R or N."""

    def __init__(self, center: Center, profile: Callable[[FloatArray], FloatArray], tolerance: float):
        table = radial_table(profile, tolerance)
        one_of("center of a radial lobe", center, ("reflection", "normal"))
        self.center: Center = center
        self.width, self.error = table.width, table.error
        self._table: dict[str, Any] = {**profile_arguments(table), "outer": table.outer}

    def about(self, picture: dict[str, Any], centers: FloatArray) -> Float32Array:
        """Radiance (n, 3) for centers (n, 3)."""
        return np.asarray(_core.angular_radial(**picture, **self._table, centers=centers))

    def map(self, picture: dict[str, Any], height: int, width: int, symmetry: bool) -> Float32Array:
        """Radiance (height, width, 3) for centers on a lat-long grid, by symmetry about its axis or not."""
        return np.asarray(
            _core.angular_radial_map(**picture, **self._table, height=height, width=width, symmetry=symmetry)
        )

    def radiance(self, picture: dict[str, Any], n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Reflected radiance; see `LobeIntegral`."""
        return self.about(picture, central_directions(self.center, n, v, t))

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Normals of centers; see `LobeIntegral`."""
        return centers if self.center == "normal" else bisector(centers, v)


def profile_arguments(table: RadialTable) -> dict[str, Any]:
    """A radial table as the core takes it."""
    return {
        "profile": table.values,
        "shift": table.shift,
        "scale": table.scale,
        "support": table.support,
    }


class ZonalIntegral:
    """A lobe that depends on two angles from its center."""

    def __init__(
        self, center: Center, profile: Callable[[FloatArray, FloatArray], FloatArray], tolerance: float
    ):
        one_of("center of a zonal lobe", center, ("reflection", "normal", "tangent"))
        self.center: Center = center
        table = lobe_tables.zonal_table(for_all_views(center, profile), tolerance)
        self.width, self.error = table.width, table.error
        self._table: dict[str, Any] = {"profiles": table.values, "bands": table.bands}

    def radiance(self, picture: dict[str, Any], n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Reflected radiance; see `LobeIntegral`."""
        axes = central_directions(self.center, n, v, t)
        return np.asarray(
            _core.angular_zonal(**picture, **self._table, axes=axes, theta_o=across(axes, v)[1])
        )

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Normals of centers; see `LobeIntegral`."""
        return bisector(centers, v) if self.center == "reflection" else centers


class IsotropicIntegral:
    """Any other lobe, cut at the horizon of N."""

    def __init__(
        self,
        center: Center,
        transfer: Callable[[FloatArray, FloatArray], FloatArray],
        tolerance: float,
        share: bool,
    ):
        one_of("center of an isotropic lobe", center, ("lobe", "reflection", "normal"))
        self.center: Center = center
        half_angle = lobe_tables.half_angle_table(transfer, tolerance)
        table = half_angle or lobe_tables.isotropic_table(transfer, tolerance)
        self.width, self.error = table.width, table.error
        self._integrate: Callable[..., Any]
        self._table: dict[str, Any]
        if isinstance(table, lobe_tables.HalfAngleTable):
            self._integrate = _core.angular_half_angle
            self._table = {**profile_arguments(table.radial), "caps": table.caps, "share": share}
        else:
            self._integrate = _core.angular_isotropic
            self._table = {"envelope": table.envelope, "ratio": table.ratio, "caps": table.caps}
        self._transfer = transfer

    def radiance(self, picture: dict[str, Any], n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Reflected radiance; see `LobeIntegral`."""
        n, v = above_horizon(self.center, n, v)
        return np.asarray(self._integrate(**picture, **self._table, normals=n, views=v))

    def caps(self, n: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What the sum visits for normals and views (n, 3): caps about axes (n, 3), of angles (n,)."""
        n, v = above_horizon(self.center, n, v)
        x, theta_v = across(n, v)
        place = lobe_tables.view_place(np.cos(theta_v))
        low = np.minimum(place.astype(int), len(self._table["caps"]) - 2)
        center, outer = self._table["caps"].T
        offset = center[low] + (place - low) * (center[low + 1] - center[low])
        widest = np.maximum(outer[low], outer[low + 1])
        axes = np.cos(offset)[:, None] * n - np.sin(offset)[:, None] * x
        hemisphere = widest >= np.pi / 2
        return np.where(hemisphere[:, None], n, axes), np.where(hemisphere, np.pi / 2, widest)

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Normals of centers; see `LobeIntegral`."""
        return normals_of(self.center, self._transfer, centers, v)


def for_all_views(
    center: str, profile: Callable[[FloatArray, FloatArray], FloatArray]
) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Return a zonal profile for theta_o in [0, pi]: about the normal, views are brought to the horizon."""
    if center != "normal":
        return profile
    return lambda theta_i, theta_o: profile(theta_i, np.minimum(theta_o, np.pi / 2))
