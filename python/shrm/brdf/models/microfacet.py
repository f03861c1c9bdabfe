"""The simplified microfacet model of the paper [RH02 eq. 11].

    rho_hat = exp(-(theta_h / sigma)^2) / (4 pi sigma^2)    where N.L > 0,   theta_h = angle(N, H)

The cosine is in it: a Gaussian facet distribution without masking, Fresnel term or cosines. About
the lobe center; about the reflection for the paper's results. It is normalised for narrow lobes
seen from above, and does not keep energy at grazing views.
"""

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.half_vector import above_horizon, half_vector
from shrm.brdf.lobe import IsotropicLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method
from shrm.validation import number


@dataclass(frozen=True)
class Microfacet(BRDF):
    """A Gaussian of the angle between normal and half vector [RH02 eq. 11].

    Parameters
    ----------
    sigma : float
        Surface roughness in radians, > 0 (at least 1e-6).
    """

    sigma: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "sigma", number("Microfacet: sigma", self.sigma, parameters.NARROWEST))

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe center."""
        return (IsotropicLobe("lobe", Method(Microfacet._transfer, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        return f"microfacet(sigma={parameters.text(self.sigma)})"

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        h = half_vector(wi, wo)
        theta_h = np.arctan2(np.sqrt(h.sin2), np.sqrt(h.cos2))
        gaussian = np.exp(-((theta_h / self.sigma) ** 2)) / (4.0 * np.pi * self.sigma * self.sigma)
        return np.where(above_horizon(wi, wo), gaussian, 0.0)
