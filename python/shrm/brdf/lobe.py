"""Lobes and materials: what the rest of shrm sees of a BRDF.

A *lobe* is a transfer function rho_hat(wi, wo) with a central direction C. It is the BRDF times
the cosine N.L where the model has one, and it is zero below the horizon, so that the reflected
radiance is the plain integral of rho_hat times the environment over all directions wi.

Directions wi (to the light) and wo = V (to the eye) are unit vectors in the frame x = tangent,
z = normal. For lobes about the tangent the frame has z = T instead, and there is no normal.

    RadialLobe      rho_hat = profile(C.L)                 one dimension: Lambert, Phong
    ZonalLobe       rho_hat = profile(theta_i, theta_o)    angles from C: Kajiya-Kay, Banks
    IsotropicLobe   rho_hat = function(wi, wo)             any that turns with L and V about N
    AnisotropicLobe rho_hat = function(wi, wo)             everything else; no reflection map holds it

The central direction, with theta_v the angle between N and V [RH02 sec. 3.1]:

    "normal"        C = N
    "reflection"    C = R = 2 (N.V) N - V
    "lobe"          C in the plane of N and V, at the energy-weighted mean direction of the lobe
    "tangent"       C = T

A *material* (`BRDF`) is a sum of lobes, each with its own center.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import ClassVar, Literal, get_args

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.validation import RGB, number_or_rgb, one_of, unit_vectors

Center = Literal["lobe", "reflection", "normal", "tangent"]
Frame = Literal["normal", "tangent"]
Kind = Literal["radial", "zonal", "isotropic", "anisotropic"]


class Lobe(ABC):
    """A transfer function with a central direction.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        The central direction C.
    kind : {"radial", "zonal", "isotropic", "anisotropic"}
        What it depends on: theta_i alone, both angles from C, the azimuth between them too, or each
        azimuth from the tangent.
    """

    center: Center
    kind: ClassVar[Kind]

    @abstractmethod
    def transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, the cosine included.

        Parameters
        ----------
        wi, wo : (n, 3) float64
            Unit vectors to the light and to the eye, in the frame of the lobe. Not checked here:
            `BRDF.transfer` is the door.

        Returns
        -------
        (n,) or (n, 3) float64
            Per steradian; one column per channel where the channels differ.
        """

    @abstractmethod
    def scaled(self, factor: float | RGB) -> Lobe:
        """Return the lobe times a number, or times one per channel."""

    @property
    def frame(self) -> Frame:
        """The z axis of wi and wo: "normal" or "tangent"."""
        return "tangent" if self.center == "tangent" else "normal"

    @property
    def channels(self) -> Literal[1, 3]:
        """1 if `transfer` returns (n,), 3 if it returns (n, 3)."""
        z = np.array([[0.0, 0.0, 1.0]])
        return 1 if self.transfer(z, z).ndim == 1 else 3


@dataclass(frozen=True)
class RadialLobe(Lobe):
    """A lobe of fixed shape, symmetric about C: rho_hat = profile(C.L), [RH02 sec. 3.1].

    Parameters
    ----------
    center : {"reflection", "normal"}
        C.
    profile : callable
        cos(theta_i) = C.L, (n,) float64 in [-1, 1], to (n,) or (n, 3) float64.
    """

    kind = "radial"
    center: Center
    profile: Callable[[FloatArray], FloatArray]

    def __post_init__(self) -> None:
        _require_center(self, "reflection", "normal")

    def transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat; see `Lobe.transfer`."""
        cos_theta_i = wi[:, 2]
        if self.center == "reflection":  # R.L with R = 2 (N.V) N - V
            cos_theta_i = 2.0 * wo[:, 2] * wi[:, 2] - np.einsum("nc,nc->n", wi, wo)
        return self.profile(np.clip(cos_theta_i, -1.0, 1.0))

    def scaled(self, factor: float | RGB) -> RadialLobe:
        """Return the lobe times a number, or times one per channel."""
        return replace(self, profile=lambda cos_theta_i: _times(self.profile(cos_theta_i), factor))


@dataclass(frozen=True)
class ZonalLobe(Lobe):
    """A lobe symmetric about C for every view: rho_hat = profile(theta_i, theta_o).

    Only q = 0 remains of its coefficients [RH02 sec. 7.1, footnote 7]. About the tangent, whose lobes have
    no normal: Kajiya-Kay, Banks. About the reflection: the approximation of isotropic BRDFs in
    J. Kautz, M. McCool, Approximation of Glossy Reflection with Prefiltered Environment Maps, Graphics
    Interface 2000. No horizon cuts them.

    Parameters
    ----------
    center : {"reflection", "normal", "tangent"}
        C.
    profile : callable
        theta_i, theta_o, the angles of L and V from C, (n,) float64 in [0, pi] (theta_o in [0, pi/2] about
        the normal), to (n,) or (n, 3) float64.
    """

    kind = "zonal"
    center: Center
    profile: Callable[[FloatArray, FloatArray], FloatArray]

    def __post_init__(self) -> None:
        _require_center(self, "reflection", "normal", "tangent")

    def transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat; see `Lobe.transfer`. Views below the normal's horizon are brought back to it."""
        theta_v = _colatitude(wo)
        if self.center == "reflection":
            R = np.stack([-wo[:, 0], -wo[:, 1], wo[:, 2]], axis=1)  # R = 2 (N.V) N - V
            across, along = np.linalg.norm(np.cross(R, wi), axis=1), np.einsum("nc,nc->n", R, wi)
            return self.profile(np.arctan2(across, along), self.theta_o(theta_v))
        return self.profile(_colatitude(wi), self.theta_o(theta_v))

    def theta_o(self, theta_v: FloatArray) -> FloatArray:
        """Return the angles between C and V for those of V from the z axis of the frame, N or T."""
        if self.center == "reflection":
            return np.minimum(2.0 * theta_v, 2.0 * (np.pi - theta_v))
        return np.minimum(theta_v, np.pi / 2) if self.center == "normal" else theta_v

    def scaled(self, factor: float | RGB) -> ZonalLobe:
        """Return the lobe times a number, or times one per channel."""
        return replace(self, profile=lambda theta_i, theta_o: _times(self.profile(theta_i, theta_o), factor))


@dataclass(frozen=True)
class IsotropicLobe(Lobe):
    """Any lobe that keeps its value when L and V turn together about N, or are mirrored together.

    That is, it depends on theta_i, theta_o and |phi_i - phi_o| about N; hence about R, or any
    other C in the plane of N and V, it is a function rho_hat(theta_i, theta_o, |phi|).

    Parameters
    ----------
    center : {"lobe", "reflection", "normal"}
        C.
    function : callable
        wi, wo, (n, 3) float64, to (n,) or (n, 3) float64, zero where N.L <= 0.
    """

    kind = "isotropic"
    center: Center
    function: Callable[[FloatArray, FloatArray], FloatArray]

    def __post_init__(self) -> None:
        _require_center(self, "lobe", "reflection", "normal")

    def transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat; see `Lobe.transfer`."""
        return self.function(wi, wo)

    def scaled(self, factor: float | RGB) -> IsotropicLobe:
        """Return the lobe times a number, or times one per channel."""
        return replace(self, function=lambda wi, wo: _times(self.function(wi, wo), factor))


@dataclass(frozen=True)
class AnisotropicLobe(Lobe):
    """A lobe of four angles, which no reflection map holds: it depends on each azimuth from the tangent.

    Parameters
    ----------
    function : callable
        wi, wo, (n, 3) float64, to (n,) or (n, 3) float64, zero where N.L <= 0.
    """

    kind = "anisotropic"
    center: Center = field(default="normal", init=False)
    function: Callable[[FloatArray, FloatArray], FloatArray]

    def transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat; see `Lobe.transfer`."""
        return self.function(wi, wo)

    def scaled(self, factor: float | RGB) -> AnisotropicLobe:
        """Return the lobe times a number, or times one per channel."""
        return AnisotropicLobe(lambda wi, wo: _times(self.function(wi, wo), factor))


def refuse_anisotropic(lobe: object) -> None:
    """Raise ValueError if a lobe is anisotropic."""
    if getattr(lobe, "kind", None) == "anisotropic":
        raise ValueError(
            "an anisotropic lobe depends on the azimuths of light and view each, and a reflection map over "
            "two or three dimensions cannot hold that: use matrix radiance transfer (shrm.transfer)"
        )


class BRDF(ABC):
    """A material: a sum of lobes, each with its own center.

    `a + b` is the material that reflects what both reflect; `0.5 * a` and `(1, 0.5, 0.2) * a`
    scale it, per channel where three numbers are given. Factors are at least 0.

    The package's own materials do not change: what is computed for one is kept, and found for its equals.
    """

    # So that numpy's scalars and arrays leave `factor * material` to `__rmul__`.
    __array_ufunc__ = None

    @property
    @abstractmethod
    def lobes(self) -> tuple[Lobe, ...]:
        """The lobes whose sum the material is, in a fixed order."""

    @property
    @abstractmethod
    def name(self) -> str:
        """A short text such as "ggx(alpha=0.1)"; `parse` reads those of analytic materials."""

    @property
    def channels(self) -> Literal[1, 3]:
        """3 if any lobe has three channels, else 1."""
        return 3 if any(lobe.channels == 3 for lobe in self.lobes) else 1

    @property
    def frame(self) -> Frame:
        """The frame that all lobes share: "normal" or "tangent".

        Raises
        ------
        ValueError
            If some are about the tangent and some are not.
        """
        frames = {lobe.frame for lobe in self.lobes}
        if len(frames) > 1:
            raise ValueError(
                f"{self.name} has lobes about the tangent and lobes about the normal, "
                "which share no frame: evaluate its lobes one by one"
            )
        return frames.pop()

    def transfer(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> FloatArray:
        """Evaluate rho_hat, the sum over the lobes, the cosine included.

        Parameters
        ----------
        wi, wo : (n, 3) array_like
            Unit vectors to the light and to the eye in the frame x = tangent, z = normal (a
            material about the tangent: z = T).

        Returns
        -------
        (n,) or (n, 3) float64
            Per steradian.

        Raises
        ------
        TypeError, ValueError
            If `wi` or `wo` is not an array of n unit vectors, or the lobes share no frame.
        """
        directions_i, directions_o = unit_vectors("wi", wi), unit_vectors("wo", wo)
        if directions_i.shape != directions_o.shape:
            raise ValueError(
                f"wi and wo must have the same shape, got {directions_i.shape} and {directions_o.shape}"
            )
        self.frame  # noqa: B018  (refuses lobes that share no frame)
        return _sum_of_transfers(self.lobes, directions_i, directions_o)

    def recentered(self, center: Center, *, merge: bool = False) -> BRDF:
        """Return the same material with its lobes about another center.

        Lobes that are exactly symmetric (radial) about their own center keep it, unless they are merged.

        Parameters
        ----------
        center : {"lobe", "reflection", "normal"}
            The new center of the isotropic lobes. ("tangent" leaves a material about the tangent
            as it is.)
        merge : bool
            Put everything, a diffuse lobe included, into one isotropic lobe about `center`; with
            "reflection" that is how [RH02] treats materials with a diffuse part (footnote 6).

        Raises
        ------
        ValueError
            If no such material exists; the text says why.
        """
        one_of("center", center, get_args(Center))
        if _does_not_change(self):
            return _kept_recentered(self, center, bool(merge))
        return _recentered(self, center, bool(merge))

    def __add__(self, other: object) -> BRDF:
        if not isinstance(other, BRDF):
            return NotImplemented
        return Material(self.lobes + other.lobes, f"{self.name} + {other.name}")

    def __mul__(self, factor: object) -> BRDF:
        if isinstance(factor, BRDF):
            return NotImplemented
        weight = number_or_rgb(f"{self.name}: factor", factor, 0.0)
        terms = (f"{parameters.text(weight)}*{term}" for term in self.name.split(" + "))
        return Material(tuple(lobe.scaled(weight) for lobe in self.lobes), " + ".join(terms))

    def __rmul__(self, factor: object) -> BRDF:
        return self * factor

    def __repr__(self) -> str:
        lobes = ", ".join(
            f"{type(lobe).__name__} about the {_CENTER_TEXT[lobe.center]}" for lobe in self.lobes
        )
        return f"<{type(self).__name__} {self.name}: {lobes}>"


class Material(BRDF):
    """A material given by its lobes: what sums, products and `recentered` return.

    Parameters
    ----------
    lobes : sequence of Lobe
        At least one.
    name : str
        A short text.
    """

    def __init__(self, lobes: tuple[Lobe, ...], name: str):
        self._lobes = tuple(lobes)
        self._name = name
        if not self._lobes or not all(isinstance(lobe, Lobe) for lobe in self._lobes):
            raise TypeError(f"Material: lobes must be one or more Lobe objects, got {lobes!r}")

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The lobes it was made of."""
        return self._lobes

    @property
    def name(self) -> str:
        """The name it was given."""
        return self._name


def _does_not_change(material: BRDF) -> bool:
    """Whether a material is a frozen dataclass that can be hashed, as all models of this package are."""
    parameters_of = getattr(type(material), "__dataclass_params__", None)
    if parameters_of is None or not parameters_of.frozen:
        return False
    try:
        hash(material)
    except TypeError:
        return False
    return True


def _recentered(material: BRDF, center: Center, merge: bool) -> BRDF:
    """See `BRDF.recentered`."""
    wanted = "tangent" if center == "tangent" else "normal"
    if any(lobe.frame != wanted for lobe in material.lobes):
        raise ValueError(
            f"{material.name} cannot be centered on the {_CENTER_TEXT[center]}: a lobe about the tangent has "
            "no normal, and a lobe about the normal, the reflection or the lobe center depends on it"
        )
    if not merge:
        moved = (
            replace(lobe, center=center) if isinstance(lobe, IsotropicLobe) else lobe
            for lobe in material.lobes
        )
        return Material(tuple(moved), material.name)
    if center == "tangent":
        raise ValueError(f"{material.name} cannot be merged about the tangent: its lobes have no normal")
    for lobe in material.lobes:
        refuse_anisotropic(lobe)
    if any(_has_no_horizon(lobe) for lobe in material.lobes):
        raise ValueError(
            f"{material.name} cannot be merged: its lobe about the reflection has no horizon, "
            "and an isotropic lobe is zero below it"
        )
    lobes = material.lobes
    return Material((IsotropicLobe(center, lambda wi, wo: _sum_of_transfers(lobes, wi, wo)),), material.name)


# Equal materials give the same one, so that what is kept for it is found again.
_kept_recentered = lru_cache(maxsize=64)(_recentered)

_CENTER_TEXT = {"lobe": "lobe center", "reflection": "reflection", "normal": "normal", "tangent": "tangent"}


def _has_no_horizon(lobe: Lobe) -> bool:
    return isinstance(lobe, ZonalLobe) or (isinstance(lobe, RadialLobe) and lobe.center == "reflection")


def _colatitude(w: FloatArray) -> FloatArray:
    """Angles (n,) of unit vectors (n, 3) from z, accurate near 0 and pi."""
    return np.asarray(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]))


def _require_center(lobe: Lobe, *centers: Center) -> None:
    one_of(f"{type(lobe).__name__}: center", lobe.center, centers)


def _times(values: FloatArray, factor: float | RGB) -> FloatArray:
    if isinstance(factor, float):
        return np.asarray(values * factor)
    columns = values if values.ndim == 2 else values[:, None]
    return np.asarray(columns * np.array(factor))


def _sum_of_transfers(lobes: tuple[Lobe, ...], wi: FloatArray, wo: FloatArray) -> FloatArray:
    parts = [lobe.transfer(wi, wo) for lobe in lobes]
    if any(part.ndim == 2 for part in parts):
        parts = [part if part.ndim == 2 else part[:, None] for part in parts]
    return np.asarray(sum(parts[1:], start=parts[0]))
