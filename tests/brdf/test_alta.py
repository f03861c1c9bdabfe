"""ALTA's text files: each set of coordinates, and the slice of MERL that comes with the library."""

import numpy as np
import pytest
from shrm import brdf
from shrm.brdf import fits
from shrm.brdf.measured import alta
from support.data import require
from support.directions import hemisphere

SLICE = "brdf/pink-felt-1d.alta"


def write(path, inputs, outputs, coordinates, values, extra=""):
    lines = [
        f"#DIM {coordinates.shape[1]} {values.shape[1]}",
        f"#PARAM_IN  {inputs}",
        f"#PARAM_OUT {outputs}",
    ]
    lines += [extra, "# a comment"]
    rows = np.concatenate([coordinates, values], axis=1)
    lines += ["\t".join(f"{x:.17g}" for x in row) + "\t" for row in rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_slice_is_found_again_at_its_rows():
    rows = np.loadtxt(require(SLICE))
    assert rows.shape == (90, 4)
    material = alta.read(require(SLICE))
    assert material.source == "ALTA"
    assert material.label == "pink-felt-1d"
    w = np.stack([np.sqrt(1 - rows[:, 0] ** 2), 0 * rows[:, 0], rows[:, 0]], axis=1)  # L = V = H
    assert material.covers(w, w).all()
    np.testing.assert_allclose(material.function(w, w) / w[:, 2:], rows[:, 1:], rtol=1e-12)
    # of the half angle alone: another pair with the same H
    tilt = np.array([0.0, 0.3, 0.0])
    wi, wo = (np.sqrt(1 - 0.09) * w[:60] + sign * tilt for sign in (1, -1))
    np.testing.assert_allclose(material.function(wi, wo) / wi[:, 2:], rows[:60, 1:], rtol=1e-9)


def test_the_slice_is_even_in_the_sine_and_looks_up_bins_of_merl():
    rows = np.loadtxt(require(SLICE))
    np.testing.assert_allclose(np.sqrt(1 - rows[:, 0] ** 2), (np.arange(90) + 0.5) / 90, atol=2e-5)
    # MERL's bin j holds theta_h from j^2 / 90 to (j + 1)^2 / 90 degrees
    bins = np.floor(np.sqrt(90 * np.degrees(np.arccos(rows[:, 0]))))
    equal = np.all(rows[1:, 1:] == rows[:-1, 1:], axis=1)
    assert equal.sum() == 14
    assert np.all((bins[1:] == bins[:-1])[equal])
    # no other angle whose rows are in bins of their own, or in the bins of even steps, would allow that
    even = np.floor(np.sqrt(90 * (np.arange(90) + 0.5)))
    assert not np.all((even[1:] == even[:-1])[equal])


def test_the_slice_agrees_with_the_published_fit():
    rows = np.loadtxt(require(SLICE))
    rows = rows[rows[:, 0] > 0.25]
    w = np.stack([np.sqrt(1 - rows[:, 0] ** 2), 0 * rows[:, 0], rows[:, 0]], axis=1)
    found = alta.read(require(SLICE)).function(w, w)
    expected = fits.fit("merl-sgd", "pink-felt").transfer(w, w)
    assert np.linalg.norm(found - expected) < 0.1 * np.linalg.norm(expected)


def test_one_coordinate_is_linear_in_between_and_held_beyond(tmp_path):
    theta = np.array([0.1, 0.5, 1.0])
    values = np.array([[3.0], [1.0], [0.5]])
    path = write(tmp_path / "a.alta", "COS_TH", "INV_STERADIAN", np.cos(theta)[::-1, None], values[::-1])
    material, black = alta.read(path), alta.read(path, "zero")

    def at(angle):
        w = np.array([[np.sin(angle), 0.0, np.cos(angle)]])
        return material.function(w, w)[0] / w[0, 2], black.function(w, w)[0] / w[0, 2], material.covers(w, w)

    np.testing.assert_allclose(at(0.3)[0], 2.0, rtol=1e-12)
    np.testing.assert_allclose(at(0.0)[0], 3.0, rtol=1e-12)
    assert at(0.9)[2][0]
    held, zero, covered = at(1.2)
    np.testing.assert_allclose(held, 0.5, rtol=1e-12)
    assert np.all(zero == 0.0)
    assert not covered[0]


MODEL = brdf.GGX(0.4, (1.0, 0.5, 0.2))


def f(wi, wo):
    """A BRDF, without the cosine, that light and eye cannot be exchanged in."""
    return MODEL.transfer(wi, wo) / wi[:, 2:] * (1 + wi[:, 2:])


def sampled(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions below 70 degrees from the normal."""
    wi, wo = hemisphere(4 * n, seed), hemisphere(4 * n, seed + 1)
    low = (wi[:, 2] > np.cos(1.2)) & (wo[:, 2] > np.cos(1.2))
    return wi[low][:n], wo[low][:n]


def half_angles_of_view(wi, wo):
    """theta_h, theta_d and phi_d of V about H: turn H to azimuth 0 and to the pole, as ALTA does."""
    rows = []
    for light, view in zip(wi, wo, strict=True):
        h = (light + view) / np.linalg.norm(light + view)
        theta, phi = np.arccos(h[2]), np.arctan2(h[1], h[0])
        about_z = np.array([[np.cos(phi), np.sin(phi), 0], [-np.sin(phi), np.cos(phi), 0], [0, 0, 1]])
        about_y = np.array([[np.cos(theta), 0, -np.sin(theta)], [0, 1, 0], [np.sin(theta), 0, np.cos(theta)]])
        d = about_y @ about_z @ view
        rows.append([theta, np.arccos(np.clip(d[2], -1, 1)), np.arctan2(d[1], d[0])])
    return np.array(rows)


def angles_of_both(wi, wo):
    azimuth = np.arctan2(wi[:, 1], wi[:, 0]) - np.arctan2(wo[:, 1], wo[:, 0])
    return np.stack([np.arccos(wo[:, 2]), np.arccos(wi[:, 2]), azimuth], axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "coordinates_of"),
    [("RUSIN_TH_TD_PD", half_angles_of_view), ("ISOTROPIC_TV_TL_DPHI", angles_of_both)],
)
def test_three_coordinates_tell_light_from_eye(tmp_path, name, coordinates_of):
    wi, wo = sampled(1500, 1)
    path = write(tmp_path / "a.alta", name, "RGB_COLOR", coordinates_of(wi, wo), f(wi, wo))
    material = alta.read(path)
    assert material.covers(wi, wo).all()
    at_rows = material.function(wi, wo) / wi[:, 2:]
    assert np.median(np.abs(at_rows / f(wi, wo) - 1)) < 0.005
    wi, wo = sampled(1000, 3)
    wi, wo = (w[(wi[:, 2] > 0.45) & (wo[:, 2] > 0.45)] for w in (wi, wo))
    error = material.function(wi, wo) / wi[:, 2:] / f(wi, wo) - 1
    assert np.median(np.abs(error)) < 0.02
    exchanged = material.function(wi, wo) / wi[:, 2:] / f(wo, wi) - 1
    assert np.median(np.abs(exchanged)) > 5 * np.median(np.abs(error))
    grazing = np.array([[np.sin(1.4), 0.0, np.cos(1.4)]])
    assert not material.covers(grazing, wo[:1])[0]
    assert np.all(alta.read(path, "zero").function(grazing, wo[:1]) == 0.0)


def test_two_coordinates_do_not_depend_on_the_third(tmp_path):
    theta_h, theta_d = (x.ravel() for x in np.meshgrid(np.linspace(0, 1.2, 30), np.linspace(0, 1.2, 20)))
    values = (np.exp(-((theta_h / 0.4) ** 2)) * (1 + theta_d) + 0.1)[:, None]
    coordinates = np.stack([theta_h, theta_d], axis=1)
    material = alta.read(write(tmp_path / "a.alta", "RUSIN_TH_TD", "INV_STERADIAN", coordinates, values))
    wi, wo = sampled(1000, 5)
    h = half_angles_of_view(wi, wo)
    expected = np.exp(-((h[:, 0] / 0.4) ** 2)) * (1 + h[:, 1]) + 0.1
    found = material.function(wi, wo) / wi[:, 2:]
    np.testing.assert_allclose(found, np.repeat(expected[:, None], 3, axis=1), rtol=0.02)


def test_intervals_of_confidence_and_missing_rows(tmp_path):
    cosines = np.linspace(0.2, 1.0, 10)[:, None]
    values = np.concatenate([cosines, 0 * cosines + 0.1], axis=1)
    values[3, 0] = -1.0
    path = write(tmp_path / "a.alta", "COS_TH", "INV_STERADIAN", cosines, values, "#VS 1")
    path.write_text(path.read_text().replace("#DIM 1 2", "#DIM 1 1"))
    material = alta.read(path)
    assert material.notes == ("9 rows over COS_TH", "1 rows have negative values: no data, left out")
    up = np.array([[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(material.function(up, up), 1.0)


HEADER = "#DIM 1 3\n#PARAM_IN COS_TH\n#PARAM_OUT RGB_COLOR\n"
ROWS = "0.9 1 1 1\n0.8 1 1 1\n"
KNOWN = "COS_TH, RUSIN_TH_TD, RUSIN_TH_TD_PD, ISOTROPIC_TV_TL_DPHI"


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("", "#PARAM_IN must be one of .* got none"),
        (HEADER, "has no rows of numbers"),
        (HEADER.replace("COS_TH", "COS_TK") + ROWS, f"#PARAM_IN must be one of {KNOWN}, got COS_TK"),
        (HEADER.replace("RGB_COLOR", "XYZ_COLOR") + ROWS, "must be one of RGB_COLOR, INV_STERADIAN, got XYZ"),
        (HEADER.replace("#DIM 1 3\n", "") + ROWS, "COS_TH and RGB_COLOR need the line #DIM 1 3, got none"),
        (HEADER.replace("1 3", "1000000000 3") + ROWS, "need the line #DIM 1 3, got #DIM 1000000000 3"),
        (HEADER.replace("1 3", "") + ROWS, "got #DIM"),
        (HEADER + "#FORMAT binary\n" + ROWS, "binary form, which is not read"),
        (HEADER + "0.9 1 1\n", r"rows must have 1 \+ 3 numbers, got 3"),
        (HEADER + "0.9 1 1 1 1\n", r"rows must have 1 \+ 3 numbers, got 5"),
        (HEADER + ROWS + "0.7 1\n", "row 3 has 2 numbers where the first has 4"),
        (HEADER + ROWS + "1.5 1 1 1\n", r"cos\(theta_h\) must be in \[0, 1\], got 1.5"),
        (HEADER + ROWS + "0.5 nan 1 1\n", "1 numbers are not finite"),
        (HEADER + ROWS + "0.5 red 1 1\n", "expected a number, got 'red'"),
        (HEADER + "0.5 1 1 1\n", "1 rows have data, at least 2 are needed"),
        (HEADER + ROWS * 3000, "6000 rows are too many"),
        (HEADER + "\x00\x01\x02", "is not text"),
        (HEADER + "0.9 1e30 1 1\n" + ROWS, "values must be in"),
        ("#DIM 2 1\n#PARAM_IN RUSIN_TH_TD\n#PARAM_OUT INV_STERADIAN\n2 0 1\n0 0 1\n", "theta_h must be in"),
        (
            "#DIM 3 1\n#PARAM_IN RUSIN_TH_TD_PD\n#PARAM_OUT INV_STERADIAN\n" + "1.5 1.5 0 1\n" * 3,
            "0 rows have light and eye above the surface",
        ),
    ],
)
def test_files_that_are_damaged_are_refused_in_one_line(tmp_path, content, text):
    path = tmp_path / "bad.alta"
    path.write_text(content)
    with pytest.raises(ValueError, match=text) as caught:
        alta.read(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_file_is_recognised_by_its_header():
    assert alta.recognises((HEADER + ROWS).encode(), 100)
    assert alta.recognises(b"# words\n\n#PARAM_IN COS_TH\n", 100)
    others = (b"", b"31\n400 410\n", b"\x89PNG\r\n", b"# DIM 1 3", b"#DIMS", b"0.1 0 0.2 0 1")
    assert not any(alta.recognises(head, len(head)) for head in others)
