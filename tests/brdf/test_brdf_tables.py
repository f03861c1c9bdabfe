"""Materials from functions, tables and files of coefficients."""

import json

import numpy as np
import pytest
from shrm import brdf
from support.data import require
from support.directions import direction, hemisphere, sphere, turned

MEASURED = "brdf/lafortune_pbrt1.json"


# Functions and tables -----------------------------------------------------------------------------


def test_a_function_gives_the_material_it_describes():
    model = brdf.GGX(0.2, (1.0, 0.5, 0.1))

    def without_cosine(wi, wo):
        return model.transfer(wi, wo) / wi[:, 2:]

    material = brdf.from_function(without_cosine)
    assert material.name == "without_cosine"
    assert [lobe.center for lobe in material.lobes] == ["lobe"]
    wi, wo = sphere(1000, 31), sphere(1000, 32)
    np.testing.assert_allclose(material.transfer(wi, wo), model.transfer(wi, wo), rtol=1e-13)
    assert np.all(material.transfer(-hemisphere(5, 1), hemisphere(5, 2)) == 0)


def test_a_function_about_the_tangent_has_no_cosine():
    model = brdf.Banks(0.3)
    material = brdf.from_function(model.transfer, center="tangent", name="copy")
    assert isinstance(material.lobes[0], brdf.ZonalLobe)
    wi, wo = sphere(1000, 33), sphere(1000, 34)
    np.testing.assert_allclose(material.transfer(wi, wo), model.transfer(wi, wo), atol=1e-12)


@pytest.mark.parametrize("center", ["lobe", "reflection", "normal"])
def test_functions_of_absolute_azimuth_are_refused(center):
    def ward(wi, wo):  # elliptical highlight
        h = wi + wo
        return np.exp(-((h[:, 0] / 0.2) ** 2 + (h[:, 1] / 0.1) ** 2) / h[:, 2] ** 2)

    with pytest.raises(ValueError, match="ward: depends on the absolute azimuth"):
        brdf.from_function(ward, center=center)


def test_functions_with_a_handedness_are_refused():
    def swirl(wi, wo):
        return 1 + wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]

    with pytest.raises(ValueError, match="sign of phi_i - phi_o"):
        brdf.from_function(swirl)


def test_functions_of_azimuth_about_the_tangent_are_refused():
    with pytest.raises(ValueError, match="azimuth about the tangent"):
        brdf.from_function(lambda wi, wo: 1 + wi[:, 0] * wo[:, 0], center="tangent")


@pytest.mark.parametrize(
    ("f", "error", "text"),
    [
        (lambda wi, wo: wi[:, :2], ValueError, r"must return the shape \(2,\) or \(2, 3\)"),
        (lambda wi, wo: 1.0, ValueError, "must return the shape"),
        (lambda wi, wo: wi[:, 0] * np.nan, ValueError, "must be finite"),
        (lambda wi, wo: wi[:, 0] * 1j, TypeError, "must return real numbers"),
        (3, TypeError, "must be a function"),
    ],
)
def test_functions_that_return_no_brdf_are_refused(f, error, text):
    with pytest.raises(error, match=text):
        brdf.from_function(f)


def test_a_function_that_fails_later_says_where():
    material = brdf.from_function(lambda wi, wo: np.where(wo[:, 2] == 0, np.nan, 1.0), name="fragile")
    with pytest.raises(ValueError, match=r"fragile: must be finite, got 1 of 1 .* wo = \(1, 0, 0\)"):
        material.transfer(hemisphere(1, 0), direction(0.0, 0.0))


def test_a_center_that_is_none_is_refused():
    with pytest.raises(ValueError, match="center must be one of"):
        brdf.from_function(lambda wi, wo: wi[:, 2], center="half")


def table_of(f, shape):
    ends = np.pi / 2, np.pi / 2, np.pi
    return f(
        *np.meshgrid(*(np.linspace(0, end, n) for end, n in zip(ends, shape, strict=True)), indexing="ij")
    )


def test_a_table_over_angles_is_exact_for_trilinear_functions():
    def f(theta_i, theta_o, phi):
        return (1 + theta_i) * (2 + theta_o) * (4 - phi)

    material = brdf.Tabulated(table_of(f, (4, 5, 6)))
    wi, wo = hemisphere(1000, 35), hemisphere(1000, 36)
    phi = np.abs(np.angle(np.exp(1j * (np.arctan2(wi[:, 1], wi[:, 0]) - np.arctan2(wo[:, 1], wo[:, 0])))))
    expected = f(np.arccos(wi[:, 2]), np.arccos(wo[:, 2]), phi) * wi[:, 2]
    np.testing.assert_allclose(material.transfer(wi, wo), expected, rtol=1e-10)
    assert np.all(material.transfer(-wi, wo) == 0)


def test_a_table_over_half_angles_is_exact_for_trilinear_functions():
    def f(theta_h, theta_d, phi_d):
        return (1 + theta_h) * (2 + theta_d) * (4 - phi_d)

    rgb = table_of(f, (4, 5, 6))[..., None] * [1.0, 2.0, 0.5]
    material = brdf.Tabulated(rgb, "half-angle")
    wi, wo = hemisphere(1000, 37), hemisphere(1000, 38)
    expected = np.empty((1000, 3))
    for n in range(1000):  # Rusinkiewicz 1998: turn H to the pole, about the normal and then about y
        h = (wi[n] + wo[n]) / np.linalg.norm(wi[n] + wo[n])
        theta_h, phi_h = np.arccos(h[2]), np.arctan2(h[1], h[0])
        c, s = np.cos(theta_h), np.sin(theta_h)
        d = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ turned(wi[n : n + 1], -phi_h)[0]
        value = f(theta_h, np.arccos(d[2]), np.abs(np.arctan2(d[1], d[0])))
        expected[n] = value * wi[n, 2] * np.array([1.0, 2.0, 0.5])
    np.testing.assert_allclose(material.transfer(wi, wo), expected, rtol=1e-9)


@pytest.mark.parametrize("axes", ["angles", "half-angle"])
def test_tables_are_isotropic(axes):
    material = brdf.Tabulated(np.random.default_rng(39).uniform(size=(5, 6, 7)), axes)
    wi, wo = hemisphere(500, 40), hemisphere(500, 41)
    value = material.transfer(wi, wo)
    np.testing.assert_allclose(material.transfer(turned(wi, 1.0), turned(wo, 1.0)), value, rtol=1e-9)


# Coefficients from files --------------------------------------------------------------------------


def test_skin_is_read_with_its_signs():
    skin = brdf.Lafortune.read(require(MEASURED), "skin")
    assert skin.name.endswith("#skin)")
    assert np.shape(skin.x) == (3, 3)
    # The third lobe (-0.999, 0.858, 64) points forward: the mirror direction outshines the way back.
    view = direction(np.cos(1.0), 0.0)
    ahead, back = skin.transfer(view * [-1, -1, 1], view), skin.transfer(view, view)
    assert np.all(ahead > 1.5 * back)
    assert np.all(brdf.directional_albedo(skin, [1.0, 0.7, 0.3]) < 1)


def test_every_material_of_the_file_is_read():
    names = list(json.loads(require(MEASURED).read_text()))
    assert "brushedmetal" in names
    for name in names:
        value = brdf.Lafortune.read(require(MEASURED), name).transfer(hemisphere(50, 42), hemisphere(50, 43))
        assert value.shape == (50, 3)
        assert np.all(np.isfinite(value))


LOBE = {"xy0": [-1, -1, -1], "z0": [1, 1, 1], "e0": [9, 9, 9]}


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("{", "not a JSON file"),
        ("[1]", "must be a JSON object"),
        ('{"felt": {}}', "no material 'skin'; it has 'felt'"),
        (json.dumps({"skin": []}), "must be a JSON object"),
        (json.dumps({"skin": {"z0": [1, 1, 1]}}), "xy0 or x0 is missing"),
        (json.dumps({"skin": {**LOBE, "e0": [9, 9]}}), "must share the shape"),
        (json.dumps({"skin": {**LOBE, "diffuse": "red"}}), "diffuse must be a number"),
        (json.dumps({"skin": {**LOBE, "xy1": [[1]], "z1": 1, "e1": 1}}), "unequal length"),
        (
            json.dumps({"skin": {"x0": [1, 1, 1], "y0": [0, 0, 0], "z0": [1, 1, 1], "e0": [1, 1, 1]}}),
            "absolute azimuth",
        ),
    ],
)
def test_files_that_are_no_coefficients_are_refused_by_name(tmp_path, content, text):
    path = tmp_path / "skin.json"
    path.write_text(content)
    with pytest.raises(ValueError, match=text) as caught:
        brdf.Lafortune.read(path, "skin")
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_an_oserror(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.json"):
        brdf.Lafortune.read(tmp_path / "none.json", "skin")


def test_a_binary_file_is_refused(tmp_path):
    path = tmp_path / "skin.json"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(ValueError, match="not a JSON file"):
        brdf.Lafortune.read(path, "skin")
