"""The micro-facet form of the ABC model, Löw et al. [LKYU12], whose fits to MERL are published.

    rho_hat = N.L kD / pi + F G S / (pi N.V)    where N.L > 0,    S = A / (1 + B (1 - N.H))^C

F is Fresnel's for unpolarised light and a real index of refraction, G Cook and Torrance's, of V-grooves. The
cosine is in it. Article and programs differ about 1 / pi in the specular part; with it the fits of a metal
reflect about as much as those of [BSH12] (see `sgd`).

About the lobe center.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.half_vector import above_horizon, half_vector
from shrm.brdf.lobe import IsotropicLobe
from shrm.brdf.material import BRDF
from shrm.brdf.models import json_file
from shrm.brdf.value import Method
from shrm.files import PathLike
from shrm.validation import RGB, number, number_or_rgb

GRAZING = 1e-6
"""Smallest cosine of L, V or the half angle that the model divides by; smaller ones are raised to it."""


@dataclass(frozen=True, repr=False)
class ABC(BRDF):
    """A diffuse part and microfacets of the ABC distribution.

    Parameters
    ----------
    kD : float or three floats
        Albedo of the diffuse part, at least 0.
    A : float or three floats
        Height of the distribution, at least 0.
    B, C : float
        Its width and its fall, in [0, 1e12] and [0, 100]; S falls to half where 1 - N.H = (2^(1/C) - 1) / B,
        at least 1e-6 radians from the normal.
    ior : float
        Index of refraction, at least 1.
    label : str
        What the name shows in place of the numbers.
    """

    kD: float | RGB
    A: float | RGB
    B: float
    C: float
    ior: float
    label: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        for key in ("kD", "A"):
            object.__setattr__(self, key, number_or_rgb(f"ABC: {key}", getattr(self, key), 0.0, 1e12))
        for key, least, most in (("B", 0.0, 1e12), ("C", 0.0, 100.0), ("ior", 1.0, 1e3)):
            object.__setattr__(self, key, number(f"ABC: {key}", getattr(self, key), least, most))
        if self.B > 0.0 and self.C > 0.0:
            half_width = math.sqrt(2.0 * math.expm1(math.log(2.0) / max(self.C, 1e-2)) / self.B)
            if half_width < parameters.NARROWEST:
                raise ValueError(
                    f"ABC: B and C must make a lobe that falls to half at {parameters.NARROWEST:g} radians "
                    f"or more, got {half_width:.2g}: take a smaller B"
                )

    @classmethod
    def read(cls, path: PathLike, name: str) -> ABC:
        """Read one material of a JSON file: an object of materials, each with kD, A, B, C, ior.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If it is no such file, or has no material of that name; the text names those it has.
        """
        keys = ("kD", "A", "B", "C", "ior")
        return json_file.material(
            path,
            name,
            "ABC parameters",
            lambda values: cls(*(values[key] for key in keys), label=f"abc:{path}#{name}"),
        )

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe center."""
        return (IsotropicLobe("lobe", Method(ABC._transfer, self)),)

    @property
    def name(self) -> str:
        """The label, or the text that `parse` reads."""
        return self.label or parameters.named(self, "abc")

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        # The specular part: F G S / N.V
        h = half_vector(wi, wo)
        cos_h = np.sqrt(h.cos2)
        cos_i, cos_o = np.maximum(wi[:, 2], GRAZING), np.maximum(wo[:, 2], GRAZING)
        S = (1 + self.B * h.sin2 / (1 + cos_h)) ** -self.C  # 1 - cos would lose its digits in narrow lobes
        G = np.minimum(1.0, 2 * cos_h * np.minimum(cos_i, cos_o) / np.maximum(h.cos_d, GRAZING))
        specular = fresnel(self.ior, h.cos_d) * G * S / cos_o

        # Both parts in all channels, black below the horizon
        kD, A = np.atleast_1d(self.kD), np.atleast_1d(self.A)
        total = (np.multiply.outer(cos_i, kD) + np.multiply.outer(specular, A)) / np.pi
        above = above_horizon(wi, wo)
        total = np.where(above[:, None], total, 0.0)
        return np.asarray(total if total.shape[1] == 3 else total[:, 0])


def fresnel(ior: float, cos_d: FloatArray) -> FloatArray:
    """Return the reflectance (n,) of a surface with a real index of refraction >= 1 for unpolarised light."""
    g = np.sqrt(ior * ior - 1 + cos_d * cos_d)
    p = (cos_d * (g + cos_d) - 1) / (cos_d * (g - cos_d) + 1)
    s = (g - cos_d) / (g + cos_d)
    return np.asarray(0.5 * s * s * (1 + p * p))
