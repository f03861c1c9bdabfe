"""One lobe ready for hierarchical prefiltering: its table, and the cap in which nodes are always split.

The difference of a lobe between a node and its children tells how far to descend [KVHS00 section 5.1], except
for lobes so narrow that no sample meets them: in the cap where most of a lobe lies, nodes are split until
they are small against it. The tables are those of direct integration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, cast

import numpy as np

from shrm import _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center, IsotropicLobe, Lobe, RadialLobe, ZonalLobe, refuse_anisotropic
from shrm.integrate import tables as lobe_tables
from shrm.integrate.angular_lobes import for_all_views
from shrm.integrate.radial_table import NEGLIGIBLE, Profile, integral_within, radial_table
from shrm.integrate.saved_arrays import SMALLEST, NamedArrays, angles, number, table
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

LEAST_SEGMENTS, LARGEST_SHIFT = 32, 22
"""Fewest segments of a profile's table, and most bits of its shift, that the core takes."""


class LobeDescent(Protocol):
    """A lobe that can be prefiltered by descent.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        Direction that its maps are indexed by.
    depends_on_view : bool
        True if its maps differ from view to view.
    table_error : float
        Relative root mean square error of its table; 0 where it is not measured, as for cores.
    """

    @property
    def center(self) -> Center: ...  # noqa: D102

    @property
    def table_error(self) -> float: ...  # noqa: D102

    @property
    def depends_on_view(self) -> bool: ...  # noqa: D102

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
        return ZonalDescent(lobe.center, lobe.profile)
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
        one_of("center of a radial lobe", center, ("reflection", "normal"))
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
        names = ("shift", "scale", "support", "integral", "width", "within")
        return {
            "profile": self.values.reshape(-1, self.values.shape[-1]),
            **{name: np.asarray(getattr(self, name)) for name in names},
        }

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> RadialDescent:
        """Restore it from what `to_arrays` returned.

        Raises
        ------
        KeyError, ValueError
            If an array is missing, or none that the core could use.
        """
        profile = table(arrays, "profile", (None, None)).astype(np.float32)
        segments = profile.shape[1]
        if len(profile) not in (4, 12) or segments < LEAST_SEGMENTS or segments & (segments - 1):
            raise ValueError(f"profile of shape {profile.shape}")
        within = table(arrays, "within", (None, 2))
        if len(within) < 2:
            raise ValueError(f"within of shape {within.shape}")

        names = ("shift", "scale", "support", "integral", "width")
        shift, scale, support, integral, width = (number(arrays, name) for name in names)
        if not (
            shift <= LARGEST_SHIFT and min(scale, support) > SMALLEST and max(scale, support) < 1 / SMALLEST
        ):
            raise ValueError(f"profile over {shift:g}, {scale:g}, {support:g}")
        values = np.ascontiguousarray(profile.reshape(-1, 4, segments))
        return cls(center, values, int(shift), scale, support, integral, width, within)

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


class ZonalDescent:
    """A lobe that depends on two angles from its center."""

    depends_on_view = True

    def __init__(self, center: Center, profile: Callable[[FloatArray, FloatArray], FloatArray]) -> None:
        one_of("center of a zonal lobe", center, ("reflection", "normal", "tangent"))
        self.center: Center = center
        table = lobe_tables.zonal_table(for_all_views(center, profile), LARGEST_OUTSIDE)
        self._width, self._integral, self.table_error = table.width, table.integral, table.error
        self._table: dict[str, Any] = {
            "profiles": table.values,
            "bands": table.bands,
            "supports": table.supports(NEGLIGIBLE),
        }

    def radiance(
        self, pyramid: _core.Pyramid, n: FloatArray, v: FloatArray, t: FloatArray, threshold: float
    ) -> tuple[Float32Array, float]:
        """Return reflected radiance; see `LobeDescent`."""
        axes = central_directions(self.center, n, v, t)
        return _core.hierarchical_zonal(
            pyramid=pyramid,
            **self._table,
            **_depth(threshold, self._integral, ZONAL_NODE * self._width),
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
        one_of("center of an isotropic lobe", center, ("lobe", "reflection", "normal"))
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
            core, below = cast(SplitFunction, core.whole), core.height

        envelope, ratio = lobe_tables.channel_tables(core.whole)
        caps, integral = lobe_tables.caps_and_integral(lobe.transfer, LARGEST_OUTSIDE)
        gamma, width = gamma_table(lobe.center, lobe.function), lobe_center(lobe.function)[1]
        return cls(lobe.center, gamma, width, envelope, ratio, caps, integral, core.height, below)

    def to_arrays(self) -> NamedArrays:
        """Return what `from_arrays` takes, `center` apart; the ratio as rows of azimuths."""
        names = ("width", "envelope", "caps", "integral", "above", "below")
        return {
            "gamma": self.gamma[None],
            "ratio": self.ratio.reshape(-1, self.ratio.shape[-1]),
            **{name: np.asarray(getattr(self, name)) for name in names},
        }

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
        rows = table(arrays, "ratio", (None, None)).astype(np.float32)
        caps = table(arrays, "caps", (None, 2))
        views, lights, azimuths = len(caps), lobe_tables.LIGHT_INTERVALS + 2, rows.shape[1]
        channels = len(rows) // max(views * lights, 1)
        if channels not in (1, 3) or len(rows) != channels * views * lights or views < 2 or azimuths < 3:
            raise ValueError(f"ratio of shape {rows.shape}")
        if len(envelope) not in (1, channels) or envelope.shape[1] < 3:
            raise ValueError(f"envelope of shape {envelope.shape}")
        ratio = np.ascontiguousarray(rows.reshape(views, -1, lights, azimuths))

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


def _depth(threshold: float, integral: float, finest: float) -> dict[str, Any]:
    """Return the core's arguments that tell how far to descend; `finest` is the largest node, radians."""
    return {
        "threshold": threshold,
        "integral": integral,
        "finest": finest * min(1.0, float(np.sqrt(threshold / LARGEST_OUTSIDE))),
    }
