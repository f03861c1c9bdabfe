"""From a mesh and a material to an object with transfer: the time of each stage, and the most memory."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from processes import found_by
from shrm.threads import thread_count

MESH = Path(__file__).resolve().parents[2] / "shared" / "data" / "mesh" / "armadillo.obj"

OBJECTS = (
    ("lambert:0.8", "shadowed"),
    ("ashikhmin-shirley:nu=40,nv=10", "shadowed"),
    ("ashikhmin-shirley:nu=40,nv=40", "shadowed"),
    ("ashikhmin-shirley:nu=40,nv=10", "interreflected"),
)


@pytest.mark.benchmark(group="transfer precomputation")
def bench_transfer_precompute(noted: Callable[[Callable[[], list[dict[str, Any]]]], None]) -> None:
    """The armadillo with 50,000 vertices, 4096 directions, an accuracy of 24 dB."""
    if not MESH.exists():
        pytest.skip("needs ../shared/data/mesh/armadillo.obj")
    noted(
        lambda: [
            found_by("precompute_transfer.py", str(MESH), *one, threads=thread_count()) for one in OBJECTS
        ]
    )
