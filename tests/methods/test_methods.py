"""Which method of prefiltering costs least at a tolerance; that each meets it."""

import numpy as np
import pytest
from shrm import (
    Environment,
    ToleranceWarning,
    brdf,
    cheapest,
    prefilter,
    prefilter_angular,
    prefilter_hierarchical,
)
from shrm.frequency import orders
from shrm.integrate.angular import integrate
from shrm.methods import cost
from support import oracles

SKY = Environment.daylight(size=32)


def seconds(s: float, H: int, layout: str = "latlong") -> tuple[float, float]:
    """Predicted for Phong between pictures of H rows, F as [RH02] appendix D has it."""
    material, F = brdf.Phong(s), int(np.ceil(np.sqrt(-s * np.log(0.01))))
    chosen = orders.Orders(F, 0, 0.0, "", (orders.LobeOrders(F, 0, 0.0, 1.0),))
    work = (2 * H * H, material, 2 * H * H, layout, 1)
    return cost.frequency_seconds(*work, chosen), cost.angular_seconds(*work, 0.05)  # type: ignore[arg-type]


METHODS = {
    "frequency": prefilter,
    "angular": prefilter_angular,
    "hierarchical": prefilter_hierarchical,
}


def test_broad_lobes_are_left_to_frequency_space():
    assert cheapest(SKY, brdf.Phong(20)) == "frequency"
    assert cheapest(SKY, brdf.Lambert(0.5), layout="cube", size=32, views=10) == "frequency"


def test_frequency_costs_more_with_the_exponent_and_integration_less():
    exponents = 2.0 ** np.arange(2, 14)
    times = np.array([seconds(s, 512) for s in exponents])
    assert (np.diff(times[:, 0]) >= 0).all()
    assert (np.diff(times[:, 1]) <= 0).all()
    # eq. 9 and eq. 10 cross once
    cheaper = times[:, 0] <= times[:, 1]
    assert cheaper[0]
    assert (np.diff(cheaper.astype(int)) <= 0).all()


def test_integration_costs_as_the_square_of_the_texels():
    # eq. 10, where tables and calls no longer count
    assert seconds(8, 4096)[1] / seconds(8, 2048)[1] == pytest.approx(16, rel=0.01)
    # eq. 9 at fixed F
    assert seconds(8, 4096)[0] / seconds(8, 2048)[0] == pytest.approx(4, rel=0.05)


def test_what_frequency_space_cannot_reach_is_integrated():
    mirror = brdf.GGX(0.05)
    with pytest.warns(ToleranceWarning):
        prefilter(SKY, mirror, tolerance=0.02, F_max=20, P_max=2, size=8)
    assert cheapest(SKY, mirror, tolerance=0.02, F_max=20, P_max=2, size=8) == "angular"
    found = prefilter_angular(SKY, mirror, tolerance=0.02, size=8)
    N, V = oracles.random_views(40, seed=3)
    exact = integrate(SKY, mirror, N, V, subsamples=4)
    # The bare sun: nodes finer than texels are needed, and had by default.
    assert oracles.relative_rms(found.radiance(N, V), exact) < 0.02


@pytest.mark.parametrize("method", METHODS)
def test_either_way_the_tolerance_is_met(method):
    material, view = brdf.Phong(40), [0.0, 0.0, 1.0]
    # A radial lobe's map is the reflected light over all directions; at F = 60 no energy is left out.
    exact = prefilter(SKY, material, orders=(60, 0), size=48).at_view(view)
    found = METHODS[method](SKY, material, tolerance=0.05, size=48).at_view(view)
    area = np.sqrt(np.sin((np.arange(48) + 0.5) * np.pi / 48))[:, None, None]
    assert oracles.relative_rms(area * found, area * exact) < 0.05


@pytest.mark.parametrize(
    ("changed", "error", "text"),
    [
        ({"views": 0}, ValueError, "views must be"),
        ({"points": -1}, ValueError, "points must be"),
        ({"size": 1}, ValueError, "size must be"),
        ({"layout": "fisheye"}, ValueError, "layout must be one of latlong, cube, got 'fisheye'"),
        ({"tolerance": 0.0}, ValueError, "tolerance must be"),
        ({"F_max": -1}, ValueError, "F_max must be"),
        ({"brdf": "ggx"}, TypeError, "brdf must be"),
        ({"env": None}, TypeError, "env must be"),
    ],
)
def test_wrong_arguments(changed, error, text):
    with pytest.raises(error, match=text):
        cheapest(**{"env": SKY, "brdf": brdf.Phong(20)} | changed)


@pytest.mark.slow
def test_sharp_lobes_under_a_large_light_are_descended_for_and_under_a_small_one_integrated():
    """What frequency space cannot reach within the caps, where it would take fewer evaluations."""
    glossy = brdf.GGX(0.15)
    options = {"tolerance": 0.02, "F_max": 40, "P_max": 1, "size": 32}
    large = Environment.daylight(size=512)
    assert cheapest(large, glossy, **options) == "hierarchical"
    assert cheapest(SKY, glossy, **options) == "angular"
    # texels as points: about as many as there are lobes' widths would not do
    assert cheapest(large.resized((64, 128)), brdf.GGX(0.02), **options) == "angular"


def test_a_descent_costs_as_texels_of_the_map_and_hardly_those_of_the_light():
    def cost_of(light: int, texels: int) -> float:
        return cost.hierarchical_seconds(light, brdf.GGX(0.2), texels, "latlong", 1)

    assert cost_of(10**5, 4 * 10**6) / cost_of(10**5, 10**6) == pytest.approx(4, rel=0.05)
    assert cost_of(4 * 10**5, 10**6) / cost_of(10**5, 10**6) < 1.1


@pytest.mark.parametrize("H", [4, 16])
def test_a_lobe_far_narrower_than_texels_reflects_all_of_a_constant_light(H):
    white = Environment(np.ones((H, 2 * H, 3), dtype=np.float32))
    found = prefilter_angular(white, brdf.Phong(20000.0), tolerance=0.05, size=16)
    # Phong reflects all light; at most 0.75 x 5% may be cut off.
    np.testing.assert_allclose(found.at_view([0.0, 0.0, 1.0]), 1.0, atol=0.0375)


def test_what_no_nodes_resolve_is_said():
    # The half width of cos^s is sqrt(2 ln 2 / s): a thousandth of the spacing of 2048 columns' nodes.
    with pytest.warns(UserWarning, match="narrower than what the nodes resolve"):
        prefilter_angular(SKY, brdf.Phong(1e10), tolerance=0.05, size=2)


@pytest.mark.parametrize("method", METHODS)
def test_results_say_their_size_and_layout(method):
    reflection = METHODS[method](SKY, brdf.Phong(20), size=12, layout="cube")
    assert (reflection.size, reflection.layout) == (12, "cube")


def test_points_cost_what_they_are_asked_for_not_what_maps_are():
    """Each pixel of a picture has its own direction and view: the texels of a map say nothing of that."""
    glossy, n = brdf.GGX(0.15), 10**9
    chosen = orders.Orders(40, 1, 0.0, "", (orders.LobeOrders(40, 1, 0.0, 1.0),))

    def costs(points: int, views: int = 1) -> np.ndarray:
        work = (32 * 64, glossy, 2 * 32**2, "latlong", views)
        return np.array(
            [
                cost.frequency_seconds(*work, chosen, points),  # type: ignore[arg-type]
                cost.angular_seconds(*work, 0.05, points),  # type: ignore[arg-type]
                cost.hierarchical_seconds(*work, points),  # type: ignore[arg-type]
            ]
        )

    # In proportion to many points, whatever the views
    np.testing.assert_allclose(costs(2 * n) / costs(n), 2.0, rtol=1e-2)
    np.testing.assert_array_equal(costs(n), costs(n, views=100))
    # The integrators take as long for as many points as a map has texels
    np.testing.assert_allclose(costs(2 * 32**2)[1:], costs(0)[1:], rtol=1e-12)
    # A table for descents pays for the pixels of a picture, and not for a small map
    light = Environment.daylight(size=64)
    assert cheapest(light, glossy, size=8) == "angular"
    assert cheapest(light, glossy, size=8, points=10**6) == "hierarchical"
