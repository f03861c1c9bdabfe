"""Layouts: directions and texels, solid angles, and the energy of conversions."""

from __future__ import annotations

import itertools
import math
import os
import subprocess
import sys

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shrm.environment import layouts

Array = npt.NDArray[np.float64]

PICTURES = {
    "latlong": (24, 48),
    "openexr-latlong": (25, 49),
    "vertical-cross": (48, 36),
    "horizontal-cross": (36, 48),
    "strip": (12, 72),
    "faces": (78, 13),
    "openexr-cube": (78, 13),
    "angular": (33, 33),
    "mirror-ball": (34, 34),
    "dual-paraboloid": (24, 48),
    "octahedral": (29, 29),
}


def random_directions(n: int, seed: int) -> Array:
    d = np.random.default_rng(seed).normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def random_rotation(seed: int) -> Array:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def test_every_layout_is_tested() -> None:
    assert set(PICTURES) == set(layouts.LAYOUTS)


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_positions_and_rays_are_inverse(layout: str) -> None:
    h, w = PICTURES[layout]
    d = random_directions(2000, seed=1)
    p = layouts.positions(layout, h, w, d)
    assert np.all((p >= 0) & (p < [w, h]))
    # 1e-9 of a texel is how far positions stay off a cell's far edge; a texel is less than 1 radian
    assert np.abs(layouts.rays(layout, h, w, p) - d).max() < 2e-9


@settings(max_examples=200)
@given(
    st.sampled_from(layouts.LAYOUTS),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3),
)
def test_any_direction_falls_in_a_texel_that_belongs(layout: str, vector: tuple[float, float, float]) -> None:
    h, w = PICTURES[layout]
    d = np.array([vector]) / np.linalg.norm(vector)
    p = layouts.positions(layout, h, w, d)
    back = layouts.rays(layout, h, w, p)
    assert np.abs(back - d).max() < 1e-7  # the mirror ball's rim: sqrt(1e-16) of rounding


@settings(max_examples=200)
@given(st.sampled_from(layouts.LAYOUTS), st.floats(0.01, 0.99), st.floats(0.01, 0.99), st.integers(0, 10**6))
def test_any_point_inside_a_texel_comes_back(layout: str, u: float, v: float, k: int) -> None:
    h, w = PICTURES[layout]
    belonging = np.argwhere(np.isfinite(layouts.directions(layout, h, w)[..., 0]))
    i, j = belonging[k % len(belonging)]
    p = np.array([[j + u, i + v]])
    d = layouts.rays(layout, h, w, p)
    if np.isfinite(d).all():  # a texel at the rim may be outside there
        at_pole = 1.0 / max(1e-3, math.hypot(d[0, 0], d[0, 1]))
        assert np.abs(layouts.positions(layout, h, w, d) - p).max() < 1e-6 * at_pole


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_solid_angles_sum_to_the_sphere(layout: str) -> None:
    areas = layouts.solid_angles(layout, *PICTURES[layout])
    assert np.all(areas >= 0)
    assert areas.sum() == pytest.approx(4 * math.pi, rel=1e-9)


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_solid_angles_are_the_directions_share_of_the_sphere(layout: str) -> None:
    """The oracle counts directions spread evenly over the sphere by a Fibonacci lattice."""
    h, w = 12 * PICTURES[layout][0] // 12, PICTURES[layout][1]
    n = 400_000
    k = np.arange(n) + 0.5
    z, phi = 1 - 2 * k / n, k * math.pi * (3 - math.sqrt(5))
    r = np.sqrt(1 - z * z)
    d = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    column, row = layouts.positions(layout, h, w, d).astype(int).T
    count = np.bincount(row * w + column, minlength=h * w).reshape(h, w)
    areas = layouts.solid_angles(layout, h, w)
    # lattice points are about sqrt(4 pi / n) apart: a texel's count is off by at most those along its edge
    bound = 6 * math.sqrt(4 * math.pi / n) * np.sqrt(areas + 4 * math.pi / n) + 30 * 4 * math.pi / n
    assert np.all(np.abs(count * 4 * math.pi / n - areas) < bound)


@pytest.mark.parametrize("layout", ["angular", "mirror-ball", "octahedral", "dual-paraboloid"])
@pytest.mark.parametrize("size", [2, 3, 4, 5, 64, 101])
def test_solid_angles_of_cut_texels(layout: str, size: int) -> None:
    areas = layouts.solid_angles(layout, *layouts.shape(layout, size))
    # five Gauss nodes on a texel as large as the disc's radius still give 4 digits
    assert areas.sum() == pytest.approx(4 * math.pi, rel=1e-4 if size == 2 else 1e-6)


@pytest.mark.parametrize(
    ("layout", "position", "direction"),
    [
        ("latlong", (0.5, 0.5), (1, 0, 0)),
        ("latlong", (0.25, 0.5), (0, 1, 0)),
        ("vertical-cross", (0.5, 3 / 8), (1, 0, 0)),
        ("vertical-cross", (1 / 6, 3 / 8), (0, 1, 0)),
        ("vertical-cross", (0.5, 1 / 8), (0, 0, 1)),
        ("vertical-cross", (0.5, 7 / 8), (-1, 0, 0)),
        ("horizontal-cross", (3 / 8, 0.5), (1, 0, 0)),
        ("horizontal-cross", (7 / 8, 0.5), (-1, 0, 0)),
        ("horizontal-cross", (5 / 8, 0.5), (0, -1, 0)),
        ("strip", (1 / 12, 0.5), (0, -1, 0)),
        ("strip", (5 / 12, 0.5), (0, 0, 1)),
        ("strip", (9 / 12, 0.5), (1, 0, 0)),
        ("openexr-cube", (0.5, 1 / 12), (0, 1, 0)),
        ("openexr-cube", (0.5, 9 / 12), (1, 0, 0)),
        ("angular", (0.5, 0.5), (1, 0, 0)),
        ("angular", (0.75, 0.5), (0, -1, 0)),
        ("angular", (0.5, 0.25), (0, 0, 1)),
        ("mirror-ball", (0.5, 0.5), (1, 0, 0)),
        ("mirror-ball", (0.5 + math.sqrt(0.125), 0.5), (0, -1, 0)),
        ("dual-paraboloid", (0.25, 0.5), (0, 0, 1)),
        ("dual-paraboloid", (0.75, 0.5), (0, 0, -1)),
        ("octahedral", (0.5, 0.5), (0, 0, 1)),
        ("octahedral", (0.5, 1.0), (1, 0, 0)),
    ],
)
def test_axes(layout: str, position: tuple[float, float], direction: tuple[int, int, int]) -> None:
    h, w = layouts.shape(layout, 12)
    ray = layouts.rays(layout, h, w, np.array([[position[0] * w, position[1] * h]]))
    assert ray[0] == pytest.approx(direction, abs=1e-12)


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_unmirrored_from_inside(layout: str) -> None:
    """Right x up points back to the viewer."""
    h, w = PICTURES[layout]
    centers = np.argwhere(np.isfinite(layouts.directions(layout, h, w)[..., 0]))[:, ::-1] + 0.5
    e = 1e-4
    d, right, up = (layouts.rays(layout, h, w, centers + s) for s in ([0, 0], [e, 0], [0, -e]))
    handed = np.einsum("ij,ij->i", np.cross(right - d, up - d), d)
    handed = handed[np.isfinite(handed) & (np.abs(handed) > 1e-14)]
    assert np.all(handed < 0)


def sun(layout: str, direction: Array, radius: float, picture: npt.NDArray[np.float32]) -> Array:
    """Put a sun on a picture; return where it is."""
    h, w = PICTURES[layout]
    centers = layouts.directions(layout, h, w)
    lit: Array = np.nan_to_num(centers @ direction, nan=-2) > math.cos(radius)
    lit[tuple(layouts.positions(layout, h, w, direction[None])[0, ::-1].astype(int))] = True
    picture[lit] = 1e5
    return lit


CORNERS = np.array(list(itertools.product([-1, 1], repeat=3))) / math.sqrt(3)
PLACES = np.concatenate([np.eye(3), -np.eye(3), CORNERS, random_directions(10, seed=2)])


@pytest.mark.parametrize("source", layouts.LAYOUTS)
@pytest.mark.parametrize("target", layouts.LAYOUTS)
def test_a_sun_keeps_its_energy(source: str, target: str) -> None:
    """Each place is a channel of one picture; the sun is about two texels wide."""
    h, w = PICTURES[source]
    pixels = np.zeros((h, w, len(PLACES) + 1), dtype=np.float32)
    for k, place in enumerate(PLACES):
        channel = np.zeros((h, w), dtype=np.float32)
        sun(source, place, math.radians(4), channel)
        pixels[..., k] = channel
    pixels[..., -1] = 1
    result = layouts.convert(pixels, source, target, PICTURES[target])
    there, here = layouts.solid_angles(source, h, w), layouts.solid_angles(target, *PICTURES[target])
    before, after = np.einsum("ij,ijc->c", there, pixels), np.einsum("ij,ijc->c", here, result)
    assert after == pytest.approx(before, rel=1e-3)
    assert np.all(result >= 0)
    assert np.abs(result[here > 0, -1] - 1).max() < 1e-6
    assert np.all(result[here == 0] == 0)


@pytest.mark.parametrize("target", layouts.LAYOUTS)
@pytest.mark.parametrize("factor", [0.5, 3])
def test_energy_when_the_size_changes(target: str, factor: float) -> None:
    h, w = PICTURES["latlong"]
    size = max(4, int(factor * layouts.size_like(target, "latlong", h, w)))
    pixels = np.random.default_rng(3).random((h, w, 3), dtype=np.float32) ** 20 + np.float32(1e-3)
    pixels[..., 2] = 1
    result = layouts.convert(pixels, "latlong", target, size)
    before = np.einsum("ij,ijc->c", layouts.solid_angles("latlong", h, w), pixels)
    here = layouts.solid_angles(target, *layouts.shape(target, size))
    assert np.einsum("ij,ijc->c", here, result) == pytest.approx(before, rel=1e-4)
    assert np.abs(result[here > 0, 2] - 1).max() < 1e-6
    assert result[here > 0].min() > 0  # no holes


def test_resizing_by_whole_numbers_is_averaging() -> None:
    """Exact: the weights are the texels' solid angles."""
    fine = np.random.default_rng(4).random((24, 48, 2), dtype=np.float32)
    areas = layouts.solid_angles("latlong", 24, 48)[..., None]
    expected = (fine * areas).reshape(8, 3, 16, 3, 2).sum((1, 3)) / areas.reshape(8, 3, 16, 3, 1).sum((1, 3))
    assert layouts.convert(fine, "latlong", "latlong", (8, 16)) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_enlarging_and_back_is_close(layout: str) -> None:
    """A smooth picture survives a round trip through twice the detail."""
    h, w = PICTURES["latlong"]
    d = layouts.directions("latlong", h, w)
    smooth = (1 + d @ np.array([[0.3, 0.1], [0.2, -0.5], [0.4, 0.2]])).astype(np.float32)
    size = 2 * layouts.size_like(layout, "latlong", h, w)
    there = layouts.convert(smooth, "latlong", layout, size)
    back = layouts.convert(there, layout, "latlong", (h, w))
    # texels are taken as flat: the error is of the order of the slope, 0.6, times a part of a texel
    assert np.abs(back - smooth).mean() < 0.6 * math.pi / h * 0.25


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_conversion_puts_light_where_it_belongs(layout: str) -> None:
    """The mean direction of a sun's light is the same in both pictures."""
    h, w = PICTURES["latlong"]
    shape = layouts.shape(layout, 2 * layouts.size_like(layout, "latlong", h, w))
    pixels = np.zeros((h, w, len(PLACES)), dtype=np.float32)
    for k, place in enumerate(PLACES):
        sun("latlong", place, math.radians(15), pixels[..., k])
    result = layouts.convert(pixels, "latlong", layout, shape)

    def mean(name: str, picture: npt.NDArray[np.float32]) -> Array:
        d = np.nan_to_num(layouts.directions(name, *picture.shape[:2]))
        areas = layouts.solid_angles(name, *picture.shape[:2])
        total = np.einsum("ij,ijc,ijk->ck", areas, picture, d, optimize=True)
        return np.asarray(total / np.linalg.norm(total, axis=1, keepdims=True))

    # a tenth of a texel; at the mirror ball's rim, which is one direction, texels are much longer
    bound = math.radians(5.0 if layout == "mirror-ball" else 0.75)
    assert mean(layout, result) == pytest.approx(mean("latlong", pixels), abs=bound)


def test_rotation_keeps_energy_and_moves_the_mean() -> None:
    h, w = PICTURES["latlong"]
    pixels = np.zeros((h, w, len(PLACES)), dtype=np.float32)
    for k, place in enumerate(PLACES):
        sun("latlong", place, math.radians(10), pixels[..., k])
    R = random_rotation(5)
    result = layouts.convert(pixels, "latlong", "latlong", (h, w), R)
    areas, d = layouts.solid_angles("latlong", h, w), layouts.directions("latlong", h, w)
    before, after = (np.einsum("ij,ijc,ijk->ck", areas, p, d) for p in (pixels, result))
    assert np.einsum("ij,ijc->c", areas, result) == pytest.approx(
        np.einsum("ij,ijc->c", areas, pixels), rel=1e-3
    )
    after /= np.linalg.norm(after, axis=1, keepdims=True)
    before /= np.linalg.norm(before, axis=1, keepdims=True)
    assert after == pytest.approx(before @ R.T, abs=math.radians(1))


def test_rotation_by_a_column_is_a_shift() -> None:
    h, w = PICTURES["latlong"]
    pixels = np.random.default_rng(6).random((h, w, 3), dtype=np.float32)
    a = 2 * math.pi / w * 5  # towards +y, that is to the left
    R = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    result = layouts.convert(pixels, "latlong", "latlong", (h, w), R)
    # 1e-6 of a texel stays with the neighbors
    assert result == pytest.approx(np.roll(pixels, -5, axis=1), abs=1e-4)


@pytest.mark.slow
def test_the_number_of_threads_changes_nothing() -> None:
    script = (
        "import numpy, hashlib; from shrm.environment import layouts;"
        "p = numpy.random.default_rng(7).random((96, 192, 3), dtype=numpy.float32);"
        "r = layouts.convert(p, 'latlong', 'angular', 100);"
        "print(hashlib.sha256(r.tobytes()).hexdigest())"
    )
    digests = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "OMP_NUM_THREADS": threads},
            capture_output=True,
            check=True,
        ).stdout
        for threads in ("1", "2", "5")
    }
    assert len(digests) == 1


@pytest.mark.parametrize(
    ("size", "layout"),
    [
        ((512, 1024), "latlong"),
        ((300, 300), "angular"),
        ((400, 300), "vertical-cross"),
        ((300, 400), "horizontal-cross"),
        ((64, 384), "strip"),
        ((384, 64), "strip"),
    ],
)
def test_aspects(size: tuple[int, int], layout: str) -> None:
    assert layouts.recognise(*size) == layout
    assert layouts.recognise(*size, hint="octahedral") == "octahedral"


def test_unknown_aspect_and_names_are_refused() -> None:
    with pytest.raises(ValueError, match=r"640 x 480.*|1023 x 511.*latlong, .*octahedral"):
        layouts.recognise(511, 1023)
    with pytest.raises(ValueError, match=r"layout must be one of latlong.*got 'sphere'"):
        layouts.shape("sphere", 4)
    with pytest.raises(ValueError, match="size must be at least 2"):
        layouts.shape("angular", 1)
    with pytest.raises(
        ValueError, match="a picture of layout strip is n x 6n or 6n x n, but this one is 4 x 5"
    ):
        layouts.solid_angles("strip", 4, 5)


@pytest.mark.parametrize("layout", layouts.LAYOUTS)
def test_sizes_like(layout: str) -> None:
    """There and back is the same size, and the number of texels is of the same order."""
    size = layouts.size_like(layout, "latlong", 256, 512)
    h, w = layouts.shape(layout, size)
    assert abs(layouts.size_like("latlong", layout, h, w) - 256) <= 3
    texels = np.count_nonzero(layouts.solid_angles(layout, h, w))
    assert 0.7 < texels / (256 * 512) < 1.4
