"""Lighting an object, with one thread and with two, in turns with a hand-written timing study.

    python bench/beside_transfer_prototype.py          # the comparison, as JSON; takes three minutes and 2 GB

The study, ../shared/prototypes/mrt_runtime_prototype.cpp, is a C++ program for one order of light, two
numbers of tents and this very processor, that stands beside the project and is no part of it. Where it is, it
is compiled with its sweep narrowed, and the medians that it prints are read: of its ways to do a thing the
fastest, with large pages of memory and without. It is made to measure as object_lighting.py does: CPU time
with one thread.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import Any

from limits import BUILD, ROOT, compiled, least_seconds, limits
from object_lighting import SECONDS, WAYS, write_object
from processes import BOUND, found_by

SOURCE = ROOT.parent / "shared" / "prototypes" / "mrt_runtime_prototype.cpp"
TURNS = 3
THREADS = (1, 2)

# The study's clock, and the one it gets
WALL = "return chrono::duration<double>(chrono::steady_clock::now().time_since_epoch()).count();"
CPU_OF_ONE = """
    timespec t;
    clock_gettime(omp_get_max_threads() == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
"""

# Our ways, and the study's for the same
SAME = {
    "a: projection, T and a stored rotation": ("a0 Kautz T,then R",),
    "a: projection, T rotated beforehand": ("a1 Kautz prerotated",),
    "b: 7 x 7 tents": ("b 7x7 f32 prefetch", "b 7x7 f32"),
    "7 x 7 tents, halves": ("b 7x7 f16 prefetch", "b 7x7 f16"),
    "c: 11 x 11 tents": ("c 11x11 f32 prefetch", "c 11x11 f32"),
    "11 x 11 tents, halves": ("c 11x11 f16 prefetch", "c 11x11 f16"),
    "d: PCA, K = 10": ("d PCA11 K=10 avx512", "d PCA11 K=10 eq13 autovec"),
    "K = 10, half weights": ("  PCA11 K=10 avx512 w f16",),
    "e: PCA, K = 25": ("e PCA11 K=25 avx512", "e PCA11 K=25 eq13 autovec"),
    "K = 25, half weights": ("  PCA11 K=25 avx512 w f16",),
}

Times = dict[str, float]  # milliseconds by way


def build() -> Path:
    """Compile the study with its sweep narrowed; what cannot be narrowed it runs whole."""
    text = SOURCE.read_text()
    for sweep, wanted in {
        "for(int th=1;th<=2;th++)": "for(int th=1;th<=0;th++)",
        "for(int th:{2})": "for(int th:{1,2})",
        "for(int K:{10,25,50})": "for(int K:{10,25})",
        "now()-t0<0.8": f"now()-t0<{SECONDS}",
        WALL: CPU_OF_ONE,
    }.items():
        text = text.replace(sweep, wanted)
    BUILD.mkdir(exist_ok=True)
    narrowed = BUILD / "mrt_runtime_prototype.cpp"
    narrowed.write_text(text)
    return compiled(narrowed, "mrt_runtime_prototype", "-Ofast", "-w")


def study(program: Path, folder: Path) -> dict[int, Times]:
    """Run it, and return its medians by threads."""
    printed = ""
    for pages in ({}, {"HUGE": "1"}):
        done = subprocess.run(
            [str(program)],
            cwd=folder,
            env={**os.environ, **BOUND, **pages},
            capture_output=True,
            text=True,
            check=True,
        )
        printed += done.stdout
    times: dict[tuple[int, str], float] = {}
    for name, threads, ms in re.findall(r"^(.+?) +thr (\d) moving .*?median (\S+) ms", printed, re.M):
        way = int(threads), name
        times[way] = min(float(ms), times.get(way, float("inf")))
    return {
        threads: {way: min(times[threads, name] for name in names) for way, names in SAME.items()}
        for threads in THREADS
    }


def compare() -> list[dict[str, Any]]:
    """Return a row for each way, milliseconds: the study first and last, ours between."""
    program = build() if SOURCE.exists() else None
    theirs: list[dict[int, Times]] = []
    own: list[dict[int, dict[str, Any]]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_object(folder)
        for turn in range(TURNS + 1):
            if program:
                theirs.append(study(program, folder))
            if turn < TURNS:
                own.append({k: found_by("object_lighting.py", name, threads=k, **BOUND) for k in THREADS})

    rows = []
    for way, known in WAYS.items():
        row: dict[str, Any] = {"work": way, "error": own[0][1][way]["error"]}
        for threads in THREADS:
            ms = median(run[threads][way]["ms"] for run in own)
            least, bound = least_seconds(known.work, limits(threads))
            row |= {f"ours {threads}": ms, f"share {threads}": 1e3 * least / ms, f"bound {threads}": bound}
            if program and way in SAME:
                row[f"study {threads}"] = median(run[threads][way] for run in theirs)
                row[f"ratio {threads}"] = ms / row[f"study {threads}"]
        rows.append(row)
    return rows


if __name__ == "__main__":
    json.dump(compare(), sys.stdout, indent=1)
    print()
