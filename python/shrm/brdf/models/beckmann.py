"""Beckmann microfacets with exact Smith masking [WMLT07].

    rho_hat = D(H) G1(L) G1(V) F(L.H) / (4 N.V)    where N.L > 0            [WMLT07 eq. 20, times N.L]

    D(H)  = exp(-tan^2 theta_h / alpha^2) / (pi alpha^2 cos^4 theta_h)      [WMLT07 eq. 25]
    G1(v) = 2 / (1 + erf(a) + exp(-a^2) / (a sqrt(pi))),  a = 1 / (alpha tan theta_v)   [WMLT07 eq. 26]
    F     = f0 + (1 - f0) (1 - L.H)^5                                       Schlick

The cosine is in it. About the lobe center, or about the reflection. Single scattering: a rough
surface with f0 = 1 reflects less than it receives.
"""

import math
from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.half_vector import above_horizon, half_vector, schlick
from shrm.brdf.lobe import IsotropicLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method
from shrm.validation import RGB, number, number_or_rgb


@dataclass(frozen=True)
class Beckmann(BRDF):
    """Microfacets of the Beckmann distribution with exact Smith masking and Schlick's Fresnel term.

    Parameters
    ----------
    alpha : float
        Width parameter (alpha_b in the source): sqrt(2) times the RMS slope, 0 < alpha <= 1 (at
        least 1e-6).
    f0 : float or three floats
        Reflectance at normal incidence, in [0, 1]; three numbers for R, G, B.
    """

    alpha: float
    f0: float | RGB = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "alpha", number("Beckmann: alpha", self.alpha, parameters.NARROWEST, 1.0))
        object.__setattr__(self, "f0", number_or_rgb("Beckmann: f0", self.f0, 0.0, 1.0))

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe center."""
        return (IsotropicLobe("lobe", Method(Beckmann._transfer, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        f0 = "" if self.f0 == 1.0 else f",f0={parameters.text(self.f0)}"
        return f"beckmann(alpha={parameters.text(self.alpha)}{f0})"

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        alpha2 = self.alpha * self.alpha
        h = half_vector(wi, wo)
        cos2 = np.maximum(h.cos2, 1e-30)  # the exponential is 0 long before
        D = np.exp(-h.sin2 / (cos2 * alpha2)) / (np.pi * alpha2 * cos2**2)
        cos_l = np.maximum(wi[:, 2], 0.0)
        scalar = D * cos_l * self._g1_over_cosine(wi) * self._g1_over_cosine(wo) / 4.0
        scalar = np.where(above_horizon(wi, wo), scalar, 0.0)
        F = schlick(self.f0, h.cos_d)
        return F * (scalar if F.ndim == 1 else scalar[:, None])

    def _g1_over_cosine(self, w: FloatArray) -> FloatArray:
        """G1(w) / N.w with a = N.w / (alpha sin): finite (2 sqrt(pi) / alpha) as w grazes the surface."""
        cosine = np.abs(w[:, 2])  # below the horizon the result is not used
        alpha_sin = self.alpha * np.hypot(w[:, 0], w[:, 1])
        # Beyond a = 6, erf(a) is 1 and exp(-a^2) is 0 in float64.
        masked = cosine < 6.0 * alpha_sin
        a = cosine[masked] / alpha_sin[masked]
        erf = np.fromiter(map(math.erf, a.tolist()), np.float64, a.size)
        denominator = 2.0 * cosine
        denominator[masked] = cosine[masked] * (1.0 + erf) + alpha_sin[masked] * np.exp(-(a**2)) / math.sqrt(
            np.pi
        )
        return np.asarray(2.0 / denominator)
