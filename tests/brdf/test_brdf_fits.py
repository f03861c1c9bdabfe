"""Published fits to measured materials: the models, and the parameters that come with the package."""

import json
from pathlib import Path

import numpy as np
import pytest
from shrm.brdf import ABC, BRDF, SGD, Lafortune, directional_albedo, fits, parse
from shrm.brdf.models.abc_model import fresnel
from support.data import require

# Made up, in the range of the published ones; two of the second go below zero unless they are cut.
MADE_UP: dict[str, BRDF] = {
    "abc": ABC(kD=(0.1, 0.2, 0.3), A=(40.0, 30.0, 20.0), B=900.0, C=1.3, ior=1.6),
    "sgd": SGD(
        rhoD=(0.1, 0.2, 0.0),
        rhoS=(0.3, 0.2, 0.1),
        alpha=(0.01, 0.05, 0.3),
        p=(0.5, 0.2, 1.1),
        f0=(0.05, 0.0, 0.1),
        f1=(0.06, -0.5, 0.2),
        K=(80.0, 20.0, 4.0),
        lam=(3.0, 4.0e6, 2.0),
        c=(1e-7, 1e38, 0.03),
        k=(30.0, 500.0, 8.0),
        theta0=(0.2, 1.0, -0.3),
    ),
}
FILES = {"merl-abc": "merl_abc_low2012.json", "merl-sgd": "merl_sgd_bagher2012.json"}


def directions(n: int, seed: int) -> np.ndarray:
    w = np.random.default_rng(seed).normal(size=(n, 3))
    w[:, 2] = np.abs(w[:, 2]) + 1e-3
    return w / np.linalg.norm(w, axis=1, keepdims=True)


@pytest.mark.parametrize("name", MADE_UP)
def test_models_are_reciprocal_and_not_negative(name: str) -> None:
    wi, wo = directions(2000, 1), directions(2000, 2)
    forth = MADE_UP[name].transfer(wi, wo) / wi[:, 2:]
    back = MADE_UP[name].transfer(wo, wi) / wo[:, 2:]
    np.testing.assert_allclose(forth, back, rtol=1e-9)
    assert forth.min() >= 0


@pytest.mark.parametrize("name", MADE_UP)
def test_models_peak_at_the_mirror_direction(name: str) -> None:
    theta = np.linspace(-1.5, 1.5, 3001)  # the plane of N and V
    wi = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    wo = np.broadcast_to([np.sin(-0.5), 0.0, np.cos(-0.5)], wi.shape)
    f = (MADE_UP[name].transfer(wi, wo) / wi[:, 2:]).sum(axis=1)
    assert abs(theta[np.argmax(f)] - 0.5) < 0.02  # of a lobe 0.1 wide or wider


@pytest.mark.parametrize("name", MADE_UP)
def test_models_reflect_nothing_below_the_horizon(name: str) -> None:
    wi, wo = directions(50, 3), directions(50, 4)
    wi[:, 2] *= -1
    assert not MADE_UP[name].transfer(wi, wo).any()


@pytest.mark.parametrize("name", MADE_UP)
def test_a_models_name_is_its_text(name: str) -> None:
    again = parse(MADE_UP[name].name)
    assert again == MADE_UP[name]
    assert hash(again) == hash(MADE_UP[name])


def test_fresnel_at_its_known_angles() -> None:
    n = 1.5
    brewster = np.cos(np.arctan(n))
    expected = [((n - 1) / (n + 1)) ** 2, 0.5 * ((n * n - 1) / (n * n + 1)) ** 2, 1.0]
    np.testing.assert_allclose(fresnel(n, np.array([1.0, brewster, 0.0])), expected, rtol=1e-12)


# ---- The parameters that come with the package


@pytest.mark.parametrize(("source", "count"), [("merl-abc", 100), ("merl-sgd", 86), ("lafortune", 6)])
def test_every_fit_has_a_name_that_parses_to_it(source: str, count: int) -> None:
    names = fits.names(source)
    assert len(names) == count
    assert list(names) == sorted(names)
    for name in names:
        assert parse(f"{source}:{name}").name == fits.fit(source, name).name
        assert parse(fits.fit(source, name).name).name == fits.fit(source, name).name


@pytest.mark.parametrize("source", FILES)
def test_fits_are_the_published_numbers(source: str) -> None:
    """Against the numbers as they were extracted elsewhere, each written to six digits or so."""
    published = json.loads(require(f"brdf/{FILES[source]}").read_text())
    assert list(fits.names(source)) == sorted(published)
    read = {"merl-abc": ABC, "merl-sgd": SGD}[source].read
    wi, wo = directions(20, 5), directions(20, 6)
    for name in fits.names(source):
        found = fits.fit(source, name).transfer(wi, wo)
        np.testing.assert_array_equal(found, read(require(f"brdf/{FILES[source]}"), name).transfer(wi, wo))


def test_lafortunes_fits_are_the_published_numbers() -> None:
    path = require("brdf/lafortune_pbrt1.json")
    wi, wo = directions(20, 5), directions(20, 6)
    for name in json.loads(path.read_text()):
        found = fits.fit("lafortune", name).transfer(wi, wo)
        np.testing.assert_array_equal(found, Lafortune.read(path, name).transfer(wi, wo))


@pytest.mark.slow
@pytest.mark.parametrize("source", FILES)
def test_fits_are_reciprocal_and_reflect_no_more_than_they_get(source: str) -> None:
    wi, wo = directions(200, 3), directions(200, 4)
    for k, name in enumerate(fits.names(source)[::9]):
        brdf = fits.fit(source, name)
        forth = brdf.transfer(wi, wo) / wi[:, 2:]
        np.testing.assert_allclose(forth, brdf.transfer(wo, wi) / wo[:, 2:], rtol=1e-9, err_msg=name)
        assert forth.min() >= 0, name
        if k % 3 == 0:  # an integral of a second
            assert albedo(brdf).max() <= 1, name


@pytest.mark.slow
def test_both_fits_of_a_metal_reflect_about_the_same() -> None:
    """Closer to equal than to a factor of pi, which the sources' conventions leave open."""
    metals = ("aluminium", "nickel", "chrome-steel", "alum-bronze")
    ratio = [
        albedo(fits.fit("merl-abc", name)).sum() / albedo(fits.fit("merl-sgd", name)).sum() for name in metals
    ]
    assert 1 / np.sqrt(np.pi) < np.exp(np.mean(np.log(ratio))) < np.sqrt(np.pi)


def test_a_fit_is_near_what_was_measured() -> None:
    """Pink felt of MERL, L = V in steps of the angle to N; a fourth of the peak is specular."""
    measured = np.loadtxt(require("brdf/pink-felt-1d.alta"))
    measured = measured[measured[:, 0] > 0.25]  # to 75 degrees
    w = np.stack([np.sqrt(1 - measured[:, 0] ** 2), 0 * measured[:, 0], measured[:, 0]], axis=1)
    found = fits.fit("merl-sgd", "pink-felt").transfer(w, w) / w[:, 2:]
    error = np.linalg.norm(found - measured[:, 1:]) / np.linalg.norm(measured[:, 1:])
    assert error < 0.1


def albedo(brdf: BRDF) -> np.ndarray:
    """At 30 degrees, of R, G, B."""
    return np.atleast_2d(directional_albedo(brdf, np.radians([30.0])))[0]


# ---- Names and files that are wrong


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("merl-abc", "needs the name of a material"),
        ("merl-abc:unobtainium", "no material 'unobtainium'; it has alum-bronze"),
        ("lafortune:", "needs the name of a material"),
        ("lafortune:#skin", "FILE#NAME"),
        ("abc:0.1,20,100,1,0.5", "ior must be"),
        ("sgd:1", "rhoS, alpha"),
    ],
)
def test_wrong_names_are_refused_in_a_line(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=said) as refusal:
        parse(text)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("model", ["abc", "sgd", "lafortune"])
def test_faulty_files_are_refused_in_a_line(model: str, tmp_path: Path) -> None:
    path = tmp_path / "fits.json"
    for text in ("{", "[1]", "\xff", '{"thing": {"kD": [0, 0, 0]}}', '{"thing": 1}', '{"other": {}}'):
        path.write_text(text, encoding="latin-1")
        with pytest.raises(ValueError, match=path.name) as refusal:
            parse(f"{model}:{path}#thing")
        assert "\n" not in str(refusal.value)
