"""One lobe ready for direct integration: its table, and the directions its integral is indexed by.

The radiance of a query is one call into C++; see `shrm.integrate.tables` for the tables.
"""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

import shrm._core as _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center, Lobe, RadialLobe, ZonalLobe, refuse_anisotropic
from shrm.integrate import tables as lobe_tables
from shrm.integrate.queries import CENTERS
from shrm.integrate.radial_table import RadialTable, integral_within, radial_table
from shrm.integrate.saved_arrays import NamedArrays, angles, number
from shrm.integrate.table_arrays import (
    half_angle_arrays,
    half_angle_from,
    isotropic_arrays,
    isotropic_from,
    radial_arrays,
    radial_from,
    zonal_arrays,
    zonal_from,
)
from shrm.lobes.center import gamma_at, gamma_table, lobe_center
from shrm.lobes.directions import above_horizon, across, bisector, central_directions, normals_at
from shrm.validation import one_of

LARGEST_SUBSAMPLES = 16
"""Most nodes along each side of a texel; beyond them texels are cut into smaller ones."""

LARGEST_CUT = 2048
"""Most columns of a picture whose texels are cut for narrow lobes: 25 MB of radiance."""

Picture = dict[str, Any]
"""The light as arguments of the core: the planes of its power, and the nodes along each side of a texel."""


def picture_of(pixels: Float32Array, subsamples: int) -> Picture:
    """Return the light (H, W, 3) as arguments of the core."""
    H, W, _ = pixels.shape
    # cos(i pi/H) - cos((i+1) pi/H) without cancellation, times 2 pi/W
    solid_angle = 4 * np.pi / W * np.sin(np.pi * (np.arange(H) + 0.5) / H) * np.sin(0.5 * np.pi / H)
    power = (pixels * solid_angle[:, None, None]).astype(np.float32)
    # rows are repeated so that any run of columns lies in one piece
    columns = np.arange(2 * W + _core.ANGULAR_LANES) % W
    planes = np.ascontiguousarray(power.transpose(2, 0, 1)[:, :, columns])
    return {"planes": planes, "subsamples": subsamples}


class LobeIntegral(ABC):
    """A lobe that can be integrated: arrays alone.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        Direction that its maps are indexed by.
    kind : {"radial", "zonal", "isotropic"}
    """

    center: Center
    kind: ClassVar[str]

    @abstractmethod
    def to_arrays(self) -> NamedArrays:
        """Return what `from_arrays` takes, `center` apart."""

    @classmethod
    @abstractmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> LobeIntegral:
        """Restore it from what `to_arrays` returned; KeyError or ValueError if that is damaged."""

    @property
    @abstractmethod
    def width(self) -> float:
        """Angle that holds half of the lobe's integral, radians."""

    @property
    @abstractmethod
    def table_error(self) -> float:
        """Relative root mean square error of its table."""

    @abstractmethod
    def radiance(self, picture: Picture, n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Return reflected radiance (n, 3) for normals, views and tangents (n, 3)."""

    @abstractmethod
    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals (n, 3) whose centers, seen from v, are `centers`; any about the tangent."""

    @abstractmethod
    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles between C and V of frames drawn at random, for values uniform in [0, 1]."""

    @abstractmethod
    def uncut(self) -> LobeIntegral:
        """Return the same lobe, integrated without a cutoff."""


def lobe_integral(lobe: Lobe, cutoff: float, center: Center | None, share: bool) -> LobeIntegral:
    """Tabulate a lobe of any kind; `center` replaces an isotropic lobe's own.

    With `share`, queries that have the first one's view read their half vectors from one table (lobes of the
    half angle alone). An anisotropic lobe is refused.
    """
    refuse_anisotropic(lobe)
    if isinstance(lobe, ZonalLobe):
        return ZonalIntegral.of(lobe.center, lobe.profile, cutoff)
    if isinstance(lobe, RadialLobe):
        return RadialIntegral.of(lobe.center, lobe.profile, cutoff)
    return IsotropicIntegral.of(center or lobe.center, lobe.transfer, cutoff, share)


def share_visited(lobe: Lobe, tolerance: float) -> float:
    """Return the share of the sphere that is visited for all but a part of a lobe's integral.

    For isotropic lobes that at a view of 45 degrees, for zonal ones the mean over views [RH02 appendix D].
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

    For radial lobes, half of the integral; for isotropic ones, half of the integral of the square, at the
    narrowest view; for zonal ones, half the width of the narrowest ring that holds half of the integral.
    """
    if isinstance(lobe, RadialLobe):
        angle, within = integral_within(lobe.profile)
        return float(np.interp(0.5, within, angle))
    if isinstance(lobe, ZonalLobe):
        return lobe_tables.zonal_table(for_all_views(lobe.center, lobe.profile), 0.5).width
    return lobe_center(lobe.transfer)[1]


def resolving(shape: Sequence[int], width: float) -> tuple[int, int]:
    """Return how a picture (H, W, 3) resolves a lobe: parts of a texel, and nodes in each, along a side.

    Texels are cut in smaller ones of the same radiance where their own nodes do not suffice.
    """
    # Nodes closer than a quarter of the lobe's width
    H, W, _ = shape
    spacing = max(np.pi / H, 2 * np.pi / W)
    needed = max(2, int(np.ceil(4 * spacing / width)))
    cut = min(-(-needed // LARGEST_SUBSAMPLES), max(1, LARGEST_CUT // max(H, W)))
    subsamples = min(-(-needed // cut), LARGEST_SUBSAMPLES)
    if cut * subsamples < needed:
        warnings.warn(
            f"a lobe {width:.1g} rad wide is narrower than what the nodes resolve: up to"
            f" {spacing / (cut * subsamples):.1g} rad between them",
            stacklevel=3,
        )
    return cut, subsamples


@dataclass(frozen=True, eq=False)
class RadialIntegral(LobeIntegral):
    """A lobe of fixed shape about R or N."""

    kind = "radial"
    center: Center
    table: RadialTable

    @classmethod
    def of(cls, center: Center, profile: Callable[[FloatArray], FloatArray], cutoff: float) -> RadialIntegral:
        """Tabulate a profile."""
        one_of("center of a radial lobe", center, CENTERS["radial"])
        return cls(center, radial_table(profile, cutoff))

    def to_arrays(self) -> NamedArrays:
        """Return its table; see `LobeIntegral`."""
        return radial_arrays(self.table)

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> RadialIntegral:
        """Restore it; see `LobeIntegral`."""
        return cls(center, radial_from(arrays))

    @property
    def width(self) -> float:
        """Angle that holds half; see `LobeIntegral`."""
        return self.table.width

    @property
    def table_error(self) -> float:
        """Error of the table; see `LobeIntegral`."""
        return self.table.error

    def about(self, picture: Picture, centers: FloatArray) -> Float32Array:
        """Return radiance (n, 3) for centers (n, 3)."""
        return np.asarray(_core.angular_radial(**picture, **self._arguments, centers=centers))

    def map(self, picture: Picture, height: int, width: int, symmetry: bool) -> Float32Array:
        """Return radiance (height, width, 3) for a lat-long grid of centers, by symmetry or not."""
        return np.asarray(
            _core.angular_radial_map(
                **picture, **self._arguments, height=height, width=width, symmetry=symmetry
            )
        )

    @property
    def _arguments(self) -> dict[str, Any]:
        return {**profile_arguments(self.table), "outer": self.table.outer}

    def radiance(self, picture: Picture, n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Return reflected radiance; see `LobeIntegral`."""
        return self.about(picture, central_directions(self.center, n, v, t))

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals of centers; see `LobeIntegral`."""
        return centers if self.center == "normal" else bisector(centers, v)

    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles of views, on which nothing depends; see `LobeIntegral`."""
        return np.asarray(np.arccos(np.sqrt(cos2)))

    def uncut(self) -> RadialIntegral:
        """Return the same lobe, nothing cut."""
        return replace(self, table=replace(self.table, outer=np.pi))


def profile_arguments(table: RadialTable) -> dict[str, Any]:
    """Return a radial table as the core takes it."""
    return {
        "profile": table.values,
        "shift": table.shift,
        "scale": table.scale,
        "support": table.support,
    }


@dataclass(frozen=True, eq=False)
class ZonalIntegral(LobeIntegral):
    """A lobe that depends on two angles from its center."""

    kind = "zonal"
    center: Center
    table: lobe_tables.ZonalTable

    @classmethod
    def of(cls, center: Center, profile: lobe_tables.Profile2D, cutoff: float) -> ZonalIntegral:
        """Tabulate a profile."""
        one_of("center of a zonal lobe", center, CENTERS["zonal"])
        return cls(center, lobe_tables.zonal_table(for_all_views(center, profile), cutoff))

    def to_arrays(self) -> NamedArrays:
        """Return its table; see `LobeIntegral`."""
        return zonal_arrays(self.table)

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> ZonalIntegral:
        """Restore it; see `LobeIntegral`."""
        return cls(center, zonal_from(arrays))

    @property
    def width(self) -> float:
        """Angle that holds half; see `LobeIntegral`."""
        return self.table.width

    @property
    def table_error(self) -> float:
        """Error of the table; see `LobeIntegral`."""
        return self.table.error

    def radiance(self, picture: Picture, n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Return reflected radiance; see `LobeIntegral`."""
        axes = central_directions(self.center, n, v, t)
        tables: dict[str, Any] = {"profiles": self.table.values, "bands": self.table.bands}
        return np.asarray(_core.angular_zonal(**picture, **tables, axes=axes, theta_o=across(axes, v)[1]))

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals of centers; see `LobeIntegral`."""
        return bisector(centers, v) if self.center == "reflection" else centers

    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles of views; see `LobeIntegral`. About the tangent they are uniform on the sphere."""
        return zonal_theta_o(self.center, cos2)

    def uncut(self) -> ZonalIntegral:
        """Return the same lobe, nothing cut."""
        bands = np.broadcast_to([0.0, np.pi], self.table.bands.shape).copy()
        return replace(self, table=replace(self.table, bands=bands))


def zonal_theta_o(center: Center, cos2: FloatArray) -> FloatArray:
    """Return angles between C and V of a zonal lobe in random frames, for values uniform in [0, 1]."""
    if center == "normal":
        return np.asarray(np.arccos(np.sqrt(cos2)))
    return np.asarray(np.arccos(2 * cos2 - 1))


@dataclass(frozen=True, eq=False)
class IsotropicIntegral(LobeIntegral):
    """Any other lobe, cut at the horizon of N.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal"}
        Direction that its maps are indexed by.
    gamma : (257,) float64
        The angle between C and N over theta_v, radians.
    table : HalfAngleTable or IsotropicTable
        The lobe in the frame of its normal.
    share : bool
        True if queries of one view read their half vectors from one table.
    """

    kind = "isotropic"
    center: Center
    gamma: FloatArray
    table: lobe_tables.HalfAngleTable | lobe_tables.IsotropicTable
    share: bool

    @classmethod
    def of(
        cls, center: Center, transfer: lobe_tables.Transfer, cutoff: float, share: bool
    ) -> IsotropicIntegral:
        """Tabulate a lobe."""
        one_of("center of an isotropic lobe", center, CENTERS["isotropic"])
        half_angle = lobe_tables.half_angle_table(transfer, cutoff)
        table = half_angle or lobe_tables.isotropic_table(transfer, cutoff)
        return cls(center, gamma_table(center, transfer), table, share)

    def to_arrays(self) -> NamedArrays:
        """Return its tables; see `LobeIntegral`."""
        if isinstance(self.table, lobe_tables.HalfAngleTable):
            arrays = half_angle_arrays(self.table)
        else:
            arrays = isotropic_arrays(self.table)
        return {**arrays, "gamma": self.gamma[None], "share": np.asarray(int(self.share))}

    @classmethod
    def from_arrays(cls, center: Center, arrays: NamedArrays) -> IsotropicIntegral:
        """Restore it; see `LobeIntegral`."""
        table = half_angle_from(arrays) if "profile" in arrays else isotropic_from(arrays)
        return cls(center, angles(arrays, "gamma"), table, bool(number(arrays, "share")))

    @property
    def width(self) -> float:
        """Angle that holds half; see `LobeIntegral`."""
        return self.table.width

    @property
    def table_error(self) -> float:
        """Error of the table; see `LobeIntegral`."""
        return self.table.error

    def radiance(self, picture: Picture, n: FloatArray, v: FloatArray, t: FloatArray) -> Float32Array:
        """Return reflected radiance; see `LobeIntegral`."""
        n, v = above_horizon(self.center, n, v)
        table = self.table
        if isinstance(table, lobe_tables.HalfAngleTable):
            profile = {**profile_arguments(table.radial), "share": self.share}
            return np.asarray(
                _core.angular_half_angle(**picture, **profile, caps=table.caps, normals=n, views=v)
            )
        tables: dict[str, Any] = {"envelope": table.envelope, "ratio": table.ratio, "caps": table.caps}
        return np.asarray(_core.angular_isotropic(**picture, **tables, normals=n, views=v))

    def caps(self, n: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what the sum visits for normals and views (n, 3): caps about axes (n, 3), of angles (n,)."""
        n, v = above_horizon(self.center, n, v)
        x, theta_v = across(n, v)

        # The cap of a view: between those of the two nodes that it lies between
        place = lobe_tables.view_place(np.cos(theta_v))
        low = np.minimum(place.astype(int), len(self.table.caps) - 2)
        center, outer = self.table.caps.T
        offset = center[low] + (place - low) * (center[low + 1] - center[low])
        widest = np.maximum(outer[low], outer[low + 1])

        # A wide cap is the hemisphere.
        axes = np.cos(offset)[:, None] * n - np.sin(offset)[:, None] * x
        hemisphere = widest >= np.pi / 2
        return np.where(hemisphere[:, None], n, axes), np.where(hemisphere, np.pi / 2, widest)

    def normals(self, centers: FloatArray, v: FloatArray) -> FloatArray:
        """Return normals of centers; see `LobeIntegral`."""
        return normals_at(self.center, self.gamma, centers, v)

    def theta_o(self, cos2: FloatArray) -> FloatArray:
        """Return angles of views; see `LobeIntegral`."""
        theta_v = np.arccos(np.sqrt(cos2))
        return np.asarray(theta_v + gamma_at(self.gamma, theta_v))

    def uncut(self) -> IsotropicIntegral:
        """Return the same lobe, nothing cut."""
        caps = np.broadcast_to([0.0, np.pi], self.table.caps.shape).copy()
        return replace(self, table=replace(self.table, caps=caps))


INTEGRALS: dict[str, type[LobeIntegral]] = {
    cls.kind: cls for cls in (RadialIntegral, ZonalIntegral, IsotropicIntegral)
}


def for_all_views(
    center: str, profile: Callable[[FloatArray, FloatArray], FloatArray]
) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Return a zonal profile for theta_o in [0, pi]: about the normal, views are brought to the horizon."""
    if center != "normal":
        return profile
    return lambda theta_i, theta_o: profile(theta_i, np.minimum(theta_o, np.pi / 2))
