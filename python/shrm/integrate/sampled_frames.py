"""Measuring the error of a lobe's stand-in: at frames drawn at random, against quadrature over the lobe.

The nodes are directions about the lobe's center, dense where it is narrow, and each sees the texel that it
lies in: nothing is shared with the integrators, which go through the texels and see tables of the lobe.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import IsotropicLobe, RadialLobe
from shrm.integrate.tables import cap_at, light_quadrature, view_at
from shrm.lobes.center import gamma_at, gamma_table
from shrm.lobes.directions import local_frames
from shrm.lobes.quadrature import leggauss

CoreLobe = IsotropicLobe | RadialLobe

VIEWS, FRAMES_OF_A_VIEW = 64, 16
"""Angles theta_v, and frames at each, that an error is measured at."""

WIDE_TEXELS, MOST_NODES = 4, 4
"""Width of a lobe, texels, above which it gets more nodes in proportion along each angle, and the largest
multiple of them; frames become as many times fewer."""

FAINT_PART = 5e-4
"""Fraction of a lobe's integral in its faintest nodes, which are left out: well below the errors measured."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames drawn at random, with the radiance of a lobe in each: quadrature over the lobe.

    Half of them see the light in proportion to solid angle, half to the square of its radiance, there or
    nearby.

    Attributes
    ----------
    normals, views : (n, 3) float64
        Unit vectors.
    exact : (n, 3) float64
        Radiance reflected in each frame.
    weight : (n,) float64
        Weights that make a mean over the frames drawn a mean over all frames.
    """

    normals: FloatArray
    views: FloatArray
    exact: FloatArray
    weight: FloatArray

    @classmethod
    def of(cls, pixels: Float32Array, lobe: CoreLobe) -> Frames:
        """Draw frames for a light (H, W, 3), and integrate a lobe in each."""
        # Wide lobes get more nodes and fewer frames.
        random = np.random.default_rng(2002)
        H, W, _ = pixels.shape
        extent = cap_at(lobe.transfer, float(np.sqrt(0.5)), 0.1)[1] / max(np.pi / H, 2 * np.pi / W)
        finer = int(np.clip(np.ceil(extent / WIDE_TEXELS), 1, MOST_NODES))
        n = VIEWS * (FRAMES_OF_A_VIEW // finer)

        # Frames about centers drawn by the light, each with one of the angles theta_v
        C, weight = drawn_directions(pixels, n, random)
        theta_v = np.arccos(np.sqrt((np.arange(VIEWS) + 0.5) / VIEWS))
        transfer = lobe.transfer
        gamma = gamma_table(lobe.center, transfer)
        x = np.einsum("nxk,nk->nx", local_frames(C, C), _around(2 * np.pi * random.random(n)))
        view = random.permutation(n) % VIEWS
        turn, tilt = gamma_at(gamma, theta_v)[view, None], theta_v[view, None]
        N = np.cos(turn) * C + np.sin(turn) * x
        V = np.cos(turn + tilt) * C + np.sin(turn + tilt) * x

        # The lobe at its nodes, for all frames of one angle
        exact = np.empty((n, 3))
        for k in range(VIEWS):
            frames = local_frames(N[view == k], V[view == k])
            wi, area = _nodes(lobe, float(theta_v[k]), finer)
            rho = transfer(wi, view_at(float(np.cos(theta_v[k])), len(wi))).reshape(len(wi), -1)
            rho = rho * area[:, None]

            # Its brightest nodes alone, and the texels that they see
            height = np.abs(rho).sum(axis=1)
            brightest = np.argsort(-height)
            total = np.cumsum(height[brightest])
            nodes = brightest[: np.searchsorted(total, (1 - FAINT_PART) * total[-1]) + 1]
            light = _texels_at(pixels, np.einsum("fxk,ik->fix", frames, wi[nodes]))
            exact[view == k] = np.einsum("fic,ic->fc", light, np.broadcast_to(rho[nodes], (len(nodes), 3)))
        return cls(N, V, exact, weight)

    def error(self, radiance: Float32Array) -> float:
        """Return the mean square error of radiance (n, 3), channels summed."""
        return float((self.weight * ((radiance - self.exact) ** 2).sum(axis=1)).mean())


def _nodes(lobe: CoreLobe, theta_v: float, finer: int) -> tuple[FloatArray, FloatArray]:
    """Return lights and their solid angles, dense about the center of a lobe, in the frame of the normal."""
    if isinstance(lobe, IsotropicLobe):
        wi, weight = light_quadrature(float(np.cos(theta_v)), 96 * finer, 32 * finer)
        mirrored = wi * [1.0, -1.0, 1.0]
        return np.concatenate([wi, mirrored]), np.concatenate([weight, weight]) / 2

    # A radial lobe: theta = pi t^2 from its center, azimuths even
    x, w = leggauss(96 * finer)
    azimuths = 64 * finer
    t = 0.5 * (1 + x)
    theta = np.pi * t**2
    phi = 2 * np.pi * (np.arange(azimuths) + 0.5) / azimuths
    sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None]
    about = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine + 0 * phi], axis=-1).reshape(-1, 3)

    # Turned to where the center is
    tilt = theta_v if lobe.center == "reflection" else 0.0
    c, s = np.cos(tilt), np.sin(tilt)
    turned = about @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])  # z to (-sin, 0, cos)
    weight = w * np.pi * t * np.sin(theta) * 2 * np.pi / azimuths
    return turned, np.repeat(weight, azimuths)


def drawn_directions(
    pixels: Float32Array, n: int, random: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Draw directions (n, 3), half of them by the light, and weights (n,) for means over the sphere."""
    # The energy of blocks of texels, of the square of their radiance
    H, W, _ = pixels.shape
    rows, columns = (
        np.unique(np.linspace(0, H, min(H, 32) + 1).astype(int)),
        np.unique(np.linspace(0, W, min(W, 64) + 1).astype(int)),
    )
    edges = np.cos(np.pi * np.arange(H + 1) / H)
    square = (pixels.astype(np.float64) ** 2).sum(axis=2) * (edges[:-1] - edges[1:])[:, None]
    energy = np.add.reduceat(np.add.reduceat(square, rows[:-1], axis=0), columns[:-1], axis=1)

    # The chance of a block: half by solid angle, a quarter each by its energy and its neighborhood's
    top, bottom = edges[rows[:-1]], edges[rows[1:]]
    area = np.outer(top - bottom, np.diff(columns)) / (2 * W)
    share = area
    if energy.sum() > 0:  # the neighborhood of bright blocks too, since lobes have tails
        near = sum(np.roll(energy, k, axis=1) for k in (-1, 0, 1))
        above_and_below = np.pad(near, ((1, 1), (0, 0)))
        near = above_and_below[2:] + near + above_and_below[:-2]
        share = 0.5 * energy / energy.sum() + 0.5 * near / near.sum()
    chance = 0.5 * area + 0.5 * share

    # Uniform directions within the blocks
    block = random.choice(chance.size, n, p=chance.ravel() / chance.sum())
    i, j = np.divmod(block, len(columns) - 1)
    z = bottom[i] + (top - bottom)[i] * random.random(n)
    column = columns[j] + np.diff(columns)[j] * random.random(n)
    phi = np.pi - 2 * np.pi * column / W
    s = np.sqrt(np.maximum(1 - z**2, 0))
    directions = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)
    return directions, (area / chance).ravel()[block]


def _around(angle: FloatArray) -> FloatArray:
    """Return unit vectors (n, 3) at angles (n,) about z."""
    return np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)


def _texels_at(pixels: Float32Array, directions: FloatArray) -> Float32Array:
    """Return the radiance (..., 3) of the texels that directions lie in."""
    H, W, _ = pixels.shape
    row = np.minimum((np.arccos(np.clip(directions[..., 2], -1, 1)) * (H / np.pi)).astype(int), H - 1)
    phi = np.arctan2(directions[..., 1], directions[..., 0])
    return np.asarray(pixels[row, ((np.pi - phi) * (W / (2 * np.pi))).astype(int) % W])
