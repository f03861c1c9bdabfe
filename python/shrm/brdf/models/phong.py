"""Phong's lobe about the reflection, normalised over the sphere [RH02 sec. 6.3].

    rho_hat = (s + 1) / (2 pi)  max(R.L, 0)^s

The cosine is in it, and it has no horizon term: light from below the surface counts, which is what
makes it radially symmetric about R. Its integral over all directions is 1 for every view.
"""

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.cosine_power import SharpProfile, cosine_power
from shrm.brdf.lobe import RadialLobe
from shrm.brdf.material import BRDF
from shrm.validation import number


@dataclass(frozen=True)
class Phong(BRDF):
    """A lobe cos^s about the reflection, of unit integral over the sphere.

    Parameters
    ----------
    exponent : float
        s, in [0, 1e12].
    """

    exponent: float

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "exponent", number("Phong: exponent", self.exponent, 0.0, parameters.SHARPEST)
        )

    @property
    def lobes(self) -> tuple[RadialLobe]:
        """One radial lobe about the reflection."""
        return (RadialLobe("reflection", SharpProfile(Phong._profile, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        return f"phong(exponent={parameters.text(self.exponent)})"

    def _profile(self, cos_theta_i: FloatArray, haversine: FloatArray | None = None) -> FloatArray:
        half = 0.5 * (1.0 - cos_theta_i) if haversine is None else haversine
        return cosine_power(cos_theta_i, half, self.exponent) * ((self.exponent + 1.0) / (2.0 * np.pi))
