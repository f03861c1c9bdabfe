"""What figures 9 and 10 of [RH02] compare SHRMs with, and how."""

import numpy as np
import pytest
from shrm import Environment
from shrm_papers.comparison import Frames
from shrm_papers.result import Settings
from shrm_papers.rh02 import figure_9, figure_10
from shrm_papers.rh02.velvet import velvet
from support.light import band_limited_environment


def test_random_frames_are_what_they_say():
    frames = Frames.drawn(4000)
    cosine = np.einsum("nk,nk->n", frames.normals, frames.views)
    assert cosine.min() >= 0
    np.testing.assert_allclose(np.mean(cosine**2), 1 / 2, atol=4 * np.sqrt(1 / 12 / 4000))
    np.testing.assert_allclose(np.einsum("nk,nk->n", frames.normals, frames.tangents), 0, atol=1e-14)
    for x in (frames.normals, frames.views):  # of variance 1/3 each
        np.testing.assert_allclose(x.mean(axis=0), 0, atol=4 * np.sqrt(1 / 3 / 4000))


def test_the_velvet_s_distribution_is_normalised_and_its_light_comes_from_the_rim():
    white = velvet(0.5, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    # D at theta_h from L = V: f = D / (4 (2 c - c^2)), rho_hat = f c
    x, w = np.polynomial.legendre.leggauss(200)
    c, w = (1 + x) / 2, w / 2
    along = np.stack([np.sqrt(1 - c**2), 0 * c, c], axis=1)
    D = white.transfer(along, along)[:, 0] * 4 * (2 - c)
    np.testing.assert_allclose(2 * np.pi * np.sum(w * c * D), 1, rtol=1e-6)
    assert D[0] > 2 * D[-1]


@pytest.mark.slow
@pytest.mark.parametrize("figure", [figure_9, figure_10], ids=["rh02-figure-9", "rh02-figure-10"])
def test_quick_figures(figure):
    settings = Settings(band_limited_environment(6, seed=8, H=32), "a test", quick=True)
    result = figure.make(settings)
    assert result.name == figure.NAME
    assert result.figure is not None
    assert all(len(row) == len(result.columns) for row in result.rows)
    errors = np.array([row[-2:] for row in result.rows], dtype=float)
    assert np.all((errors > 0) & (errors < 1))
    assert f"| {result.columns[0]} |" in result.markdown()


def test_the_fabric_is_the_fit_where_there_is_one(tmp_path):
    env = Environment.daylight(size=16)
    assert figure_9.fabric(Settings(env, "daylight")).name == f"merl-sgd:{figure_9.FIT[1]}"
    (tmp_path / "merl_sgd_bagher2012.json").write_text("{}")
    assert figure_9.fabric(Settings(env, "daylight", tmp_path)).name == "velvet"
