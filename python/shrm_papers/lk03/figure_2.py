"""[LK03] figure 2: the error of the change from harmonics to tents, against their numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from shrm.arrays import FloatArray
from shrm.transfer.directional_basis import DirectionalBasis

from shrm_papers.plotting import COLORS, MARKS, panels
from shrm_papers.result import Cell, Result, Settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "lk03-figure-2"

TENTS = (3, 5, 7, 9, 11, 13, 15)
"""M, the tents along each side of the square."""

ORDERS = (2, 3, 4, 5, 6, 7, 8)
"""m, the order of the harmonics."""

POPULATION = 1000
"""Random expansions for each m and M, as many as in [LK03 section 5]."""


def make(settings: Settings) -> Result:
    """Find the average PSNR for every m and M, exactly and from a population."""
    tents = TENTS[:3] if settings.quick else TENTS
    rng = np.random.default_rng(20030428)
    exact, sampled = np.empty((len(ORDERS), len(tents))), np.empty((len(ORDERS), len(tents)))
    for row, m in enumerate(ORDERS):
        for column, M in enumerate(tents):
            basis = DirectionalBasis(M)
            exact[row, column] = basis.average_psnr(m)
            sampled[row, column] = population(basis.error_matrix(m), rng)
    table: list[list[Cell]] = [[m, *(float(x) for x in line)] for m, line in zip(ORDERS, exact, strict=True)]
    return Result(
        NAME,
        "Average PSNR in dB of M x M tents against the order m of the harmonics that they replace",
        ("m", *(f"M = {M}" for M in tents)),
        table,
        _notes(exact, sampled),
        _draw(tents, exact, sampled),
    )


def population(E: FloatArray, rng: np.random.Generator, size: int = POPULATION) -> float:
    """Return the PSNR of the mean squared error l^T E l of random l of norm 1, in dB [LK03 eqs. 10, 11]."""
    l = rng.normal(size=(size, len(E)))
    l /= np.linalg.norm(l, axis=1, keepdims=True)
    return -10 * float(np.log10(np.mean(np.einsum("pi,ij,pj->p", l, E, l))))


def _notes(exact: FloatArray, sampled: FloatArray) -> list[str]:
    return [
        "The mean over random expansions of norm 1 is taken exactly, 10 log10(m^2 / tr E) with the E of "
        f"[LK03 eq. 10]; the paper measured populations of {POPULATION}. Such populations are here within "
        f"{np.abs(exact - sampled).max():.2f} dB of it.",
        "[LK03 eq. 11] has the sign wrong as it is printed; order 1, a constant, is held exactly. The paper "
        "shows curves and prints no numbers.",
    ]


def _draw(tents: tuple[int, ...], exact: FloatArray, sampled: FloatArray) -> Figure:
    figure, (panel,) = panels(1, 1, 6.4, 4.6)
    for k, M in enumerate(tents):
        panel.plot(ORDERS, exact[:, k], color=COLORS[k], linewidth=1.6)
        panel.plot(ORDERS, sampled[:, k], MARKS[k], color=COLORS[k], markersize=6, label=f"M = {M}")
    panel.set(xlabel="order m of outgoing radiance", ylabel="average PSNR, dB", xticks=ORDERS, ylim=(0, None))
    panel.set_title(f"Lines: exact. Marks: populations of {POPULATION}", fontsize=10)
    panel.legend(frameon=False, fontsize=8, reverse=True)
    return figure
