"""The spectrum of a light: its energy by degree [RH02 section 5.1]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shrm.arrays import FloatArray
from shrm.environment import Environment


@dataclass(frozen=True)
class LightPower:
    """The spectrum of a light: its energy by degree.

    Attributes
    ----------
    degrees : (K+1, channels) float64
        sum_m |L_lm|^2.
    above : (channels,) float64
        Energy of all higher degrees.
    """

    degrees: FloatArray
    above: FloatArray

    @classmethod
    def of(cls, env: Environment, K: int) -> LightPower:
        """Measure an environment to degree K, what lies above by Parseval's theorem [RH02 section 5.1]."""
        power = degree_power(env.coefficients(K))
        H, W, _ = env.pixels.shape
        rows = np.einsum("hwc,hwc->hc", env.pixels, env.pixels, dtype=np.float64)
        edges = np.cos(np.pi * np.arange(H + 1) / H)
        energy = 2 * np.pi / W * (edges[:-1] - edges[1:]) @ rows
        return cls(power, np.maximum(energy - power.sum(axis=0), 0.0))

    @classmethod
    def natural(cls, K: int, slope: float = 0.35) -> LightPower:
        """Return the spectrum of typical photographed light: 1 at l = 0 and slope / l above, to degree K."""
        l = np.arange(K + 1)
        return cls(np.where(l == 0, 1.0, slope / np.maximum(l, 1))[:, None], np.zeros(1))

    @property
    def per_coefficient(self) -> FloatArray:
        """Mean energy of the coefficients of each degree, (K+1, channels): sum_m |L_lm|^2 / (2l + 1)."""
        return np.asarray(self.degrees / (2 * np.arange(len(self.degrees))[:, None] + 1))


def degree_power(coefficients: FloatArray) -> FloatArray:
    """Sum |L_lm|^2 over m: ((F+1)^2, channels) coefficients to (F+1, channels)."""
    F = int(np.sqrt(len(coefficients))) - 1
    starts = np.arange(F + 1) ** 2
    return np.asarray(np.add.reduceat(np.asarray(coefficients, dtype=np.float64) ** 2, starts, axis=0))
