"""Methods that light an object at run time, compared: frames per second, memory, error [LK03 table 1]."""

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
from shrm.transfer.matrices.product import (
    Route,
    accumulate,
    harmonics,
    product,
    published,
    rotated,
    view_rows,
)
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.variant import Variant

from shrm_papers.lk03.reference import VERTICES, VIEWS, Reference
from shrm_papers.lk03.subject import Subject, n

Vertices = slice | npt.NDArray[np.intp]

GLOSSY = brdf.AshikhminShirley(40, 10)
MATT = brdf.Lambert(1.0)
PHONG = brdf.Phong(10)
"""About as sharp as a half-vector lobe of exponent 40, whose half vectors turn half as far."""

FEW, TENTS = 7, 11
"""M, the tents along each side of the square."""

COMPONENTS = (10, 25)
"""K, the principal components."""

ACCURACY, QUICK_ACCURACY = 24.0, 12.0
"""SNR in dB that a further number of components is chosen for, in full and in quick runs."""

SAMPLES = 64
"""Samples along each side of the parabolic map."""

SECONDS = 0.6
"""Seconds in which the frames of a method are timed."""

_BURSTS, _PAUSE = 3, 0.1
"""Bursts into which these seconds are divided, and seconds of rest before each."""

ALL_VERTICES = slice(None)
"""Index of all vertices."""

ROTATIONS = sum((2 * l + 1) ** 2 for l in range(n))
"""Elements of a rotation R_p, block by block."""


@dataclass(frozen=True)
class Judged:
    """A method with its time, memory and error.

    Attributes
    ----------
    method, material : str
        Names of the method and of the material.
    shadowed : bool
        True if the object shadows itself.
    seconds : float
        Median wall time of a frame: every vertex lit, eye and light moving.
    bytes : int
        Bytes of precomputed arrays, without vertices and frames.
    snr : float
        Relative SNR of radiance, in dB.
    published : float or None
        The SNR through the expansions of [LK03], if the method takes another route.
    K : int or None
        Principal components, if there are any.
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
    """A method to be judged; its lighting is made for given vertices when needed: some takes much memory."""

    method: str
    material: brdf.BRDF
    shadowed: bool
    bytes: int
    make: Callable[[Vertices], Lighting]
    make_published: Callable[[Vertices], Lighting] | None = None
    K: int | None = None


def compare(subject: Subject, quick: bool = False) -> list[Judged]:
    """Light an object by all methods, shadowed and not.

    Parameters
    ----------
    subject : Subject
        The object.
    quick : bool
        True to take fewer vertices, views and samples.

    Returns
    -------
    list of Judged
        Method by method, each with shadows, then without.
    """
    extent = (VERTICES // 4, VIEWS // 4) if quick else (VERTICES, VIEWS)
    materials: tuple[brdf.BRDF, ...] = (GLOSSY, MATT, PHONG)
    references = {material: Reference(subject, material, *extent) for material in materials}
    judged = []
    for candidate in _candidates(subject, *((16, QUICK_ACCURACY) if quick else (SAMPLES, ACCURACY))):
        reference = references[candidate.material]
        snr = reference.snr(candidate.make(reference.at), candidate.shadowed)
        published_snr = None
        if candidate.make_published is not None:
            published_snr = reference.snr(candidate.make_published(reference.at), candidate.shadowed)
        seconds = frame_seconds(candidate.make(ALL_VERTICES), 0.0 if quick else SECONDS)
        key = candidate.method, candidate.material.name, candidate.shadowed
        judged.append(Judged(*key, seconds, candidate.bytes, snr, published_snr, candidate.K))
    return judged


def frame_seconds(lighting: Lighting, seconds: float) -> float:
    """Return the median wall time of a frame, in the best of some bursts; eye and light move between frames.

    Two threads that share a processor for a while, and wait for each other, take ten times as long.
    """
    out = np.empty((lighting.size, 3), np.float32)
    bursts = []
    for _ in range(_BURSTS):
        time.sleep(min(_PAUSE, seconds))  # no rest where nothing is timed for long
        times: list[float] = []
        end = time.perf_counter() + seconds / _BURSTS
        while len(times) < 5 or time.perf_counter() < end:
            k = len(times)
            light = 0.2 * np.sin(1.7 * np.arange(n * n)[:, None] + 0.9 * np.arange(3) + 0.05 * k)
            eye = (4 * np.cos(0.13 * k), 4 * np.sin(0.13 * k), 0.8)
            start = time.perf_counter()
            lighting.radiance(light, eye=eye, out=out)
            times.append(time.perf_counter() - start)
        bursts.append(median(times[2:]))  # the first frames find nothing in the caches
    return min(bursts)


def _candidates(subject: Subject, samples: int, accuracy: float) -> Iterator[_Candidate]:
    """Yield all methods in the table's order."""
    yield from _projections(subject, samples)

    # Tents without compression: the matrices of few are discarded when those of many are made.
    through_harmonics = subject.precomputed(
        GLOSSY, tents=TENTS, route=published(n), components=COMPONENTS[-1], half=False
    )
    for M in (FEW, TENTS):
        few = {"components": 1} if M == FEW else {}
        straight = subject.precomputed(
            GLOSSY, tents=M, route=Route(), accuracy=accuracy, matrices=True, **few
        )
        for shadowed, variant in _by_shadows(straight).items():
            yield _tents(subject, M, shadowed, variant)

    # Principal components, as many as the paper's and to an accuracy
    for K in COMPONENTS:
        for shadowed, variant in _by_shadows(straight).items():
            name = f"{TENTS} x {TENTS} tents, PCA, K = {K}"
            papers_variant = _by_shadows(through_harmonics)[shadowed]
            yield _compressed(subject, name, K, shadowed, variant, papers_variant)
    for shadowed, variant in _by_shadows(straight).items():
        name = f"{TENTS} x {TENTS} tents, PCA to {accuracy:g} dB"
        yield _compressed(subject, name, variant.K, shadowed, variant)

    yield from _sloans(subject)


def _by_shadows(transfer: RadianceTransfer) -> dict[bool, Variant]:
    """Return the variants, the shadowed one under True."""
    return {True: transfer.variants["shadowed"], False: transfer.variants["unshadowed"]}


# ---- The methods, one by one


def _projections(subject: Subject, side: int) -> Iterator[_Candidate]:
    """Yield [KSS02]: T, a rotation, and the material's row at the view."""
    vertices, frames = subject.mesh.vertices, subject.frames
    samples = parabolic_map(GLOSSY, n, side)

    def lighting(transfer: Float32Array | None, prerotated: bool = False) -> Callable[[Vertices], Lighting]:
        return lambda at: Projection(
            vertices[at],
            frames[at],
            samples,
            None if transfer is None else transfer[at],
            prerotated=prerotated,
        )

    T, rotations = subject.transfer, 4 * subject.size * ROTATIONS
    name = "Kautz et al. 2002"
    yield _Candidate(name, GLOSSY, True, T.nbytes + rotations + samples.nbytes, lighting(T))
    yield _Candidate(name, GLOSSY, False, rotations + samples.nbytes, lighting(None))
    name = "Kautz et al. 2002, rotated beforehand"
    yield _Candidate(name, GLOSSY, True, T.nbytes + samples.nbytes, lighting(T, prerotated=True))


def _tents(subject: Subject, M: int, shadowed: bool, variant: Variant) -> _Candidate:
    """Return tents without compression [LK03 eq. 9]."""
    vertices, frames, matrices = subject.mesh.vertices, subject.frames, variant.matrices
    assert matrices is not None
    P = product(GLOSSY, M, n, subject.rays, published(n)).outer
    assert P is not None
    tents = P.reshape(M * M, 1, n * n)  # times R_p T_p they are the matrices of [LK03]

    def through_harmonics(at: Vertices) -> Lighting:
        return Projection(vertices[at], frames[at], tents, subject.transfer[at] if shadowed else None)

    def straight(at: Vertices) -> Lighting:
        return Tents(vertices[at], frames[at], np.array(matrices[at]))  # from disk into memory

    return _Candidate(f"{M} x {M} tents", GLOSSY, shadowed, matrices.nbytes, straight, through_harmonics)


def _compressed(
    subject: Subject, name: str, K: int, shadowed: bool, variant: Variant, papers: Variant | None = None
) -> _Candidate:
    """Return K principal components [LK03 eq. 13], and those of the paper's route if it is another."""
    vertices, frames = subject.mesh.vertices, subject.frames

    def lighting(variant: Variant) -> Callable[[Vertices], Lighting]:
        weights, components = _weights_and_components(variant)
        used = min(K, variant.K)  # simple objects have fewer
        return lambda at: Compressed(vertices[at], frames[at], weights[at], components, K=used)

    weights, components = _weights_and_components(variant)
    size = weights[:, :K].nbytes + components[:K].nbytes
    through_harmonics = None if papers is None else lighting(papers)
    return _Candidate(name, GLOSSY, shadowed, size, lighting(variant), through_harmonics, min(K, variant.K))


def _weights_and_components(variant: Variant) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    assert variant.weights is not None
    assert variant.components is not None
    return variant.weights, variant.components


def _sloans(subject: Subject) -> Iterator[_Candidate]:
    """Yield [SKS02]: a row for each vertex of a matt material, a convolution for a lobe about R."""
    # Matt: the row of the upward view, from the rays that meet nothing
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

    # Phong
    name, kernel, T = "Sloan et al. 2002, Phong by convolution", zonal_kernel(PHONG, n), subject.transfer
    yield _Candidate(
        name, PHONG, True, T.nbytes, lambda at: Convolution(vertices[at], frames[at], kernel, T[at])
    )
    yield _Candidate(
        name, PHONG, False, kernel.nbytes, lambda at: Convolution(vertices[at], frames[at], kernel)
    )
