"""One lobe ready for direct integration: its table, and the directions its integral is indexed by.

The radiance of a query is one call into C++; see `shrm.integrate.tables` for the tables.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

import shrm._core as _core
from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center, refuse_anisotropic
from shrm.integrate import tables as lobe_tables
from shrm.integrate.radial_table import RadialTable, integral_within, radial_table
from shrm.lobes.center import gamma_table, lobe_center
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


def kind_of(lobe: Any) -> str:
    """Return a lobe's kind, as `shrm.brdf.lobe.Lobe` has it; other classes need not say theirs."""
    if not hasattr(lobe, "profile"):
        return str(getattr(lobe, "kind", "isotropic"))
    return str(getattr(lobe, "kind", "zonal" if lobe.center == "tangent" else "radial"))


def lobe_integral(lobe: Any, tolerance: float, center: Center | None, share: bool) -> LobeIntegral:
    """Tabulate a lobe of any kind; `center` replaces an isotropic lobe's own.

    With `share`, queries that have the first one's view read their half vectors from one table (lobes of the
    half angle alone). An anisotropic lobe is refused.
    """
    refuse_anisotropic(lobe)
    kind = kind_of(lobe)
    if kind == "zonal":
        return ZonalIntegral(lobe.center, lobe.profile, tolerance)
    if kind == "radial":
        return RadialIntegral(lobe.center, lobe.profile, tolerance)
    return IsotropicIntegral(center or lobe.center, lobe.transfer, tolerance, share)


def share_visited(lobe: Any, tolerance: float) -> float:
    """Return the share of the sphere that is visited for all but a part of a lobe's integral.

    For isotropic lobes at 45 degrees, for zonal ones the mean over views [RH02 appendix D].
    """
    kind = kind_of(lobe)
    if kind == "radial":
        angle, within = integral_within(lobe.profile)
        return float(0.5 * (1 - np.cos(np.interp(1 - tolerance, within, angle))))
    if kind == "zonal":
        bands = lobe_tables.zonal_table(for_all_views(lobe.center, lobe.profile), tolerance).bands
        weight = np.sin(np.linspace(0, np.pi, len(bands)))
        return float(np.average(0.5 * (np.cos(bands[:, 0]) - np.cos(bands[:, 1])), weights=weight))
    _, outer = lobe_tables.cap_at(lobe.transfer, float(np.sqrt(0.5)), tolerance)
    return float(0.5 * (1 - np.cos(min(outer, np.pi / 2))))


def half_width(lobe: Any) -> float:
    """Return an angle from the center within which half of a lobe is, radians.

    Of a radial lobe's integral; of the square of an isotropic one, for the narrowest view; for zonal ones,
    half the width of the narrowest ring that holds half of it.
    """
    kind = kind_of(lobe)
    if kind == "radial":
        angle, within = integral_within(lobe.profile)
        return float(np.interp(0.5, within, angle))
    if kind == "zonal":
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


# ---- Directions


def central_directions(center: str, n: FloatArray, v: FloatArray, t: FloatArray) -> FloatArray:
    """C of lobes whose center is none of their own: R, N or T, (n, 3)."""
    if center == "reflection":
        return reflection(n, v)
    return n if center == "normal" else t


def for_all_views(
    center: str, profile: Callable[[FloatArray, FloatArray], FloatArray]
) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Return a zonal profile for theta_o in [0, pi]: about the normal, views are brought to the horizon."""
    if center != "normal":
        return profile
    return lambda theta_i, theta_o: profile(theta_i, np.minimum(theta_o, np.pi / 2))


def normals_of(
    center: str, transfer: Callable[[FloatArray, FloatArray], FloatArray], centers: FloatArray, v: FloatArray
) -> FloatArray:
    """Normals (n, 3) of an isotropic lobe whose centers, seen from v, are `centers`."""
    gamma = gamma_table("lobe", transfer) if center == "lobe" else np.zeros(0)
    return normals_at(center, gamma, centers, v)


def normals_at(center: str, gamma: FloatArray, centers: FloatArray, v: FloatArray) -> FloatArray:
    """Normals (n, 3) whose centers, seen from v, are `centers`; gamma (257,) is that of the lobe center."""
    if center == "normal":
        return centers
    if center == "reflection":
        return bisector(centers, v)
    # theta_o = theta_v + gamma(theta_v) is monotone: read it backwards.
    theta_v = np.linspace(0, np.pi / 2, len(gamma))
    theta_o = np.maximum.accumulate(theta_v + gamma)
    x, angle = across(v, centers)
    angle = np.interp(angle, theta_o, theta_v)
    return np.asarray(np.cos(angle)[:, None] * v + np.sin(angle)[:, None] * x)


def across(z: FloatArray, towards: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (n, 3) square to z, in the plane of z and `towards` unless parallel; the angles (n,)."""
    cosine = np.einsum("nc,nc->n", towards, z)
    x = towards - cosine[:, None] * z
    sine = np.sqrt(np.einsum("nc,nc->n", x, x))
    angle = np.arctan2(sine, cosine)  # accurate when small
    parallel = sine < 1e-7
    if parallel.any():
        x[parallel] = np.cross(z[parallel], np.eye(3)[np.argmin(np.abs(z[parallel]), axis=1)])
        sine[parallel] = np.linalg.norm(x[parallel], axis=1)
    x /= sine[:, None]
    return x, angle


def local_frames(z: FloatArray, towards: FloatArray) -> FloatArray:
    """Frames (n, 3, 3) with columns x, y, z; x as `across` has it."""
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    x, _ = across(z, towards)
    return np.stack([x, np.cross(z, x), z], axis=2)


def reflection(n: FloatArray, v: FloatArray) -> FloatArray:
    """R = 2 (N.V) N - V."""
    return np.asarray(2 * np.einsum("nc,nc->n", n, v)[:, None] * n - v)


def bisector(a: FloatArray, b: FloatArray) -> FloatArray:
    """The unit vector between a and b: for R and V, the normal. Square to both if they are opposite."""
    sum_ = a + b
    length = np.sqrt(np.einsum("nc,nc->n", sum_, sum_))
    opposite = length < 1e-7
    if opposite.any():
        sum_[opposite], length[opposite] = across(b[opposite], a[opposite])[0], 1.0
    sum_ /= length[:, None]
    return sum_


def above_horizon(center: str, n: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """N and V for views below the horizon of N, as reflection maps have them.

    About the reflection -N takes the place of N, which leaves R as it is; about the lobe or the normal V is
    brought back to the horizon.
    """
    cosine = np.einsum("nc,nc->n", n, v)
    below = cosine < 0
    if not below.any():
        return n, v
    if center == "reflection":
        return np.where(below[:, None], -n, n), v
    level = v[below] - cosine[below, None] * n[below]
    level /= np.maximum(np.linalg.norm(level, axis=1, keepdims=True), 1e-12)
    v = v.copy()
    v[below] = level
    return n, v
