"""GGX (Trowbridge-Reitz) microfacets [WMLT07].

    rho_hat = D(H) G1(L) G1(V) F(L.H) / (4 N.V)    where N.L > 0            [WMLT07 eq. 20, times N.L]

    D(H)  = alpha^2 / (pi (alpha^2 cos^2 theta_h + sin^2 theta_h)^2)        [WMLT07 eq. 33]
    G1(v) = 2 N.v / (N.v + sqrt((N.v)^2 + alpha^2 (1 - (N.v)^2)))           [WMLT07 eq. 34], Smith, separable
    F     = f0 + (1 - f0) (1 - L.H)^5                                       Schlick

The cosine is in it. About the lobe center, or about the reflection. Single scattering: a rough
surface with f0 = 1 reflects less than it receives.
"""

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
class GGX(BRDF):
    """Microfacets of the GGX distribution with Smith masking and Schlick's Fresnel term.

    Parameters
    ----------
    alpha : float
        Width parameter (alpha_g in the source), 0 < alpha <= 1 (at least 1e-6).
    f0 : float or three floats
        Reflectance at normal incidence, in [0, 1]; three numbers for R, G, B.
    """

    alpha: float
    f0: float | RGB = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "alpha", number("GGX: alpha", self.alpha, parameters.NARROWEST, 1.0))
        object.__setattr__(self, "f0", number_or_rgb("GGX: f0", self.f0, 0.0, 1.0))

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe center."""
        return (IsotropicLobe("lobe", Method(GGX._transfer, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        f0 = "" if self.f0 == 1.0 else f",f0={parameters.text(self.f0)}"
        return f"ggx(alpha={parameters.text(self.alpha)}{f0})"

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        alpha2 = self.alpha * self.alpha
        h = half_vector(wi, wo)
        D = alpha2 / (np.pi * (alpha2 * h.cos2 + h.sin2) ** 2)
        cos_l = np.maximum(wi[:, 2], 0.0)
        scalar = D * cos_l * self._g1_over_cosine(wi) * self._g1_over_cosine(wo) / 4.0
        scalar = np.where(above_horizon(wi, wo), scalar, 0.0)
        F = schlick(self.f0, h.cos_d)
        return F * (scalar if F.ndim == 1 else scalar[:, None])

    def _g1_over_cosine(self, w: FloatArray) -> FloatArray:
        """G1(w) / N.w, which stays finite (2 / alpha) as w grazes the surface."""
        cosine = np.abs(w[:, 2])  # below the horizon the result is not used
        sin2 = w[:, 0] ** 2 + w[:, 1] ** 2
        return 2.0 / (cosine + np.sqrt(cosine**2 + self.alpha * self.alpha * sin2))
