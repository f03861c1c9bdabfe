"""Regular tables over angles: nodes, warps, strides; the angles are tested with the materials."""

import numpy as np
import pytest
from shrm import _core, brdf
from shrm.brdf.angle_table import AngleTable
from support.directions import direction, hemisphere

SHAPE = (4, 5, 6)


def table(nodes: str, warp: str, dtype: type = np.float64) -> AngleTable:
    values = np.random.default_rng(1).uniform(size=(*SHAPE, 3)).astype(dtype)
    return AngleTable(values, "angles", nodes, warp)


@pytest.mark.parametrize("nodes", ["ends", "centers"])
@pytest.mark.parametrize("warp", ["uniform", "square-root"])
def test_values_at_the_nodes_are_those_of_the_table(nodes: str, warp: str) -> None:
    shares = [np.linspace(0, 1, n) if nodes == "ends" else (np.arange(n) + 0.5) / n for n in SHAPE]
    if warp == "square-root":
        shares[0] = shares[0] ** 2
    theta_i, theta_o, phi = (
        grid.ravel()
        for grid in np.meshgrid(
            *(s * end for s, end in zip(shares, (np.pi / 2, np.pi / 2, np.pi), strict=True)), indexing="ij"
        )
    )
    wi = np.stack([np.sin(theta_i) * np.cos(phi), np.sin(theta_i) * np.sin(phi), np.cos(theta_i)], axis=1)
    wo = np.stack([np.sin(theta_o), 0 * theta_o, np.cos(theta_o)], axis=1)
    clear = (theta_i > 0) & (theta_o > 0)  # phi is none at the pole
    made = table(nodes, warp)
    np.testing.assert_allclose(made(wi, wo)[clear], made.values.reshape(-1, 3)[clear], rtol=1e-10)
    np.testing.assert_array_equal(made.nearest(wi, wo)[clear], np.flatnonzero(clear))


def test_float32_tables_give_what_float64_tables_of_their_values_give() -> None:
    wi, wo = hemisphere(1000, 2), hemisphere(1000, 3)
    single = table("centers", "uniform", np.float32)
    double = AngleTable(single.values.astype(np.float64), "angles", "centers", "uniform")
    np.testing.assert_array_equal(single(wi, wo), double(wi, wo))


@pytest.mark.parametrize("axes", ["angles", "half-angle"])
def test_directions_of_any_strides_and_none(axes: str) -> None:
    made = AngleTable(table("ends", "uniform").values, axes)
    wi, wo = hemisphere(1001, 4), hemisphere(1001, 5)
    values = made(wi, wo)
    np.testing.assert_array_equal(made(np.asfortranarray(wi), wo), values)
    np.testing.assert_array_equal(made(wi[::-2], wo[::-2]), values[::-2])
    np.testing.assert_array_equal(made.nearest(np.asfortranarray(wi), wo), made.nearest(wi, wo))
    assert made(wi[:0], wo[:0]).shape == (0, 3)


def test_directions_without_an_azimuth_have_azimuth_0() -> None:
    """L = V, and H = N: what rounding leaves of them is not taken for one."""
    made = AngleTable(table("ends", "uniform").values, "half-angle")
    wo = hemisphere(500, 6)
    theta_h = np.arccos(wo[:, 2])
    along = [np.interp(theta_h, np.linspace(0, np.pi / 2, 4), made.values[:, 0, 0, c]) for c in range(3)]
    np.testing.assert_allclose(made(wo, wo), np.transpose(along), rtol=1e-7)
    mirror = made(wo * [-1, -1, 1], wo)
    along = [np.interp(theta_h, np.linspace(0, np.pi / 2, 5), made.values[0, :, 0, c]) for c in range(3)]
    np.testing.assert_allclose(mirror, np.transpose(along), rtol=1e-7)


def test_opposite_grazing_directions_are_finite() -> None:
    made = AngleTable(table("ends", "uniform").values, "half-angle")
    assert np.isfinite(made(direction(0.0, 0.0), -direction(0.0, 0.0))).all()


def test_the_core_guards_memory() -> None:
    wi, values = hemisphere(4, 7), np.ones((2, 2, 2, 3))
    grid = {"axes": "angles", "square_root": False, "centers": False}
    for wrong in ({"table": np.ones((1, 2, 2, 3))}, {"table": np.ones((2, 2, 2, 2))}, {"axes": "none"}):
        with pytest.raises(ValueError, match=r"table|axes"):
            _core.interpolate_angles(**({"table": values, **grid, "wi": wi, "wo": wi} | wrong))
    with pytest.raises(ValueError, match="wo must have the shape"):
        _core.interpolate_angles(table=values, **grid, wi=wi, wo=wi[:3])
    unaligned = np.zeros(4, np.dtype([("byte", "u1"), ("w", "f8", 3)]))["w"]
    with pytest.raises((ValueError, TypeError)):
        _core.interpolate_angles(table=values, **grid, wi=unaligned, wo=wi)
    with pytest.raises(TypeError):
        _core.interpolate_angles(table=values, **grid, wi=wi.astype(np.float32), wo=wi)


def test_a_table_keeps_what_it_was_given() -> None:
    values = np.asfortranarray(np.random.default_rng(8).uniform(size=(3, 4, 5)))
    material = brdf.Tabulated(values)
    wi, wo = hemisphere(100, 9), hemisphere(100, 10)
    before = material.transfer(wi, wo)
    values[:] = 0
    np.testing.assert_array_equal(material.transfer(wi, wo), before)
