"""Lighting an object beside a hand-written timing study, in turns, with one thread and with two.

    python bench/beside_transfer_prototype.py          # the comparison, as JSON; takes two minutes and 2 GB

The study, ../shared/prototypes/mrt_runtime_prototype.cpp, is a C++ program for one order of light, one number
of tents and this very processor, that stands beside the project and is no part of it. It is compiled with its
sweep narrowed, reads the arrays that are written for it into a temporary folder, and the medians that it
prints are read: of its ways to do a thing the fastest in float32. Ours read the same arrays and are measured
as it measures itself: the median of frames for half a second, wall time, eye and light moving.
"""

import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt
from limits import BUILD, ROOT, compiled
from processes import found_by

SOURCE = ROOT.parent / "shared" / "prototypes" / "mrt_runtime_prototype.cpp"
TURNS = 2
V, n, SIDE, STORED = 50_000, 5, 64, 50
TERMS = n * n
SECONDS = 0.5

# Our names, and the study's
WORK = {
    "a0: T, then a stored rotation": "a0 Kautz T,then R",
    "a1: T rotated beforehand": "a1 Kautz prerotated",
    "b: 7 x 7 tents": "b 7x7 f32 prefetch",
    "c: 11 x 11 tents": "c 11x11 f32 prefetch",
    "c: the same, halves": "c 11x11 f16 prefetch",
    "d: PCA, K = 10": "d PCA11 K=10 avx512",
    "e: PCA, K = 25": "e PCA11 K=25 avx512",
}

Times = dict[str, float]  # milliseconds by work


# ---- The object


def frames() -> npt.NDArray[np.float32]:
    """Vertices on a spiral over the unit sphere, as (V, 3, 3) frames; z is the vertex itself."""
    k = np.arange(V) + 0.5
    z, phi = 1 - 2 * k / V, np.pi * (1 + np.sqrt(5)) * k
    normal = np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], axis=1)
    tangent = np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=1)
    return np.stack([tangent, np.cross(normal, tangent), normal], axis=2).astype(np.float32)


def write_object(folder: Path) -> None:
    """Write the arrays that the study reads: random, but for vertices and frames."""
    rng = np.random.default_rng(1)
    (folder / "meshes").mkdir()
    local = frames()
    np.ascontiguousarray(local[:, :, 2]).tofile(folder / "meshes" / "nef50.v")
    np.ascontiguousarray(np.swapaxes(local, 1, 2)).tofile(folder / "meshes" / "nef50.tbn")
    for name, values in {
        "Tt": V * TERMS**2,
        "RTt": V * TERMS**2,
        "Rb": V * sum((2 * l + 1) ** 2 for l in range(n)),
        "pm": SIDE**2 * TERMS,
        "A7": V * 7**2 * TERMS,
        "A11": V * 11**2 * TERMS,
        "W50": V * STORED,
        "Ak50": STORED * 11**2 * TERMS,
    }.items():
        with (folder / f"bench_{name}.f32").open("wb") as file:
            for start in range(0, values, 1 << 22):
                (rng.random(min(values - start, 1 << 22), dtype=np.float32) - np.float32(0.5)).tofile(file)


# ---- The study


def build() -> Path:
    """Compile the study with its sweep narrowed; what cannot be narrowed it runs whole."""
    text = SOURCE.read_text()
    for sweep, wanted in {
        "for(int th=1;th<=2;th++)": "for(int th=1;th<=0;th++)",
        "for(int th:{2})": "for(int th:{1,2})",
        "for(int K:{10,25,50})": "for(int K:{10,25})",
        "now()-t0<0.8": f"now()-t0<{SECONDS}",
    }.items():
        text = text.replace(sweep, wanted)
    BUILD.mkdir(exist_ok=True)
    narrowed = BUILD / "mrt_runtime_prototype.cpp"
    narrowed.write_text(text)
    return compiled(narrowed, "mrt_runtime_prototype", "-w")


def parsed(printed: str) -> dict[int, Times]:
    """Return the study's medians, by threads."""
    found: dict[int, Times] = {1: {}, 2: {}}
    ours = {theirs: work for work, theirs in WORK.items()}
    for name, threads, ms in re.findall(r"^(.+?) +thr (\d) moving .*?median (\S+) ms", printed, re.M):
        if name in ours:
            found[int(threads)][ours[name]] = float(ms)
    return found


# ---- Ours


def ours(folder: Path) -> Times:
    """Measure with the threads that OpenMP was started with."""
    from shrm.transfer.lighting import Compressed, Projection, Tents

    def read(name: str, *shape: int) -> npt.NDArray[np.float32]:
        return np.fromfile(folder / f"bench_{name}.f32", dtype=np.float32).reshape(shape)

    local = frames()
    at = np.ascontiguousarray(local[:, :, 2])
    rows, T = read("pm", SIDE, SIDE, 1, TERMS), read("Tt", V, TERMS, TERMS)
    matrices, weights = read("A11", V, 121, 1, TERMS), read("W50", V, STORED)[:, :25]
    components = read("Ak50", STORED, 121, 1, TERMS)[:25]
    makers: dict[str, Callable[[], Any]] = {
        "a0: T, then a stored rotation": lambda: Projection(at, local, rows, T),
        "a1: T rotated beforehand": lambda: Projection(at, local, rows, T, prerotated=True),
        "b: 7 x 7 tents": lambda: Tents(at, local, read("A7", V, 49, 1, TERMS)),
        "c: 11 x 11 tents": lambda: Tents(at, local, matrices),
        "c: the same, halves": lambda: Tents(at, local, matrices.astype(np.float16)),
        "d: PCA, K = 10": lambda: Compressed(at, local, weights, components, K=10),
        "e: PCA, K = 25": lambda: Compressed(at, local, weights, components, K=25),
    }
    return {work: _median(make()) for work, make in makers.items()}


def _median(lighting: Any) -> float:
    """Milliseconds a frame."""
    out = np.empty((V, 3), dtype=np.float32)
    taken: list[float] = []
    end = time.perf_counter() + SECONDS
    while len(taken) < 10 or time.perf_counter() < end:
        angle = 0.13 * len(taken)
        light = 0.2 * np.sin(1.7 * np.arange(TERMS)[:, None] + 0.9 * np.arange(3) + 0.05 * len(taken))
        eye = np.array([3 * np.cos(angle), 0.5, 3 * np.sin(angle)])
        start = time.perf_counter()
        lighting.radiance(light, eye=eye, out=out)
        taken.append(1e3 * (time.perf_counter() - start))
    return median(taken[2:])


# ---- The comparison


def compare(limit: float = 120.0) -> list[dict[str, Any]]:
    """Return a row for each method, milliseconds: the study first and last, ours between.

    Parameters
    ----------
    limit : float
        Seconds that one run of the study may take.
    """
    program = build()
    study: list[dict[int, Times]] = []
    own: list[dict[int, Times]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_object(folder)
        for turn in range(TURNS + 1):
            done = subprocess.run(
                [str(program)], cwd=folder, capture_output=True, text=True, check=True, timeout=limit
            )
            study.append(parsed(done.stdout))
            if turn < TURNS:
                script = Path(__file__).name
                own.append({threads: found_by(script, name, threads=threads) for threads in (1, 2)})

    def middle(runs: list[dict[int, Times]], threads: int, work: str) -> float:
        return median(run[threads][work] for run in runs)

    rows = []
    for work in WORK:
        row: dict[str, Any] = {"work": work}
        for threads in (1, 2):
            row[f"study {threads}"] = middle(study, threads, work)
            row[f"ours {threads}"] = middle(own, threads, work)
            row[f"ratio {threads}"] = row[f"ours {threads}"] / row[f"study {threads}"]
        row["gain of the second thread"] = row["ours 1"] / row["ours 2"]
        rows.append(row)
    return rows


if __name__ == "__main__":
    json.dump(ours(Path(sys.argv[1])) if sys.argv[1:] else compare(), sys.stdout, indent=1)
    print()
