"""Material to rho_lpq."""

from collections.abc import Callable
from typing import Any

import pytest
from shrm import brdf
from shrm.frequency.analysis import analyse
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]


@pytest.mark.benchmark(group="BRDF analysis")
@pytest.mark.parametrize(("L", "P"), [(12, 2), (30, 3), (60, 8)])
def bench_brdf_analysis(measured: Measured, L: int, P: int) -> None:
    lobe = brdf.GGX(0.2).lobes[0]
    fine = analyse(lobe, max(L, 61), 8).coefficients(L, P)
    measured(
        lambda: analyse.__wrapped__(lobe, L, P),  # not the one that is kept
        lambda found: relative_rms(found.coefficients(L, P), fine),
        f"GGX .2, L = {L}, P = {P}",
    )
