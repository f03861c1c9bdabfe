"""All ways to light an object with transfer side by side: what each takes and loses [LK03 table 1]."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from processes import BOUND, found_by
from shrm.threads import thread_count

MESH = Path(__file__).resolve().parents[2] / "shared" / "data" / "mesh" / "armadillo.obj"


@pytest.mark.benchmark(group="transfer methods")
def bench_transfer_methods(noted: Callable[[Callable[[], list[dict[str, Any]]]], None]) -> None:
    """The armadillo, glossy, shadowed and not; rays, precomputation and judging included in the time."""
    if not MESH.exists():
        pytest.skip("needs ../shared/data/mesh/armadillo.obj")
    noted(lambda: found_by("transfer_methods.py", str(MESH), threads=thread_count(), **BOUND))
