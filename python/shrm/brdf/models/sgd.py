"""The shifted gamma distribution of microfacets of [BSH12], whose fits to MERL are published.

    rho_hat = N.L rhoD / pi + rhoS F G D / (pi N.V)    where N.L > 0

    D = K exp(-x) / (pi x^p cos^4 theta_h),    x = alpha + tan^2(theta_h) / alpha
    G = G1(L) G1(V),    G1 = 1 + lam (1 - exp(c (theta - theta0)^k)) beyond theta0, within [0, 1]
    F = f0 - f1 (V.H) + (1 - f0) (1 - V.H)^5

A few fits take F below zero: it is cut there. The cosine is in rho_hat. Article and programs differ about
1 / pi in the specular part; with it the fit of pink felt is within a tenth of what was measured.

About the lobe center.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.half_vector import above_horizon, half_vector
from shrm.brdf.lobe import IsotropicLobe
from shrm.brdf.material import BRDF
from shrm.brdf.models import json_file
from shrm.brdf.value import Method
from shrm.files import PathLike
from shrm.validation import RGB, number_or_rgb

GRAZING = 1e-6
"""Smallest cosine of L, V or the half angle that the model divides by; smaller ones are raised to it."""


@dataclass(frozen=True, repr=False)
class SGD(BRDF):
    """A diffuse part and microfacets of the shifted gamma distribution.

    Parameters
    ----------
    rhoD, rhoS : float or three floats
        Weights of the diffuse and the specular part, at least 0.
    alpha, p, K : float or three floats
        Width (above 0), shape and normalisation of the distribution, at least 0.
    f0, f1 : float or three floats
        Coefficients of the Fresnel term.
    lam, c, k, theta0 : float or three floats
        Coefficients of the masking term: lambda, c and k at least 0, theta0 in radians.
    label : str
        What the name shows in place of the numbers.
    """

    rhoD: float | RGB
    rhoS: float | RGB
    alpha: float | RGB
    p: float | RGB
    f0: float | RGB
    f1: float | RGB
    K: float | RGB
    lam: float | RGB
    c: float | RGB
    k: float | RGB
    theta0: float | RGB
    label: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        for key in PARAMETERS:
            least, most = _LEAST.get(key, 0.0), parameters.LARGEST if key in ("rhoD", "rhoS") else 1e40
            object.__setattr__(self, key, number_or_rgb(f"SGD: {key}", getattr(self, key), least, most))
        half_width = min(_half_width(fit["alpha"], fit["p"]) for fit in self._channels())
        if half_width < parameters.NARROWEST:
            raise ValueError(
                f"SGD: alpha and p must make a lobe that falls to half at {parameters.NARROWEST:g} radians "
                f"or more, got {half_width:.2g}: take a larger alpha or a smaller p"
            )

    @classmethod
    def read(cls, path: PathLike, name: str) -> SGD:
        """Read one material of a JSON file: an object of materials, each with the parameters.

        K is also read as `kap`, lam as `lambda`.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If it is no such file, or has no material of that name; the text names those it has.
        """

        def value(values: Mapping[str, float | RGB], key: str) -> float | RGB:
            other = {"K": "kap", "lam": "lambda"}.get(key, key)
            return values[key if key in values else other]

        return json_file.material(
            path,
            name,
            "SGD parameters",
            lambda values: cls(*(value(values, key) for key in PARAMETERS), label=f"sgd:{path}#{name}"),
        )

    @property
    def lobes(self) -> tuple[IsotropicLobe]:
        """One isotropic lobe about the lobe center."""
        return (IsotropicLobe("lobe", Method(SGD._transfer, self)),)

    @property
    def name(self) -> str:
        """The label, or the text that `parse` reads."""
        return self.label or parameters.named(self, "sgd")

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        # The angles, which all channels share
        h = half_vector(wi, wo)
        cos_i, cos_o = np.maximum(wi[:, 2], GRAZING), np.maximum(wo[:, 2], GRAZING)
        theta_i, theta_o = np.arccos(np.minimum(cos_i, 1.0)), np.arccos(np.minimum(cos_o, 1.0))
        cos2 = np.maximum(h.cos2, GRAZING**2)
        tan2 = h.sin2 / cos2
        common = 1 / (np.pi * np.pi * cos2 * cos2 * cos_o)
        grazing = (1 - h.cos_d) ** 5

        def channel(fit: Mapping[str, float]) -> FloatArray:
            x = fit["alpha"] + tan2 / fit["alpha"]
            D = fit["K"] * np.exp(-x) / x ** fit["p"]
            F = np.maximum(fit["f0"] - fit["f1"] * h.cos_d + (1 - fit["f0"]) * grazing, 0.0)
            G = _g1(fit, theta_i) * _g1(fit, theta_o)
            return np.asarray(cos_i * (fit["rhoD"] / np.pi) + fit["rhoS"] * F * D * G * common)

        # Channel by channel: arrays (n, 3) take three times as long.
        parts = [np.where(above_horizon(wi, wo), channel(fit), 0.0) for fit in self._channels()]
        return parts[0] if len(parts) == 1 else np.stack(parts, axis=1)

    def _channels(self) -> list[Mapping[str, float]]:
        """Return the parameters of each channel; of one channel if no parameter has three values."""
        values = {key: getattr(self, key) for key in PARAMETERS}
        count = 3 if any(isinstance(value, tuple) for value in values.values()) else 1
        return [
            {key: value[i] if isinstance(value, tuple) else value for key, value in values.items()}
            for i in range(count)
        ]


PARAMETERS = tuple(each.name for each in fields(SGD) if not each.kw_only)
_BISECTIONS = 100
_LEAST = {"alpha": parameters.NARROWEST, "f0": -1e40, "f1": -1e40, "theta0": -np.pi}


def _half_width(alpha: float, p: float) -> float:
    """Return tan(theta_h) at which exp(-x) / x^p falls to half, x = alpha (1 + u), u = (tan / alpha)^2."""

    def fall(u: float) -> float:
        return alpha * u + p * math.log1p(u)

    # The logarithm of the fall grows with u: alpha u alone reaches log 2 at the upper end.
    low, high = 0.0, math.log(2.0) / alpha
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fall(middle) < math.log(2.0) else (low, middle)
    return alpha * math.sqrt(high)


def _g1(fit: Mapping[str, float], theta: FloatArray) -> FloatArray:
    """Return the masking G1 (n,) of directions at angles (n,) from the normal, radians."""
    beyond = np.maximum(theta - fit["theta0"], 0.0)
    exponent = np.minimum(fit["c"] * beyond ** fit["k"], 700.0)  # within float64
    return np.clip(1 - fit["lam"] * np.expm1(exponent), 0.0, 1.0)
