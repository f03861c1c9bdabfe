"""Dual paraboloids with a border: in and out."""

from pathlib import Path

import numpy as np
import pytest
from shrm import Environment, ImageError
from shrm.environment import layouts
from shrm.environment.paraboloid import face_directions, face_positions
from support.light import band_limited_environment

SIZE, BORDER = 32, 5


def faces(picture: np.ndarray) -> np.ndarray:
    return np.stack(np.split(picture, 2, axis=1))


def test_directions_and_positions_are_inverse() -> None:
    D = face_directions(SIZE, BORDER)
    side = SIZE + 2 * BORDER
    np.testing.assert_allclose(np.linalg.norm(D, axis=-1), 1, rtol=1e-14)
    for face in (0, 1):
        at = face_positions(D[face].reshape(-1, 3), SIZE, BORDER)[face].reshape(side, side, 2)
        x, y = np.meshgrid(np.arange(side) + 0.5, np.arange(side) + 0.5)
        np.testing.assert_allclose(at, np.stack([x, y], axis=-1), atol=1e-9)


def test_within_the_discs_they_look_where_the_layout_does() -> None:
    D = face_directions(SIZE, BORDER)[:, BORDER:-BORDER, BORDER:-BORDER]
    expected = faces(layouts.directions("dual-paraboloid", SIZE, 2 * SIZE))
    inside = np.isfinite(expected[..., 0])
    np.testing.assert_allclose(D[inside], expected[inside], atol=1e-12)


def test_a_border_continues_the_picture() -> None:
    """Of a smooth light, to what texels of the lat-long picture show as steps."""
    env = band_limited_environment(4, seed=1, H=128)
    found = faces(env.picture("dual-paraboloid", SIZE, border=BORDER))
    D = face_directions(SIZE, BORDER)
    x, y = layouts.positions("latlong", 128, 256, D.reshape(-1, 3)).T
    seen = env.pixels[np.clip(y.astype(int), 0, 127), x.astype(int) % 256].reshape(found.shape)
    assert np.abs(found - seen).max() < 0.06 * seen.max()
    plain = faces(env.picture("dual-paraboloid", SIZE))
    whole = (np.abs(2 * np.arange(SIZE) + 1 - SIZE) + 1) / SIZE
    inside = whole[:, None] ** 2 + whole**2 <= 1
    np.testing.assert_array_equal(found[:, BORDER:-BORDER, BORDER:-BORDER][:, inside], plain[:, inside])


@pytest.mark.parametrize("border", [0, 3])
def test_what_is_written_is_read(tmp_path: Path, border: int) -> None:
    env, path = band_limited_environment(4, seed=2, H=32), tmp_path / "sky.exr"
    env.write(path, "dual-paraboloid", size=64, border=border)
    back = Environment.read(path, layout="dual-paraboloid", border=border)
    # The integral is kept by both conversions; texels that a rim cuts are samples in a picture with a border.
    accuracy = 1e-3 if border == 0 else 5e-3
    np.testing.assert_allclose(back.coefficients(0), env.coefficients(0), rtol=accuracy)
    np.testing.assert_allclose(back.resized((16, 32)).pixels, env.resized((16, 32)).pixels, rtol=0.1)


def test_borders_that_cannot_be_are_refused(tmp_path: Path) -> None:
    env = band_limited_environment(2, seed=3, H=16)
    with pytest.raises(ValueError, match="border is for the layout dual-paraboloid, got strip"):
        env.picture("strip", 8, border=2)
    with pytest.raises(ValueError, match="border must be"):
        env.picture("dual-paraboloid", 8, border=-1)
    env.write(tmp_path / "sky.exr", "dual-paraboloid", size=8)
    env.write(tmp_path / "sky.hdr", "dual-paraboloid", size=8)  # states no layout
    with pytest.raises(ImageError, match="border is for the layout dual-paraboloid, got latlong"):
        Environment.read(tmp_path / "sky.hdr", border=2)
    with pytest.raises(ValueError, match="border must be"):
        Environment.read(tmp_path / "sky.hdr", border=-1)
    with pytest.raises(ImageError, match=r"sky\.exr: a dual paraboloid with a border of 4"):
        Environment.read(tmp_path / "sky.exr", layout="dual-paraboloid", border=4)
