"""The stages of the pipeline, each with its error beside its time. Run by `./run bench`."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shrm import Environment, _core, brdf, orders, prefilter, sh
from shrm.brdf_analysis import analyse
from shrm.orders import analysed
from shrm.reference import prefilter_angular
from shrm.reflection_map import synthesised

Measured = Callable[..., Any]
FloatArray = npt.NDArray[np.float64]


def relative_rms(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> float:
    return float(np.sqrt(((a.astype(np.float64) - b) ** 2).sum() / (b.astype(np.float64) ** 2).sum()))


def coefficients(F: int, channels: int = 3) -> FloatArray:
    """A natural fall of the spectrum: energy 1 / l in degree l."""
    c = np.random.default_rng(1).normal(size=((F + 1) ** 2, channels))
    l = np.sqrt(np.arange((F + 1) ** 2)).astype(int)
    return np.asarray(c / np.maximum(l, 1)[:, None])


def frames(n: int) -> tuple[FloatArray, FloatArray]:
    """Normals and views, cos^2(theta_v) uniform."""
    rng = np.random.default_rng(2)
    N, T = rng.normal(size=(2, n, 3))
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    T -= N * (N * T).sum(axis=1, keepdims=True)
    T /= np.linalg.norm(T, axis=1, keepdims=True)
    cosine = np.sqrt(rng.random(n))[:, None]
    return N, cosine * N + np.sqrt(1 - cosine**2) * T


@pytest.mark.benchmark(group="analysis")
@pytest.mark.parametrize(("H", "F"), [(128, 30), (512, 12), (512, 30), (512, 100)])
def bench_analysis(measured: Measured, H: int, F: int) -> None:
    c = coefficients(min(F, H // 2 - 1))
    pixels = sh.synthesis(c, H, 2 * H)
    known = np.zeros(((F + 1) ** 2, 3))
    known[: len(c)] = c
    measured(
        lambda: sh.analysis(pixels, F), lambda found: relative_rms(found, known), f"{2 * H} x {H}, F = {F}"
    )


@pytest.mark.benchmark(group="rotation")
@pytest.mark.parametrize("F", [30, 200])
def bench_rotation(measured: Measured, F: int) -> None:
    c = coefficients(F)
    R = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    measured(lambda: sh.rotate(c, R), lambda found: relative_rms(sh.rotate(found, R.T), c), f"F = {F}")


@pytest.mark.benchmark(group="BRDF analysis")
@pytest.mark.parametrize(("L", "P"), [(12, 2), (30, 3), (60, 8)])
def bench_brdf_analysis(measured: Measured, L: int, P: int) -> None:
    lobe = brdf.GGX(0.2).lobes[0]
    fine = analyse(lobe, max(L, 61), 8).coefficients(L, P)
    measured(
        lambda: analyse(lobe, L, P),
        lambda found: relative_rms(found.coefficients(L, P), fine),
        f"GGX .2, L = {L}, P = {P}",
    )


@pytest.mark.benchmark(group="synthesis")
@pytest.mark.parametrize(("F", "P"), [(12, 2), (30, 3), (30, 5)])
@pytest.mark.parametrize("layout", ["latlong", "cube"])
def bench_global_synthesis(measured: Measured, F: int, P: int, layout: str) -> None:
    light = coefficients(F)
    rho = analysed(brdf.GGX(0.2).recentred("reflection"), F, P)[0].coefficients(F, P)
    rho = np.ascontiguousarray(np.broadcast_to(rho, (*rho.shape[:3], 3)))
    size = 128 if layout == "latlong" else 64

    def error(rings: npt.NDArray[np.float32]) -> float:
        b = _core.global_coefficients(light=light, rho=rho)
        if layout == "latlong":  # against the local form, turned: the other way to the same maps
            local = _core.local_reflection_map(light=light, rho=rho, H=size, W=2 * size)
            return relative_rms(rings, _core.global_from_local(local=local))
        directions = _core.cube_directions(N=size)
        exact = _core.evaluate(coefficients=b.reshape(len(b), -1), directions=directions.reshape(-1, 3))
        exact = exact.reshape(*directions.shape[:2], -1, 3).transpose(0, 2, 3, 1)
        return relative_rms(rings, exact)

    where = "256 x 128" if layout == "latlong" else "6 x 64 x 64"
    measured(
        lambda: synthesised(_core.global_coefficients(light=light, rho=rho), size, layout),  # type: ignore[arg-type]
        error,
        f"F = {F}, P = {P}, {where}",
    )


@pytest.mark.benchmark(group="per view")
@pytest.mark.parametrize("P", [3, 5])
def bench_dynamic_map(measured: Measured, P: int) -> None:
    material = brdf.GGX(0.3).recentred("reflection")
    rm = prefilter(Environment.daylight(size=128), material, orders=(20, P), size=64, layout="cube")
    view = np.array([0.48, 0.6, 0.64])
    Y = sh.evaluate(np.eye((P + 1) ** 2), view[None])[0]
    exact = np.tensordot(Y, rm.parts[0].maps.astype(np.float64), axes=1)
    measured(
        lambda: rm.at_view(view),
        lambda pixels: relative_rms(pixels, exact),
        f"P = {P}, 6 x 64 x 64, {(P + 1) ** 2} maps",
    )


@pytest.mark.benchmark(group="radiance")
@pytest.mark.parametrize("interpolation", ["bilinear", "cubic"])
def bench_radiance(measured: Measured, interpolation: Any) -> None:
    rm = prefilter(
        Environment.daylight(size=128), brdf.GGX(0.3).recentred("reflection"), orders=(20, 3), size=128
    )
    N, V = frames(100_000)
    R = 2 * (N * V).sum(axis=1, keepdims=True) * N - V
    R /= np.linalg.norm(R, axis=1, keepdims=True)
    part = rm.parts[0]
    few = slice(0, 2000)
    series = sh.evaluate(part.coefficients.reshape(len(part.coefficients), -1), R[few]).reshape(2000, -1, 3)
    exact = np.einsum("nz,nzc->nc", sh.evaluate(np.eye(16), V[few]), series)
    measured(
        lambda: rm.radiance(N, V, interpolation=interpolation),
        lambda found: relative_rms(found[few], exact),
        f"100,000 points, P = 3, {interpolation}",
    )


@pytest.mark.benchmark(group="end to end")
@pytest.mark.parametrize("known", [True, False], ids=["known", "new"])
def bench_prefilter(measured: Measured, known: bool) -> None:
    pixels = Environment.daylight(size=512).pixels
    material = brdf.Microfacet(0.2)

    def run() -> Any:
        if not known:
            orders.analysed.cache_clear()
        return prefilter(Environment(pixels), material, orders=(12, 2), size=128)

    which = "known material" if known else "new material"
    measured(run, lambda rm: rm.error, f"1024 x 512 to 256 x 128, F = 12, P = 2, {which}")


@pytest.mark.benchmark(group="Phong, 256 x 128 to 256 x 128")
@pytest.mark.parametrize("s", [8, 32, 128, 512])
@pytest.mark.parametrize("method", ["frequency", "angular"])
def bench_phong(measured: Measured, s: int, method: str) -> None:
    """[RH02] table 4, with its tolerances: .01 of the BRDF's energy in frequency, .05 in angle.

    Eq. 9 has the time in frequency grow as sqrt(s), eq. 10 the time in angle fall as 1 / s.
    """
    env = Environment(Environment.daylight(size=128).pixels)
    material = brdf.Phong(s)
    view = [0.0, 0.0, 1.0]
    F = int(np.ceil(np.sqrt(-s * np.log(0.01))))  # [RH02] appendix D
    exact = prefilter(env, material, orders=(max(4 * F, 60), 0), size=128).at_view(view)

    def frequency() -> Any:
        return prefilter(Environment(env.pixels), material, orders=(F, 0), size=128).at_view(view)

    def angular() -> Any:
        return prefilter_angular(env, material, tolerance=0.05, size=128, subsamples=1).at_view(view)

    measured(
        frequency if method == "frequency" else angular,
        lambda pixels: relative_rms(np.asarray(pixels), np.asarray(exact)),
        f"s = {s}, {method}" + (f", F = {F}" if method == "frequency" else ", eps = .05"),
    )
