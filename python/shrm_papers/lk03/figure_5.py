"""[LK03] figure 5: the object from 3, 10 and 20 principal components, and without compression."""

from __future__ import annotations

from dataclasses import dataclass

from shrm import brdf
from shrm.transfer.lighting import Tents
from shrm.transfer.matrices.product import published

from shrm_papers.comparison import Block, draw_blocks
from shrm_papers.lk03.pictures import Stage
from shrm_papers.lk03.subject import Subject, n, note, subject_of
from shrm_papers.result import Cell, Result, Settings

NAME = "lk03-figure-5"

TENTS = 11
"""M, the tents along each side of the square."""

PAPER = {3: 950, 10: 285, 20: 142, 50: None}
"""[LK03 figure 5]: the compression by K at 50000 vertices. It has no number for 50, good with shadows."""


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
    subject = subject_of(settings)
    stage = Stage(subject, settings)
    blocks, rows = [], []
    for case in CASES:
        transfer = subject.precomputed(
            case.material,
            tents=TENTS,
            route=published(n),
            components=max(PAPER),
            half=False,
            matrices=True,
            variants=[case.variant],
        )
        matrices = transfer.variants[case.variant].matrices
        assert matrices is not None
        truth = stage.lit(Tents(transfer.vertices, transfer.frames, matrices))
        columns = []
        for K, papers_ratio in PAPER.items():
            shot = stage.lit(transfer.lighting(components=K), truth)
            ratio = compression(subject.size, K)
            columns.append((f"K = {K}\n1 : {ratio:.0f}", shot))
            shadowed = case.variant == "shadowed"
            snr = transfer.report["compression"][case.variant]["SNR of 1 to K"][K - 1]
            row: list[Cell] = [case.material.name, "yes" if shadowed else "no", K, ratio]
            rows.append([*row, None if shadowed else papers_ratio, shot.error, snr])
        blocks.append(Block(case.name, truth, columns, "uncompressed"))
    return Result(
        NAME,
        f"From few and many principal components, {subject.name}, {settings.env_name}",
        COLUMNS,
        rows,
        _notes(subject),
        draw_blocks(blocks),
    )


def compression(V: int, K: int) -> float:
    """Return how many times fewer numbers K components and weights of V vertices are than V matrices."""
    matrix = TENTS**2 * n**2
    return V * matrix / (K * (V + matrix))


def _notes(subject: Subject) -> list[str]:
    return [
        note(subject),
        f"{TENTS} x {TENTS} tents by the published path, m = 8, light of order 5, all float32. Errors are "
        "against the uncompressed matrices; SNR is that of radiance under white light towards all views, "
        "vertices pooled. The paper's model has no shadows; those with shadows, and K = 50, are added: it "
        "finds K above 25 hardly to be told from the uncompressed without shadows, and 50 good with them.",
    ]
