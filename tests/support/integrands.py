"""Pictures and lobes for the integrators: their transfer functions are the oracles'."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from shrm.brdf import Material
from shrm.brdf.lobe import IsotropicLobe, RadialLobe, ZonalLobe
from shrm.environment import Environment

from support import oracles


def material(*lobes):
    return Material(lobes, "material")


@dataclass(frozen=True)
class Radial(RadialLobe):
    """A radial lobe whose transfer function is not made of its profile."""

    oracle: Callable

    def transfer(self, wi, wo):
        return self.oracle(wi, wo)


@dataclass(frozen=True)
class Zonal(ZonalLobe):
    """A zonal lobe whose transfer function is not made of its profile."""

    oracle: Callable

    def transfer(self, wi, wo):
        return self.oracle(wi, wo)


def radial(transfer, profile, center):
    return Radial(center, profile, transfer)


def phong(s):
    return radial(
        oracles.phong(s), lambda c: (s + 1) / (2 * np.pi) * np.maximum(c, 0) ** s, center="reflection"
    )


def lambert(color=1.0):
    c = np.asarray(color)
    return radial(
        oracles.lambert(color), lambda x: np.multiply.outer(np.maximum(x, 0) / np.pi, c), center="normal"
    )


def isotropic(transfer, center="lobe"):
    return IsotropicLobe(center, transfer)


def zonal(transfer):
    def profile(theta_i, theta_o):
        def direction(theta):
            return np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=-1)

        return transfer(direction(theta_i), direction(theta_o))

    return Zonal("tangent", profile, transfer)


def noise(H, W, seed=0):
    """A hard picture: most of it dark, bright texels everywhere."""
    return np.random.default_rng(seed).random((H, W, 3)).astype(np.float32) ** 8


def environment(pixels):
    return Environment(np.asarray(pixels, dtype=np.float32))
