"""Miller's and Heidrich's sum of a diffuse and a Phong lobe with Fresnel factors [KVHS00 eq. 2].

    rho_hat = F_d(N.R) albedo / pi max(N.L, 0)  +  F_p(N.R) (s + 1) / (2 pi) max(R.L, 0)^s

with F_p Schlick's term at N.R = N.V and F_d = 1 - F_p, so that no more is reflected than comes in. Each lobe
keeps its shape for all views, and only its size changes: two maps of two dimensions hold all.
"""

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.cosine_power import profile_at_angles
from shrm.brdf.half_vector import schlick
from shrm.brdf.lobe import ZonalLobe
from shrm.brdf.material import BRDF
from shrm.brdf.models.lambert import Lambert
from shrm.brdf.models.phong import Phong
from shrm.brdf.value import Method
from shrm.validation import RGB, number, number_or_rgb


@dataclass(frozen=True)
class MillerHeidrich(BRDF):
    """A diffuse lobe and a Phong lobe, shared out by Fresnel's law.

    Parameters
    ----------
    albedo : float or three floats
        Albedo of the diffuse lobe, in [0, 1].
    exponent : float
        Exponent s of the Phong lobe, in [0, 1e12].
    f0 : float or three floats
        Reflectance at normal incidence, in [0, 1].
    """

    albedo: float | RGB
    exponent: float
    f0: float | RGB = 0.04

    def __post_init__(self) -> None:
        object.__setattr__(self, "albedo", number_or_rgb("MillerHeidrich: albedo", self.albedo, 0.0, 1.0))
        object.__setattr__(
            self, "exponent", number("MillerHeidrich: exponent", self.exponent, 0.0, parameters.SHARPEST)
        )
        object.__setattr__(self, "f0", number_or_rgb("MillerHeidrich: f0", self.f0, 0.0, 1.0))

    @property
    def lobes(self) -> tuple[ZonalLobe, ZonalLobe]:
        """The diffuse lobe about the normal and the Phong lobe about the reflection."""
        diffuse, specular = Method(MillerHeidrich._diffuse, self), Method(MillerHeidrich._specular, self)
        return (ZonalLobe("normal", diffuse), ZonalLobe("reflection", specular))

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        albedo, exponent, f0 = map(parameters.text, (self.albedo, self.exponent, self.f0))
        return f"miller-heidrich(albedo={albedo},exponent={exponent},f0={f0})"

    def _diffuse(self, theta_i: FloatArray, theta_o: FloatArray) -> FloatArray:
        lambert = Lambert(self.albedo).lobes[0].profile(np.cos(theta_i))
        return _product(1.0 - schlick(self.f0, np.cos(theta_o)), lambert)  # theta_o = theta_v

    def _specular(self, theta_i: FloatArray, theta_o: FloatArray) -> FloatArray:
        phong = profile_at_angles(Phong(self.exponent).lobes[0].profile, theta_i)
        return _product(schlick(self.f0, np.cos(0.5 * theta_o)), phong)  # theta_o = 2 theta_v


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Multiply arrays of (n,) or (n, 3) each: (n, 3) where either has channels."""
    if a.ndim == b.ndim:
        return a * b
    return a * b[:, None] if a.ndim == 2 else a[:, None] * b
