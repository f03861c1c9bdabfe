"""Ashikhmin and Shirley's anisotropic Phong model [AS00].

    rho_s = sqrt((n_u+1) (n_v+1)) / (8 pi)  (N.H)^e / ((H.L) max(N.L, N.V))  F(H.L)          [AS00 eq. 4]
    e     = (n_u (H.T)^2 + n_v (H.B)^2) / (1 - (N.H)^2)
    F     = R_s + (1 - R_s) (1 - H.L)^5                                          Schlick      [AS00 eq. 6]
    rho_d = 28 R_d / (23 pi) (1 - R_s) (1 - (1 - N.L/2)^5) (1 - (1 - N.V/2)^5)                [AS00 eq. 5]

rho_hat = (rho_s + rho_d) N.L where N.L > 0; T is the tangent, B = N x T. An anisotropic lobe, and an
isotropic one about the normal.
"""

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.half_vector import HalfVector, above_horizon, half_vector, schlick, tangential_squares
from shrm.brdf.lobe import AnisotropicLobe, IsotropicLobe, Lobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method
from shrm.validation import RGB, number, number_or_rgb


@dataclass(frozen=True)
class AshikhminShirley(BRDF):
    """A glossy lobe that is narrower across one direction of the surface than along it, and a diffuse one.

    Parameters
    ----------
    nu, nv : float
        Exponents along the tangent and across it, in [0, 1e12].
    Rs : float or three floats
        Reflectance of the glossy part at normal incidence, in [0, 1]; three numbers for R, G, B.
    Rd : float or three floats
        Reflectance of the diffuse part, in [0, 1]; what the glossy part reflects is kept from it.
    """

    nu: float
    nv: float
    Rs: float | RGB = 1.0
    Rd: float | RGB = 0.0

    def __post_init__(self) -> None:
        for name in ("nu", "nv"):
            exponent = number(f"AshikhminShirley: {name}", getattr(self, name), 0.0, parameters.SHARPEST)
            object.__setattr__(self, name, exponent)
        for name in ("Rs", "Rd"):
            reflectance = number_or_rgb(f"AshikhminShirley: {name}", getattr(self, name), 0.0, 1.0)
            object.__setattr__(self, name, reflectance)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The glossy lobe, and the diffuse one if there is any."""
        glossy = AnisotropicLobe(Method(AshikhminShirley._glossy, self))
        if self.Rd == 0.0:
            return (glossy,)
        return (glossy, IsotropicLobe("normal", Method(AshikhminShirley._diffuse, self)))

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        text = f"nu={parameters.text(self.nu)},nv={parameters.text(self.nv)}"
        text += "" if self.Rs == 1.0 else f",Rs={parameters.text(self.Rs)}"
        text += "" if self.Rd == 0.0 else f",Rd={parameters.text(self.Rd)}"
        return f"ashikhmin-shirley({text})"

    def _glossy(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        above = above_horizon(wi, wo)
        h = half_vector(wi, wo)
        norm = np.sqrt((self.nu + 1.0) * (self.nv + 1.0)) / (8.0 * np.pi)
        larger = np.maximum(np.maximum(wi[:, 2], wo[:, 2]), 1e-300)
        share = np.where(above, wi[:, 2], 0.0) / larger  # at most 1, however small both cosines are
        scalar = norm * self._power(wi, wo, h) * share / np.maximum(h.cos_d, 1e-30)  # [AS00] eq. 4, times N.L
        F = schlick(self.Rs, h.cos_d)  # [AS00] eq. 6
        return np.asarray(F * (scalar if F.ndim == 1 else scalar[:, None]))

    def _diffuse(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        rest_l, rest_v = ((1.0 - 0.5 * np.maximum(w[:, 2], 0.0)) ** 5 for w in (wi, wo))
        cos_l = np.where(above_horizon(wi, wo), wi[:, 2], 0.0)
        shape = 28.0 / (23.0 * np.pi) * (1.0 - rest_l) * (1.0 - rest_v) * cos_l  # [AS00] eq. 5
        scale = np.asarray(self.Rd) * (1.0 - np.asarray(self.Rs))
        return np.asarray(shape * scale if scale.ndim == 0 else shape[:, None] * scale)

    def _power(self, wi: FloatArray, wo: FloatArray, h: HalfVector) -> FloatArray:
        """(N.H)^e, without the digits that 1 - (N.H)^2 would lose for narrow lobes."""
        x2, y2 = tangential_squares(wi, wo, h)
        near = h.sin2 < 0.5
        log_cos2 = np.log1p(-np.where(near, h.sin2, 0.0))
        log_cos2 = np.where(near, log_cos2, np.log(np.maximum(h.cos2, 1e-300)))
        # log(cos^2) / sin^2 tends to -1 at H = N
        slope = np.divide(log_cos2, h.sin2, out=np.full_like(h.sin2, -1.0), where=h.sin2 > 0.0)
        return np.asarray(np.exp(0.5 * (self.nu * x2 + self.nv * y2) * slope))
