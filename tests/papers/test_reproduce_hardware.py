"""[KVHS00] section 5.2 made again: table and figures of hardware prefiltering, with OpenGL and without."""

import numpy as np
import pytest
from shrm.environment import Environment
from shrm.viewer import ContextError
from shrm_papers import Settings, grid_meshes
from shrm_papers.kvhs00 import figure_3 as kautz_figure_3
from shrm_papers.kvhs00 import figure_4 as kautz_figure_4
from shrm_papers.kvhs00 import figure_5 as kautz_figure_5
from shrm_papers.kvhs00 import opengl
from shrm_papers.kvhs00 import table_2 as kautz_table_2
from shrm_papers.result import Result
from support.opengl import context

DRAWN = (kautz_table_2, kautz_figure_4, kautz_figure_5)
SETTINGS = Settings(Environment.daylight(size=32), "daylight", quick=True)


def made(module) -> Result:
    context().release()
    return module.make(SETTINGS)


def column(result: Result, name: str) -> list:
    return [row[list(result.columns).index(name)] for row in result.rows]


@pytest.mark.slow
@pytest.mark.parametrize("module", [kautz_figure_3, *DRAWN], ids=lambda module: module.NAME)
def test_every_row_is_whole_and_there_is_a_picture(module):
    result = made(module)
    assert len(set(result.columns)) == len(result.columns)
    assert all(len(row) == len(result.columns) for row in result.rows)
    assert result.figure is not None
    assert "OpenGL: " in " ".join(result.notes) or module is kautz_figure_3


@pytest.mark.slow
def test_the_table_is_beside_the_papers():
    result = made(kautz_table_2)
    for name in ("small filter", "large filter", "small shrink", "large shrink"):
        assert column(result, name) == column(result, f"{name} [KVHS00]")
    for method in ("two passes", "one pass"):
        assert all(x > 0 for x in column(result, f"{method}, frames/s"))
        assert column(result, f"{method}, frames/s [KVHS00]")[0] in (25, 33)
    assert all(0 < x < 1 for x in column(result, "error, exact"))
    # At exponent 10; at 500 the lobe is as wide as texels are in a quick map.
    assert column(result, "error, exact")[0] < column(result, "error, two passes")[0]
    assert column(result, "error, two passes")[0] < column(result, "error, one pass")[0]


def test_filters_are_compared_with_the_sum():
    result = made(kautz_figure_4)
    errors = dict(zip(column(result, "filter"), column(result, "relative RMS error"), strict=True))
    assert errors["classic"] is None
    assert errors["hierarchical"] < 0.01
    assert max(x for name, x in errors.items() if name.startswith("hardware")) < errors["unfiltered"]


def test_the_torus_is_drawn_twice_in_two_lights():
    result = made(kautz_figure_5)
    assert column(result, "exponent") == [50, 500, 50, 500]
    assert len(set(column(result, "environment"))) == 2
    assert all(0 < x < 0.5 for x in column(result, "relative RMS error"))


@pytest.mark.parametrize("module", DRAWN, ids=lambda module: module.NAME)
def test_without_opengl_what_needs_it_is_left_out_with_a_note(module, monkeypatch, tmp_path):
    def none():
        raise ContextError("no OpenGL without a display: apt-get install libegl1")

    monkeypatch.setattr(opengl, "offscreen", none)
    result = module.make(SETTINGS)
    assert any(note.startswith("What needs OpenGL was left out: no OpenGL") for note in result.notes)
    assert result.rows
    assert all(len(row) == len(result.columns) for row in result.rows)
    result.write(tmp_path)


# ---- Circles


@pytest.mark.parametrize("r", kautz_figure_3.RADII)
def test_deviations_are_those_of_the_nearest_and_the_farthest_point(r):
    for d in kautz_figure_3.DISTANCES:
        # tan(theta / 2) = distance: along the line through both centers.
        outwards, inwards = (abs(2 * (np.arctan(d + k) - np.arctan(d))) for k in (r, -r))
        wanted = (inwards - outwards) / (inwards + outwards)
        assert kautz_figure_3.deviation(r, d) == pytest.approx(wanted, abs=1e-9)
    assert kautz_figure_3.deviation(r, 1.0) < kautz_figure_3.LARGEST


def test_circles_are_circles_on_the_sphere():
    angles, azimuths = kautz_figure_3.border(0.4, 0.7)
    points = np.stack(
        [np.sin(angles) * np.cos(azimuths), np.sin(angles) * np.sin(azimuths), np.cos(angles)], axis=1
    )
    # A circle on a sphere lies in a plane.
    assert np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[-1] < 1e-12


# ---- Meshes


@pytest.mark.parametrize("tilt", [0.0, 60.0])
def test_the_torus_is_one(tilt):
    mesh = grid_meshes.torus(tilt, 0.3)
    axis = np.array([np.sin(np.radians(tilt)), 0.0, np.cos(np.radians(tilt))])
    along = mesh.vertices @ axis
    across = np.linalg.norm(mesh.vertices - along[:, None] * axis, axis=1)
    np.testing.assert_allclose(np.hypot(across - 1.0, along), 0.3, atol=1e-12)
    assert outward(mesh)


def test_the_ball_has_the_papers_triangles():
    mesh = grid_meshes.ball()
    assert len(mesh.faces) == 2592
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, atol=1e-12)
    assert outward(mesh)


def outward(mesh) -> bool:
    """Whether all triangles are some, and turn the way that their normals say."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    sides = np.einsum("nc,nc->n", np.cross(b - a, c - a), mesh.normals[mesh.faces[:, 0]])
    return bool(np.all(np.abs(sides) > 1e-8) and len(set(np.sign(sides))) == 1)
