"""[RH02] figure 5: light of every sharpness on materials of every sharpness.

Light and material are made less sharp by the same family of lobes, so that F means the same on both axes:
the material is a Phong lobe, and the light is blurred with one. Each lobe's F is the order that holds 1 - eps
of its energy, F = sqrt(-s ln eps) [RH02 section 6.3, appendix D].
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from shrm import sh
from shrm.arrays import FloatArray
from shrm.brdf import Phong
from shrm.environment import Environment
from shrm.frequency.analysis import analyse
from shrm.frequency.light_power import degree_power
from shrm.frequency.prefilter import prefilter
from shrm.render import Picture

from shrm_papers.result import Result, Settings
from shrm_papers.spheres import View, brightest, caption, common_exposure, show, sphere, view_turned

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "rh02-figure-5"
FREQUENCIES = (64, 32, 16, 8, 4)
"""The F of light and materials, from sharp to blurred."""

SHARE = 0.99
"""Fraction of a lobe's energy within its F."""

AZIMUTH, ELEVATION = 60.0, 10.0
"""The viewer's direction: degrees from the brightest light, and above the horizon."""

YELLOW = "#ffd400"
"""The paper's delimiters."""


def make(settings: Settings) -> Result:
    """Draw the spheres, and find the degree where the energy of their light ends."""
    frequencies = FREQUENCIES[2:] if settings.quick else FREQUENCIES
    L = 2 * frequencies[0]
    light = settings.env.coefficients(L)
    gains = {F: gain(F, L) for F in frequencies}
    power = degree_power(light).sum(axis=1) / (2 * np.arange(L + 1) + 1)

    # The reflected light of a cell is the light times both gains, degree by degree.
    cells = list(itertools.product(frequencies, frequencies))
    amplitude = {cell: np.sqrt(power) * gains[cell[0]] * gains[cell[1]] for cell in cells}
    highest = {cell: highest_frequency(amplitude[cell]) for cell in cells}
    below = sum(highest[cell] <= min(cell) for cell in cells)
    rows = [[F_L, F_rho, min(F_L, F_rho), highest[F_L, F_rho]] for F_L, F_rho in cells]
    within, across = _differences(amplitude)
    return Result(
        NAME,
        f"Blurred light on blurred materials, {settings.env_name}",
        ["F of the light", "F of the BRDF", "smaller of both", f"F with {SHARE:.0%} of the reflected energy"],
        rows,
        [
            "The light is blurred with Phong lobes, the materials of the other direction of the grid; "
            f"a lobe's F holds {SHARE:.0%} of its energy.",
            f"The smaller F is not exceeded in {below} of {len(cells)} cells. It is not reached because "
            "natural light has less energy in higher degrees, and two blurs of equal F are as one of "
            "F / sqrt(2).",
            f"Relative RMS difference of the reflected light (median): {within:.2f} between two cells of one "
            f"delimiter, {across:.2f} between neighbors on its two sides.",
        ],
        _draw(_spheres(light, gains, _view(settings.env), 64 if settings.quick else 192), highest),
    )


def gain(F: int, L: int) -> FloatArray:
    """Return the factor of a Phong lobe of order F on each degree to L, (L+1,): 1 at degree 0."""
    exponent = F * F / -np.log(1 - SHARE)
    l = np.arange(L + 1)
    rho = analyse(Phong(exponent).lobes[0], L, 0).coefficients(L, 0)[:, 0, 0, 0] / np.sqrt(2 * l + 1)
    return np.asarray(rho / rho[0])


def highest_frequency(amplitude: FloatArray) -> int:
    """Return the smallest F that holds `SHARE` of the energy of these degrees."""
    energy = np.cumsum(amplitude**2)
    return int(np.searchsorted(energy, SHARE * energy[-1]))


def _differences(amplitude: dict[tuple[int, int], FloatArray]) -> tuple[float, float]:
    """Return median relative RMS differences: of cells of one delimiter, and of neighbors of two."""
    within, across = [], []
    for (a, of_a), (b, of_b) in itertools.combinations(amplitude.items(), 2):
        norms = np.linalg.norm(of_a), np.linalg.norm(of_b)
        relative = float(np.linalg.norm(of_a - of_b) / max(norms))
        if min(a) == min(b):
            within.append(relative)
        elif abs(np.log2(a[0] / b[0])) + abs(np.log2(a[1] / b[1])) == 1:
            across.append(relative)
    return float(np.median(within)), float(np.median(across))


def _view(env: Environment) -> View:
    return view_turned(brightest(env), AZIMUTH, ELEVATION)


def _spheres(
    light: FloatArray, gains: dict[int, FloatArray], view: View, pixels: int
) -> dict[tuple[int, int], Picture]:
    """Draw a sphere for every F of the light and F of the material."""
    L = len(next(iter(gains.values()))) - 1
    degrees = np.repeat(np.arange(L + 1), 2 * np.arange(L + 1) + 1)
    pictures = {}
    for F_L, blur in gains.items():
        blurred = Environment(sh.synthesis(light * blur[degrees, None], (2 * L + 2, 4 * L + 4)))
        for F_rho in gains:
            material = Phong(F_rho * F_rho / -np.log(1 - SHARE))
            rm = prefilter(blurred, material, orders=(L, 0), size=2 * L)
            pictures[F_L, F_rho] = sphere(rm, view, pixels)
    return pictures


def _draw(pictures: dict[tuple[int, int], Picture], highest: dict[tuple[int, int], int]) -> Figure:
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    frequencies = list(dict.fromkeys(F for F, _ in pictures))
    n = len(frequencies)
    side = 1.4 * n + 0.6  # inches
    figure = Figure(figsize=(side, side))
    # In parts of the side: 0.68 inches for labels at the left, 0.6 above
    left, top, extent = 0.68 / side, 1 - 0.6 / side, 1 - 0.76 / side
    grid = figure.add_gridspec(
        n, n, left=left, right=left + extent, bottom=top - extent, top=top, wspace=0.0, hspace=0.0
    )
    exposure = common_exposure(list(pictures.values()))
    for i, F_L in enumerate(frequencies):
        for j, F_rho in enumerate(frequencies):
            axes = figure.add_subplot(grid[i, j])
            show(axes, pictures[F_L, F_rho], exposure)
            caption(axes, str(highest[F_L, F_rho]))
            if i == 0:
                axes.set_title(f"F = {F_rho}", fontsize=10)
            if j == 0:
                axes.set_ylabel(f"F = {F_L}", fontsize=10)

    # Axes, and between two delimiters the cells whose smaller F is the same
    figure.text(left + extent / 2, 1 - 0.23 / side, "material: more diffuse →", ha="center", fontsize=11)
    figure.text(0.15 / side, top - extent / 2, "← light: more blurred", va="center", rotation=90, fontsize=11)
    for k in range(1, n):
        x, y = left + extent * k / n, top - extent * k / n
        figure.add_artist(Line2D([left, x, x], [y, y, top], color=YELLOW, linewidth=2.5))
    return figure
