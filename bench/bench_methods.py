"""All ways to prefilter side by side: what each keeps, costs and loses; and which integrator to take."""

import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from inputs import frames
from shrm import (
    Environment,
    ToleranceWarning,
    brdf,
    cheapest,
    prefilter,
    prefilter_angular,
    prefilter_hierarchical,
)
from shrm.frequency.reflection_map import ReflectionMap
from shrm.integrate.angular import integrate
from shrm.prefiltered import Anisotropic, Cabral, Diffuse, KautzMcCool2D, KautzMcCool3D, Phong
from shrm.prefiltered import prefilter as prefilter_explicit
from shrm.viewer import Context, ContextError, HardwarePrefilter, offscreen
from shrm_papers.errors import relative_rms

Noted = Callable[[Callable[[], list[dict[str, Any]]]], None]
Row = dict[str, Any]

LIGHT = Path(__file__).resolve().parents[2] / "shared" / "data" / "env" / "debevec_grace_cross.hdr"
N, V = frames(1500)
T = N[::-1]
MATT, PLASTIC = brdf.Lambert(0.8), brdf.Phong(50)
GOLD = brdf.GGX(0.2, (1.0, 0.71, 0.29))
BRUSHED = brdf.Banks(0.8)
ERROR = 0.01
TOLERANCE = 0.03
CLAMP = 0.02  # of the two passes, as in the window: less of the long tail is cut than by a tenth


@pytest.fixture(scope="module")
def env() -> Environment:
    if not LIGHT.exists():
        pytest.skip("needs ../shared/data/env/debevec_grace_cross.hdr")
    return Environment.read(LIGHT)


@pytest.fixture(scope="module")
def context() -> Iterator[Context | None]:
    try:
        made = offscreen()
    except ContextError:
        yield None
        return
    yield made
    made.release()


class Entry(NamedTuple):
    """A row of the table of methods."""

    method: str
    keeps: str
    material: brdf.BRDF
    make: Callable[..., Any]
    when: str


ENTRIES = (
    Entry("diffuse (Miller)", Diffuse.keeps, MATT, Diffuse.prefilter, "matt surfaces"),
    Entry("Phong (Miller, Heidrich)", Phong.keeps, PLASTIC, Phong.prefilter, "lobes of one shape"),
    Entry(
        "Phong lobe with Fresnel factors (Miller, Heidrich)",
        KautzMcCool2D.keeps,
        GOLD,
        lambda light, material: prefilter_explicit(
            light, material, technique="miller-heidrich", tolerance=ERROR
        ),
        "the least memory, any shader",
    ),
    Entry(
        "Kautz & McCool, 2D",
        KautzMcCool2D.keeps,
        GOLD,
        KautzMcCool2D.prefilter,
        "the same, nearer to the lobe",
    ),
    Entry(
        "Kautz & McCool, 2D, 3 lobes",
        KautzMcCool2D.keeps,
        GOLD,
        lambda light, material: KautzMcCool2D.prefilter(light, material, lobes=3),
        "round lobes that change their shape",
    ),
    Entry("Kautz & McCool, 3D", KautzMcCool3D.keeps, GOLD, KautzMcCool3D.prefilter, "round lobes, exactly"),
    Entry("12 views (Cabral)", Cabral.keeps, GOLD, Cabral.prefilter, "a few fixed views"),
    Entry(
        "SHRM (Ramamoorthi & Hanrahan)",
        "(r_v, v), to degrees F, P",
        GOLD,
        lambda light, material: prefilter(light, material, tolerance=TOLERANCE),
        "an error that is asked for; changing light",
    ),
    Entry(
        "anisotropic (Kautz et al.)", Anisotropic.keeps, BRUSHED, Anisotropic.prefilter, "hair, brushed metal"
    ),
)


@pytest.mark.benchmark(group="methods")
def bench_methods(noted: Noted, env: Environment, context: Context | None) -> None:
    """Each class of `shrm.prefiltered`, hierarchically at 1%, the SHRM, and what OpenGL filters."""
    light = env.resized((128, 256))

    def row(entry: Entry, make: Callable[[], Any]) -> Row:
        found, seconds = timed(make)
        layers, size = held(found)
        exact = integrate(light, entry.material, N, V, T)
        return {
            "method": entry.method,
            "keeps": entry.keeps,
            "material": entry.material.name,
            "layers": layers,
            "bytes": size,
            "seconds": seconds,
            "error": relative_rms(found.radiance(N, V, T), exact),
            "when": entry.when,
        }

    def on_the_gpu(gpu: Context, filter: Any, when: str) -> Row:
        entry = Entry(f"GPU, {filter} (Kautz et al.)", KautzMcCool2D.keeps, GOLD, HardwarePrefilter, when)
        with HardwarePrefilter(GOLD, size=256, filter=filter, clamp=CLAMP, context=gpu) as hardware:

            def filtered() -> HardwarePrefilter:
                hardware.update(light)
                gpu.gl.finish()
                return hardware

            return row(entry, filtered)

    def compared() -> list[Row]:
        rows = [row(entry, lambda entry=entry: entry.make(light, entry.material)) for entry in ENTRIES]  # type: ignore[misc]
        if context is not None:
            rows.append(on_the_gpu(context, "two-pass", "a light that changes every frame"))
            rows.append(on_the_gpu(context, "exact", "the same, nearer, on a fast card"))
        return rows

    noted(compared)


@pytest.mark.benchmark(group="crossover")
def bench_crossover(noted: Noted, env: Environment) -> None:
    """From light and material to a map for one view at 3%, by each method, and which `auto` takes."""

    def compared() -> list[Row]:
        rows = []
        for H in (128, 256):
            light = env.resized((H, 2 * H))
            for alpha in (0.05, 0.1, 0.2, 0.4):
                rows.append(crossing(light, brdf.GGX(alpha)))
        return rows

    noted(compared)


def crossing(light: Environment, material: brdf.GGX) -> Row:
    """Seconds of each method, and its error at some normals under that view."""
    view = [0.48, 0.6, 0.64]
    makers: dict[str, Callable[[], Any]] = {
        "frequency": lambda: prefilter(light, material, tolerance=TOLERANCE, size=64),
        "angular": lambda: prefilter_angular(light, material, tolerance=TOLERANCE, size=64),
        "hierarchical": lambda: prefilter_hierarchical(light, material, tolerance=TOLERANCE, size=64),
    }
    made: dict[str, tuple[Any, float, float]] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ToleranceWarning)
        for name, make in makers.items():
            found, seconds = timed(make)
            _, again = timed(lambda of=found: of.maps_at_view(view))  # type: ignore[misc]
            made[name] = found, seconds + again, again
        orders = makers["frequency"]()
    n = N[N @ view > 0.05][:200]
    v = np.broadcast_to(view, n.shape)
    exact = prefilter_angular(light, material, subsamples=1).radiance(n, v)
    return {
        "light": "{1} x {0}".format(*light.pixels.shape),
        "alpha": material.alpha,
        "orders": f"{orders.F}, {orders.P}",
        "auto": cheapest(light, material, tolerance=TOLERANCE, size=64),
        **{
            name: {"seconds": first, "view": again, "error": relative_rms(found.radiance(n, v), exact)}
            for name, (found, first, again) in made.items()
        },
    }


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """What a call returns, and the shortest time of those that half a second holds."""
    best, begun = np.inf, time.perf_counter()
    while True:
        start = time.perf_counter()
        found = call()
        best = min(best, time.perf_counter() - start)
        if time.perf_counter() - begun > 0.5:
            return found, float(best)


def held(found: Any) -> tuple[int, int]:
    """Number of maps, and their bytes."""
    if isinstance(found, HardwarePrefilter):
        maps = found.maps().maps
        return len(maps), sum(part.pixels.nbytes for part in maps)
    if isinstance(found, ReflectionMap):
        return sum(part.rings.shape[1] for part in found.parts), sum(
            part.rings.nbytes for part in found.parts
        )
    lobes = getattr(found, "lobes", (found,))
    return sum(len(one.layers) for one in lobes), sum(one.nbytes for one in lobes)
