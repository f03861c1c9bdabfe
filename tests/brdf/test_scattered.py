"""Thin-plate splines through scattered values, and BRDFs by them."""

import numpy as np
import pytest
from shrm import brdf
from shrm.brdf.measured.resampled import from_half_angles, half_angle_nodes, within
from shrm.brdf.measured.scattered import MOST_PLACES, ThinPlateSpline, coordinates, interpolated
from support.directions import hemisphere


def test_it_takes_the_values_at_the_places():
    rng = np.random.default_rng(1)
    places, values = rng.normal(size=(300, 3)), rng.normal(size=(300, 2))
    np.testing.assert_allclose(ThinPlateSpline(places, values)(places), values, atol=1e-9)


def test_it_is_exact_for_what_is_linear():
    rng = np.random.default_rng(2)
    places, elsewhere = rng.normal(size=(50, 3)), rng.normal(size=(80, 3)) * 5
    slope = rng.normal(size=(3, 2))
    spline = ThinPlateSpline(places, places @ slope + 7)
    np.testing.assert_allclose(spline(elsewhere), elsewhere @ slope + 7, atol=1e-9)


def test_it_is_the_solution_of_its_equations():
    """Against the equations written out and solved in another order of the places."""
    rng = np.random.default_rng(3)
    places, values, at = rng.uniform(size=(40, 2)), rng.normal(size=(40, 1)), rng.uniform(size=(30, 2))

    def kernel(a, b):
        r = np.linalg.norm(a[:, None] - b[None], axis=2)
        return np.where(r > 0, r**2 * np.log(np.maximum(r, 1e-300)), 0.0)

    shuffled = rng.permutation(40)
    x, y = places[shuffled], values[shuffled]
    tail = np.concatenate([np.ones((40, 1)), x], axis=1)
    system = np.block([[kernel(x, x), tail], [tail.T, np.zeros((3, 3))]])
    w = np.linalg.solve(system, np.concatenate([y, np.zeros((3, 1))]))
    expected = kernel(at, x) @ w[:40] + w[40] + at @ w[41:]
    np.testing.assert_allclose(ThinPlateSpline(places, values)(at), expected, atol=1e-9)


def test_the_mean_is_taken_where_a_place_is_given_twice():
    places = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0]])
    spline = ThinPlateSpline(places, np.array([[1.0], [2.0], [5.0], [4.0]]))
    np.testing.assert_allclose(spline(places[:3])[:, 0], [1.0, 3.0, 5.0], atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 30])
def test_directions_without_spread_are_ignored(count):
    along = np.linspace(0.0, 1.0, count)[:, None] * np.array([1.0, 2.0, -1.0])
    values = np.arange(float(count))[:, None]
    spline = ThinPlateSpline(along, values)
    across = np.array([2.0, -1.0, 0.0])
    np.testing.assert_allclose(spline(along + 3 * across), values, atol=1e-8)


@pytest.mark.parametrize("count", [0, MOST_PLACES + 1])
def test_a_count_that_cannot_be_solved_is_refused(count):
    with pytest.raises(ValueError, match=f"{count} scattered places: 1 to {MOST_PLACES}"):
        ThinPlateSpline(np.zeros((count, 3)), np.zeros((count, 1)))


def test_half_angles_and_back():
    rng = np.random.default_rng(4)
    theta_h, theta_d, phi_d = rng.uniform(size=(3, 200)) * np.array([[1.5], [1.5], [np.pi]])
    wi, wo = from_half_angles(theta_h, theta_d, phi_d)
    h = wi + wo
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(wo, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(np.arccos(h[:, 2] / np.linalg.norm(h, axis=1)), theta_h, atol=1e-7)
    np.testing.assert_allclose(np.arccos(np.einsum("nc,nc->n", wi, wo)) / 2, theta_d, atol=1e-7)
    difference = 2 * np.sin(theta_h) * np.sin(theta_d) * np.cos(phi_d)
    np.testing.assert_allclose(wo[:, 2] - wi[:, 2], difference, atol=1e-12)
    assert half_angle_nodes((3, 4, 5))[0].shape == (60, 3)


def test_directions_are_brought_to_a_cone_at_their_azimuth():
    w = hemisphere(300, 5)
    inside = within(w, 1.0)
    theta = np.arccos(w[:, 2])
    np.testing.assert_allclose(np.arccos(inside[:, 2]), np.minimum(theta, 1.0), atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(inside, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(np.arctan2(inside[:, 1], inside[:, 0]), np.arctan2(w[:, 1], w[:, 0]))


def cone(n: int, seed: int) -> np.ndarray:
    return within(hemisphere(n, seed), np.radians(75.0))


def test_a_lobe_is_found_between_the_geometries():
    """A glossy lobe on a dark ground, from 1500 geometries that are denser where it is high."""
    model = brdf.GGX(0.2, 0.04) + brdf.Lambert(0.02)

    def f(wi, wo):
        return model.transfer(wi, wo)[:, None] / wi[:, 2:]

    rng = np.random.default_rng(6)
    wo = cone(1500, 7)
    near = wo * [-1.0, -1.0, 1.0] + 0.3 * rng.normal(size=(1500, 3))
    near[:, 2] = np.abs(near[:, 2])
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    wi = np.where(np.arange(1500)[:, None] < 1000, within(near, np.radians(75.0)), cone(1500, 8))
    found = interpolated(wi, wo, f(wi, wo))
    np.testing.assert_allclose(found(wi, wo), f(wi, wo), rtol=1e-6)
    there_i, there_o = cone(2000, 9), cone(2000, 10)
    error = np.abs(found(there_i, there_o) / f(there_i, there_o) - 1)[:, 0]
    assert np.median(error) < 0.02
    assert np.quantile(error, 0.95) < 0.2


def test_light_and_eye_are_not_exchanged():
    wi, wo = cone(600, 11), cone(600, 12)
    values = (1.0 + wi[:, 2:]) * (2.0 - wo[:, 2:])
    found = interpolated(wi, wo, values)
    there_i, there_o = cone(300, 13), cone(300, 14)
    expected = (1.0 + there_i[:, 2:]) * (2.0 - there_o[:, 2:])
    np.testing.assert_allclose(found(there_i, there_o), expected, rtol=0.1)
    assert np.abs(coordinates(wi, wo) - coordinates(wo, wi))[:, 2].max() > 0.1


def test_black_stays_black_and_nothing_is_negative():
    wi, wo = cone(200, 15), cone(200, 16)
    assert np.all(interpolated(wi, wo, np.zeros((200, 3)))(cone(500, 17), cone(500, 18)) < 1e-9)
    speckle = np.random.default_rng(19).uniform(size=(200, 3)) ** 8
    assert np.all(interpolated(wi, wo, speckle)(cone(500, 17), cone(500, 18)) >= 0.0)
