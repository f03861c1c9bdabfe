"""Pictures and lobes for the integrators, as plain as these take them."""

from types import SimpleNamespace

import numpy as np

from support import oracles


def material(*lobes):
    return SimpleNamespace(lobes=lobes)


def radial(transfer, profile, center):
    return SimpleNamespace(center=center, profile=profile, transfer=transfer)


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
    return SimpleNamespace(center=center, transfer=transfer)


def zonal(transfer):
    def profile(theta_i, theta_o):
        def direction(theta):
            return np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], axis=-1)

        return transfer(direction(theta_i), direction(theta_o))

    return SimpleNamespace(center="tangent", profile=profile, transfer=transfer)


def noise(H, W, seed=0):
    """A hard picture: most of it dark, bright texels everywhere."""
    return np.random.default_rng(seed).random((H, W, 3)).astype(np.float32) ** 8


def environment(pixels):
    return SimpleNamespace(pixels=np.asarray(pixels, dtype=np.float32))
