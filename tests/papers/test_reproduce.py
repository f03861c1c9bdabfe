"""The paper's tables made again: how they are written, what they rest on, the command."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shrm_papers
from matplotlib.figure import Figure
from shrm.prefiltered import explicit
from shrm.prefiltered.icosahedron import icosahedron
from shrm_papers import RESULTS, make
from shrm_papers.exponents import fit
from shrm_papers.result import Result, Settings
from shrm_papers.rh02 import light_fields as forms
from shrm_papers.rh02.table_3 import PANELS
from support.directions import sphere

Command = Callable[..., tuple[int, str, str]]


def test_a_result_is_written_as_csv_and_markdown(tmp_path: Path) -> None:
    rows = [["a, b", 1, 0.1 + 0.2, None], ["c|d", 12345, 1234.5678, "Yes"]]
    result = Result("rh02-table-9", "a title", ("name", "count", "value", "speed [RH02]"), rows, ("A note.",))
    assert [path.name for path in result.write(tmp_path)] == ["rh02-table-9.csv", "rh02-table-9.md"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rh02-table-9.csv", "rh02-table-9.md"]
    with (tmp_path / "rh02-table-9.csv").open(newline="") as file:
        header, *found = csv.reader(file)
    assert header == list(result.columns)
    assert [[a, int(b), float(c), d or None] for a, b, c, d in found] == rows
    lines = (tmp_path / "rh02-table-9.md").read_text().splitlines()
    assert lines[0] == "# [RH02] table 9: a title"
    assert lines[4:6] == ["| a, b | 1 | 0.3 |  |", r"| c\|d | 12345 | 1235 | Yes |"]
    assert lines[-1] == "- A note."


@pytest.mark.parametrize("exponent", [-1.0, 0.0, 0.5, 2.0])
def test_the_exponent_of_a_power_law(exponent: float) -> None:
    x = np.array([3.0, 5.0, 11.0, 40.0])
    law = fit(x, 7.0 * x**exponent)
    assert law.exponent == pytest.approx(exponent, abs=1e-12)
    assert law.factor == pytest.approx(7.0, rel=1e-12)
    assert law.deviation < 1e-12


def test_the_standard_error_is_the_scatter_of_exponents() -> None:
    x = np.geomspace(1, 100, 8)
    noise = np.random.default_rng(1).normal(scale=0.1, size=(2000, 8))
    laws = [fit(x, x**1.5 * np.exp(e)) for e in noise]
    scatter = np.std([law.exponent for law in laws])
    # The root mean square of 2000 estimates of 6 degrees of freedom: 1 / sqrt(2 6 2000) = 0.7% off; so is the
    # scatter, by 1 / sqrt(2 2000) = 1.6%. 6% is more than three of both together.
    assert np.sqrt(np.mean([law.deviation**2 for law in laws])) == pytest.approx(scatter, rel=0.06)


@pytest.mark.parametrize(("sizes", "seconds"), [([2, 2], [1, 1]), ([1, 2], [0, 1]), ([1, 2, 3], [1, 2])])
def test_what_is_no_power_law(sizes: list[float], seconds: list[float]) -> None:
    with pytest.raises(ValueError, match="a power law needs"):
        fit(sizes, seconds)


T, H = 16, 32


@pytest.fixture(scope="module")
def table() -> forms.Tabular:
    """The product of one function of R and one of V, both smooth."""
    from shrm.environment.layouts import directions

    views, R = explicit.grid_views(T), directions("latlong", H, 2 * H)
    both = of_V(views)[:, :, None, None] * of_R(R)
    return forms.Tabular(np.repeat(both[..., None], 3, axis=-1).astype(np.float32))


def of_R(R: np.ndarray) -> np.ndarray:
    return np.asarray(2 + R[..., 0] * R[..., 2])


def of_V(V: np.ndarray) -> np.ndarray:
    return np.asarray(1 + 0.5 * V[..., 1])


def test_representations_hold_the_light_that_they_were_made_from(table: forms.Tabular) -> None:
    R, V = sphere(2000, 1), sphere(2000, 2)
    exact = (of_R(R) * of_V(V))[:, None]
    # Linear interpolation is off by h^2 / 8 times the second derivative. For R, h = pi / 32 and 2 at most:
    # .0024 for each axis; for V in phi, h = 2 pi / 16 and .5: .0096, in theta a quarter. The values are up to
    # 2.5 and 1.5.
    bound = 2 * 0.0024 * 1.5 + (0.0096 + 0.0024) * 2.5
    assert np.abs(table.radiance(R, V) - exact).max() < bound
    twelve = np.repeat((of_V(icosahedron())[:, None] * table_over_R())[..., None], 3, axis=-1)
    icosahedral = forms.Icosahedral(twelve.reshape(12, H, 2 * H, 3).astype(np.float32))
    vertices = icosahedron()
    at_vertices = icosahedral.radiance(R[:12], vertices)
    np.testing.assert_allclose(at_vertices[:, 0], of_R(R[:12]) * of_V(vertices), atol=2 * 0.0024 * 1.5)
    # One product is one term, and one distribution over the views.
    for form in (forms.factored(table.maps, 1), forms.quantised(table.maps, 1, rounds=1)):
        np.testing.assert_allclose(form.radiance(R, V), table.radiance(R, V), rtol=2e-3)
        assert form.bytes < table.bytes / 20


def table_over_R() -> np.ndarray:
    from shrm.environment.layouts import directions

    return of_R(directions("latlong", H, 2 * H)).reshape(-1)


# Results that are made, written and drawn for real by the tests of their own.
MADE_ELSEWHERE = (
    *("rh02-figure-1", "rh02-figure-5", "rh02-figure-6", "rh02-figure-7", "rh02-figure-8"),
    *("rh02-figure-9", "rh02-figure-10", "kvhs00-table-2", "kvhs00-figure-4", "kvhs00-figure-5"),
    *("lk03-table-1", "lk03-figure-2", "lk03-figure-3", "lk03-figure-4", "lk03-figure-5"),
)


def made(name: str, settings: Settings) -> Result:
    """Make a result, or one of a row in place of those that are made elsewhere."""
    if name not in MADE_ELSEWHERE:
        return make(name, settings)
    columns = "value", f"value [{name.partition('-')[0].upper()}]"
    return Result(name, "a title", columns, [[1.0, 2.0]], figure=Figure())


@pytest.mark.slow
def test_the_command_writes_every_result_and_the_index(
    shrm: Command, sky: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shrm_papers, "make", made)
    status, out, err = shrm("reproduce", "--env", sky, "--quick", "-o", tmp_path / "out")
    assert (status, err) == (0, "")
    assert [line.split()[0] for line in out.splitlines()[:-1]] == list(RESULTS)
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {f"{name}.{kind}" for name in RESULTS for kind in ("csv", "md", "png")} | {"index.md"}
    index = (tmp_path / "out" / "index.md").read_text()
    assert "- Environment: sky, 32 x 16" in index
    for name in RESULTS:
        assert f"]({name}.png)" in index
        with (tmp_path / "out" / f"{name}.csv").open(newline="") as file:
            header, *rows = csv.reader(file)
        assert rows
        paper, kind, _ = name.split("-")
        assert any(column.endswith(f"[{paper.upper()}]") for column in header) or kind == "figure"
    with (tmp_path / "out" / "rh02-table-3.csv").open(newline="") as file:
        costs = list(csv.DictReader(file))
    shown = {variable for _, variables in PANELS.values() for variable in variables}
    assert {row["against"] for row in costs} == shown
    assert all(float(row["ms, first"]) > 0 for row in costs)
    with (tmp_path / "out" / "rh02-table-2.csv").open(newline="") as file:
        errors = [float(row["relative RMS error"]) for row in csv.DictReader(file)]
    assert all(0 < error < 0.5 for error in errors)


def test_only_what_is_asked_for_or_nothing(shrm: Command, tmp_path: Path) -> None:
    status, _, err = shrm("reproduce", "tabel-3", "-o", tmp_path / "out")
    assert status == 2
    assert len(err.splitlines()) == 1
    assert "'tabel-3'" in err
    assert all(name in err for name in RESULTS)
    status, _, err = shrm("reproduce", "--fits", tmp_path / "nowhere", "-o", tmp_path / "out")
    assert status == 1
    assert str(tmp_path / "nowhere") in err
    assert not (tmp_path / "out").exists()


def test_light_that_is_black_is_refused(shrm: Command, tmp_path: Path) -> None:
    from shrm.image_io import write_image

    write_image(tmp_path / "black.exr", np.zeros((8, 16, 3), dtype=np.float32))
    status, _, err = shrm(
        "reproduce", "rh02-figure-6", "--env", tmp_path / "black.exr", "-o", tmp_path / "out"
    )
    assert status == 1
    assert "every texel is black" in err
    assert not (tmp_path / "out").exists()
