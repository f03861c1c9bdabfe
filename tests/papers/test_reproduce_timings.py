"""Tables 4 and 5 of [RH02] made again: what must hold whatever the clock says."""

import math

import numpy as np
import pytest
from shrm import brdf
from shrm.environment import Environment, layouts
from shrm.integrate.angular import integrate, prefilter_angular
from shrm_papers.errors import relative_rms, relative_rms_on_sphere
from shrm_papers.exponents import fit
from shrm_papers.result import Result, Settings
from shrm_papers.rh02 import flops, microfacet_maps, table_4, table_5


@pytest.fixture(scope="module")
def light() -> Environment:
    return Environment.daylight(size=32)


@pytest.fixture(scope="module", params=[table_4, table_5], ids=lambda module: module.NAME)
def result(request: pytest.FixtureRequest, light: Environment) -> Result:
    made: Result = request.param.make(Settings(light, "daylight", quick=True))
    return made


def column(result: Result, name: str) -> list[float]:
    return [float(row[list(result.columns).index(name)]) for row in result.rows]  # type: ignore[arg-type]


# ---- The tables


@pytest.mark.slow
def test_the_frequency_side_is_at_least_as_accurate(result: Result) -> None:
    angular = np.minimum(column(result, "error, angular"), column(result, "error, angular rescaled"))
    frequency = np.array(column(result, "error, frequency"))
    assert np.all(frequency <= angular)
    assert np.all(frequency > 0)
    # What is left out is 5% of the lobe: the error is of that kind.
    assert np.all((angular > 0.01) & (angular < 0.2))


@pytest.mark.slow
def test_every_cell_is_there_and_the_papers_are_beside(result: Result) -> None:
    assert len(result.rows) == 2
    assert len(set(result.columns)) == len(result.columns)
    for row in result.rows:
        assert len(row) == len(result.columns)
        assert all(cell is not None for cell in row)
        assert all(math.isfinite(cell) and cell > 0 for cell in row if not isinstance(cell, str))
    assert sum(name.endswith("[RH02]") for name in result.columns) >= 3
    assert result.figure is not None


def test_the_papers_printed_ratios_are_those_of_its_times() -> None:
    printed = (830.6, 333.6, 137.1, 52.6, 21.9, 7.7, 3.3)  # [RH02] table 4, to the rounding of its times
    for (angular, frequency), ratio in zip(table_4.PAPER.values(), printed, strict=True):
        assert angular / frequency == pytest.approx(ratio, rel=0.005, abs=0.05)
    for _, _, all_maps, one, _, _ in microfacet_maps.PAPER.values():
        assert all_maps == pytest.approx(100 * one, rel=1e-3)


# ---- Table 4


@pytest.mark.parametrize("s", [8, 64, 512])
def test_converged_maps_are_the_integrals_of_the_light(light: Environment, s: int) -> None:
    exact = table_4.converged(light, s)
    # Lobes of s = 512 are half as wide as these texels: 6 x 6 nodes are well inside of them.
    whole = prefilter_angular(light, brdf.Phong(s), size=32, subsamples=6).at_view(table_4.VIEW)
    assert isinstance(whole, np.ndarray)
    assert relative_rms_on_sphere(whole, exact) < 2e-3


def test_both_forms_of_integration_are_one(light: Environment) -> None:
    a, b = (table_4.integrated(light, 32, symmetry) for symmetry in (False, True))
    assert relative_rms_on_sphere(a, b) < 1e-5  # single precision


def test_samples_are_the_pairs_within_the_width() -> None:
    # Against all pairs of directions, and the width against W [RH02 appendix D].
    H, s = 12, 8
    within = flops.outer_angle(s, 0.05)
    theta = (np.arange(H) + 0.5) * np.pi / H
    phi = (np.arange(2 * H) + 0.5) * np.pi / H
    t, p = (grid.ravel() for grid in np.meshgrid(theta, phi, indexing="ij"))
    w = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=1)
    assert flops.samples(H, within) == np.count_nonzero(w @ w.T >= np.cos(within))
    assert (1 - np.cos(within)) / 2 == pytest.approx((1 - 0.05 ** (1 / (s + 1))) / 2)
    assert flops.samples(H, np.pi) == (2 * H * H) ** 2


def test_flops_are_those_of_the_loops() -> None:
    n = flops.samples(16, flops.outer_angle(32, 0.05))
    assert flops.angular_flops(16, 32, 0.05, symmetry=False) == 14 * n
    assert flops.angular_flops(16, 32, 0.05, symmetry=True) == 6 * n + 8 * n / 32
    # F = 0: one sum over a quarter of each ring and one over half the rings, for 3 channels, both ways.
    assert flops.frequency_flops(16, 0) == 2 * 2 * 3 * (16 * 8 + 8)


def test_lines_cross_where_both_cost_the_same() -> None:
    s = np.array([8.0, 32.0, 128.0, 512.0])
    angular, frequency = 600 / s, 0.03 * np.sqrt(s)
    star = (600 / 0.03) ** (2 / 3)  # of eq. 9 and 10
    by_theory, free = table_4.crossings(s, angular, frequency)
    assert by_theory == pytest.approx(star, rel=1e-9)
    assert free == pytest.approx(star, rel=1e-9)
    further = np.append(s, 2048.0)
    assert table_4.measured_crossing(further, 600 / further, 0.03 * np.sqrt(further)) == pytest.approx(star)
    assert table_4.measured_crossing(s, angular, frequency) is None
    # The theory's slopes hold only the factors: through bent times they differ from free ones.
    assert table_4.crossings(s, angular**0.5, frequency)[0] != pytest.approx(
        table_4.crossings(s, angular**0.5, frequency)[1], rel=0.1
    )
    assert fit(s, 7 * s**2, 2.0).factor == pytest.approx(7)


# ---- Table 5


def test_the_judge_of_microfacets_agrees_with_the_plain_sum(light: Environment) -> None:
    few = Environment(light.resized((16, 32)).pixels)
    samples = microfacet_maps.draw_samples(16, 6)
    angular = microfacet_maps.angular_of(few, 0.3, 0.0, subsamples=4)
    found = samples.integrated(angular)
    R = layouts.directions("latlong", 16, 32).reshape(-1, 3)[samples.texels.ravel()]
    V = np.repeat(samples.views, 6, axis=0)
    N = (R + V) / np.linalg.norm(R + V, axis=1, keepdims=True)
    exact = integrate(few, microfacet_maps.material(0.3), N, V, subsamples=4)
    assert relative_rms(found, exact) < 1e-4  # of its tables


def test_texels_of_maps_are_those_that_are_integrated(light: Environment) -> None:
    few = Environment(light.resized((16, 32)).pixels)
    samples = microfacet_maps.draw_samples(16, 20)
    angular = microfacet_maps.angular_of(few, 0.4, microfacet_maps.EPSILON, subsamples=1)
    maps = [np.asarray(angular.at_view(view)) for view in samples.views]
    np.testing.assert_allclose(samples.of_maps(maps), samples.integrated(angular), rtol=1e-4)
    for symmetry in (False, True):
        timed = microfacet_maps.integration(few, 0.4, samples, symmetry)()
        for of_view, again in zip(maps[::2], timed, strict=True):  # type: ignore[call-overload]
            np.testing.assert_allclose(again, of_view, rtol=1e-5, atol=1e-6 * of_view.max())


def test_flops_of_shrms_are_those_of_their_transforms() -> None:
    assert flops.shrm_flops(16, 5, 0) == flops.frequency_flops(16, 5)
    more = flops.shrm_flops(16, 5, 2) - flops.shrm_flops(16, 5, 1)
    assert more == 5 * flops.frequency_flops(16, 7) / 2
    assert flops.view_flops(16, 2) == 2 * 3 * 9 * 512
    # One degree up and down the circle, by hand: 3 sums of a quarter for each ring, 4 for each pair of rings.
    assert flops.transform_flops(16, 1) == 2 * 3 * (16 * 3 * 8 + 4 * 8)


def test_flops_of_half_angles_are_those_of_their_samples() -> None:
    assert flops.half_angle_flops(10, tabulated=True) == 10 * (15 + 6)
    assert flops.half_angle_flops(10, tabulated=False) == 10 * (15 + 6 + 13)
    # Caps of half the sphere hold half of the texels, whichever way they look.
    axes = np.eye(3)
    assert flops.samples_in_caps(16, axes, np.full(3, np.pi / 2)) == pytest.approx(16 * 16, rel=0.07)
    assert flops.samples_in_caps(16, axes, np.full(3, np.pi)) == 16 * 32


def test_truncated_maps_are_those_of_fewer_degrees(light: Environment) -> None:
    few = Environment(light.resized((16, 32)).pixels)
    made = microfacet_maps.shrm_of(few, 0.4, (5, 2)).parts[0].rings
    cut = microfacet_maps.truncated(microfacet_maps.shrm_of(few, 0.4, (9, 2)), 5).parts[0].rings
    np.testing.assert_allclose(cut, made, atol=1e-5 * np.abs(made).max())
