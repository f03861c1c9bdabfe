"""Lobes: transfer functions with a central direction, the parts of every material.

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

A lobe is a value: equal lobes are those of equal functions about the same center. Its function must not
change once the lobe is made.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.cosine_power import profile_at
from shrm.brdf.value import Value
from shrm.validation import RGB, one_of

Center = Literal["lobe", "reflection", "normal", "tangent"]
Frame = Literal["normal", "tangent"]
Kind = Literal["radial", "zonal", "isotropic", "anisotropic"]


@dataclass(frozen=True, eq=False, repr=False)
class Scaled(Value):
    """A lobe's function or profile times a number, or times one per channel.

    Attributes
    ----------
    function : callable
        Arrays of n directions or angles to (n,) or (n, 3) float64.
    factor : float or three floats
        Factor of its values; at most 1e30 with the factors before it.
    """

    function: Callable[..., FloatArray]
    factor: float | RGB

    def __post_init__(self) -> None:
        if self.largest > parameters.LARGEST:
            raise ValueError(
                f"factor must be at most {parameters.LARGEST:g}, with the factors before it, "
                f"got {self.largest:g}"
            )

    @property
    def largest(self) -> float:
        """The largest factor of all that the function is multiplied by."""
        before = self.function.largest if isinstance(self.function, Scaled) else 1.0
        return before * float(np.max(self.factor))

    @property
    def takes_haversine(self) -> bool:
        """True if the function is a profile of cosine and haversine; see `shrm.brdf.cosine_power`."""
        return bool(getattr(self.function, "takes_haversine", False))

    def __call__(self, *angles: FloatArray) -> FloatArray:
        """Evaluate the function, (n,), or (n, 3) where it or the factor has three channels."""
        values = self.function(*angles)
        if isinstance(self.factor, float):
            return np.asarray(values * self.factor)
        columns = values if values.ndim == 2 else values[:, None]
        return np.asarray(columns * np.array(self.factor))


class Lobe(ABC, Value):
    """A transfer function with a central direction.

    Attributes
    ----------
    center : {"lobe", "reflection", "normal", "tangent"}
        The central direction C.
    kind : {"radial", "zonal", "isotropic", "anisotropic"}
        The angles it depends on: theta_i alone, both angles from C, the azimuth between them too, or each
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


@dataclass(frozen=True, eq=False, repr=False)
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
        if self.center == "reflection":  # R.L with R = 2 (N.V) N - V
            cos_theta_i = 2.0 * wo[:, 2] * wi[:, 2] - np.einsum("nc,nc->n", wi, wo)
            apart = wi - wo * [-1.0, -1.0, 1.0]
        else:
            cos_theta_i, apart = wi[:, 2], wi - [0.0, 0.0, 1.0]
        haversine = np.minimum(
            0.25 * np.einsum("nc,nc->n", apart, apart), 1.0
        )  # |L - C| = 2 sin(theta_i / 2)
        return profile_at(self.profile, np.clip(cos_theta_i, -1.0, 1.0), haversine)

    def scaled(self, factor: float | RGB) -> RadialLobe:
        """Return the lobe times a number, or times one per channel."""
        return replace(self, profile=Scaled(self.profile, factor))


@dataclass(frozen=True, eq=False, repr=False)
class ZonalLobe(Lobe):
    """A lobe symmetric about C for every view: rho_hat = profile(theta_i, theta_o).

    Only q = 0 remains of its coefficients [RH02 sec. 7.1, footnote 7]. About the tangent, whose lobes have
    no normal: Kajiya-Kay, Banks. About the reflection: the approximation of isotropic BRDFs of [KM00]. No
    horizon cuts them.

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
        return replace(self, profile=Scaled(self.profile, factor))


@dataclass(frozen=True, eq=False, repr=False)
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
        return replace(self, function=Scaled(self.function, factor))


@dataclass(frozen=True, eq=False, repr=False)
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
        return AnisotropicLobe(Scaled(self.function, factor))


def refuse_anisotropic(lobe: object) -> None:
    """Raise ValueError if a lobe is anisotropic."""
    if getattr(lobe, "kind", None) == "anisotropic":
        raise ValueError(
            "an anisotropic lobe depends on the azimuths of light and view each, and a reflection map over "
            "two or three dimensions cannot hold that: use matrix radiance transfer (shrm.transfer)"
        )


def _colatitude(w: FloatArray) -> FloatArray:
    """Return the angles (n,) of unit vectors (n, 3) from z, accurate near 0 and pi."""
    return np.asarray(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]))


def _require_center(lobe: Lobe, *centers: Center) -> None:
    one_of(f"{type(lobe).__name__}: center", lobe.center, centers)
