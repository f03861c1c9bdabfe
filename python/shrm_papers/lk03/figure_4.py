"""[LK03] figure 4: the object by the method before, by the material's matrix, and by tents, few and many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shrm import brdf, sh
from shrm.arrays import Float32Array
from shrm.transfer.brdf_matrix import project
from shrm.transfer.lighting import Lighting, Projection, Tents, parabolic_map
from shrm.transfer.matrices.product import Route, product, published
from shrm.transfer.tangent_frames import local_coefficients

from shrm_papers.comparison import Block, draw_blocks
from shrm_papers.lk03.pictures import Shot, Stage
from shrm_papers.lk03.reference import local_views, radiance
from shrm_papers.lk03.subject import Subject, n, note, subject_of
from shrm_papers.result import Cell, Result, Settings

NAME = "lk03-figure-4"

TENTS = (11, 7, 3)
"""M, the tents along each side of the square."""

VIEW_ORDER = 8
"""m, the order of the view."""

GAIN = 4.0
"""Factor that differences are shown with."""


@dataclass(frozen=True)
class Case:
    """A row of the figure."""

    name: str
    material: brdf.BRDF
    shadowed: bool


CASES = (
    Case("isotropic, unshadowed", brdf.AshikhminShirley(40, 40), False),
    Case("anisotropic, shadowed", brdf.AshikhminShirley(40, 10), True),
)
"""The head and the bird of [LK03]."""

COLUMNS = ("material", "self-shadowing", "method", "relative RMS error of the picture")


def make(settings: Settings) -> Result:
    """Draw the object in both materials by every method."""
    subject = subject_of(settings)
    stage = Stage(subject, settings)
    blocks, rows = [], []
    for case in CASES:
        summed = radiance(subject, case.material, stage.light, stage.eye, case.shadowed, stage.visible)
        truth = stage.shot(summed)
        columns = _columns(subject, stage, case, truth, 16 if settings.quick else 64)
        blocks.append(Block(case.name, truth, columns, gain=GAIN))
        for title, shot in columns:
            row: list[Cell] = [case.material.name, "yes" if case.shadowed else "no"]
            rows.append([*row, title.replace("\n", ", "), shot.error])
    return Result(
        NAME,
        f"A comparison of methods, {subject.name}, {settings.env_name}",
        COLUMNS,
        rows,
        _notes(subject),
        draw_blocks(blocks),
    )


def _columns(subject: Subject, stage: Stage, case: Case, truth: Shot, side: int) -> list[tuple[str, Shot]]:
    """Return the picture of each method with its title."""
    vertices, frames = subject.mesh.vertices, subject.frames
    T = subject.transfer if case.shadowed else None

    def projected(rows: Float32Array) -> Shot:
        return stage.lit(Projection(vertices, frames, rows, T), truth)

    def tents(M: int) -> Shot:
        P = product(case.material, M, n, subject.rays, published(n)).outer
        assert P is not None
        return projected(P.reshape(M * M, 1, n * n))  # tents of the view in place of a parabolic map

    most = TENTS[0]
    return [
        ("Kautz et al.\n2002", projected(parabolic_map(case.material, n, side))),
        ("matrix of order 8\n[LK03 eq. 6]", stage.shot(_by_harmonics(subject, case, stage, T), truth)),
        *((f"{M} x {M} tents\n[LK03 eq. 9]", tents(M)) for M in TENTS),
        (f"{most} x {most} tents\ndirect", stage.lit(_direct(subject, case, most), truth)),
    ]


def _by_harmonics(subject: Subject, case: Case, stage: Stage, T: Float32Array | None) -> Float32Array:
    """Return radiance (V, 3) as a sum of harmonics of the view, without change of basis [LK03 eqs. 5, 6]."""
    route = published(n)
    B = project(case.material, VIEW_ORDER, n, extension=route.extension, window_above=route.window_above)
    arriving = (
        np.broadcast_to(stage.light, (subject.size, *stage.light.shape)) if T is None else T @ stage.light
    )
    local = local_coefficients(arriving, subject.frames)
    views = local_views(subject, stage.eye)
    rows = sh.evaluate(np.eye(VIEW_ORDER**2), views) @ B.coefficients  # (V, n^2)
    return np.asarray(np.einsum("pj,pjc->pc", rows, local), np.float32)


def _direct(subject: Subject, case: Case, M: int) -> Lighting:
    """Return the lighting of tents that come straight from rays."""
    vertices, frames = subject.mesh.vertices, subject.frames
    if not case.shadowed:
        rows = product(case.material, M, n, subject.rays, Route()).unshadowed
        return Projection(vertices, frames, rows.reshape(M * M, 1, n * n))
    transfer = subject.precomputed(
        case.material, tents=M, route=Route(), components=1, matrices=True, variants=["shadowed"]
    )
    matrices = transfer.variants["shadowed"].matrices
    assert matrices is not None
    return Tents(vertices, frames, matrices)


def _notes(subject: Subject) -> list[str]:
    return [
        note(subject),
        "Light of order 5. Correct is a sum over the rays of every vertex, for light of that order, with "
        "neither tents nor harmonics of views or of transferred radiance. Pictures of a row have one "
        "exposure, and so have the differences below them.",
        "Methods but the last are those of the paper: transferred radiance of order 5; views of order 8 "
        "continued evenly, with a window above degree 5. The last goes from rays to tents straight.",
        "Where nothing shadows Kautz et al. are exact for such light, but for their map's samples; with "
        "shadows they, too, know transferred radiance to order 5 alone.",
    ]
