"""The basis of Koenderink and van Doorn, and CUReT's files of measurements and coefficients."""

import numpy as np
import pytest
from scipy.special import eval_jacobi
from shrm.brdf.measured import curet
from shrm.brdf.measured import koenderink_van_doorn as kvd
from support.directions import hemisphere, turned

KVD_TABLE = 0.01
"""What the table over half angles may miss of a fit's largest value."""


def spread(count: int, seed: int, largest: float = 1.4) -> np.ndarray:
    """theta_i phi_i theta_v phi_v, well spread, below an angle from the normal."""
    u = np.random.default_rng(seed).uniform(size=(count, 4))
    theta = np.arccos(1 - u[:, [0, 2]] * (1 - np.cos(largest)))
    return np.stack([theta[:, 0], 2 * np.pi * u[:, 1], theta[:, 1], 2 * np.pi * u[:, 3]], axis=1)


def directions(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    def unit(theta, phi):
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)

    return unit(*angles[:, :2].T), unit(*angles[:, 2:].T)


def coefficients(seed: int, channels: int = 3) -> np.ndarray:
    """Of order 8, (55, channels), of a BRDF that is positive everywhere."""
    a = 0.002 * np.random.default_rng(seed).normal(size=(55, channels))
    a[0] = 3.0
    return a


def write_rows(path, rows) -> None:
    path.write_text("\n".join(" ".join(f"{x:.17g}" for x in row) for row in rows) + "\n")


# The basis ----------------------------------------------------------------------------------------


def test_there_are_as_many_functions_as_published():
    assert [len(kvd.indices(order)) for order in (0, 2, 8)] == [1, 5, 55]
    n, m, l = kvd.indices(8).T
    assert np.all((l >= 0) & (l <= m) & (m <= n) & (n <= 8) & ((n - l) % 2 == 0) & ((m - l) % 2 == 0))


def test_they_are_orthogonal_over_both_hemispheres():
    # Of degree 16 in cos(theta) at most and 16 in the azimuth, for which these rules are exact.
    x, w = np.polynomial.legendre.leggauss(10)
    phi = 2 * np.pi * np.arange(20) / 20
    cos_i, cos_v, phi = (a.ravel() for a in np.meshgrid((x + 1) / 2, (x + 1) / 2, phi, indexing="ij"))
    weight = np.repeat(np.outer(w / 2, w / 2).ravel(), 20) / 20 * (2 * np.pi) ** 2
    wi, wo = directions(np.stack([np.arccos(cos_i), 0 * phi, np.arccos(cos_v), phi], axis=1))
    basis = kvd.evaluate(8, wi, wo) / kvd.norms(8)
    np.testing.assert_allclose((basis * weight[:, None]).T @ basis, np.eye(55), atol=1e-12)


def test_they_are_zernike_functions_of_the_disk_that_keeps_areas():
    """Against R_n^l(r) = (-1)^k r^l P_k^(l, 0)(1 - 2 r^2), k = (n - l) / 2, by Jacobi's polynomials."""
    angles = spread(50, 1, np.pi / 2)
    wi, wo = directions(angles)

    def theta_nl(n, l, theta):
        r, k = np.sqrt(2) * np.sin(theta / 2), (n - l) // 2
        return np.sqrt((n + 1) / (2 * np.pi)) * (-1) ** k * r**l * eval_jacobi(k, l, 0, 1 - 2 * r * r)

    found = kvd.evaluate(8, wi, wo)
    for (n, m, l), column in zip(kvd.indices(8).tolist(), found.T, strict=True):
        i, v = angles[:, 0], angles[:, 2]
        both = theta_nl(n, l, i) * theta_nl(m, l, v) + theta_nl(m, l, i) * theta_nl(n, l, v)
        expected = both * np.cos(l * (angles[:, 1] - angles[:, 3]))
        np.testing.assert_allclose(column, expected, atol=1e-10, err_msg=f"{n} {m} {l}")


def test_they_are_reciprocal_and_isotropic():
    wi, wo = hemisphere(200, 2), hemisphere(200, 3)
    found = kvd.evaluate(8, wi, wo)
    np.testing.assert_allclose(kvd.evaluate(8, wo, wi), found, atol=1e-12)
    np.testing.assert_allclose(kvd.evaluate(8, turned(wi, 1.0), turned(wo, 1.0)), found, atol=1e-12)


def test_the_first_is_lambert():
    up = np.array([[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(kvd.evaluate(0, up, up), 1 / np.pi)  # 2 (1 / sqrt(2 pi))^2


@pytest.mark.parametrize("count", [205, 1000])
def test_a_fit_finds_the_coefficients_of_what_it_spans(count):
    wi, wo = directions(spread(count, 4))
    a = np.random.default_rng(5).normal(size=(55, 3))
    np.testing.assert_allclose(kvd.fit(8, wi, wo, kvd.evaluate(8, wi, wo) @ a), a, atol=1e-10)


# Files --------------------------------------------------------------------------------------------


def require_equal(material, a: np.ndarray, largest: float, seed: int = 6) -> None:
    """Whether a material is what its coefficients say, at directions below an angle from the normal."""
    wi, wo = directions(spread(2000, seed, largest))
    expected = kvd.evaluate(8, wi, wo) @ a
    assert material.covers(wi, wo).all()
    found = material.function(wi, wo) / wi[:, 2:]
    np.testing.assert_allclose(found, expected, atol=KVD_TABLE * expected.max())


def test_rows_of_directions_and_values(tmp_path):
    angles, a, path = spread(205, 7), coefficients(8), tmp_path / "felt.txt"
    values = kvd.evaluate(8, *directions(angles)) @ a
    write_rows(path, np.concatenate([angles, values], axis=1))
    head = path.read_bytes()[:4096]
    assert curet.recognises(head, path.stat().st_size)
    material = curet.read(path)
    assert (material.label, material.source) == ("felt", "CUReT")
    assert "205 measurements" in material.notes[0]
    assert float(material.notes[0].rsplit(maxsplit=1)[1]) < 1e-10  # the error of the fit
    require_equal(material, a, angles[:, [0, 2]].max())
    limit = angles[:, [0, 2]].max()
    beyond = np.array([[np.sin(limit + 0.05), 0.0, np.cos(limit + 0.05)]])
    up = np.array([[0.0, 0.0, 1.0]])
    assert not material.covers(up, beyond)[0]
    assert np.all(curet.read(path, "zero").function(up, beyond) == 0.0)
    edge = np.array([[np.sin(limit), 0.0, np.cos(limit)]])
    np.testing.assert_allclose(material.function(up, beyond), material.function(up, edge), rtol=0.01)


def test_a_grey_column_and_missing_values(tmp_path):
    angles, a, path = spread(205, 9), coefficients(10, 1), tmp_path / "felt.txt"
    values = kvd.evaluate(8, *directions(angles)) @ a
    values[[3, 50]] = -1.0
    write_rows(path, np.concatenate([angles, values], axis=1))
    material = curet.read(path)
    assert material.notes[1].startswith("2 measurements are negative")
    require_equal(material, np.repeat(a, 3, axis=1), 1.3)


def test_the_files_of_the_database(tmp_path):
    """Measurements of samples 1 to 3, a file for each channel, and the directions in their own."""
    angles = spread(205, 11)
    samples = [coefficients(seed) for seed in (12, 13, 14)]
    values = [kvd.evaluate(8, *directions(angles)) @ a for a in samples]
    for channel, name in enumerate("rgb"):
        rows = [[k + 1, *value[:, channel]] for k, value in enumerate(values)]
        write_rows(tmp_path / f"{name}brdf.dat", rows)
    write_rows(tmp_path / "abrdf.dat", [[k + 1, *value.mean(axis=1)] for k, value in enumerate(values)])
    numbers = np.arange(1, 206)[:, None]
    write_rows(tmp_path / "table.txt", np.concatenate([numbers, angles[:, [2, 3, 0, 1]]], axis=1))
    head = (tmp_path / "rbrdf.dat").read_bytes()[:4096]
    assert curet.recognises(head, (tmp_path / "rbrdf.dat").stat().st_size)
    for name in ("rbrdf.dat", "bbrdf.dat"):
        material = curet.read(tmp_path / name, sample=2)
        assert material.label == f"{name[:5]} sample 2"
        require_equal(material, samples[1], 1.3)
    grey = np.repeat(samples[2].mean(axis=1, keepdims=True), 3, axis=1)
    require_equal(curet.read(tmp_path / "abrdf.dat", sample=3), grey, 1.3)
    with pytest.raises(ValueError, match="holds 3 samples, numbers 1 to 3: say which"):
        curet.read(tmp_path / "rbrdf.dat")
    with pytest.raises(ValueError, match="has 0 rows for sample 62"):
        curet.read(tmp_path / "rbrdf.dat", sample=62)
    write_rows(tmp_path / "table.txt", angles)
    with pytest.raises(ValueError, match=r"table\.txt: must have 205 rows of 5 numbers, got 205 of 4"):
        curet.read(tmp_path / "rbrdf.dat", sample=2)
    (tmp_path / "table.txt").unlink()
    with pytest.raises(FileNotFoundError):
        curet.read(tmp_path / "rbrdf.dat", sample=2)


def test_files_of_coefficients(tmp_path):
    samples = [coefficients(seed) for seed in (15, 16)]
    for channel, name in enumerate("rgb"):
        rows = [[k + 1, *a[:, channel]] for k, a in enumerate(samples)]
        write_rows(tmp_path / f"kp8{name}.dat", rows)
    write_rows(tmp_path / "kp2.dat", [[1, 3.0, 0.0, 0.0, 0.0, 0.0]])
    head = (tmp_path / "kp8r.dat").read_bytes()
    assert curet.recognises(head[:4096], len(head))
    require_equal(curet.read(tmp_path / "kp8g.dat", sample=2), samples[1], np.pi / 2 - 1e-6)
    wi, wo = hemisphere(100, 17), hemisphere(100, 18)
    grey = curet.read(tmp_path / "kp2.dat")
    np.testing.assert_allclose(grey.function(wi, wo), np.repeat(3.0 / np.pi * wi[:, 2:], 3, 1), rtol=1e-5)


def test_a_fit_below_zero_is_cut_and_says_so(tmp_path):
    a = coefficients(19)
    a[:, 0] = 5 * np.random.default_rng(20).normal(size=55)
    for channel, name in enumerate("rgb"):
        write_rows(tmp_path / f"kp8{name}.dat", [[1, *a[:, channel]]])
    material = curet.read(tmp_path / "kp8r.dat")
    assert any("below 0, and cut there, at" in note for note in material.notes)
    wi, wo = hemisphere(500, 21), hemisphere(500, 22)
    assert np.all(material.function(wi, wo) >= 0.0)


ROW = "0.1 0 0.2 0 0.5\n"


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("", "has no rows of numbers"),
        ("1 2 3\n", "rows must have 6 or 56 numbers .* got 3"),
        (ROW + "0.1 0 0.2 0\n", "row 2 has 4 numbers where the first has 5"),
        (ROW * 20, "20 measurements are too few for 55 coefficients"),
        (ROW * 60 + "0.1 0 1.6 0 0.5\n", r"theta_v \(radians\) must be in"),
        (ROW * 60 + "0.1 0 0.2 400 0.5\n", r"phi_v \(radians\) must be in"),
        (ROW * 60 + "0.1 0 0.2 0 nan\n", "1 numbers are not finite"),
        (ROW * 60 + "0.1 0 0.2 0 red\n", "expected a number, got 'red'"),
        ("1 " + "1e300 " * 55 + "\n", "coefficients must be in"),
        ("1 " + "0.1 " * 55 + "\n1 " + "0.1 " * 55 + "\n", "holds 2 samples"),
        ("\x00\x01", "is not text"),
    ],
)
def test_files_that_are_damaged_are_refused_in_one_line(tmp_path, content, text):
    path = tmp_path / "bad.dat"
    path.write_text(content)
    with pytest.raises(ValueError, match=text) as caught:
        curet.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_other_files_are_not_recognised():
    others = (b"", b"\xff\xfe", b"#DIM 1 3\n0.1 0 0.2 0 0.5", b"31\n400 410", b"a b c d e", b"9 0 9 0 1\n")
    assert not any(curet.recognises(head, len(head)) for head in others)
