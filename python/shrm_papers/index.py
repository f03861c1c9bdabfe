"""The page that joins all results: what they were made from, on which machine, then each with its picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import shrm
from shrm.files import write_bytes
from shrm.threads import thread_count

from shrm_papers.machine import processor
from shrm_papers.result import Result, Settings


def write_index(folder: Path, settings: Settings, results: Sequence[Result]) -> Path:
    """Write `index.md` into the folder that holds the results' files; return its path."""
    H, W, _ = settings.env.pixels.shape
    lines = [
        "# Tables and figures of [RH02], [KVHS00] and [LK03], made again",
        "",
        "Columns and marks called [RH02] (Frequency Space Environment Map Rendering), [KVHS00] (A Unified "
        "Approach to Prefiltered Environment Maps) or [LK03] (Matrix Radiance Transfer) are the papers' own "
        "numbers; all others were computed in this run.",
        "",
        f"- Environment: {settings.env_name}, {W} x {H} as lat-long",
        f"- Fits to measured materials: {'none' if settings.fits is None else settings.fits.name}",
        f"- Machine: {processor()}, {thread_count()} threads",
        f"- shrm {shrm.__version__}" + (", quick: fewer rows and samples" if settings.quick else ""),
        "",
    ]
    path = folder / "index.md"
    text = "\n".join(lines) + "".join("\n" + result.markdown(level=2) for result in results)
    write_bytes(path, text.encode())
    return path
