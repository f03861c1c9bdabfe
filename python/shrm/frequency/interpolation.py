"""The error of cubic look-ups between the texels of a map, which tells how far apart they may be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shrm.arrays import FloatArray
from shrm.frequency.light_power import degree_power
from shrm.frequency.part import Part
from shrm.lobes.center import gamma_at
from shrm.lobes.reflection import Layout
from shrm.vectors import GOLDEN_RATIO, golden_azimuths


def map_spectrum(part: Part) -> FloatArray:
    """Return the energy of each degree of a part's maps, all maps and channels together: (J+1,)."""
    return np.asarray(degree_power(part.coefficients.reshape(len(part.coefficients), -1)).sum(axis=1))


def interpolation_error(spectra: Sequence[FloatArray], size: int, layout: Layout) -> float:
    """Return the relative RMS error of four-point Lagrange interpolation between the texels of a map.

    A degree j turns by j h radians from one texel to the next, at most; its error is that of interpolating
    e^{i j h x} in one dimension, the mean over x.

    Parameters
    ----------
    spectra : sequence of (J+1,) float64
        Energy of each degree of the maps of each part.
    size : int
        Rows of a lat-long map, or of a cube's face.
    layout : {"latlong", "cube"}
        The grid.
    """
    spacing = np.pi / size if layout == "latlong" else 2 / size  # the widest texels, at a face's center

    # Lagrange's weights of the texels at -1, 0, 1, 2 for places t between 0 and 1
    t = (np.arange(16) + 0.5) / 16
    weights = np.array(
        [
            -t * (t - 1) * (t - 2) / 6,
            (t + 1) * (t - 1) * (t - 2) / 2,
            -(t + 1) * t * (t - 2) / 2,
            (t + 1) * t * (t - 1) / 6,
        ]
    )

    # The mean square error of each degree
    J = max(len(spectrum) for spectrum in spectra)
    shifts = np.arange(-1, 3)[:, None] - t
    turn = np.exp(1j * np.arange(J)[:, None, None] * spacing * shifts)  # (degree, sample, t)
    squared = np.mean(np.abs((weights * turn).sum(axis=1) - 1) ** 2, axis=1)

    lost = sum(float((spectrum * squared[: len(spectrum)]).sum()) for spectrum in spectra)
    total = sum(float(spectrum.sum()) for spectrum in spectra)
    return float(np.sqrt(lost / total)) if total > 0 else 0.0


def measured_interpolation_error(parts: Sequence[Part], frames: int = 128) -> float:
    """Return the relative RMS error of cubic look-ups against the exact series, over frames of all kinds.

    The spectrum of the maps tells it precisely where the fit over theta_o is well conditioned; where it
    is not, maps hold large values for views that do not occur, and only the radiance itself tells.

    Parameters
    ----------
    parts : sequence of Part
        The sampled maps of all lobes.
    frames : int
        Number of central directions, each with one view.
    """
    C, across, share = _spiral_frames(frames)
    lost = total = 0.0
    for part in parts:
        # cos^2(theta_v) is uniform; about the tangent cos(theta_o) is
        theta_v = np.arccos(np.sqrt(share))
        about_tangent = part.center == "tangent"
        theta_o = np.arccos(2 * share - 1) if about_tangent else theta_v + gamma_at(part.gamma, theta_v)
        V = np.cos(theta_o)[:, None] * C + np.sin(theta_o)[:, None] * across
        exact, looked_up = part.series(C, V), part.looked_up(C, V)
        lost += float(((looked_up - exact) ** 2).sum())
        total += float((exact**2).sum())
    return float(np.sqrt(lost / total)) if total > 0 else 0.0


def _spiral_frames(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return central directions on the golden spiral, directions across, and numbers in [0, 1) for views.

    The numbers step by seven times the golden ratio, and so do not follow the azimuths, which step by one.
    """
    i = np.arange(count) + 0.5
    z, phi, spin = 1 - 2 * i / count, golden_azimuths(count, 0.5), 2 * np.pi * GOLDEN_RATIO**2 * i
    s = np.sqrt(1 - z**2)
    C = np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=1)
    x = np.stack([z * np.cos(phi), z * np.sin(phi), -s], axis=1)  # d C / d theta
    across = np.cos(spin)[:, None] * x + np.sin(spin)[:, None] * np.cross(C, x)
    return C, across, (GOLDEN_RATIO * 7 * i) % 1
