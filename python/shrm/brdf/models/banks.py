"""Banks' model of brushed surfaces, with the sharpness of [KVHS00 sec. 5.3].

    rho_hat = max(0, sqrt(1 - (L.T)^2) sqrt(1 - (V.T)^2) - (L.T)(V.T) - s) / (1 - s)^2

which is max(0, -cos(theta_i + theta_o) - s) / (1 - s)^2 with the angles from the tangent T.
Negative values are cut, as in [B94].

Centered on the tangent. Neither a cosine nor a horizon: self-shadowing is left out in the source too,
so that the model has no normal.
"""

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.lobe import ZonalLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method
from shrm.validation import number


@dataclass(frozen=True)
class Banks(BRDF):
    """A highlight on the mirror cone about the tangent, with a linear fall-off.

    Parameters
    ----------
    sharpness : float
        s, 0 <= s < 1 (at most 1 - 1e-6).
    """

    sharpness: float

    def __post_init__(self) -> None:
        highest = 1.0 - parameters.NARROWEST
        object.__setattr__(self, "sharpness", number("Banks: sharpness", self.sharpness, 0.0, highest))

    @property
    def lobes(self) -> tuple[ZonalLobe]:
        """One zonal lobe about the tangent."""
        return (ZonalLobe("tangent", Method(Banks._profile, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        return f"banks(sharpness={parameters.text(self.sharpness)})"

    def _profile(self, theta_i: FloatArray, theta_o: FloatArray) -> FloatArray:
        return np.maximum(-np.cos(theta_i + theta_o) - self.sharpness, 0.0) / (1.0 - self.sharpness) ** 2
