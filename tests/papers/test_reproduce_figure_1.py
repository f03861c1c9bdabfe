"""Figure 1 of [RH02] made again: how its panels are framed and judged, and what it needs."""

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from shrm.brdf import GGX, Lambert
from shrm.environment import Environment
from shrm.frequency.prefilter import prefilter
from shrm.image_io import write_image
from shrm.integrate.angular import prefilter_angular
from shrm_papers.comparison import Frames
from shrm_papers.grid_meshes import knot
from shrm_papers.result import Result, Settings
from shrm_papers.rh02 import figure_1
from support.data import require

Command = Callable[..., tuple[int, str, str]]
SKY = Environment.daylight(size=32)
SHAPE = knot(96, 18).placed().with_tangents("principal")
MEASURED = "krylon_blue.brdf", "vch_golden_yellow_rgb.bsdf"


def check(result: Result) -> None:
    assert result.name == "rh02-figure-1"
    assert [row[0] for row in result.rows] == [panel.paper for panel in figure_1.PANELS]
    assert {len(row) for row in result.rows} == {len(result.columns)}
    for row in result.rows:
        predicted, picture, frames, milliseconds = row[-4:]
        assert 0 < predicted < 0.5
        assert 0 < picture < 0.5
        assert 0 < frames < 0.5
        assert milliseconds > 0
    assert result.figure is not None
    result.figure.savefig(io.BytesIO(), dpi=30)


@pytest.mark.slow
def test_it_needs_no_file_and_says_what_stands_in() -> None:
    result = figure_1.make(Settings(SKY, "a sky", quick=True))
    check(result)
    assert {row[3] for row in result.rows} == {"a sky"}
    assert all(
        "merl" in row[1] for row, panel in zip(result.rows, figure_1.PANELS, strict=True) if panel.file
    )
    assert "--data" in result.notes[-1]
    assert "knot" in result.notes[-1]


@pytest.mark.slow
def test_the_folder_s_light_object_and_materials_are_shown(tmp_path: Path) -> None:
    """Its measurements are real; a knot is named the armadillo, and small pictures as the lights are."""
    for part in ("env", "brdf", "mesh"):
        (tmp_path / part).mkdir()
    for name in MEASURED:
        (tmp_path / "brdf" / name).symlink_to(require(f"brdf/{name}"))
    trimesh.Trimesh(SHAPE.vertices, SHAPE.faces, process=False).export(tmp_path / "mesh" / "armadillo.obj")
    for k, light in enumerate(("grace_cross", "stpeters_cross", "spica_uffizi", "rnl_probe")):
        write_image(tmp_path / "env" / f"{light}.exr", np.roll(SKY.pixels, 8 * k, axis=1))
    result = figure_1.make(Settings(SKY, "a sky", quick=True, data=tmp_path))
    check(result)
    assert [row[3] for row in result.rows] == [panel.place for panel in figure_1.PANELS]
    assert [row[2] for row in result.rows if row[1] == "krylon blue"] == ["Cornell"]
    assert not any("--data" in note for note in result.notes)


def test_what_a_folder_lacks_is_named_in_a_line(shrm: Command, tmp_path: Path) -> None:
    for part in ("env", "brdf", "mesh"):
        (tmp_path / "data" / part).mkdir(parents=True)
    status, _, err = shrm(
        "reproduce", "rh02-figure-1", "--data", tmp_path / "data", "--quick", "-o", tmp_path / "out"
    )
    assert status == 1
    assert len(err.splitlines()) == 1
    assert "armadillo" in err
    assert str(tmp_path / "data" / "mesh") in err
    status, _, err = shrm(
        "reproduce", "rh02-figure-1", "--data", tmp_path / "nowhere", "-o", tmp_path / "out"
    )
    assert status == 1
    assert str(tmp_path / "nowhere") in err


@pytest.mark.parametrize("panel", figure_1.PANELS, ids=lambda panel: panel.name)
def test_the_object_fills_its_panel_and_stays_within(panel: figure_1.Panel) -> None:
    camera, mesh = figure_1.framed(SHAPE, panel)
    x, y = camera.project(mesh.vertices, figure_1.PANEL)
    filled = max(np.ptp(part) / extent for part, extent in zip((y, x), figure_1.PANEL, strict=True))
    assert filled == pytest.approx(figure_1.FILLED, rel=1e-9)
    # moved across the view at the distance of its center; nearer parts move by up to a third more
    for part, extent in zip((y, x), figure_1.PANEL, strict=True):
        assert part.min() > 0
        assert part.max() < extent


def test_what_is_seen_faces_the_camera_and_is_on_the_object() -> None:
    panel = figure_1.PANELS[1]
    camera, mesh = figure_1.framed(SHAPE, panel)
    frames = figure_1.visible_frames(mesh, camera, 500)
    for vectors in (frames.normals, frames.views, frames.tangents):
        assert vectors.shape == (500, 3)
        np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, rtol=1e-6)
    np.testing.assert_allclose(np.einsum("nk,nk->n", frames.normals, frames.tangents), 0, atol=1e-6)
    assert np.einsum("nk,nk->n", frames.normals, frames.views).mean() > 0.4
    # views point to the camera, whichever part is seen
    assert (frames.views @ camera.forward).max() < -np.cos(np.radians(camera.fov))


def test_errors_are_relative_and_of_the_map_alone() -> None:
    light = SKY.resized((16, 32))
    brdf = Lambert(0.5)
    exact, frames, weights = prefilter_angular(light, brdf), Frames.drawn(200), np.ones(200)
    rm = prefilter(light, brdf, orders=(2, 0))
    assert figure_1.relative_error(exact, exact, frames, weights) == 0
    once = figure_1.relative_error(rm, exact, frames, weights)
    assert 0 < once < 0.1  # [RH01]: nine terms of diffuse reflection
    brighter = prefilter(light, 2 * brdf, orders=(2, 0)), prefilter_angular(light, 2 * brdf)
    assert figure_1.relative_error(*brighter, frames, weights) == pytest.approx(once, rel=1e-4)
    assert figure_1.relative_error(rm, exact, frames, 3 * weights) == pytest.approx(once, rel=1e-12)


def test_frames_chosen_by_their_light_stand_for_all() -> None:
    """Weighted means over the chosen are those over all frames, and of the light with less scatter."""
    rm = prefilter(SKY, GGX(0.2), orders=(12, 2))
    frames, weights = figure_1.random_frames(rm, 2000)
    every = np.sum(Frames.drawn(32000).radiance(rm) ** 2, axis=1)
    light = weights * np.sum(frames.radiance(rm) ** 2, axis=1)
    # Chances are at least half of the frame's share of the light and half of uniform: weights are at most 2,
    # weighted light at most twice its mean. Means of 2000 values within [0, 2] scatter by 1 / sqrt(2000).
    assert weights.max() <= 2
    assert light.max() <= 2 * every.mean() * (1 + 1e-6)
    assert weights.mean() == pytest.approx(1, abs=4 / np.sqrt(2000))
    assert light.mean() == pytest.approx(every.mean(), rel=4 / np.sqrt(2000))
