"""One lobe ready for hierarchical prefiltering: its table, and the cap in which nodes are always split.

The difference of a lobe between a node and its children tells how far to descend [KVHS00 section 5.1], except
for lobes so narrow that no sample meets them: in the cap where most of a lobe lies, nodes are split until
they are small against it. The tables are those of direct integration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, cast

import numpy as np

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center, IsotropicLobe, Lobe, RadialLobe, ZonalLobe, refuse_anisotropic
from shrm.integrate import tables as lobe_tables
from shrm.integrate.angular_lobes import for_all_views
from shrm.integrate.queries import CENTERS
from shrm.integrate.radial_table import NEGLIGIBLE, Profile, integral_within, radial_table
from shrm.integrate.saved_arrays import SMALLEST, NamedArrays, angle_pairs, angles, number, table
from shrm.integrate.table_arrays import (
    as_rows,
    numbers_of,
    profile_from,
    profiles_from,
    ratio_from,
)
from shrm.integrate.tables import Transfer
from shrm.lobes.center import gamma_at, gamma_table, lobe_center
from shrm.lobes.directions import above_horizon, across, bisector, central_directions, normals_at
from shrm.lobes.split import SplitFunction
from shrm.validation import one_of

LARGEST_OUTSIDE = 0.05
"""Largest fraction of a lobe's integral outside the cap in which nodes are always split until they are small.

Outside, a node is split only if the lobe differs between it and its parent, so the cap must hold all that
samples could miss. Thresholds below this one leave less outside.
"""

RADIAL_NODE = 4.0
"""Largest node in that cap, in units of the angle that holds half of a radial lobe; smaller, by the root of
the threshold, for thresholds below LARGEST_OUTSIDE."""

ISOTROPIC_NODE = 8.0
"""Largest node in the cap of an isotropic lobe, in units of the angle that holds half of its square at its
narrowest view."""

ZONAL_NODE = 8.0
"""Largest node in the band of a zonal lobe, in half widths of its ring, which nodes meet somewhere along."""


class LobeDescent(Protocol):
    """A lobe that can be prefiltered by descent.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        Direction that its maps are indexed by.
    depends_on_view : bool
        True if its maps differ from view to view.
    kind : {"radial", "zonal", "isotropic"}
        Which of the three classes it is of.
    table_error : float
        Relative root mean square error of its table; 0 where it is not measured, as for cores.
    """

    @property
    def center(self) -> Center: ...  # noqa: D102

    @property
    def table_error(self) -> float: ...  # noqa: D102

    @property
    def depends_on_view(self) -> bool: ...  # noqa: D102

    @property
    def kind(self) -> str: ...  # noqa: D102

    def to_arrays(self) -> NamedArrays:
        """Return the arrays that `descent_from_arrays` takes."""

    def radiance(
        self, pyramid: _core.Pyramid, n: FloatArray, v: FloatArray, t: FloatArray, threshold: float
    ) -> tuple[Float32Array, float]:
        """Return radiance (n, 3) for normals, views and tangents (n, 3), and evaluations for each."""

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals (n, 3) whose centers, seen from v, are `centers`; any about the tangent."""

    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles between C and V for cos^2(theta_v), (n,): if that is uniform, so are frames."""


def lobe_descent(lobe: Lobe) -> LobeDescent:
    """Tabulate a lobe of any kind; an anisotropic one is refused."""
    refuse_anisotropic(lobe)
    if isinstance(lobe, RadialLobe):
        return RadialDescent.of(lobe.center, lobe.profile)
    if isinstance(lobe, ZonalLobe):
        return ZonalDescent.of(lobe.center, lobe.profile)
    return IsotropicDescent.of(lobe.center, lobe.transfer)


@dataclass(frozen=True, eq=False)
class RadialDescent:
    """A lobe of fixed shape about R or N: arrays alone, so that it can be stored.

    Attributes
    ----------
    center : {"reflection", "normal"}
        Direction that its maps are indexed by.
    values, shift, scale, support, integral, width
        The attributes of its `RadialTable`.
    within : (1025, 2) float64
        Angles, and the part of the integral within each, from 1 - LARGEST_OUTSIDE to 1.
    """

    depends_on_view: ClassVar[bool] = False
    kind: ClassVar[str] = "radial"
    center: Center
    values: Float32Array
    shift: int
    scale: float
    support: float
    integral: float
    width: float
    within: FloatArray
    table_error: float = 0.0

    @classmethod
    def of(cls, center: Center, profile: Profile) -> RadialDescent:
        """Tabulate a profile."""
        one_of("center of a radial lobe", center, CENTERS["radial"])
        table = radial_table(profile, LARGEST_OUTSIDE)
        angle, within = integral_within(profile)
        # Angles within which all but a part lies; parts are dense where little is left outside.
        left_out = LARGEST_OUTSIDE * (np.arange(1025)[::-1] / 1024) ** 4
        outer = np.stack([np.interp(1 - left_out, within, angle), 1 - left_out], axis=1)
        return cls(
            center,
            table.values,
            table.shift,
            table.scale,
            table.support,
            table.integral,
            table.width,
            outer,
            table_error=table.error,
        )

    def to_arrays(self) -> NamedArrays:
        """Return what `from_arrays` takes, `center` apart; the profile as rows of segments."""
        numbers = numbers_of(self, "shift", "scale", "support", "integral", "width", "within")
        return {"profile": as_rows(self.values), **numbers}

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> RadialDescent:
        """Restore it from what `to_arrays` returned.

        Raises
        ------
        KeyError, ValueError
            If an array is missing, or none that the core could use.
        """
        within = table(arrays, "within", (None, 2))
        if len(within) < 2:
            raise ValueError(f"within of shape {within.shape}")
        integral, width = number(arrays, "integral"), number(arrays, "width")
        return cls(center, *profile_from(arrays), integral, width, within)

    def radiance(
        self, pyramid: _core.Pyramid, n: FloatArray, v: FloatArray, t: FloatArray, threshold: float
    ) -> tuple[Float32Array, float]:
        """Return reflected radiance; see `LobeDescent`."""
        left_out = min(LARGEST_OUTSIDE, max(threshold, 1e-6))
        return _core.hierarchical_radial(
            pyramid=pyramid,
            profile=self.values,
            shift=self.shift,
            scale=self.scale,
            support=self.support,
            outer=float(np.interp(1.0 - left_out, self.within[:, 1], self.within[:, 0])),
            **_depth(threshold, self.integral, RADIAL_NODE * self.width),
            centers=central_directions(self.center, n, v, t),
        )

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals of centers; see `LobeDescent`."""
        return centers if self.center == "normal" else bisector(centers, v)

    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles of views, on which nothing depends; see `LobeDescent`."""
        return np.asarray(np.arccos(np.sqrt(cos2)))


@dataclass(frozen=True, eq=False)
class ZonalDescent:
    """A lobe that depends on two angles from its center.

    Attributes
    ----------
    center : {"reflection", "normal", "tangent"}
    values, bands, integral, width
        Of its `lobe_tables.ZonalTable`.
    supports : (rows, 2) float64
        Smallest and largest theta_i outside of which the lobe is nothing.
    """

    depends_on_view: ClassVar[bool] = True
    kind: ClassVar[str] = "zonal"
    center: Center
    values: Float32Array
    bands: FloatArray
    supports: FloatArray
    integral: float
    width: float
    table_error: float = 0.0

    @classmethod
    def of(cls, center: Center, profile: Callable[[FloatArray, FloatArray], FloatArray]) -> ZonalDescent:
        """Tabulate a profile."""
        one_of("center of a zonal lobe", center, CENTERS["zonal"])
        table = lobe_tables.zonal_table(for_all_views(center, profile), LARGEST_OUTSIDE)
        supports = table.supports(NEGLIGIBLE)
        return cls(center, table.values, table.bands, supports, table.integral, table.width, table.error)

    def to_arrays(self) -> NamedArrays:
        """Return what `from_arrays` takes, `center` apart; the profiles as rows."""
        numbers = numbers_of(self, "bands", "supports", "integral", "width")
        return {"profiles": as_rows(self.values), **numbers}

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> ZonalDescent:
        """Restore it from what `to_arrays` returned; KeyError or ValueError if that is damaged."""
        values = profiles_from(arrays)
        bands, supports = (angle_pairs(arrays, name, len(values)) for name in ("bands", "supports"))
        return cls(center, values, bands, supports, number(arrays, "integral"), number(arrays, "width"))

    def radiance(
        self, pyramid: _core.Pyramid, n: FloatArray, v: FloatArray, t: FloatArray, threshold: float
    ) -> tuple[Float32Array, float]:
        """Return reflected radiance; see `LobeDescent`."""
        axes = central_directions(self.center, n, v, t)
        return _core.hierarchical_zonal(
            pyramid=pyramid,
            profiles=self.values,
            bands=self.bands,
            supports=self.supports,
            **_depth(threshold, self.integral, ZONAL_NODE * self.width),
            axes=axes,
            theta_o=across(axes, v)[1],
        )

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals of centers; see `LobeDescent`."""
        return bisector(centers, v) if self.center == "reflection" else centers

    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles of views; see `LobeDescent`. About the tangent they are uniform on the sphere."""
        if self.center == "normal":
            return np.asarray(np.arccos(np.sqrt(cos2)))
        return np.asarray(np.arccos(2 * cos2 - 1))


@dataclass(frozen=True, eq=False)
class IsotropicDescent:
    """Any other lobe, cut at the horizon of N: arrays alone, so that it can be stored.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal"}
        Direction that its maps are indexed by.
    gamma : (257,) float64
        The angle between C and N over theta_v, radians.
    width : float
        Angle that holds half of the square at the narrowest view, radians: where light at the horizon has
        most of the integral, the highlight is narrower.
    envelope : (1 or channels, intervals + 2) float32
        Envelope of its `lobe_tables.IsotropicTable`; of a core, that of its lobe's `channel_tables`.
    ratio : (views, channels, lights + 2, azimuths + 2) float32
        The ratio that belongs to the envelope.
    caps, integral
        The attributes of its `lobe_tables.IsotropicTable`.
    above, below : float
        Heights, per steradian, between which it is a part of the tabulated lobe (`shrm.lobes.split`): the
        core at the first, then the smooth part of that at the second. Whole lobes are between 0 and infinity.
    """

    depends_on_view: ClassVar[bool] = True
    kind: ClassVar[str] = "isotropic"
    center: Center
    gamma: FloatArray
    width: float
    envelope: Float32Array
    ratio: Float32Array
    caps: FloatArray
    integral: float
    above: float = 0.0
    below: float = float("inf")
    table_error: float = 0.0

    @classmethod
    def of(cls, center: Center, transfer: Transfer) -> IsotropicDescent:
        """Tabulate a lobe."""
        one_of("center of an isotropic lobe", center, CENTERS["isotropic"])
        table = lobe_tables.isotropic_table(transfer, LARGEST_OUTSIDE)
        envelope = table.envelope[None]
        gamma = gamma_table(center, transfer)
        width = lobe_center(transfer)[1]
        return cls(
            center, gamma, width, envelope, table.ratio, table.caps, table.integral, table_error=table.error
        )

    @classmethod
    def of_core(cls, lobe: IsotropicLobe) -> IsotropicDescent:
        """Tabulate the core of a lobe, or the smooth part of its core: the table is the lobe's.

        Where a split lobe goes over from one part to the other, its ratio to the mean at a half angle
        changes with the view within the highlight, where tables of the ratio have few nodes.
        """
        # The split or the two splits that made it
        core, below = cast(SplitFunction, lobe.function), float("inf")
        if core.part == "smooth":
            core, below = cast(SplitFunction, core.function), core.height

        envelope, ratio = lobe_tables.channel_tables(core.function)
        caps, integral = lobe_tables.caps_and_integral(lobe.transfer, LARGEST_OUTSIDE)
        gamma, width = gamma_table(lobe.center, lobe.function), lobe_center(lobe.function)[1]
        return cls(lobe.center, gamma, width, envelope, ratio, caps, integral, core.height, below)

    def to_arrays(self) -> NamedArrays:
        """Return what `from_arrays` takes, `center` apart; the ratio as rows of azimuths."""
        numbers = numbers_of(self, "width", "envelope", "caps", "integral", "above", "below")
        return {"gamma": self.gamma[None], "ratio": as_rows(self.ratio), **numbers}

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> IsotropicDescent:
        """Restore it from what `to_arrays` returned.

        Raises
        ------
        KeyError, ValueError
            If an array is missing, or none that the core could use.
        """
        # Tables; the rows of the ratio run over views, channels and lights.
        envelope = table(arrays, "envelope", (None, None)).astype(np.float32)
        ratio, caps = ratio_from(arrays), angle_pairs(arrays, "caps", lobe_tables.VIEW_INTERVALS + 1)
        if len(envelope) not in (1, ratio.shape[1]) or envelope.shape[1] < 3:
            raise ValueError(f"envelope of shape {envelope.shape}")

        # Numbers, and the angles to the center
        width, integral, above, below = (
            number(arrays, name) for name in ("width", "integral", "above", "below")
        )
        if not min(below, 1.0) > SMALLEST:
            raise ValueError(f"below = {below}")
        gamma = angles(arrays, "gamma")
        return cls(center, gamma, width, envelope, ratio, caps, integral, above, below)

    def radiance(
        self, pyramid: _core.Pyramid, n: FloatArray, v: FloatArray, t: FloatArray, threshold: float
    ) -> tuple[Float32Array, float]:
        """Return reflected radiance; see `LobeDescent`."""
        n, v = above_horizon(self.center, n, v)
        return _core.hierarchical_isotropic(
            pyramid=pyramid,
            envelope=self.envelope,
            ratio=self.ratio,
            caps=self.caps,
            **_depth(threshold, self.integral, ISOTROPIC_NODE * self.width),
            normals=n,
            views=v,
            above=self.above,
            below=self.below,
        )

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals of centers; see `LobeDescent`."""
        return normals_at(self.center, self.gamma, centers, v)

    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles of views; see `LobeDescent`."""
        theta_v = np.arccos(np.sqrt(cos2))
        return np.asarray(theta_v + gamma_at(self.gamma, theta_v))


DESCENTS: dict[str, type[RadialDescent] | type[ZonalDescent] | type[IsotropicDescent]] = {
    cls.kind: cls for cls in (RadialDescent, ZonalDescent, IsotropicDescent)
}


def descent_from_arrays(
    kind: str, center: Center, arrays: NamedArrays
) -> RadialDescent | ZonalDescent | IsotropicDescent:
    """Restore a lobe from its kind and what `to_arrays` returned, with the error of its table.

    Raises
    ------
    KeyError, ValueError
        If there is no such kind, or an array is missing, or none that the core could use.
    """
    lobe = DESCENTS[kind].from_arrays(center, arrays)
    return replace(lobe, table_error=number(arrays, "table error"))


def _depth(threshold: float, integral: float, finest: float) -> dict[str, Any]:
    """Return the core's arguments that tell how far to descend; `finest` is the largest node, radians."""
    return {
        "threshold": threshold,
        "integral": integral,
        "finest": finest * min(1.0, float(np.sqrt(threshold / LARGEST_OUTSIDE))),
    }
