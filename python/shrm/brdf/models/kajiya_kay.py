"""Kajiya and Kay's model of hair, an anisotropic cousin of Phong's [RH02 sec. 3.1].

With theta_i, theta_o the angles of L and V from the tangent T:

    cone="paper"     rho_hat = max(0, cos(theta_i - theta_o))^s
    cone="mirror"    rho_hat = max(0, cos(theta_i + theta_o - pi))^s

[RH02] prints the first. A fibre reflects light into the cone about T that the mirror direction lies
on; with L and V both pointing away from the surface that cone is theta_i = pi - theta_o, the second.

Centered on the tangent. Neither a cosine nor a horizon: the model has no normal.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.cosine_power import cosine_power
from shrm.brdf.lobe import ZonalLobe
from shrm.brdf.material import BRDF
from shrm.brdf.value import Method
from shrm.validation import number, one_of


@dataclass(frozen=True)
class KajiyaKay(BRDF):
    """A highlight on a cone about the tangent.

    Parameters
    ----------
    exponent : float
        s, in [0, 1e12].
    cone : {"paper", "mirror"}
        Which cone: theta_i = theta_o as printed in [RH02], or theta_i = pi - theta_o.
    """

    exponent: float
    cone: Literal["paper", "mirror"] = "paper"

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "exponent", number("KajiyaKay: exponent", self.exponent, 0.0, parameters.SHARPEST)
        )
        one_of("KajiyaKay: cone", self.cone, ("paper", "mirror"))

    @property
    def lobes(self) -> tuple[ZonalLobe]:
        """One zonal lobe about the tangent."""
        return (ZonalLobe("tangent", Method(KajiyaKay._profile, self)),)

    @property
    def name(self) -> str:
        """The text that `parse` reads."""
        cone = "" if self.cone == "paper" else f",cone={self.cone}"
        return f"kajiya-kay(exponent={parameters.text(self.exponent)}{cone})"

    def _profile(self, theta_i: FloatArray, theta_o: FloatArray) -> FloatArray:
        axis = theta_o if self.cone == "paper" else np.pi - theta_o
        angle = theta_i - axis
        return cosine_power(np.cos(angle), np.sin(0.5 * angle) ** 2, self.exponent)
