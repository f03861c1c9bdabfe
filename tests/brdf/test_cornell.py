"""Cornell's goniometer files: as they are written, between the measurements, and damaged."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from shrm.brdf import Measured
from shrm.brdf.measured import cornell
from shrm.brdf.measured.scattered import interpolated
from shrm.brdf.measured.spectrum import to_linear_srgb, to_xyz
from support.data import require
from support.directions import hemisphere

REAL = ["brdf/krylon_blue.brdf", "brdf/garnet_red.brdf"]
WAVELENGTHS = np.arange(400, 701, 50)


@cache
def read(name: str) -> Measured:
    """A real file: tabulating it takes a second."""
    return cornell.read(require(name))


def parsed(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles (n, 4), wavelengths (K,) and spectra (n, K), by another reader."""
    kept = [line for line in path.read_text().split("\n") if not line.lstrip().startswith("#")]
    values = np.fromstring(" ".join(kept), sep=" ")
    count = int(values[0])
    rows = values[1 + count :].reshape(-1, 4 + count)
    return rows[:, :4], values[1 : 1 + count], rows[:, 4:]


def directions(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    def unit(theta, phi):
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)

    return unit(*angles[:, :2].T), unit(*angles[:, 2:].T)


def written(path: Path, angles: np.ndarray, spectra: np.ndarray) -> Path:
    lines = ["# made by a test", str(len(WAVELENGTHS)), " ".join(map(str, WAVELENGTHS)), ""]
    lines += [" ".join(f"{x:.17g}" for x in row) for row in np.concatenate([angles, spectra], axis=1)]
    path.write_text("\n".join(lines) + "\n")
    return path


def made(seed: int = 1, count: int = 40) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    angles = rng.uniform(size=(count, 4)) * [1.3, 0.0, 1.2, np.pi]
    return angles, rng.uniform(0.1, 0.2, size=(count, len(WAVELENGTHS)))


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_the_measurements_are_found_again(name):
    angles, wavelengths, spectra = parsed(require(name))
    assert len(angles) == 1439
    material = read(name)
    wi, wo = directions(angles)
    assert material.covers(wi, wo).all()
    found, expected = material.function(wi, wo) / wi[:, 2:], to_linear_srgb(wavelengths, spectra)
    # away from the edge of the data, where the table's cells reach beyond it
    inner = (angles[:, 0] < 1.3) & (angles[:, 2] < 1.3)
    scale = expected.max(axis=1, keepdims=True) + 1e-3
    error = np.abs(found - expected) / scale
    assert np.median(error[inner]) < 0.004
    assert np.quantile(error[inner], 0.99) < 0.05
    assert np.median(error[~inner]) < 0.02
    # the peak
    top = np.argmax(expected.max(axis=1))
    np.testing.assert_allclose(found[top], expected[top], rtol=0.1)


def split(angles: np.ndarray, how: str) -> list[np.ndarray]:
    """Groups of measurements to leave out together."""
    if how == "geometry":
        return [np.array([k]) for k in np.random.default_rng(2).choice(len(angles), 8, replace=False)]
    return [np.flatnonzero(np.abs(angles[:, 0] - np.radians(theta)) < 0.01) for theta in (30, 60)]


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
@pytest.mark.parametrize(("how", "median", "spread"), [("geometry", 0.05, 0.3), ("plane", 0.03, 0.15)])
def test_measurements_left_out_are_found_from_the_others(name, how, median, spread):
    """Twice what `scattered` states for all of them, as these are few."""
    angles, wavelengths, spectra = parsed(require(name))
    xyz = to_xyz(wavelengths, spectra)
    wi, wo = directions(angles)
    found, expected = [], []
    for out in split(angles, how):
        kept = np.delete(np.arange(len(angles)), out)
        found.append(interpolated(wi[kept], wo[kept], xyz[kept])(wi[out], wo[out]))
        expected.append(xyz[out])
    found, expected = np.concatenate(found), np.concatenate(expected)
    assert np.median(np.abs(found - expected) / (expected + 1e-3)) < median
    assert np.sqrt(np.mean(np.log((found + 2e-3) / (expected + 2e-3)) ** 2)) < spread


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_the_table_is_near_what_it_was_made_of(name):
    angles, wavelengths, spectra = parsed(require(name))
    exact = interpolated(*directions(angles), to_xyz(wavelengths, spectra))
    material = read(name)
    wi, wo = hemisphere(4000, 3), hemisphere(4000, 4)
    covered = material.covers(wi, wo) & (wi[:, 2] > 0.25) & (wo[:, 2] > 0.25)
    wi, wo = wi[covered], wo[covered]
    luminance = np.array([0.2126, 0.7152, 0.0722])
    found, expected = (material.function(wi, wo) / wi[:, 2:]) @ luminance, exact(wi, wo)[:, 1]
    error = np.abs(found - expected) / (expected + 1e-3)
    assert np.median(error) < 0.004
    assert np.quantile(error, 0.95) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("name", REAL)
def test_the_lobe_is_round_and_at_the_mirror_direction(name):
    material = read(name)
    theta = np.radians(np.linspace(-8, 8, 33))
    wi = np.array([[np.sin(np.radians(40)), 0.0, np.cos(np.radians(40))]])
    mirror = np.radians(40) + theta
    wo = np.stack([-np.sin(mirror), 0 * mirror, np.cos(mirror)], axis=1)
    green = material.function(np.repeat(wi, 33, axis=0), wo)[:, 1]
    assert abs(np.argmax(green) - 16) <= 6  # off-specular peaks lie beyond the mirror direction
    assert np.all(green > green.max() / 4)


def test_beyond_the_data_it_holds_or_is_black(tmp_path):
    path = written(tmp_path / "made.brdf", *made())
    nearest, zero = cornell.read(path), cornell.read(path, "zero")
    theta_i, theta_s = (made()[0][:, column].max() for column in (0, 2))

    def at(theta):
        return np.array([[np.sin(theta), 0.0, np.cos(theta)]])

    for beyond_i, beyond_s in ((theta_i + 0.1, 0.3), (0.3, theta_s + 0.1)):
        wi, wo = at(beyond_i), at(beyond_s)
        assert not nearest.covers(wi, wo)[0]
        assert np.all(zero.function(wi, wo) == 0.0)
        held = nearest.function(wi, wo) / wi[:, 2:]
        edge_i, edge_s = at(min(beyond_i, theta_i)), at(min(beyond_s, theta_s))
        assert nearest.covers(edge_i, edge_s)[0]
        np.testing.assert_allclose(held, nearest.function(edge_i, edge_s) / edge_i[:, 2:], rtol=0.03)
    inside = at(0.5), at(0.4)
    np.testing.assert_array_equal(zero.function(*inside), nearest.function(*inside))


def test_source_is_light_and_detector_is_eye(tmp_path):
    rng = np.random.default_rng(5)
    angles = rng.uniform(size=(300, 4)) * [1.2, 0.0, 1.2, np.pi]
    spectra = np.repeat(1.0 + 2.0 * np.cos(angles[:, :1]), len(WAVELENGTHS), axis=1)
    material = cornell.read(written(tmp_path / "made.brdf", angles, spectra))
    high, low = np.array([[0.0, 0.0, 1.0]]), np.array([[np.sin(1.0), 0.0, np.cos(1.0)]])
    np.testing.assert_allclose(material.function(high, low), 3.0, rtol=0.03)
    np.testing.assert_allclose(material.function(low, high), (1 + 2 * np.cos(1.0)) * np.cos(1.0), rtol=0.03)


def test_negative_spectra_are_missing_and_out_of_gamut_colors_are_kept(tmp_path):
    angles, spectra = made(count=60)
    spectra[:] = [0.02, 0.5, 0.5, 0.3, 0.02, 0.0, 0.0]  # a saturated cyan
    spectra[7, 3] = -1.0
    material = cornell.read(written(tmp_path / "cyan.brdf", angles, spectra))
    assert material.notes[0].startswith("59 geometries")
    assert "59 are outside sRGB" in material.notes[1]
    assert "D65" in material.notes[1]
    assert material.notes[2].startswith("1 geometries have negative values")
    wi = np.array([[0.3, 0.0, np.sqrt(1 - 0.09)]])
    expected = to_linear_srgb(WAVELENGTHS, spectra[0])
    assert expected[0] < 0
    np.testing.assert_allclose(material.function(wi, wi)[0] / wi[0, 2], expected, rtol=0.02)
    assert material.label == "cyan"
    assert material.source == "Cornell"


HEAD = "2\n400 700\n"
ROW = "0.1 0 0.2 0 0.5 0.5\n"


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("", "must begin with the number of wavelengths"),
        ("# only a comment\n", "must begin with the number of wavelengths"),
        ("two\n400 700\n", "must begin with the number of wavelengths, got 'two'"),
        ("1000000000\n400 700\n", "1000000000 wavelengths are declared, and 2 numbers follow"),
        ("1\n400\n" + "0.1 0 0.2 0 0.5\n" * 12, "1 wavelengths are declared"),
        (HEAD, "rows must have 4 \\+ 2 numbers, but 0 are left"),
        (HEAD + ROW * 12 + "0.1 0\n", "but 74 are left, no multiple"),
        (HEAD + ROW * 3, "3 geometries have data, at least 10 are needed"),
        (
            HEAD + ROW * 12 + "1.6 0 0.2 0 0.5 0.5\n",
            r"theta_i \(radians\) must be in \[0, 1.570796\], got 1.6",
        ),
        (HEAD + ROW * 12 + "0.1 0 40 0 0.5 0.5\n", r"theta_s \(radians\)"),
        (HEAD + ROW * 12 + "0.1 0 0.2 90 0.5 0.5\n", r"phi_s \(radians\)"),
        (HEAD + ROW * 12 + "0.1 0 0.2 0 nan 0.5\n", "1 numbers are not finite, the first is 'nan'"),
        (HEAD + ROW * 12 + "0.1 0 0.2 0 red 0.5\n", "expected a number, got 'red'"),
        (HEAD + ROW * 12 + "0.1 0 0.2 0 1e30 0.5\n", "values must be in"),
        ("2\n700 400\n" + ROW * 12, "wavelengths must increase"),
        ("2\n0.4 0.7\n" + ROW * 12, r"wavelengths \(nm\) must be in \[100, 100000\], got 0.4"),
        ("2\n800 900\n" + ROW * 12, "wavelengths must reach into 380 to 780 nm"),
        (HEAD + "0.1 0 0.2 0 -1 0.5\n" * 12, "0 geometries have data"),
        (HEAD + ROW * 5000, "5000 geometries are too many"),
    ],
)
def test_files_that_are_damaged_are_refused_in_one_line(tmp_path, content, text):
    path = tmp_path / "bad.brdf"
    path.write_text(content)
    with pytest.raises(ValueError, match=text) as caught:
        cornell.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_file_is_recognised_by_its_beginning(tmp_path):
    content = written(tmp_path / "made.brdf", *made()).read_bytes()
    assert cornell.recognises(content[:4096], len(content))
    others = (b"", b"\x00\x01\x02", b"#DIM 1 3\n2\n400 700", b"2\nred blue", b"{}", b"2", b"1 2 3\n400 5 6")
    assert not any(cornell.recognises(head, len(head)) for head in others)
