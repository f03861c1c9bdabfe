"""Prefiltering by the OpenGL that there is: the filters of [KVHS00] section 5.2, and the exact one."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from inputs import frames
from shrm import Environment, brdf, prefilter_angular
from shrm.viewer import Context, ContextError, HardwarePrefilter, offscreen
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]

SIZE, BORDER = 512, 64
DIRECTIONS = frames(4000)[0]


@pytest.fixture(scope="module")
def context() -> Iterator[Context]:
    try:
        made = offscreen()
    except ContextError as fault:
        pytest.skip(str(fault))
    yield made
    made.release()


@pytest.fixture(scope="module")
def env() -> Environment:
    return Environment.daylight(size=512)


@pytest.fixture(scope="module")
def exact(env: Environment) -> Callable[[int], npt.NDArray[np.float32]]:
    """Radiance towards `DIRECTIONS` by direct integration, for an exponent."""
    found: dict[int, npt.NDArray[np.float32]] = {}

    def of(s: int) -> npt.NDArray[np.float32]:
        if s not in found:
            found[s] = prefilter_angular(env, brdf.Phong(s)).radiance(DIRECTIONS, DIRECTIONS)
        return found[s]

    return of


@pytest.mark.benchmark(group="hardware prefilter", max_time=0.5, min_rounds=2)
@pytest.mark.parametrize("s", [10, 100, 500])
@pytest.mark.parametrize(
    ("filter", "taps"), [("two-pass", 1), ("one-pass", 1), ("exact", 32), ("exact", 128)]
)
def bench_filter(
    measured: Measured, context: Context, env: Environment, exact: Any, filter: Any, taps: int, s: int
) -> None:
    """The filter alone; the unfiltered map and its mip-map are there."""
    how = f"exact, {taps} taps" if filter == "exact" else filter
    driver = str(context.gl.info["GL_RENDERER"]).split(" (")[0]
    with HardwarePrefilter(
        brdf.Phong(s), size=SIZE, border=BORDER, filter=filter, taps=taps, context=context
    ) as prefilter:
        prefilter.update(env)

        def filtered() -> HardwarePrefilter:
            prefilter.apply_filter()
            context.gl.finish()
            return prefilter

        def error(found: HardwarePrefilter) -> float:
            return relative_rms(found.radiance(DIRECTIONS, DIRECTIONS), exact(s))

        measured(filtered, error, f"{how}, s = {s}, two faces of {SIZE} and a border of {BORDER}, {driver}")


@pytest.mark.benchmark(group="hardware prefilter", max_time=0.5, min_rounds=2)
def bench_unfiltered_map(measured: Measured, context: Context, env: Environment) -> None:
    """A lat-long picture uploaded, made a dual-paraboloid map, and its mip-map."""
    driver = str(context.gl.info["GL_RENDERER"]).split(" (")[0]
    with HardwarePrefilter(brdf.Phong(10), size=SIZE, border=BORDER, context=context) as prefilter:

        def taken() -> HardwarePrefilter:
            prefilter.set_light(env)
            context.gl.finish()
            return prefilter

        def error(found: HardwarePrefilter) -> float:
            inside = found.unfiltered()[:, BORDER:-BORDER, BORDER:-BORDER]
            wanted = env.picture("dual-paraboloid", SIZE).reshape(SIZE, 2, SIZE, 3).transpose(1, 0, 2, 3)
            along = (2 * np.arange(SIZE) + 1 - SIZE) / SIZE
            disc = along[:, None] ** 2 + along**2 < 0.98  # no texel that the rim cuts
            return relative_rms(inside[:, disc], wanted[:, disc])

        measured(
            taken,
            error,
            f"unfiltered map of 1024 x 512, two faces of {SIZE} and a border of {BORDER}, {driver}",
        )
