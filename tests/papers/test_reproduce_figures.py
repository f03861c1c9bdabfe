"""Figures 5 to 8 of [RH02] made again: the fits they use, and what their numbers must satisfy."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from shrm import brdf
from shrm.brdf import GGX, Lambert
from shrm.environment import Environment
from shrm_papers.result import Result, Settings
from shrm_papers.rh02 import brdf_accuracy, figure_5, figure_6, figure_7, figure_8, fits, merl_classes
from shrm_papers.spheres import brightest, view_turned
from support.data import require

FIGURES = {module.NAME: module for module in (figure_5, figure_6, figure_7, figure_8)}

# Made up, in the range of the published ones.
ABC = {"kD": [0.1, 0.2, 0.3], "A": [40.0, 30.0, 20.0], "B": 900.0, "C": 1.3, "ior": 1.6}


def directions(n: int, seed: int) -> np.ndarray:
    w = np.random.default_rng(seed).normal(size=(n, 3))
    w[:, 2] = np.abs(w[:, 2])
    return w / np.linalg.norm(w, axis=1, keepdims=True)


# ---- The fits


def test_fits_are_those_of_the_package_or_of_a_folder(tmp_path: Path) -> None:
    shipped = fits.read(None)
    assert {source: len(materials) for source, materials in shipped.items()} == dict(
        zip(fits.SOURCES, (100, 86, 6), strict=True)
    )
    path = tmp_path / "merl_abc_low2012.json"
    path.write_text(json.dumps({"pink-felt": ABC}))
    ((source, materials),) = fits.read(tmp_path).items()
    assert list(materials) == ["pink-felt"]
    wi, wo = directions(9, 1), directions(9, 2)
    theirs, ours = materials["pink-felt"].transfer(wi, wo), shipped[source]["pink-felt"].transfer(wi, wo)
    assert not np.allclose(theirs, ours)


def test_faults_of_a_folder_of_fits_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="has none of"):
        fits.read(tmp_path)
    path = tmp_path / "merl_abc_low2012.json"
    for text in ("{", "[1]", '{"thing": {"kD": [0, 0, 0]}}', '{"thing": 1}'):
        path.write_text(text)
        with pytest.raises(ValueError, match=path.name):
            fits.read(tmp_path)


# ---- The figures


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Result]:
    folder = tmp_path_factory.mktemp("fits")
    (folder / "merl_abc_low2012.json").write_text(json.dumps({"thing": ABC}))
    settings = Settings(Environment.daylight(size=64), "daylight", folder, quick=True)
    return {name: module.make(settings) for name, module in FIGURES.items()}


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_a_table_and_a_picture(results: dict[str, Result], name: str) -> None:
    result = results[name]
    assert result.name == name
    assert result.notes
    assert result.rows
    assert {len(row) for row in result.rows} == {len(result.columns)}
    assert result.figure is not None
    result.figure.savefig(io.BytesIO(), dpi=30)


def test_5_no_light_above_the_smaller_frequency(results: dict[str, Result]) -> None:
    found = {(F_L, F_rho): (least, highest) for F_L, F_rho, least, highest in results["rh02-figure-5"].rows}
    for (F_L, F_rho), (least, highest) in found.items():
        assert least == min(F_L, F_rho)
        assert highest <= least
        assert highest == found[F_rho, F_L][1]  # one family of lobes: light and material may change places


def test_5_a_lobe_of_order_F_holds_its_share_there() -> None:
    l = np.arange(129)
    for F in figure_5.FREQUENCIES:
        energy = np.cumsum((2 * l + 1) * figure_5.gain(F, 128) ** 2)
        # sqrt(-s ln eps) is an approximation, for narrow lobes: within one degree
        assert energy[F - 1] < figure_5.SHARE * energy[-1] <= energy[F + 1]


def test_6_estimates_are_conservative_and_the_criterion_is_exact(results: dict[str, Result]) -> None:
    F, measured, light, minimum, bound, of_brdf = np.array(results["rh02-figure-6"].rows).T
    assert np.array_equal(F, np.arange(len(F)))
    np.testing.assert_allclose(light, measured, atol=2e-4)  # look-ups and integrals of 1e-4 each
    assert np.all(minimum <= measured + 2e-4)
    assert np.all(bound <= measured + 2e-4)
    for estimate in (measured, light, bound, minimum, of_brdf):
        assert np.all(np.diff(estimate) > -1e-6)


def test_7_errors_fall_with_P(results: dict[str, Result]) -> None:
    rows = results["rh02-figure-7"].rows
    for view in figure_7.INCIDENCE:
        for center in figure_7.CENTERS:
            errors = [row[3] for row in rows if row[:2] == [view, center]]
            assert len(errors) == len(figure_7.ORDERS)
            assert errors == sorted(errors, reverse=True)
    assert figure_7.brdf_error("reflection", 2) < 0.03  # [RH02 section 7.1]


@pytest.mark.parametrize("incidence", [10.0, 30.0, 75.0])
def test_7_the_light_is_reflected_at_the_angle_asked_for(incidence: float) -> None:
    light = directions(1, 5)[0]
    view = np.array(figure_7.view_reflecting(light, incidence))
    N = (light + view) / np.linalg.norm(light + view)
    np.testing.assert_allclose([N @ light, N @ view], np.cos(np.radians(incidence)), rtol=1e-12)


def test_8_accuracy_rises_with_P_to_what_F_allows() -> None:
    for material in (GGX(0.3), Lambert(0.5) + GGX(0.2, 0.04)):
        found = brdf_accuracy.measure("material", material)
        for center in brdf_accuracy.CENTERS:
            steps = np.diff([0.0, *found.by_order[center], found.every_order, 1.0])
            assert steps.min() > -1e-6
    assert brdf_accuracy.measure("Lambert", Lambert(1.0)).by_order["lobe"][0] > 0.99  # its own center: P = 0


def test_8_fits_are_the_folder_s_where_there_is_one(results: dict[str, Result]) -> None:
    assert {row[2] for row in results["rh02-figure-8"].rows if row[0] != figure_8.BUILT_IN} == {"thing"}


def test_8_every_material_of_merl_has_one_class() -> None:
    names = [name for many in merl_classes.CLASSES.values() for name in many]
    assert sorted(names) == sorted(brdf.fits.names("merl-abc"))
    assert set(brdf.fits.names("merl-sgd")) <= set(names)
    assert merl_classes.class_of("pink-felt") == "fabric, felt"
    assert merl_classes.class_of("Lambert") == ""


def test_8_counts_agree_with_the_rows(results: dict[str, Result]) -> None:
    result = results["rh02-figure-8"]
    assert result.summary is not None
    columns, counted = result.summary
    assert list(counted[-1][2:4]) == [61, 56]  # [RH02 section 7.2]
    assert f"| {columns[0]} |" in result.markdown()
    at = [result.columns.index(f"P = 5, about {text}") for text in brdf_accuracy.CENTERS.values()]
    for source, _, number, *reached in counted[:-1]:
        rows = [row for row in result.rows if row[0] == source]
        assert number == len(rows)
        assert reached[:2] == [sum(row[k] > 0.9 for row in rows) for k in at]


def test_8_the_half_energy_angle_of_cosine_lobes() -> None:
    """About N: rho_hat^2 ~ cos^2s, so that cos^(2s+1) of the angle is a half; Lambert has s = 1."""
    found = brdf_accuracy.measure("Lambert", Lambert(1.0))
    exact = np.degrees(np.arccos(0.5 ** (1 / 3)))
    # linear between Gauss nodes that are up to 2 degrees apart
    assert found.half == pytest.approx(exact, abs=1.0)
    assert found.half_grazing == pytest.approx(exact, abs=1.0)
    assert found.wide


def test_8_what_views_keep_adds_up() -> None:
    """If no view grazes, what is kept of those to the horizon is what is kept of all."""
    material = Lambert(0.5) + GGX(0.2, 0.04)
    whole = brdf_accuracy.measure("material", material)
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(brdf_accuracy, "GRAZING", 90.0)
        everywhere = brdf_accuracy.measure("material", material)
    for center in brdf_accuracy.CENTERS:
        # energies by two sets of nodes, each exact to 1e-6 for smooth lobes
        assert everywhere.below_grazing[center] == pytest.approx(whole.by_order[center][-1], abs=1e-4)
        assert whole.below_grazing[center] > whole.by_order[center][-1]  # this one is hardest where it grazes


def test_8_wide_lobes_that_miss_are_explained() -> None:
    """What they miss is at grazing views, as the notes say; a lobe that does not miss is not among them."""
    found = {
        name: brdf_accuracy.measure(name, brdf.fits.fit("merl-abc", name))
        for name in ("blue-rubber", "pink-felt", "chrome")
    }
    notes = figure_8.exceptions({"a source": {"": list(found.values())}})
    assert [note.split(" (")[0] for note in notes[1:]] == ["blue-rubber"]
    this = found["blue-rubber"]
    assert not this.reaches("reflection")
    assert min(this.below_grazing.values()) > 0.9
    assert this.half_grazing < 10 < this.half


@pytest.mark.slow
def test_8_files_of_measurements_are_read_from_the_folder(tmp_path: Path) -> None:
    assert figure_8.measured(None) == {}
    (tmp_path / "brdf").mkdir()
    (tmp_path / "brdf" / "notes.txt").write_text("not a material")
    assert figure_8.measured(tmp_path) == {}
    source = require("brdf/krylon_blue.brdf")
    (tmp_path / "brdf" / source.name).symlink_to(source)
    assert list(figure_8.measured(tmp_path)) == ["krylon_blue (Cornell)"]


# ---- Where spheres are seen from


def test_the_brightest_light_is_found() -> None:
    env = Environment.daylight(sun_elevation=40.0, sun_azimuth=70.0, size=128)
    sun = np.array(view_turned(np.array([1.0, 0.0, 0.0]), 70.0, 40.0))
    assert np.degrees(np.arccos(brightest(env) @ sun)) < 8.0  # texels of 2.8 degrees, and the sky's glow
