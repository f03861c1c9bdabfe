"""[LK03] figure 5: the object from 3, 10 and 20 principal components, and without compression."""

from __future__ import annotations

from dataclasses import dataclass

from shrm import brdf
from shrm.transfer.lighting import Tents
from shrm.transfer.matrices.product import published

from shrm_papers.comparison import Block, draw_blocks
from shrm_papers.lk03.transfer_pictures import Stage
from shrm_papers.lk03.transfer_subject import Subject, n, note, subject
from shrm_papers.result import Cell, Result, Settings

NAME = "lk03-figure-5"

TENTS = 11
PAPER = {3: 950, 10: 285, 20: 142, 50: None}
"""[LK03 figure 5], by K: how many times smaller, at 50000 vertices. With shadows it finds 50 good."""


@dataclass(frozen=True)
class Case:
    """A row of the figure."""

    name: str
    material: brdf.BRDF
    variant: str


CASES = (
    Case("no shadows", brdf.AshikhminShirley(40, 40), "unshadowed"),
    Case("shadowed", brdf.AshikhminShirley(40, 10), "shadowed"),
)
"""The first is the paper's."""

COLUMNS = (
    "material",
    "self-shadowing",
    "K",
    "compression",
    "compression [LK03]",
    "relative RMS error of the picture",
    "SNR, dB",
)


def make(settings: Settings) -> Result:
    """Draw the object from few and many components, and without compression."""
    this = subject(settings)
    stage = Stage(this, settings)
    blocks, rows = [], []
    for case in CASES:
        made = this.precomputed(
            case.material,
            M=TENTS,
            path=published(n),
            K=max(PAPER),
            half=False,
            matrices=True,
            variants=[case.variant],
        )
        matrices = made.variants[case.variant].matrices
        assert matrices is not None
        truth = stage.lit(Tents(made.vertices, made.frames, matrices))
        columns = []
        for K, smaller in PAPER.items():
            shot = stage.lit(made.lighting(K=K), truth)
            ratio = compression(this.size, K)
            columns.append((f"K = {K}\n1 : {ratio:.0f}", shot))
            row: list[Cell] = [case.material.name, "yes" if case.variant == "shadowed" else "no"]
            snr = made.report["compression"][case.variant]["SNR of 1 to K"][K - 1]
            rows.append([*row, K, ratio, None if row[1] == "yes" else smaller, shot.error, snr])
        blocks.append(Block(case.name, truth, columns, "uncompressed"))
    return Result(
        NAME,
        f"From few and many principal components, {this.name}, {settings.env_name}",
        COLUMNS,
        rows,
        _notes(this),
        draw_blocks(blocks),
    )


def compression(V: int, K: int) -> float:
    """Return how many times less numbers K components and their weights are than the matrices."""
    whole = TENTS**2 * n**2
    return V * whole / (K * (V + whole))


def _notes(this: Subject) -> list[str]:
    return [
        note(this),
        f"{TENTS} x {TENTS} tents by the published path, m = 8, light of order 5, all float32. Errors are "
        "against the uncompressed matrices; SNR is that of radiance under white light towards all views, "
        "vertices pooled. The paper's model has no shadows; those with shadows, and K = 50, are added: it "
        "finds K above 25 hardly to be told from the uncompressed without shadows, and 50 good with them.",
    ]
