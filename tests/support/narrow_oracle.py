"""Directional albedos of lobes however narrow, in float64; shares no code with shrm.

Lobes of half vectors are integrated over the slopes (x, y) of H = (x, y, 1) / length, in which light is above
the horizon within a circle: with V = (sin, 0, cos), N.L > 0 where x^2 + y^2 - 2 x tan < 1. Polar coordinates
about H = N have closed limits there, and panels that grow from the lobe's own width.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import special

Array = np.ndarray

NODES = 24


class Facets(NamedTuple):
    """Where a lobe is evaluated: of half vectors tan^2(theta_h), N.H and V.H, and the light's N.L."""

    tan2: Array
    n_h: Array
    v_h: Array
    n_l: Array


def albedo(rho: Callable[[Facets, float], Array], width: float, cos_v: float) -> float:
    """Integrate rho_hat, a function of facets and N.V, over all light; below the slope `width` it is flat."""
    tan = np.sqrt((1 - cos_v) * (1 + cos_v)) / cos_v
    last = tan + 1 / cos_v
    first = 1 / last  # circles about H = N of this radius touch the horizon
    inner = width * 2.0 ** np.arange(-3, 60)
    outer = first * 2.0 ** np.arange(1, 60)
    edges = np.concatenate([[0], inner[inner < first], [first], outer[outer < last], [last]])
    x, w = np.polynomial.legendre.leggauss(NODES)
    share, weight = np.sin(np.pi / 4 * (x + 1)) ** 2, w * np.pi / 4 * np.sin(np.pi / 2 * (x + 1))
    r = (edges[:-1, None] + np.diff(edges)[:, None] * share).ravel()[:, None]
    dr = (np.diff(edges)[:, None] * weight).ravel()[:, None]
    with np.errstate(divide="ignore"):
        arc = np.arccos(np.clip((r - 1 / r) / (2 * max(tan, 1e-100)), -1, 1))
    # at grazing views light comes from the far half of the circles only
    a = r * np.cos(arc * share)
    v_h_by_n_h = cos_v * (1 + a * tan)
    n_h = 1 / np.sqrt(1 + r * r)
    v_h = v_h_by_n_h * n_h
    n_l = 2 * v_h * n_h - cos_v
    there = (v_h > 0) & (n_l > 0)
    facets = Facets(r * r, n_h, np.where(there, v_h, 1.0), np.where(there, np.minimum(n_l, 1), 1.0))
    values = np.where(there, 4 * v_h * n_h**3 * rho(facets, cos_v), 0.0)
    return float(np.sum(values * r * dr * 2 * arc * weight))


def ggx(alpha: float, f0: float = 1.0) -> Callable[[Facets, float], Array]:
    """[WMLT07] eqs. 20, 33, 34."""

    def masking(cosine: Array) -> Array:
        return 2 / (1 + np.sqrt(1 + alpha**2 * (1 - cosine**2) / cosine**2))

    def rho(at: Facets, cos_v: float) -> Array:
        D = 1 / (np.pi * alpha**2 * at.n_h**4 * (1 + at.tan2 / alpha**2) ** 2)
        F = f0 + (1 - f0) * (1 - at.v_h) ** 5
        return D * F * masking(at.n_l) * masking(np.array(cos_v)) / (4 * cos_v)

    return rho


def beckmann(alpha: float) -> Callable[[Facets, float], Array]:
    """[WMLT07] eqs. 20, 25, 26."""

    def masking(cosine: Array) -> Array:
        a = np.minimum(cosine / (alpha * np.sqrt(np.maximum(1 - cosine**2, 1e-30))), 20.0)
        return 2 / (1 + special.erf(a) + np.exp(-a * a) / (a * np.sqrt(np.pi)))

    def rho(at: Facets, cos_v: float) -> Array:
        D = np.exp(-np.minimum(at.tan2 / alpha**2, 700)) / (np.pi * alpha**2 * at.n_h**4)
        return D * masking(at.n_l) * masking(np.array(cos_v)) / (4 * cos_v)

    return rho


def microfacet(sigma: float) -> Callable[[Facets, float], Array]:
    """[RH02] eq. 11."""

    def rho(at: Facets, cos_v: float) -> Array:
        theta_h = np.arctan(np.sqrt(at.tan2))
        return np.exp(-np.minimum((theta_h / sigma) ** 2, 700)) / (4 * np.pi * sigma**2)

    return rho


def abc(B: float, C: float) -> Callable[[Facets, float], Array]:
    """[LKYU12] with kD = 0, A = B and an index of 1.5."""

    def rho(at: Facets, cos_v: float) -> Array:
        S = B / (1 + B * at.tan2 * at.n_h**2 / (1 + at.n_h)) ** C
        G = np.minimum(1, 2 * at.n_h * np.minimum(at.n_l, cos_v) / at.v_h)
        g = np.sqrt(1.25 + at.v_h**2)
        s = (g - at.v_h) / (g + at.v_h)
        p = (at.v_h * (g + at.v_h) - 1) / (at.v_h * (g - at.v_h) + 1)
        return 0.5 * s**2 * (1 + p**2) * G * S / (np.pi * cos_v)

    return rho


def sgd(alpha: float, p: float) -> Callable[[Facets, float], Array]:
    """[BSH12] without a diffuse part, masking and Fresnel's term."""

    def rho(at: Facets, cos_v: float) -> Array:
        x = alpha + at.tan2 / alpha
        return np.exp(-np.minimum(x, 700)) / x**p / (np.pi**2 * at.n_h**4 * cos_v)

    return rho


def kajiya_kay(exponent: float, sin_o: float) -> float:
    """2 pi int cos^s(d) sin(theta_o + d) dd, for lobes that do not reach the tangent."""
    # B(1/2, (s + 2) / 2), by its expansion where s is large
    half = (exponent + 2) / 2
    beta = special.beta(0.5, half) if half < 1e6 else np.sqrt(np.pi / half) * (1 + 1 / (8 * half))
    return float(2 * np.pi * sin_o * beta)


def banks(sharpness: float, sin_o: float) -> float:
    """2 pi int max(cos(d) - s, 0) sin(theta_o + d) dd / (1 - s)^2, likewise."""
    end = np.arccos(sharpness)
    integral = end + 0.5 * np.sin(2 * end) - 2 * sharpness * np.sin(end)
    return float(2 * np.pi * sin_o * integral / (1 - sharpness) ** 2)
