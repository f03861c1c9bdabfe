"""A model of velvet: upright fibres that shine where the half vector is far from the normal [AP07].

    f = D(theta_h) F(L.H) / (4 (N.L + N.V - N.L N.V)) + diffuse / pi
    D = (1 + 4 exp(-cot^2(theta_h) / width^2) / sin^4(theta_h)) / (pi (1 + 4 width^2))

D integrates to 1 over the projected hemisphere. It is largest near theta_h = 90 degrees, where light and view
both graze: light comes back brightly from everywhere around the horizon, also towards its source.
"""

from __future__ import annotations

import numpy as np
from shrm.arrays import FloatArray
from shrm.brdf import BRDF, from_function
from shrm.brdf.half_vector import half_vector, schlick
from shrm.validation import RGB

LEAST_SIN2 = 1e-3
"""Smallest sin^2(theta_h) used: below it exp(-cot^2 / width^2) vanishes for any width up to 5."""


def velvet(width: float, f0: RGB, diffuse: RGB) -> BRDF:
    """Return a material of the model.

    Parameters
    ----------
    width : float
        Width of the fibres' spread about upright, above 0, up to 5.
    f0 : three floats
        Reflectance of the fibres at normal incidence.
    diffuse : three floats
        Albedo of the ground between the fibres.
    """

    def f(wi: FloatArray, wo: FloatArray) -> FloatArray:
        h = half_vector(wi, wo)
        sin2 = np.maximum(h.sin2, LEAST_SIN2)
        D = (1 + 4 * np.exp(-h.cos2 / (sin2 * width**2)) / sin2**2) / (np.pi * (1 + 4 * width**2))
        cos_i, cos_o = wi[:, 2], wo[:, 2]
        sheen = D / (4 * (cos_i + cos_o - cos_i * cos_o))
        return np.asarray(schlick(f0, h.cos_d) * sheen[:, None] + np.array(diffuse) / np.pi)

    return from_function(f, name="velvet")
