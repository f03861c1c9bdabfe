"""Published fits to the measured materials of the MERL database, as materials.

    Löw et al. 2012      f = kD / pi + F G S / (pi (N.L) (N.V)),        S = A / (1 + B (1 - N.H))^C
    Bagher et al. 2012   f = rhoD / pi + rhoS F G D / (pi (N.L) (N.V)), D = K exp(-x) / (pi x^p cos^4 theta_h)
                         x = alpha + tan^2(theta_h) / alpha

Löw: G is Cook and Torrance's, of V-grooves; F is Fresnel's for unpolarised light and a real index. Bagher:
G = G1(L) G1(V) with G1 = 1 + lambda (1 - exp(c (theta - theta0)^k)) beyond theta0, within [0, 1]; F = f0 -
f1 (V.H) + (1 - f0) (1 - V.H)^5, which a few fits take below zero: it is cut there.

Articles and programs differ about 1 / pi in the specular parts. With it both fits of a metal reflect about
the same, and Bagher's pink felt is within a tenth of the measured one.

A file is a JSON object of materials, each an object of parameters: numbers, or three for R, G, B.

References
----------
J. Löw, J. Kronander, A. Ynnerman, J. Unger. BRDF Models for Accurate and Efficient Rendering of Glossy
Surfaces. ACM TOG 31(1), 2012: the micro-facet form of the ABC model, with its fits.
M. Bagher, C. Soler, N. Holzschuch. Accurate Fitting of Measured Reflectances Using a Shifted Gamma
Micro-facet Distribution. Computer Graphics Forum 31(4), 2012.
R. Cook, K. Torrance. A Reflectance Model for Computer Graphics. ACM TOG 1(1), 1982: G, and F from an index.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from shrm.brdf import BRDF, Lafortune, from_function
from shrm.brdf.half_vector import half_vector
from shrm.brdf.lobe import FloatArray

Fit = Mapping[str, FloatArray]
"""The parameters of one material, (3,) float64 each; for Löw's B, C and ior ()."""

GRAZING = 1e-6
"""Cosines below this are taken for it: the fits divide by them."""


def abc(fit: Fit, name: str = "abc") -> BRDF:
    """Make a material of a fit of Löw et al. with the parameters kD, A, B, C and ior."""
    kD, A, B, C, ior = (fit[key] for key in ("kD", "A", "B", "C", "ior"))

    def f(wi: FloatArray, wo: FloatArray) -> FloatArray:
        h = half_vector(wi, wo)
        cos_h = np.sqrt(h.cos2)
        cos_i, cos_o = np.maximum(wi[:, 2], GRAZING), np.maximum(wo[:, 2], GRAZING)
        # sin^2 / (1 + cos): 1 - cos itself loses its digits where lobes are narrow
        S = (1 + B * h.sin2 / (1 + cos_h)) ** -C
        G = np.minimum(1.0, 2 * cos_h * np.minimum(cos_i, cos_o) / np.maximum(h.cos_d, GRAZING))
        specular = fresnel(ior, h.cos_d) * G * S / (cos_i * cos_o)
        return np.asarray((kD + A * specular[:, None]) / np.pi)

    return from_function(f, name=name)


def sgd(fit: Fit, name: str = "sgd") -> BRDF:
    """Make a material of a fit of Bagher et al.: rhoD, rhoS, alpha, p, f0, f1, kap, lambda, c, k, theta0."""
    channels = [{key: float(value[i]) for key, value in fit.items()} for i in range(3)]

    def f(wi: FloatArray, wo: FloatArray) -> FloatArray:
        h = half_vector(wi, wo)
        cos_i, cos_o = np.maximum(wi[:, 2], GRAZING), np.maximum(wo[:, 2], GRAZING)
        theta_i, theta_o = np.arccos(np.minimum(cos_i, 1.0)), np.arccos(np.minimum(cos_o, 1.0))
        cos2 = np.maximum(h.cos2, GRAZING**2)
        tan2 = h.sin2 / cos2
        common = 1 / (np.pi * np.pi * cos2 * cos2 * cos_i * cos_o)
        grazing = (1 - h.cos_d) ** 5

        def channel(fit: Mapping[str, float]) -> FloatArray:
            x = fit["alpha"] + tan2 / fit["alpha"]
            D = fit["kap"] * np.exp(-x) / x ** fit["p"]
            F = np.maximum(fit["f0"] - fit["f1"] * h.cos_d + (1 - fit["f0"]) * grazing, 0.0)
            G = _g1(fit, theta_i) * _g1(fit, theta_o)
            return np.asarray(fit["rhoD"] / np.pi + fit["rhoS"] * F * D * G * common)

        return np.stack([channel(fit) for fit in channels], axis=1)  # arrays (n, 3) take three times as long

    return from_function(f, name=name)


def _g1(fit: Mapping[str, float], theta: FloatArray) -> FloatArray:
    beyond = np.maximum(theta - fit["theta0"], 0.0)
    exponent = np.minimum(fit["c"] * beyond ** fit["k"], 700.0)  # within float64
    return np.clip(1 - fit["lambda"] * np.expm1(exponent), 0.0, 1.0)


def fresnel(ior: FloatArray | float, cos_d: FloatArray) -> FloatArray:
    """Reflectance for unpolarised light of a surface with a real index of refraction of at least 1."""
    g = np.sqrt(ior * ior - 1 + cos_d * cos_d)
    p = (cos_d * (g + cos_d) - 1) / (cos_d * (g - cos_d) + 1)
    s = (g - cos_d) / (g + cos_d)
    return np.asarray(0.5 * s * s * (1 + p * p))


SOURCES: Mapping[str, tuple[str, Callable[[Fit, str], BRDF] | None]] = {
    "merl_abc_low2012.json": ("MERL, fits of Löw et al. 2012", abc),
    "merl_sgd_bagher2012.json": ("MERL, fits of Bagher et al. 2012", sgd),
    "lafortune_pbrt1.json": ("fits of Lafortune lobes", None),
}
"""The files of a folder of fits: who made them, and what makes a material of each."""


def read(folder: Path) -> dict[str, dict[str, BRDF]]:
    """Read the fits of a folder, by source and name; files that are not there are left out.

    Raises
    ------
    FileNotFoundError
        If the folder has none of `SOURCES`.
    ValueError
        If a file holds something else; the text names it.
    """
    found = {
        source: _materials(folder / name, make)
        for name, (source, make) in SOURCES.items()
        if (folder / name).exists()
    }
    if not found:
        raise FileNotFoundError(f"{folder}: has none of {', '.join(SOURCES)}")
    return found


def _materials(path: Path, make: Callable[[Fit, str], BRDF] | None) -> dict[str, BRDF]:
    try:
        fits = json.loads(path.read_text(encoding="utf-8"))
        if make is None:
            return {name: Lafortune.read(path, name) for name in fits}
        return {
            name: make({key: np.asarray(value, dtype=np.float64) for key, value in fit.items()}, name)
            for name, fit in fits.items()
        }
    except KeyError as missing:
        raise ValueError(f"{path}: a material has no parameter {missing}") from None
    except (AttributeError, TypeError, ValueError) as fault:
        raise ValueError(f"{path}: not a file of fits ({fault})") from None
