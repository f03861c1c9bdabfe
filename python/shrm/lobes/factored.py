"""Approximations of lobes by lobes that are radially symmetric, about R unless they have another center.

Three dimensions are left of the prefiltered map, p(N.R, R.L) [KM00]: the lobe's mean over the azimuth about
R, the nearest symmetric one in the sense of least squares. Two are left, F(N.R) p(R.L), if one shape serves
all views; several such lobes are summed where one does not do [KM00]. Products of factors and shapes that are
nearest in the same sense are the singular vectors of the lobe's table; their factors are then moved so that
as much of a white light is reflected as by the lobe. With Phong's shape in place of the
nearest it is the glossy part of Miller's and Heidrich's sum [KVHS00 eq. 2]. The cosine is in the lobe, as
everywhere here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.brdf.cosine_power import profile_at_angles
from shrm.brdf.lobe import Lobe, RadialLobe, ZonalLobe, refuse_anisotropic
from shrm.brdf.models.phong import Phong
from shrm.lobes.center import lobe_center
from shrm.validation import whole_number

VIEWS, LIGHTS, AZIMUTHS = 97, 385, 48
"""Nodes of a table in theta_v, theta_i and, over half a circle, in phi."""

MOST_LOBES = 8
"""Most factored lobes that are summed."""

NEGLIGIBLE = 1e-12
"""Part of the largest singular value of a table below which others are its rounding."""

PHONG_EXPONENTS = (1.0, 1e5, 200)
"""Exponents tried for a Phong lobe, in geometric progression: the first, the last and their number."""


@dataclass(frozen=True, eq=False)
class FactoredLobe:
    """F(theta_v) p(C.L): a lobe of one shape, whose size changes with the view.

    Attributes
    ----------
    factor : (VIEWS, channels) float64
        F, uniform in theta_v over [0, pi/2], linear in between.
    lobe : RadialLobe
        p, about the reflection or the normal; negative in places for all but the first of several.
    """

    factor: FloatArray
    lobe: RadialLobe


def factor_at(factor: FloatArray, theta_v: FloatArray) -> FloatArray:
    """Return a factor (T, channels) over [0, pi/2] for angles theta_v, linear in between; (n, channels)."""
    k, t = _cell(np.clip(theta_v / (np.pi / 2), 0.0, 1.0) * (len(factor) - 1), len(factor))
    return np.asarray((1.0 - t)[:, None] * factor[k] + t[:, None] * factor[k + 1])


def symmetric(lobe: Lobe) -> ZonalLobe:
    """Return the lobe symmetric about R that is nearest to another for every view: its mean over azimuth.

    Parameters
    ----------
    lobe : Lobe
        Isotropic, or zonal, which is returned as it is.

    Returns
    -------
    ZonalLobe
        About the reflection, or the zonal lobe's center.

    Raises
    ------
    ValueError
        If the lobe is radial: it depends on no view.
    """
    return lobe if isinstance(lobe, ZonalLobe) else ZonalLobe("reflection", _table(lobe))


def factored(lobe: Lobe, lobes: int = 1) -> tuple[FactoredLobe, ...]:
    """Return the sum of factored lobes that is nearest to a lobe.

    The distance is the mean square over lights, and over views with cos^2(theta_v) uniform.

    Parameters
    ----------
    lobe : Lobe
        As in `symmetric`, but not about the tangent.
    lobes : int
        Number of factored lobes, 1 to 8.

    Returns
    -------
    tuple of FactoredLobe

    Raises
    ------
    TypeError, ValueError
        If the lobe is radial or about the tangent, or `lobes` is out of its range.
    """
    whole_number("lobes", lobes, 1, MOST_LOBES)
    table = _table(lobe)
    factors, shapes = [], []
    for values in np.moveaxis(table.values, 2, 0):
        # Roots of the measures: products with them have the mean square as their norm.
        _, sigma, Vt = np.linalg.svd(
            np.sqrt(table.view_measure)[:, None] * values * np.sqrt(table.light_measure)
        )
        # Shapes beyond the rank would be any, and spikes for a black channel: they stay black.
        rank = min(lobes, int(np.count_nonzero(sigma > NEGLIGIBLE * sigma[0])))
        shape = Vt[:rank] / np.sqrt(table.light_measure)
        factor = _projected(values, shape, table.light_measure)
        sign = np.where(factor.sum(axis=0) < 0, -1.0, 1.0)
        factors.append(np.pad(sign * factor, ((0, 0), (0, lobes - rank))))
        shapes.append(np.pad(sign[:, None] * shape, ((0, lobes - rank), (0, 0))))
    center = lobe.center if lobe.kind == "zonal" else "reflection"
    return tuple(
        FactoredLobe(
            np.stack([factor[:, k] for factor in factors], axis=1),
            RadialLobe(center, _Shape(table.grid, np.stack([shape[k] for shape in shapes], axis=1))),
        )
        for k in range(lobes)
    )


def as_factored(lobe: Lobe) -> FactoredLobe:
    """Return a radial lobe with the factor 1, any other as the nearest factored lobe; see `factored`."""
    return FactoredLobe(np.ones((2, 1)), lobe) if isinstance(lobe, RadialLobe) else factored(lobe)[0]


def factored_phong(lobe: Lobe) -> tuple[FactoredLobe]:
    """Return the Phong lobe, and its factor for each view, that are nearest to a lobe; see `factored`."""
    table = _table(lobe)
    best: tuple[float, float, FloatArray] | None = None
    for exponent in np.geomspace(*PHONG_EXPONENTS):
        shape = profile_at_angles(Phong(exponent).lobes[0].profile, table.theta_i)[None]
        factor = np.stack(
            [_projected(u, shape, table.light_measure)[:, 0] for u in np.moveaxis(table.values, 2, 0)], axis=1
        )
        squares = (factor[:, None] * shape[0][:, None] - table.values) ** 2
        distance = float(np.einsum("vlc,v,l->", squares, table.view_measure, table.light_measure))
        if best is None or distance < best[0]:
            best = distance, float(exponent), factor
    assert best is not None
    center = lobe.center if lobe.kind == "zonal" else "reflection"
    return (FactoredLobe(best[2], RadialLobe(center, Phong(best[1]).lobes[0].profile)),)


def _projected(values: FloatArray, shape: FloatArray, measure: FloatArray) -> FloatArray:
    """Fit factors (VIEWS, lobes) for shapes (lobes, LIGHTS) to the rows of a table.

    The fit is by least squares among those that reflect as much of a white light as the rows do.
    """
    weighted = shape * measure
    gram, integral = weighted @ shape.T, weighted.sum(axis=1)
    factor = np.linalg.solve(gram, weighted @ values.T).T
    towards = np.linalg.solve(gram, integral)  # the direction that costs least
    missing = values @ measure - factor @ integral
    reflected = float(integral @ towards)
    return np.asarray(factor + (missing[:, None] * towards / reflected if reflected > 1e-12 else 0.0))


@dataclass(frozen=True, eq=False)
class _Grid:
    """Nodes in theta_i, dense within the width of a lobe: theta_i = width sinh(x)."""

    width: float

    @property
    def nodes(self) -> FloatArray:
        end = np.arcsinh(np.pi / self.width)
        return np.minimum(self.width * np.sinh(np.linspace(0.0, end, LIGHTS)), np.pi)

    def place(self, theta_i: FloatArray) -> FloatArray:
        """Return the place of angles among the nodes, in [0, LIGHTS - 1]."""
        return np.asarray(np.arcsinh(theta_i / self.width) * ((LIGHTS - 1) / np.arcsinh(np.pi / self.width)))


@dataclass(frozen=True, eq=False)
class _Shape:
    """A profile of cos(theta_i), by cubics of Catmull and Rom between the nodes of a grid.

    Smooth, so that the integrators' tables stay small.
    """

    grid: _Grid
    values: FloatArray  # (LIGHTS, channels)

    def __call__(self, cos_theta_i: FloatArray) -> FloatArray:
        k, t = _cell(self.grid.place(np.arccos(np.clip(cos_theta_i, -1.0, 1.0))), LIGHTS)
        # At C the profile is even; behind the last node nothing changes.
        before, after = np.abs(k - 1), np.minimum(k + 2, LIGHTS - 1)
        a, b, c, d = (self.values[index] for index in (before, k, k + 1, after))
        t = t[:, None]
        u = b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
        return u[:, 0] if u.shape[1] == 1 else u


@dataclass(frozen=True, eq=False)
class _Table:
    """The mean over azimuth of a lobe, a zonal profile: bilinear between its nodes."""

    grid: _Grid
    values: FloatArray  # (VIEWS, LIGHTS, channels)

    @property
    def theta_v(self) -> FloatArray:
        return np.linspace(0.0, np.pi / 2, VIEWS)

    @property
    def theta_i(self) -> FloatArray:
        return self.grid.nodes

    @property
    def view_measure(self) -> FloatArray:
        """The measure of each view node for cos^2(theta_v) uniform: what lies nearer to it than to others."""
        return _shares(np.sin(self.theta_v) ** 2)

    @property
    def light_measure(self) -> FloatArray:
        """The solid angle of the ring of each light node: what lies nearer to it than to others."""
        return _shares(-2 * np.pi * np.cos(self.theta_i))

    def __call__(self, theta_i: FloatArray, theta_o: FloatArray) -> FloatArray:
        k, t = _cell(self.grid.place(theta_i), LIGHTS)
        v, s = _cell(np.asarray(theta_o) / np.pi * (VIEWS - 1), VIEWS)  # theta_o = 2 theta_v
        low, high = (
            self.values[row, k] * (1.0 - t)[:, None] + self.values[row, k + 1] * t[:, None]
            for row in (v, v + 1)
        )
        u = low * (1.0 - s)[:, None] + high * s[:, None]
        return u[:, 0] if u.shape[1] == 1 else u


def _table(lobe: Lobe) -> _Table:
    """Tabulate the mean of a lobe over the azimuth about R, or a zonal lobe about its center."""
    theta_v = np.linspace(0.0, np.pi / 2, VIEWS)
    if isinstance(lobe, ZonalLobe) and lobe.center != "tangent":
        grid = _Grid(_width(lobe))
        o, i = np.meshgrid(lobe.theta_o(theta_v), grid.nodes, indexing="ij")
        return _Table(grid, lobe.profile(i.ravel(), o.ravel()).reshape(VIEWS, LIGHTS, -1))
    refuse_anisotropic(lobe)
    if lobe.kind != "isotropic":
        raise ValueError(f"a {lobe.kind} lobe about the {lobe.center} is no lobe to be made symmetric")

    # Nodes about R in the lobe's plane, over half a circle: the lobe is even in phi.
    _, width = lobe_center(lobe.transfer)
    grid = _Grid(width)
    theta_i = grid.nodes
    phi = np.pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    a, b = np.meshgrid(theta_i, phi, indexing="ij")
    x, y, z = np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)

    # The mean over phi for each view
    means = []
    for angle in np.minimum(theta_v, np.pi / 2 - 1e-6):
        sine, cosine = np.sin(angle), np.cos(angle)
        # From the frame of R, azimuth 0 towards N, to that of N: R = (-sin, 0, cos).
        wi = np.stack([cosine * x - sine * z, y, sine * x + cosine * z], axis=-1).reshape(-1, 3)
        wo = np.tile([sine, 0.0, cosine], (len(wi), 1))
        means.append(lobe.transfer(wi, wo).reshape(LIGHTS, AZIMUTHS, -1).mean(axis=1))
    return _Table(grid, np.stack(means))


def _cell(place: FloatArray, nodes: int) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Return the node before each place, and how far beyond it that lies, in [0, 1]."""
    k = np.clip(place.astype(np.intp), 0, nodes - 2)
    return k, np.clip(place - k, 0.0, 1.0)


def _width(lobe: ZonalLobe) -> float:
    """Return the angle from C that holds half of the energy for a view at 45 degrees, radians."""
    theta_i = np.linspace(0.0, np.pi, 4097)[1:]
    u = lobe.profile(theta_i, np.full_like(theta_i, lobe.theta_o(np.array(np.pi / 4))))
    energy = np.cumsum((u.reshape(len(u), -1) ** 2).sum(axis=1) * np.sin(theta_i))
    return float(np.clip(theta_i[np.searchsorted(energy, energy[-1] / 2)], 1e-3, 0.8))


def _shares(position: FloatArray) -> FloatArray:
    """Return the length nearer to each of some rising positions than to the others."""
    middles = 0.5 * (position[:-1] + position[1:])
    return np.diff(np.concatenate([position[:1], middles, position[-1:]]))
