"""Materials from text: what is understood, and what the refusals say."""

import json

import numpy as np
import pytest
from shrm import brdf


@pytest.mark.parametrize(
    ("text", "material"),
    [
        ("microfacet:0.2", brdf.Microfacet(0.2)),
        ("  GGX : alpha = 0.1 , f0 = 0.04 ", brdf.GGX(0.1, 0.04)),
        ("ggx:alpha=0.1,f0=1.0/0.8/0.3", brdf.GGX(0.1, (1.0, 0.8, 0.3))),
        ("ggx:0.1,0.04", brdf.GGX(0.1, 0.04)),
        ("beckmann:f0=0.5,alpha=0.2", brdf.Beckmann(0.2, 0.5)),
        ("lambert:0.5/0.25/1", brdf.Lambert((0.5, 0.25, 1.0))),
        ("phong:1e+3", brdf.Phong(1000.0)),
        ("phong:exponent=5e1", brdf.Phong(50.0)),
        ("kajiya-kay:32", brdf.KajiyaKay(32.0)),
        ("kajiya-kay:32,cone=mirror", brdf.KajiyaKay(32.0, "mirror")),
        ("banks:0.9", brdf.Banks(0.9)),
    ],
)
def test_a_text_names_a_material(text, material):
    assert brdf.parse(text) == material


@pytest.mark.parametrize(
    "text", ["0.5*lambert:0.8 + ggx:0.2", "0.5*lambert:0.8+ggx:alpha=2e-1", "0.25*2*lambert:0.8+ggx:.2"]
)
def test_sums(text):
    w = np.array([[0.0, 0.6, 0.8], [0.0, -0.6, 0.8]])
    expected = 0.5 * brdf.Lambert(0.8) + brdf.GGX(0.2)
    np.testing.assert_allclose(
        brdf.parse(text).transfer(w, w[::-1]), expected.transfer(w, w[::-1]), rtol=1e-14
    )


@pytest.mark.parametrize(
    "material",
    [
        brdf.Lambert(1 / 3),
        brdf.Lambert((0.1, 0.2, 1 / 3)),
        brdf.Phong(12.5),
        brdf.Microfacet(1e-5),
        brdf.GGX(0.1),
        brdf.GGX(0.1, (1.0, 0.5, 0.04)),
        brdf.Beckmann(1.0, 0.04),
        brdf.KajiyaKay(1e12, "mirror"),
        brdf.Banks(0.0),
        0.5 * brdf.Lambert(0.8) + (0.1, 1e20, 0.3) * brdf.Phong(3),
    ],
    ids=lambda m: m.name,
)
def test_names_are_read_back(material):
    again = brdf.parse(material.name)
    assert again.name == material.name
    w = np.array([[0.0, 0.6, 0.8], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(again.transfer(w, w[::-1]), material.transfer(w, w[::-1]))


def test_a_material_of_a_file(tmp_path):
    path = tmp_path / "measured.json"
    lobe = {"xy0": [-1, -1, -1], "z0": [1, 1, 1], "e0": [9, 8, 7], "diffuse": [0.1, 0.2, 0.3]}
    path.write_text(json.dumps({"paint": lobe}))
    material = brdf.parse(f"0.5*lafortune:{path}#paint + lambert:0.1")
    assert material.name == f"0.5*lafortune({path}#paint) + lambert(albedo=0.1)"
    assert brdf.parse(material.name).name == material.name
    assert material.channels == 3
    with pytest.raises(ValueError, match=r"no material 'skin'; it has 'paint'"):
        brdf.parse(f"lafortune:{path}#skin")
    with pytest.raises(FileNotFoundError):
        brdf.parse(f"lafortune:{tmp_path / 'none.json'}#skin")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a material"),
        ("ggx:0.1 +", "expected a material"),
        ("0.2", "expected a material"),
        ("plastic:0.2", "no material or file 'plastic'; known are lambert, phong, microfacet, ggx"),
        ("ggx", "alpha is missing, it takes alpha, f0=1.0"),
        ("ggx:", "alpha is missing"),
        ("ggx:roughness=0.1", "no parameter 'roughness', it takes alpha, f0=1.0"),
        ("ggx:0.1,0.2,0.3", "too many arguments, it takes alpha, f0=1.0"),
        ("ggx:0.1,alpha=0.2", "alpha is given twice"),
        ("ggx:0.1,", "f0 must be a number, got ''"),
        ("ggx:shiny", "alpha must be a number, got 'shiny'"),
        ("ggx:0.1/0.2/0.3", "alpha must be a number"),
        ("ggx:0.1,f0=0.1/0.2", "f0 must be a number"),
        ("ggx:nan", "alpha must be in"),
        ("ggx:alpha=2", "alpha must be in"),
        ("kajiya-kay:8,cone=hair", "cone must be"),
        ("kajiya-kay:8,cone=3", "cone must be"),
        ("red*ggx:0.1", "a factor must be a number or R/G/B, got 'red'"),
        ("-1*ggx:0.1", "factor must be in [0, 1e+30], got -1"),
        ("*ggx:0.1", "a factor must be"),
        ("lafortune:hide", "no material 'hide'; it has bluepaint"),
        ("lafortune:#skin", "FILE#NAME"),
        ("ggx(0.1", "expected a material"),
    ],
)
def test_refusals_are_one_line_and_say_what_is_known(text, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011  (the text is compared below)
        brdf.parse(text)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_only_text_is_parsed():
    with pytest.raises(TypeError, match="must be a string"):
        brdf.parse(0.2)


def test_a_name_that_looks_like_a_file_is_one(tmp_path):
    for name in ("paint.brdf", "paint.bsdf", "paint.binary", str(tmp_path / "paint")):
        with pytest.raises(FileNotFoundError):
            brdf.parse(name)
    path = tmp_path / "a+b*c.brdf"
    path.write_text("no measurements")
    with pytest.raises(ValueError, match="no file of measurements that is known") as caught:
        brdf.parse(str(path))
    assert str(caught.value).startswith(str(path))
