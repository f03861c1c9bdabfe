"""Ways to light an object at run time, side by side: frames per second, memory, error [LK03 table 1]."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt
from shrm import brdf
from shrm.arrays import Float32Array
from shrm.transfer.brdf_matrix import rows
from shrm.transfer.lighting import (
    Compressed,
    Convolution,
    Diffuse,
    Lighting,
    Projection,
    Tents,
    parabolic_map,
    zonal_kernel,
)
from shrm.transfer.matrices.product import Path as Way
from shrm.transfer.matrices.product import accumulate, harmonics, product, published, rotated, view_rows
from shrm.transfer.object import RadianceTransfer, Variant

from shrm_papers.lk03.transfer_reference import VERTICES, VIEWS, Reference
from shrm_papers.lk03.transfer_subject import Subject, n

Vertices = slice | npt.NDArray[np.intp]

GLOSSY = brdf.AshikhminShirley(40, 10)
MATT = brdf.Lambert(1.0)
PHONG = brdf.Phong(10)
"""About as sharp as half vectors' lobes of 40: those turn half as far."""

FEW, TENTS = 7, 11
COMPONENTS = (10, 25)  # K
ACCURACY, QUICK_ACCURACY = 24.0, 12.0  # that the last K is chosen for, in dB
SAMPLES = 64  # along each side of the parabolic map
SECONDS = 0.6  # in which the frames of one way are timed
_BURSTS, _PAUSE = 3, 0.1  # in which they are, and seconds before each

EVERY = slice(None)
ROTATIONS = sum((2 * l + 1) ** 2 for l in range(n))  # numbers of R_p


@dataclass(frozen=True)
class Judged:
    """A way of lighting an object.

    Attributes
    ----------
    method : str
    material : str
    shadowed : bool
    seconds : float
        Of a frame: every vertex lit, eye and light moving. Median, wall time.
    bytes : int
        Of what was precomputed; vertices and frames left out.
    snr : float
        Relative SNR of radiance, in dB.
    published : float or None
        The same by way of the expansions of [LK03], where that is another way.
    K : int or None
        Principal components, where there are any.
    """

    method: str
    material: str
    shadowed: bool
    seconds: float
    bytes: int
    snr: float
    published: float | None
    K: int | None


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A way that is to be judged. What lights given vertices is made by functions: some takes much memory."""

    method: str
    material: brdf.BRDF
    shadowed: bool
    bytes: int
    make: Callable[[Vertices], Lighting]
    make_published: Callable[[Vertices], Lighting] | None = None
    K: int | None = None


def compare(subject: Subject, quick: bool = False) -> list[Judged]:
    """Light an object in all ways, shadowed and not.

    Parameters
    ----------
    subject : Subject
    quick : bool
        Whether to look at less.

    Returns
    -------
    list of Judged
        Way by way, each shadowed, then not.
    """
    extent = (VERTICES // 4, VIEWS // 4) if quick else (VERTICES, VIEWS)
    materials: tuple[brdf.BRDF, ...] = (GLOSSY, MATT, PHONG)
    references = {material: Reference(subject, material, *extent) for material in materials}
    found = []
    for one in _candidates(subject, *((16, QUICK_ACCURACY) if quick else (SAMPLES, ACCURACY))):
        reference = references[one.material]
        snr = reference.snr(one.make(reference.at), one.shadowed)
        by_harmonics = None
        if one.make_published is not None:
            by_harmonics = reference.snr(one.make_published(reference.at), one.shadowed)
        taken = frame_seconds(one.make(EVERY), 0.0 if quick else SECONDS)
        about = one.method, one.material.name, one.shadowed
        found.append(Judged(*about, taken, one.bytes, snr, by_harmonics, one.K))
    return found


def frame_seconds(lighting: Lighting, seconds: float) -> float:
    """Return the median wall time of a frame, in the best of some bursts; eye and light move between frames.

    Two threads that share a processor for a while, and wait for each other, take ten times as long.
    """
    out = np.empty((lighting.size, 3), np.float32)
    bursts = []
    for _ in range(_BURSTS):
        time.sleep(_PAUSE)
        taken: list[float] = []
        end = time.perf_counter() + seconds / _BURSTS
        while len(taken) < 5 or time.perf_counter() < end:
            k = len(taken)
            light = 0.2 * np.sin(1.7 * np.arange(n * n)[:, None] + 0.9 * np.arange(3) + 0.05 * k)
            eye = (4 * np.cos(0.13 * k), 4 * np.sin(0.13 * k), 0.8)
            start = time.perf_counter()
            lighting.radiance(light, eye=eye, out=out)
            taken.append(time.perf_counter() - start)
        bursts.append(median(taken[2:]))  # what is read first comes from far
    return min(bursts)


def _candidates(subject: Subject, samples: int, accuracy: float) -> Iterator[_Candidate]:
    yield from _projections(subject, samples)
    theirs = subject.precomputed(GLOSSY, M=TENTS, path=published(n), K=COMPONENTS[-1], half=False)
    for M in (FEW, TENTS):
        few = {"K": 1} if M == FEW else {}
        made = subject.precomputed(GLOSSY, M=M, path=Way(), accuracy=accuracy, matrices=True, **few)
        for shadowed, variant in _by_shadows(made):
            yield _tents(subject, M, shadowed, variant)
    for K in COMPONENTS:
        for shadowed, variant in _by_shadows(made):
            _, other = next(pair for pair in _by_shadows(theirs) if pair[0] == shadowed)
            name = f"{TENTS} x {TENTS} tents, PCA, K = {K}"
            yield _compressed(subject, name, K, shadowed, variant, other)
    for shadowed, variant in _by_shadows(made):
        name = f"{TENTS} x {TENTS} tents, PCA to {accuracy:g} dB"
        yield _compressed(subject, name, variant.K, shadowed, variant)
    yield from _sloans(subject)


def _by_shadows(made: RadianceTransfer) -> tuple[tuple[bool, Variant], tuple[bool, Variant]]:
    return (True, made.variants["shadowed"]), (False, made.variants["unshadowed"])


# ---- Each way


def _projections(subject: Subject, side: int) -> Iterator[_Candidate]:
    """[KSS02]: T, a rotation, and the material's row at the view."""
    vertices, frames = subject.mesh.vertices, subject.frames
    samples = parabolic_map(GLOSSY, n, side)

    def made(transfer: Float32Array | None, prerotated: bool = False) -> Callable[[Vertices], Lighting]:
        return lambda at: Projection(
            vertices[at],
            frames[at],
            samples,
            None if transfer is None else transfer[at],
            prerotated=prerotated,
        )

    T, rotations = subject.transfer, 4 * subject.size * ROTATIONS
    name = "Kautz et al. 2002"
    yield _Candidate(name, GLOSSY, True, T.nbytes + rotations + samples.nbytes, made(T))
    yield _Candidate(name, GLOSSY, False, rotations + samples.nbytes, made(None))
    name = "Kautz et al. 2002, rotated beforehand"
    yield _Candidate(name, GLOSSY, True, T.nbytes + samples.nbytes, made(T, prerotated=True))


def _tents(subject: Subject, M: int, shadowed: bool, variant: Variant) -> _Candidate:
    """Tents without compression [LK03 eq. 9]."""
    vertices, frames, matrices = subject.mesh.vertices, subject.frames, variant.matrices
    assert matrices is not None
    P = product(GLOSSY, M, n, subject.rays, published(n)).outer
    assert P is not None
    tents = P.reshape(M * M, 1, n * n)  # times R_p T_p they are the matrices of [LK03]

    def by_harmonics(at: Vertices) -> Lighting:
        return Projection(vertices[at], frames[at], tents, subject.transfer[at] if shadowed else None)

    def made(at: Vertices) -> Lighting:
        return Tents(vertices[at], frames[at], np.array(matrices[at]))  # from disk into memory

    return _Candidate(f"{M} x {M} tents", GLOSSY, shadowed, matrices.nbytes, made, by_harmonics)


def _compressed(
    subject: Subject, name: str, K: int, shadowed: bool, variant: Variant, theirs: Variant | None = None
) -> _Candidate:
    """Principal components [LK03 eq. 13]."""
    vertices, frames = subject.mesh.vertices, subject.frames

    def of(one: Variant) -> Callable[[Vertices], Lighting]:
        weights, components = _held(one)
        used = min(K, one.K)  # of simple objects there are not as many
        return lambda at: Compressed(vertices[at], frames[at], weights[at], components, K=used)

    weights, components = _held(variant)
    size = weights[:, :K].nbytes + components[:K].nbytes
    by_harmonics = None if theirs is None else of(theirs)
    return _Candidate(name, GLOSSY, shadowed, size, of(variant), by_harmonics, min(K, variant.K))


def _held(variant: Variant) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    assert variant.weights is not None
    assert variant.components is not None
    return variant.weights, variant.components


def _sloans(subject: Subject) -> Iterator[_Candidate]:
    """[SKS02]: a row for each vertex of matt materials, a convolution for lobes about the reflection."""
    vertices, frames = subject.mesh.vertices, subject.frames
    straight = rotated(rows(MATT, [[0.0, 0.0, 1.0]], n).astype(np.float32), frames)  # (V, 1, n^2)
    shaded = np.empty_like(straight)
    ray = view_rows(MATT, np.array([[0.0, 0.0, 1.0]]), n, subject.rays)
    Y = harmonics(subject.rays, n).astype(np.float32)
    for block in subject.visibility:
        shaded[block.vertices] = rotated(accumulate(ray, block.visible, Y), frames[block.vertices])
    name = "Sloan et al. 2002, matt"
    yield _Candidate(
        name,
        MATT,
        True,
        shaded.nbytes,
        lambda at: Diffuse(shaded[at]),
        lambda at: Diffuse(straight[at] @ subject.transfer[at]),
    )
    yield _Candidate(name, MATT, False, straight.nbytes, lambda at: Diffuse(straight[at]))
    name, kernel, T = "Sloan et al. 2002, Phong by convolution", zonal_kernel(PHONG, n), subject.transfer
    yield _Candidate(
        name, PHONG, True, T.nbytes, lambda at: Convolution(vertices[at], frames[at], kernel, T[at])
    )
    yield _Candidate(
        name, PHONG, False, kernel.nbytes, lambda at: Convolution(vertices[at], frames[at], kernel)
    )
