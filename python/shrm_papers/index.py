"""The page that joins all results: what they were made from, on which machine, then each with its picture."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from pathlib import Path

import shrm
from shrm.files import write_bytes

from shrm_papers.result import Result, Settings


def write_index(folder: Path, settings: Settings, results: Sequence[Result]) -> Path:
    """Write `index.md` into the folder that holds the results' files; return its path."""
    H, W, _ = settings.env.pixels.shape
    lines = [
        "# Frequency Space Environment Map Rendering, made again",
        "",
        "Columns and marks called [RH02], [KVHS00] (A Unified Approach to Prefiltered Environment Maps) or "
        "[LK03] (Matrix Radiance Transfer) are the papers' own figures; all others were computed in this "
        "run.",
        "",
        f"- Environment: {settings.env_name}, {W} x {H} as lat-long",
        f"- Fits to measured materials: {'none' if settings.fits is None else settings.fits.name}",
        f"- Machine: {machine()}, {threads()} threads",
        f"- shrm {shrm.__version__}" + (", quick: fewer rows and samples" if settings.quick else ""),
        "",
    ]
    path = folder / "index.md"
    text = "\n".join(lines) + "".join("\n" + result.markdown(level=2) for result in results)
    write_bytes(path, text.encode())
    return path


def machine() -> str:
    """Return the processor's name."""
    cpuinfo = Path("/proc/cpuinfo")
    for line in cpuinfo.read_text().splitlines() if cpuinfo.exists() else []:
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def threads() -> int:
    """Return how many threads the core runs: as many as OpenMP is told, else as this process may use."""
    told = os.environ.get("OMP_NUM_THREADS", "").split(",")[0]
    if told.isdigit() and int(told) > 0:
        return int(told)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
