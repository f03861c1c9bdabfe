"""All ways to light an object with transfer side by side: what each takes and loses [LK03 table 1]."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
from shrm.render import Mesh
from shrm.reproduce.lk_table_1 import PAPER
from shrm.reproduce.transfer_methods import compare
from shrm.reproduce.transfer_subject import DIRECTIONS, Subject

MESH = Path(__file__).resolve().parents[2] / "shared" / "data" / "mesh" / "armadillo.obj"


@pytest.mark.benchmark(group="transfer methods")
def bench_transfer_methods(noted: Callable[[Callable[[], list[dict[str, Any]]]], None]) -> None:
    """The armadillo, glossy, shadowed and not; rays, precomputation and judging included in the time."""
    if not MESH.exists():
        pytest.skip("needs ../shared/data/mesh/armadillo.obj")

    def compared() -> list[dict[str, Any]]:
        subject = Subject(Mesh.read(MESH).placed(radius=1.0), "armadillo", DIRECTIONS)
        return [
            {**asdict(one), "paper": theirs and theirs[not one.shadowed]}
            for one in compare(subject)
            for theirs in [PAPER.get(one.method)]
        ]

    noted(compared)
