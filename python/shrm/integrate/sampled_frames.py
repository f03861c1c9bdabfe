"""The error of what stands for a lobe, measured: at frames drawn at random, against quadrature over the lobe.

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
"""A lobe that is wider than WIDE_TEXELS texels gets more nodes in proportion along each angle, MOST_NODES
times at most, and as many times fewer frames."""
FAINT_PART = 5e-4
"""Part of a lobe's integral that its faintest nodes hold, which are not looked at."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames drawn at random, with the radiance of a lobe in each: quadrature over the lobe.

    Half of them see the light in proportion to solid angle, half to the square of its radiance, there or
    nearby.

    Attributes
    ----------
    normals, views : (n, 3) float64
    exact : (n, 3) float64
    weight : (n,) float64
        By which a mean over them is that over all.
    """

    normals: FloatArray
    views: FloatArray
    exact: FloatArray
    weight: FloatArray

    @classmethod
    def of(cls, pixels: Float32Array, lobe: CoreLobe) -> Frames:
        """Draw them for a light (H, W, 3), and integrate a lobe in each."""
        random = np.random.default_rng(2002)
        H, W, _ = pixels.shape
        extent = cap_at(lobe.transfer, float(np.sqrt(0.5)), 0.1)[1] / max(np.pi / H, 2 * np.pi / W)
        finer = int(np.clip(np.ceil(extent / WIDE_TEXELS), 1, MOST_NODES))
        n = VIEWS * (FRAMES_OF_A_VIEW // finer)
        C, weight = drawn_directions(pixels, n, random)
        theta_v = np.arccos(np.sqrt((np.arange(VIEWS) + 0.5) / VIEWS))
        transfer = lobe.transfer
        gamma = gamma_table(lobe.center, transfer)
        x = np.einsum("nxk,nk->nx", local_frames(C, C), _around(2 * np.pi * random.random(n)))
        at = random.permutation(n) % VIEWS
        turn, tilt = gamma_at(gamma, theta_v)[at, None], theta_v[at, None]
        N = np.cos(turn) * C + np.sin(turn) * x
        V = np.cos(turn + tilt) * C + np.sin(turn + tilt) * x
        exact = np.empty((n, 3))
        for k in range(VIEWS):
            frames = local_frames(N[at == k], V[at == k])
            wi, area = _nodes(lobe, float(theta_v[k]), finer)
            rho = transfer(wi, view_at(float(np.cos(theta_v[k])), len(wi))).reshape(len(wi), -1)
            rho = rho * area[:, None]
            height = np.abs(rho).sum(axis=1)
            brightest = np.argsort(-height)
            held = np.cumsum(height[brightest])
            there = brightest[: np.searchsorted(held, (1 - FAINT_PART) * held[-1]) + 1]
            light = _texels_at(pixels, np.einsum("fxk,ik->fix", frames, wi[there]))
            exact[at == k] = np.einsum("fic,ic->fc", light, np.broadcast_to(rho[there], (len(there), 3)))
        return cls(N, V, exact, weight)

    def error(self, radiance: Float32Array) -> float:
        """Mean square error of radiance (n, 3), channels summed."""
        return float((self.weight * ((radiance - self.exact) ** 2).sum(axis=1)).mean())


def _nodes(lobe: CoreLobe, theta_v: float, finer: int) -> tuple[FloatArray, FloatArray]:
    """Lights and their solid angles, dense about the center of a lobe, in the frame of the normal."""
    if isinstance(lobe, IsotropicLobe):
        wi, weight = light_quadrature(float(np.cos(theta_v)), 96 * finer, 32 * finer)
        mirrored = wi * [1.0, -1.0, 1.0]
        return np.concatenate([wi, mirrored]), np.concatenate([weight, weight]) / 2
    x, w = leggauss(96 * finer)
    azimuths = 64 * finer
    t = 0.5 * (1 + x)
    theta = np.pi * t**2
    phi = 2 * np.pi * (np.arange(azimuths) + 0.5) / azimuths
    sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None]
    about = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine + 0 * phi], axis=-1).reshape(-1, 3)
    tilt = theta_v if lobe.center == "reflection" else 0.0
    c, s = np.cos(tilt), np.sin(tilt)
    turned = about @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])  # z to (-sin, 0, cos)
    weight = w * np.pi * t * np.sin(theta) * 2 * np.pi / azimuths
    return turned, np.repeat(weight, azimuths)


def drawn_directions(
    pixels: Float32Array, n: int, random: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Draw directions (n, 3), half of them by the light, and weights (n,) for means over the sphere."""
    H, W, _ = pixels.shape
    rows, columns = (
        np.unique(np.linspace(0, H, min(H, 32) + 1).astype(int)),
        np.unique(np.linspace(0, W, min(W, 64) + 1).astype(int)),
    )
    edges = np.cos(np.pi * np.arange(H + 1) / H)
    square = (pixels.astype(np.float64) ** 2).sum(axis=2) * (edges[:-1] - edges[1:])[:, None]
    energy = np.add.reduceat(np.add.reduceat(square, rows[:-1], axis=0), columns[:-1], axis=1)
    top, bottom = edges[rows[:-1]], edges[rows[1:]]
    area = np.outer(top - bottom, np.diff(columns)) / (2 * W)
    share = area
    if energy.sum() > 0:  # and, as lobes have tails, in the neighbourhood of bright blocks
        near = sum(np.roll(energy, k, axis=1) for k in (-1, 0, 1))
        above_and_below = np.pad(near, ((1, 1), (0, 0)))
        near = above_and_below[2:] + near + above_and_below[:-2]
        share = 0.5 * energy / energy.sum() + 0.5 * near / near.sum()
    chance = 0.5 * area + 0.5 * share
    drawn = random.choice(chance.size, n, p=chance.ravel() / chance.sum())
    i, j = np.divmod(drawn, len(columns) - 1)
    z = bottom[i] + (top - bottom)[i] * random.random(n)
    column = columns[j] + np.diff(columns)[j] * random.random(n)
    phi = np.pi - 2 * np.pi * column / W
    s = np.sqrt(np.maximum(1 - z**2, 0))
    directions = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)
    return directions, (area / chance).ravel()[drawn]


def _around(angle: FloatArray) -> FloatArray:
    return np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)


def _texels_at(pixels: Float32Array, directions: FloatArray) -> Float32Array:
    """Radiance (..., 3) of the texels that directions lie in."""
    H, W, _ = pixels.shape
    row = np.minimum((np.arccos(np.clip(directions[..., 2], -1, 1)) * (H / np.pi)).astype(int), H - 1)
    phi = np.arctan2(directions[..., 1], directions[..., 0])
    return np.asarray(pixels[row, ((np.pi - phi) * (W / (2 * np.pi))).astype(int) % W])
