"""Our kernels beside those of a timing study, in turns, with one thread and with two.

    python bench/beside_prototype.py          # the comparison, as JSON; takes half a minute

The study, ../shared/prototypes/sht_prototype.cpp, is a C++ program of hand-written kernels that stands beside
the project and is no part of it. It is compiled for this very processor, its sweep narrowed to the sizes that
are compared, and the medians that it prints are read. Ours are measured as it measures itself: the median of
calls for 0.4 seconds, of CPU time with one thread, of wall time with two.
"""

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from inputs import coefficients, texels
from limits import BUILD, ROOT, compiled
from processes import found_by

SOURCE = ROOT.parent / "shared" / "prototypes" / "sht_prototype.cpp"
TURNS = 3
PICTURES = (128, 512, 2048)
ORDERS = (3, 5)
F = 30

Times = dict[str, float]  # milliseconds by kernel


def _analysis(H: int) -> str:
    return f"analysis, {2 * H} x {H}, F = {F}"


def _synthesis(P: int) -> str:
    return f"synthesis, 256 x 128, F = {F}, P = {P}"


def _view(maps: int, stored: str) -> str:
    return f"per view, {maps} {stored} maps, 6 x 64 x 64"


# ---- The study


def build() -> Path:
    """Compile the study with its sweep narrowed; what cannot be narrowed it runs whole."""
    text = SOURCE.read_text()
    for sweep, wanted in {
        "{128,256},{512,1024},{1024,2048},{2048,4096}": "{128,256},{512,1024},{2048,4096}",
        "int F:{12,30,60,100}": "int F:{30}",
        "int S:{64,128}": "int S:{128}",
        "int F:{12,24,30}": "int F:{30}",
        "int P:{0,2,3,5}": "int P:{3,5}",
        "int fs:{64,128}": "int fs:{64}",
    }.items():
        text = text.replace(sweep, wanted)
    BUILD.mkdir(exist_ok=True)
    narrowed = BUILD / "sht_prototype.cpp"
    narrowed.write_text(text)
    return compiled(narrowed, "sht_prototype", "-w")


def parsed(printed: str) -> dict[int, Times]:
    """Return the study's medians, by threads; of its two ways of storing maps the faster."""
    found: dict[int, Times] = {1: {}, 2: {}}
    for H, threads, ms in re.findall(rf"fwd +(\d+)x\d+ +F={F} +(\d)T min +\S+ med +(\S+) ms", printed):
        found[int(threads)][_analysis(int(H))] = float(ms)
    pattern = (
        rf"\[NT stores \S+?/(\S+?)\] syn S=128 F={F} P=(\d) (\d)T: "
        r"coef \S+?/(\S+?) ms, fourier \S+?/(\S+?) ms"
    )
    for streamed, P, threads, coefficient, fourier in re.findall(pattern, printed):
        found[int(threads)][_synthesis(int(P))] = float(coefficient) + min(float(fourier), float(streamed))
    pattern = r"eval n=(\d+) face=64 .*?(\d)T: .*?AoSoA \S+?/(\S+?) ms .*?AoSoA fp16 \S+?/(\S+?) ms"
    for maps, threads, full, half in re.findall(pattern, printed):
        found[int(threads)][_view(int(maps), "float")] = float(full)
        found[int(threads)][_view(int(maps), "half")] = float(half)
    return found


# ---- Ours


def ours() -> Times:
    """Measure with the threads that OpenMP was started with."""
    from shrm import _core, sh
    from shrm.frequency.rings import BORDER, empty_halves

    clock = time.thread_time if os.environ["OMP_NUM_THREADS"] == "1" else time.perf_counter
    found: Times = {}
    for H in PICTURES:
        plan, picture, out = sh.Plan((H, 2 * H), F), texels((H, 2 * H, 3)), np.empty((sh.basis_size(F), 3))
        found[_analysis(H)] = _median(partial(plan.analysis, picture, out=out), clock)
    for P in ORDERS:
        found[_synthesis(P)] = _median(_global_maps(P), clock)
    for P in ORDERS:
        maps, side = (P + 1) ** 2, 64 + 2 * BORDER
        rings = texels((6 * side, maps, 3, side))
        halves = empty_halves(rings.shape, "cube")
        _core.to_half(rings, halves)
        for stored, kept in (("float", rings), ("half", halves)):
            call = partial(
                _core.view_map,
                rings=kept,
                cube=True,
                zonal=False,
                direction=np.array([[0.48, 0.6, 0.64]]),
                pixels=np.empty((6, 64, 64, 3), dtype=np.float32),
            )
            found[_view(maps, stored)] = _median(call, clock)
    return found


def _global_maps(P: int) -> Callable[[], None]:
    """From the light's coefficients to the maps of the global form, about R."""
    from shrm import _core, sh

    H, maps = 128, (P + 1) ** 2
    light = coefficients(F)
    couple = _core.MapCoefficients(F=F, P=P, channels=3, zonal=False)
    couple.set_material(np.random.default_rng(4).random((F + 1, P + 1, P + 1, 3)))
    synthesis = _core.Synthesis(H=H, W=2 * H, channels=3 * maps, F=F + P)
    product = np.empty((sh.basis_size(F + P), maps, 3))
    rings = np.empty((H, 3 * maps, 2 * H), dtype=np.float32)

    def run() -> None:
        couple.run(light, product)
        synthesis.run(product.reshape(len(product), -1), rings)

    return run


def _median(call: Callable[[], Any], clock: Callable[[], float]) -> float:
    """Milliseconds: calls for 0.4 seconds, at least 5 and at most 300, after one that does not count."""
    call()
    taken: list[float] = []
    end = time.perf_counter() + 0.4
    while len(taken) < 5 or (time.perf_counter() < end and len(taken) < 300):
        start = clock()
        call()
        taken.append(1e3 * (clock() - start))
    return median(taken)


# ---- The comparison


def compare(limit: float = 120.0) -> list[dict[str, Any]]:
    """Return a row for each kernel, milliseconds: the study first and last, ours between, thrice.

    Parameters
    ----------
    limit : float
        Seconds that one run of the study may take.
    """
    program = build()
    study: list[dict[int, Times]] = []
    own: list[dict[int, Times]] = []
    for turn in range(TURNS + 1):
        done = subprocess.run([str(program)], capture_output=True, text=True, check=True, timeout=limit)
        study.append(parsed(done.stdout))
        if turn < TURNS:
            own.append(
                {threads: found_by("beside_prototype.py", "ours", threads=threads) for threads in (1, 2)}
            )

    def middle(runs: list[dict[int, Times]], threads: int, work: str) -> float:
        return median(run[threads][work] for run in runs)

    rows = []
    for work in own[0][1]:
        row: dict[str, Any] = {"work": work}
        for threads in (1, 2):
            row[f"study {threads}"] = middle(study, threads, work)
            row[f"ours {threads}"] = middle(own, threads, work)
            row[f"ratio {threads}"] = row[f"ours {threads}"] / row[f"study {threads}"]
        row["gain of the second thread"] = row["ours 1"] / row["ours 2"]
        rows.append(row)
    return rows


if __name__ == "__main__":
    json.dump(ours() if sys.argv[1:] == ["ours"] else compare(), sys.stdout, indent=1)
    print()
