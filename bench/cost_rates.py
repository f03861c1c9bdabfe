"""Measure the rates that `shrm.cheapest` predicts times with, and write their table.

    OMP_NUM_THREADS=1 python bench/cost_rates.py "2 cores of AMD Zen 4" > python/shrm/methods/rates.csv

The machine has to be quiet. Each rate is the least time of some calls, divided by what it is per; rates that
grow with the degree are fitted at two degrees.
"""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from shrm import Environment, _core, brdf, prefilter, prefilter_angular, prefilter_hierarchical
from shrm.frequency.prefilter import prefilter as prefilter_in_frequency
from shrm.integrate.angular_lobes import share_visited
from shrm.methods import cost

VIEW = [0.48, 0.6, 0.64]
LOBES = {"radial": brdf.Phong(64), "zonal": brdf.KajiyaKay(32), "isotropic": brdf.GGX(0.3)}
MAP_SIZE = 64


def least(call: Callable[[], object], rounds: int = 5) -> float:
    """The least seconds of some calls."""
    seconds = []
    for _ in range(rounds):
        start = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def line(x: tuple[float, float], y: tuple[float, float]) -> tuple[float, float]:
    """What a line is at 0, at least 0, and its slope."""
    slope = (y[1] - y[0]) / (x[1] - x[0])
    return max(y[0] - slope * x[0], 0.0), slope


def frequency_rates() -> dict[str, float]:
    light = Environment.daylight(size=256)
    texels = light.pixels.size / 3
    degrees = (16.0, 64.0)
    analysis = line(
        degrees,
        tuple(least(lambda F=F: Environment(light.pixels).coefficients(int(F))) / texels for F in degrees),
    )
    synthesis, cube = [], 0.0
    for F in degrees:
        part = prefilter_in_frequency(light, brdf.Phong(64), orders=(int(F), 0), size=8).parts[0]
        synthesis.append(least(lambda part=part: part.resized(256, "latlong")) / (3 * 256 * 512))
        cube = least(lambda part=part: part.resized(128, "cube")) / (3 * 6 * 128**2 * (F + 1) ** 2)
    by_degree = line(degrees, (synthesis[0], synthesis[1]))
    tiny = Environment.daylight(size=8)
    rm = prefilter(light, brdf.GGX(0.3), orders=(16, 4), size=256)
    out = np.empty((256, 512, 3), np.float32)
    up = np.random.default_rng(0).normal(size=(10**5, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    looked_up = []
    for P in (0, 4):
        maps = prefilter(light, brdf.GGX(0.3), orders=(16, P), size=128)
        looked_up.append(least(lambda maps=maps: maps.radiance(up, up)) / len(up))
    by_value = line((3.0, 75.0), (looked_up[0], looked_up[1]))
    return {
        "call": least(lambda: prefilter(tiny, brdf.Phong(8), orders=(1, 0), size=2)),
        "analysis": analysis[0],
        "analysis by degree": analysis[1],
        "synthesis": by_degree[0],
        "synthesis by degree": by_degree[1],
        "synthesis of cubes": cube,
        "view": least(lambda: rm.at_view(VIEW, out)) / (25 * out.size),
        "point": by_value[0],
        "point by value": by_value[1],
    }


def angular_rates() -> dict[str, float]:
    light, result = Environment.daylight(size=128), {}
    texels, map_texels = light.pixels.size / 3, 2 * MAP_SIZE**2
    for kind, material in LOBES.items():

        def prepare(symmetry: bool = False, material: brdf.BRDF = material):
            return prefilter_angular(
                light, material, cutoff=0.02, size=MAP_SIZE, subsamples=2, symmetry=symmetry
            )

        table = least(prepare, 2)
        pairs = map_texels * texels * share_visited(material.lobes[0], 0.02)
        result[f"table {kind}"] = table
        result[f"pair {kind}"] = max(least(lambda: prepare().maps_at_view(VIEW), 2) - table, 0) / pairs
        if kind == "radial":
            seconds = least(lambda: prepare(True).maps_at_view(VIEW), 2) - table
            result["pair by symmetry"] = max(seconds, 0) / pairs
    tiny = prefilter_angular(
        Environment.daylight(size=2), LOBES["isotropic"], cutoff=0.5, size=128, subsamples=1
    )
    result["query"] = least(lambda: tiny.maps_at_view(VIEW)) / (2 * 128**2)
    return result


def hierarchical_rates() -> dict[str, float]:
    light = Environment.daylight(size=256)
    result = {"pyramid": least(lambda: _core.Pyramid(light.pixels)) / (light.pixels.size / 3)}
    for kind, material in LOBES.items():
        descent = prefilter_hierarchical(light, material, tolerance=0.02, size=MAP_SIZE)
        result[f"descent {kind}"] = least(lambda d=descent: d.maps_at_view(VIEW), 3) / (2 * MAP_SIZE**2)
    return result


def main(machine: str) -> None:
    """Print the table, its rows as those of the present one."""
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    )
    measured = frequency_rates() | angular_rates() | hierarchical_rates()
    lines = (Path(cost.__file__).parent / "rates.csv").read_text().splitlines()
    print(
        f"# Seconds of one thread on {machine}, as measured for commit {commit.stdout.strip()};"
        " bench/cost_rates.py measures them anew."
    )
    print(lines[1])
    assert set(measured) == set(cost.rates())
    for row in lines[2:]:
        name, _, per = row.split(",", 2)
        print(f"{name},{measured[name]:.2g},{per}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "a machine not named")
