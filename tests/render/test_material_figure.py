"""The picture of a material."""

import io

import numpy as np
import pytest
from matplotlib.image import imread
from shrm import Environment, brdf
from shrm.render.material_figure import F, P, _energies, material_figure

LIGHT = Environment(np.random.default_rng(1).uniform(0.5, 2.0, (16, 32, 3)).astype(np.float32))


@pytest.mark.slow
@pytest.mark.parametrize("text", ["lambert:0.3 + ggx:0.3", "banks:0.8", "lafortune:skin"])
def test_it_is_drawn(text: str) -> None:
    drawn = io.BytesIO()
    material_figure(brdf.parse(text), LIGHT, "noise", tolerance=0.1).savefig(drawn, format="png")
    drawn.seek(0)
    pixels = imread(drawn, format="png")
    assert pixels.shape[0] > 500
    assert np.unique(pixels[..., :3].reshape(-1, 3), axis=0).shape[0] > 100


def test_its_energies_are_shares_that_grow_with_P() -> None:
    energy, captured = _energies(brdf.parse("lambert:0.3 + ggx:0.3"))
    assert energy.shape == (F + 1,)
    assert captured.shape == (P + 1, F + 1)
    assert 0.99 < energy.sum() <= 1 + 1e-9
    assert np.all(np.diff(captured.sum(axis=1)) >= -1e-12)
    assert np.all(captured <= energy + 1e-9)


def test_anisotropic_materials_have_none() -> None:
    with pytest.raises(ValueError, match="anisotropic"):
        material_figure(brdf.AshikhminShirley(nu=40, nv=10), LIGHT, "noise")
