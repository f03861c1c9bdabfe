"""Measured materials: reading and preparing their files, prefiltering, and errors beside the predicted."""

import time
import warnings
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pytest
from inputs import FloatArray
from processes import found_by
from shrm import Environment, ImageWarning, ToleranceWarning, brdf, prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.threads import thread_count
from support import oracles, sharp_oracle  # the judges of the tests

Row = dict[str, Any]
Noted = Callable[[Callable[[], list[Row]]], None]

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
ENVIRONMENTS = {
    "Grace": "debevec_grace_cross.hdr",
    "Uffizi": "spica_uffizi.hdr",
    "Venice": "venice_sunset_1k.hdr",
}
FILES = ("*.bsdf", "*.brdf", "*.binary", "*.alta")
ROWS = 64
TOLERANCE = 0.05
FRAMES = 2000
ANALYTIC = brdf.GGX(0.3, (1.0, 0.71, 0.29))


@pytest.mark.benchmark(group="measured")
def bench_measured_materials(noted: Noted) -> None:
    """Each real file under three lights."""
    files = sorted(path for pattern in FILES for path in (DATA / "brdf").glob(pattern))
    if not files:
        pytest.skip("needs ../shared/data/brdf")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", (ImageWarning, ToleranceWarning))
        lights = {
            name: Environment.read(DATA / "env" / file).resized((ROWS, 2 * ROWS))
            for name, file in ENVIRONMENTS.items()
        }
        noted(lambda: [row(file, lights) for file in files])


def row(file: Path, lights: dict[str, Environment]) -> Row:
    """One file: its preparation in a process of its own, and its errors here."""
    material = brdf.load(file)
    found = {name: under(env, material) for name, env in lights.items()}
    return {
        "material": material.name,
        **found_by("prepare_measured.py", str(file), threads=thread_count()),
        "lights": found,
    }


def under(env: Environment, material: brdf.Measured) -> Row:
    """Prefilter by tolerance, and again at those orders beside an analytic material; integrate."""
    rm = prefilter(env, material, tolerance=TOLERANCE)
    asked = {"orders": (rm.F, rm.P), "size": rm.size}
    seconds = {
        name: typical(lambda one=one: prefilter(env, one, **asked))  # type: ignore[misc]
        for name, one in (("seconds", material), ("analytic", ANALYTIC))
    }
    return {
        "F": rm.F,
        "P": rm.P,
        "predicted": rm.error,
        "measured": measured_error(rm, env, material),
        **seconds,
    }


def measured_error(rm: ReflectionMap, env: Environment, material: brdf.Measured) -> float:
    """Relative RMS error against a float64 integral, over frames of every orientation."""

    def transfer(wi: FloatArray, wo: FloatArray) -> FloatArray:
        return material.function(wi, np.broadcast_to(wo, wi.shape))

    N, V, weights = oracles.important_views(env.pixels, FRAMES, seed=1)
    expected = sharp_oracle.reflected(env.pixels, transfer, N, V)
    return float(oracles.relative_rms(rm.radiance(N, V), expected, weights))


def typical(call: Callable[[], Any], rounds: int = 7) -> float:
    """Return the median time of a call, after one that is not counted."""
    call()
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return median(times)
