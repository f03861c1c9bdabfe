"""One kernel for a few seconds, for a profiler to look at.

    OMP_NUM_THREADS=1 perf record -e cpu-clock -o build/perf.data .venv/bin/python bench/kernel.py analysis
    perf report -i build/perf.data --stdio --no-children | head -30
    perf annotate -i build/perf.data --stdio | less

Kernels: analysis, synthesis, cube, view, half. What is printed, as JSON, is the best time of a call and what
share of the machine's limit it reaches.
"""

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import counts
import numpy as np
from counts import Work
from inputs import coefficients, texels
from limits import least_seconds, limits
from shrm import _core, sh
from shrm.frequency.rings import BORDER, empty_halves
from shrm.threads import thread_count

SECONDS = 3.0
H, N, F, P = 512, 64, 30, 3
MAPS = (P + 1) ** 2


def analysis() -> tuple[Callable[[], Any], Work]:
    plan, pixels, out = sh.Plan((H, 2 * H), F), texels((H, 2 * H, 3)), np.empty((sh.basis_size(F), 3))
    return lambda: plan.analysis(pixels, out=out), counts.analysis(H, 2 * H, F)


def synthesis() -> tuple[Callable[[], Any], Work]:
    plan = _core.Synthesis(H=128, W=256, channels=3 * MAPS, F=F + P)
    c, rings = coefficients(F + P, 3 * MAPS), np.empty((128, 3 * MAPS, 256), dtype=np.float32)
    return lambda: plan.run(c, rings), counts.synthesis(128, 256, 3 * MAPS, F + P)


def cube() -> tuple[Callable[[], Any], Work]:
    plan = _core.CubeSynthesis(N=N, channels=3 * MAPS, F=F + P)
    side = N + 2 * BORDER
    c, rings = coefficients(F + P, 3 * MAPS), np.empty((6 * side, 3 * MAPS, side), dtype=np.float32)
    return lambda: plan.run(c, rings), counts.cube_synthesis(N, 3 * MAPS, F + P)


def view(half: bool = False) -> tuple[Callable[[], Any], Work]:
    side = N + 2 * BORDER
    rings = texels((6 * side, MAPS, 3, side))
    if half:
        floats, rings = rings, empty_halves(rings.shape, "cube")
        _core.to_half(floats, rings)
    direction, pixels = np.array([[0.48, 0.6, 0.64]]), np.empty((6, N, N, 3), dtype=np.float32)

    def call() -> None:
        _core.view_map(rings=rings, cube=True, zonal=False, direction=direction, pixels=pixels)

    return call, counts.view(MAPS, N, half)


KERNELS = {
    "analysis": analysis,
    "synthesis": synthesis,
    "cube": cube,
    "view": view,
    "half": lambda: view(half=True),
}


def main() -> int:
    if sys.argv[1:2] == [] or sys.argv[1] not in KERNELS:
        print(f"usage: python bench/kernel.py {'|'.join(KERNELS)}", file=sys.stderr)
        return 2
    call, work = KERNELS[sys.argv[1]]()
    best, end = float("inf"), time.perf_counter() + SECONDS
    while time.perf_counter() < end:
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
    least, bound = least_seconds(work, limits(thread_count()))
    found = {
        "work": sys.argv[1],
        "ms": 1e3 * best,
        "GFLOP/s": 1e-9 * work.flops / best,
        "GB/s": 1e-9 * work.bytes / best,
        "share": least / best,
        "bound": bound,
    }
    print(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
