"""Lambert's law: the same radiance in every direction.

    rho_hat = albedo / pi  max(N.L, 0)

The cosine is in it. Radially symmetric about the normal; needs no map at all in the nine-term form of [RH01].
"""

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.lobe import RadialLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method
from shrm.validation import RGB, number_or_rgb


@dataclass(frozen=True)
class Lambert(BRDF):
    """A diffuse reflector about the normal, rho_hat = albedo / pi max(N.L, 0).

    Parameters
    ----------
    albedo : float or three floats
        Reflected over received power, in [0, 1]; three numbers for R, G, B.
    """

    albedo: float | RGB

    def __post_init__(self) -> None:
        object.__setattr__(self, "albedo", number_or_rgb("Lambert: albedo", self.albedo, 0.0, 1.0))

    @property
    def lobes(self) -> tuple[RadialLobe]:
        """One radial lobe about the normal."""
        return (RadialLobe("normal", Method(Lambert._profile, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        return f"lambert(albedo={parameters.text(self.albedo)})"

    def _profile(self, cos_theta_i: FloatArray) -> FloatArray:
        cosine = np.maximum(cos_theta_i, 0.0)
        if isinstance(self.albedo, tuple):
            return cosine[:, None] * (np.array(self.albedo) / np.pi)
        return cosine * (self.albedo / np.pi)
