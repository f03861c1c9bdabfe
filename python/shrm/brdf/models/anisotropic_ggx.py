"""Anisotropic GGX (Trowbridge-Reitz) microfacets [H14], [WMLT07].

    rho_hat = D(H) G1(L) G1(V) F(L.H) / (4 N.V)    where N.L > 0            [WMLT07 eq. 20, times N.L]

    D(H)  = 1 / (pi alpha_x alpha_y (H_x^2 / alpha_x^2 + H_y^2 / alpha_y^2 + H_z^2)^2)          [H14 eq. 85]
    G1(v) = 2 / (1 + sqrt(1 + (alpha_x^2 v_x^2 + alpha_y^2 v_y^2) / v_z^2))     [H14 eqs. 72, 80], separable
    F     = f0 + (1 - f0) (1 - L.H)^5                                       Schlick

The cosine is in it; x is the tangent. Single scattering, as in `shrm.brdf.models.ggx`.
"""

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.half_vector import above_horizon, half_vector, schlick, tangential_squares
from shrm.brdf.lobe import AnisotropicLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method
from shrm.validation import RGB, number, number_or_rgb


@dataclass(frozen=True)
class AnisotropicGGX(BRDF):
    """GGX microfacets with one roughness along the tangent and another across it.

    Parameters
    ----------
    alpha_x, alpha_y : float
        Width parameters along the tangent and across it, 0 < alpha <= 1 (at least 1e-6).
    f0 : float or three floats
        Reflectance at normal incidence, in [0, 1]; three numbers for R, G, B.
    """

    alpha_x: float
    alpha_y: float
    f0: float | RGB = 1.0

    def __post_init__(self) -> None:
        for name in ("alpha_x", "alpha_y"):
            alpha = number(f"AnisotropicGGX: {name}", getattr(self, name), parameters.NARROWEST, 1.0)
            object.__setattr__(self, name, alpha)
        object.__setattr__(self, "f0", number_or_rgb("AnisotropicGGX: f0", self.f0, 0.0, 1.0))

    @property
    def lobes(self) -> tuple[AnisotropicLobe]:
        """One anisotropic lobe."""
        return (AnisotropicLobe(Method(AnisotropicGGX._transfer, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        alphas = f"alpha_x={parameters.text(self.alpha_x)},alpha_y={parameters.text(self.alpha_y)}"
        f0 = "" if self.f0 == 1.0 else f",f0={parameters.text(self.f0)}"
        return f"anisotropic-ggx({alphas}{f0})"

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        h = half_vector(wi, wo)
        x2, y2 = tangential_squares(wi, wo, h)
        stretched2 = x2 / self.alpha_x**2 + y2 / self.alpha_y**2 + h.cos2
        D = 1.0 / (np.pi * self.alpha_x * self.alpha_y * stretched2**2)
        cos_l = np.maximum(wi[:, 2], 0.0)
        scalar = D * cos_l * self._g1_over_cosine(wi) * self._g1_over_cosine(wo) / 4.0
        scalar = np.where(above_horizon(wi, wo), scalar, 0.0)
        F = schlick(self.f0, h.cos_d)
        return F * (scalar if F.ndim == 1 else scalar[:, None])

    def _g1_over_cosine(self, w: FloatArray) -> FloatArray:
        """G1(w) / N.w, which stays finite as w grazes the surface."""
        cosine = np.abs(w[:, 2])  # below the horizon the result is not used
        slope2 = (self.alpha_x * w[:, 0]) ** 2 + (self.alpha_y * w[:, 1]) ** 2
        return 2.0 / (cosine + np.sqrt(cosine**2 + slope2))
