"""Direct integration against the most that its own instructions allow: samples per second, and of what peak.

`angular_peak.cpp` runs the innermost loops of the core, the same source, on rows that stay in the first
cache.
"""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from inputs import frames
from shrm import Environment, brdf
from shrm.environment.layouts import directions
from shrm.integrate.angular import AngularReflection, integrate, prefilter_angular
from shrm.integrate.angular_lobes import IsotropicIntegral
from shrm.threads import thread_count
from shrm_papers.errors import relative_rms
from shrm_papers.rh02.flops import (
    FLOPS_OF_SUM,
    FLOPS_OF_WEIGHT,
    half_angle_flops,
    outer_angle,
    samples,
    samples_in_caps,
)

Measured = Callable[..., Any]

HERE = Path(__file__).resolve().parent
OPTIONS = ["-std=c++20", "-O3", "-march=native", "-mprefer-vector-width=512", "-ffp-contract=fast"]
VIEW = [0.6, 0.0, 0.8]


class Peak(NamedTuple):
    """Samples per second of the loops and operations per second of multiply-adds alone, on one core.

    The loops are those of radial lobes and of lobes of the half angle, half vectors computed or tabulated.
    """

    radial: float
    computed: float
    tabulated: float
    multiply_adds: float


@pytest.fixture(scope="module")
def peak(tmp_path_factory: pytest.TempPathFactory) -> Peak:
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("there is no g++ to build angular_peak.cpp with")
    program = tmp_path_factory.mktemp("peak") / "angular_peak"
    source = [f"-I{HERE.parent / 'cpp'}", str(HERE / "angular_peak.cpp"), "-o", str(program)]
    subprocess.run([compiler, *OPTIONS, "-fno-math-errno", *source], check=True)
    done = subprocess.run([program], capture_output=True, text=True, check=True)
    return Peak(*map(float, done.stdout.split()))


def timed(
    benchmark: Any, about: dict[str, Any], prepare: Callable[[], AngularReflection], exact: Any, work: str
) -> float | None:
    """Time `at_view` of what is prepared anew for each round, as a map is made once; the least seconds."""
    found = benchmark.pedantic(lambda r: r.at_view(VIEW), setup=lambda: ((prepare(),), {}), rounds=15)
    benchmark.extra_info.update(about, work=work, error=relative_rms(found, exact))
    return None if benchmark.stats is None else float(benchmark.stats.stats.min)


def state_share(
    benchmark: Any, pairs: float, seconds: float, most: float, operations: float, peak: Peak
) -> None:
    """Say how many samples a second a thread does, of how many that its loop could."""
    rate = pairs / seconds / thread_count()
    benchmark.extra_info.update(
        samples=pairs,
        samples_per_second_and_core=rate,
        share=rate / most,
        bound="its instructions",
        gflops=rate * operations * 1e-9,
        of_multiply_adds=rate * operations / peak.multiply_adds,
    )


@pytest.mark.benchmark(group="angular")
@pytest.mark.parametrize("s", [8, 32, 128, 512])
@pytest.mark.parametrize("symmetry", [False, True], ids=["every-pair", "symmetry"])
def bench_phong_texels(benchmark: Any, about: dict[str, Any], peak: Peak, s: int, symmetry: bool) -> None:
    """[RH02] section 7.4: for every texel of the map, every texel of the environment within the width."""
    env = Environment(Environment.daylight(size=128).pixels)

    def prepared(cutoff: float = 0.05) -> AngularReflection:
        return prefilter_angular(env, brdf.Phong(s), cutoff=cutoff, size=128, subsamples=1, symmetry=symmetry)

    exact = prepared(0.0).at_view(VIEW)
    method = "by symmetry" if symmetry else "every pair"
    work = f"Phong s = {s}, eps = .05, 256 x 128 to the same, {method}"
    seconds = timed(benchmark, about, prepared, exact, work)
    if seconds is None:
        return
    pairs = samples(128, outer_angle(s, 0.05))
    if symmetry:
        benchmark.extra_info.update(samples=pairs)
    else:
        state_share(benchmark, pairs, seconds, peak.radial, FLOPS_OF_WEIGHT + FLOPS_OF_SUM, peak)


@pytest.mark.benchmark(group="angular")
@pytest.mark.parametrize("sigma", [0.1, 0.2, 0.3, 0.4, 0.5])
@pytest.mark.parametrize("symmetry", [False, True], ids=["every-pair", "shared"])
def bench_microfacet_texels(
    benchmark: Any, about: dict[str, Any], peak: Peak, sigma: float, symmetry: bool
) -> None:
    """A map for one view; the lobe's shape changes over it, so that only half vectors can be shared."""
    env, material = Environment(Environment.daylight(size=128).pixels), brdf.Microfacet(sigma)

    def prepared(cutoff: float = 0.05) -> AngularReflection:
        return prefilter_angular(env, material, cutoff=cutoff, size=128, subsamples=1, symmetry=symmetry)

    exact = prepared(0.0).at_view(VIEW)
    method = "half vectors shared" if symmetry else "every pair"
    work = f"microfacet sigma = {sigma}, eps = .05, 256 x 128 to the same, one view, {method}"
    seconds = timed(benchmark, about, prepared, exact, work)
    if seconds is None:
        return
    part = material.lobes[0]
    lobe = IsotropicIntegral.of(part.center, part.transfer, 0.05, symmetry)
    C = directions("latlong", 128, 256).reshape(-1, 3)
    V = np.tile(VIEW, (len(C), 1))
    pairs = len(C) * samples_in_caps(128, *lobe.caps(lobe.normals(C, V), V))
    operations = half_angle_flops(1, tabulated=symmetry)
    state_share(benchmark, pairs, seconds, peak.tabulated if symmetry else peak.computed, operations, peak)


@pytest.mark.benchmark(group="angular")
def bench_queries(measured: Measured) -> None:
    env, material = Environment.daylight(size=64), brdf.GGX(0.3)
    angular = prefilter_angular(env, material, subsamples=2)
    N, V = frames(400)
    few = slice(0, 20)
    exact = integrate(env, material, N[few], V[few], subsamples=4)
    measured(
        lambda: angular.radiance(N, V),
        lambda found: relative_rms(found[few], exact),
        "GGX .3, 400 points, each integrated over 128 x 64 texels",
    )
