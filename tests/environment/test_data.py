"""The environments that come with the tests: their files are what their script makes, and what it says."""

import runpy

import numpy as np
import pytest
from shrm import Environment
from shrm.environment.layouts import solid_angles
from support.data import OWN

MAKE = runpy.run_path(str(OWN / "make.py"))


@pytest.mark.parametrize(("name", "env"), MAKE["environments"]().items(), ids=MAKE["environments"]())
def test_files_are_what_the_script_makes(name: str, env: Environment) -> None:
    found = Environment.read(OWN / name).pixels
    assert np.all(np.abs(found - env.pixels) <= env.pixels.max(axis=2, keepdims=True) / 128)
    assert (OWN / name).stat().st_size < 50_000


def test_the_irradiance_of_a_polygon_is_a_sum_over_it() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform([-2, -2, -1], [2, 2, 0], (5, 3))
    normals = np.tile([0.0, 0.0, 1.0], (5, 1))
    corners = np.array([[0.2, 0.1, 1.0], [0.2, 0.7, 1.0], [0.9, 0.7, 1.0], [0.9, 0.1, 1.0]])
    # The midpoint rule of 100 x 100 squares of sides .007: an error of (.007)^2 / 24 of curvatures below 10.
    x, y = np.meshgrid(0.2 + 0.7 * (np.arange(100) + 0.5) / 100, 0.1 + 0.6 * (np.arange(100) + 0.5) / 100)
    towards = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3) - points[:, None]
    square = (towards**2).sum(axis=2)
    expected = (towards[..., 2] ** 2 / square**2).sum(axis=1) * 0.7 * 0.6 / 1e4
    np.testing.assert_allclose(MAKE["irradiance"](points, normals, corners), expected, rtol=1e-4)


def test_nearly_all_energy_is_in_a_few_texels() -> None:
    """Lamps and the sun make their pictures hard: of the squares, half are in a hundredth of the sphere."""
    area = solid_angles("latlong", 64, 128)
    for name in ("sun.hdr", "lamps.hdr"):
        energy = (Environment.read(OWN / name).pixels.astype(float) ** 2).sum(axis=2) * area
        brightest = np.argsort(energy.ravel())[::-1]
        few = brightest[np.cumsum(area.ravel()[brightest]) < 0.01 * 4 * np.pi]
        assert energy.ravel()[few].sum() > 0.5 * energy.sum()
