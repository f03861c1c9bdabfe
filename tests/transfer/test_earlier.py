"""Lighting by the methods before matrix radiance transfer, against plain sums in float64."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from shrm import brdf
from shrm.transfer.brdf_matrix import rows as material_rows
from shrm.transfer.lighting import Convolution, Diffuse, Projection, Tents, parabolic_map, zonal_kernel
from support import oracles
from support.directions import sphere
from support.transfer_vertices import EYE, FRAMES, POINTS, SEEN, V, assert_close, local_views, random, shadows


def band_matrix(R: np.ndarray, n: int) -> np.ndarray:
    """Local coefficients from global ones (n^2, n^2), by least squares at many directions."""
    w = sphere(400, 37)
    return np.linalg.lstsq(
        oracles.real_harmonics(n - 1, w), oracles.real_harmonics(n - 1, w @ R.T), rcond=None
    )[0]


@cache
def rotations(count: int, n: int) -> np.ndarray:
    """Those of the first vertices' frames (count, n^2, n^2)."""
    return np.array([band_matrix(frame.astype(float), n) for frame in FRAMES[:count]])


def bilinear(samples: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Between samples (S, S, ...) from -1 to 1, columns along x."""
    S = len(samples)
    hat = [np.maximum(0, 1 - np.abs((S - 1) * (p + 1)[:, None] / 2 - np.arange(S))) for p in (x, y)]
    return np.einsum("vj,vi,jick->vck", hat[1], hat[0], samples.astype(np.float64), optimize=True)


@SEEN
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("way", ["stored rotation", "prerotated", "no shadows", "halves"])
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 7, 10])
def test_projection_is_row_times_rotation_times_transfer_times_light(n, way, channels, seen):
    S, count = 9, 37
    points, axes, samples = POINTS[:count], FRAMES[:count], random((S, S, channels, n * n), 38)
    T = None if way == "no shadows" else shadows(count, n, 39, np.float16 if way == "halves" else np.float32)
    light = random((n * n, 3), 40, np.float64)
    lighting = Projection(points, axes, samples, T, prerotated=way == "prerotated")
    w = local_views(seen, points, axes)
    b = bilinear(samples, w[:, 0] / (1 + w[:, 2]), w[:, 1] / (1 + w[:, 2]))
    R = rotations(count, n)
    transferred = np.broadcast_to(light, (count, n * n, 3)) if T is None else T.astype(float) @ light
    expected = np.einsum("vcj,vjc->vc", np.broadcast_to(b, (count, 3, n * n)), R @ transferred)
    # Frames of float32 turn degree n by n 1e-7; sums of n^4 products
    assert_close(lighting.radiance(light, **seen), expected, 2e-6 * n * np.abs(expected).max() + 2e-6 * n * n)


@pytest.mark.parametrize("channels", [1, 3])
def test_a_material_in_tents_without_shadows_is_matrix_radiance_transfer(channels):
    """A_p = P R_p: nothing but frames is stored."""
    P, light, count = random((49, channels, 25), 41), random((25, 3), 42, np.float64), 60
    A = np.einsum("tcj,vjk->vtck", P, rotations(count, 5))
    whole = Tents(POINTS[:count], FRAMES[:count], A).radiance(light, eye=EYE)
    found = Projection(POINTS[:count], FRAMES[:count], P).radiance(light, eye=EYE)
    assert_close(found, whole, 1e-5 * np.abs(whole).max())


def test_projection_nears_direct_evaluation_as_its_map_gets_finer():
    material, n, count = brdf.GGX(0.5), 4, 40
    T, light = shadows(count, n, 43), random((n * n, 3), 44, np.float64)
    points, axes = POINTS[:count], FRAMES[:count]
    w = local_views({"eye": EYE}, points, axes)
    above = w[:, 2] > 0.3
    exact = np.einsum(
        "vj,vjc->vc", material_rows(material, w, n), rotations(count, n) @ (T.astype(float) @ light)
    )
    errors = []
    for side in (9, 17, 33):
        lighting = Projection(points, axes, parabolic_map(material, n, side), T)
        found = lighting.radiance(light, eye=EYE)
        errors.append([oracles.relative_rms(found[which], exact[which]) for which in (above, ~above)])
    # Bilinear interpolation errs by the square of the step; at the horizon, where rows end, by the step
    assert sum(above) > 10
    assert max(errors[0]) < 0.1
    for coarse, fine in pairwise(errors):
        assert fine[0] < 0.35 * coarse[0]
        assert fine[1] < 0.65 * coarse[1]


@SEEN
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("axis", ["reflection", "normal"])
@pytest.mark.parametrize("shadowed", [False, True])
@pytest.mark.parametrize("n", [1, 3, 5, 10])
def test_convolution_scales_degrees_and_is_evaluated_at_the_axis(n, shadowed, axis, channels, seen):
    kernel, light = random((n, channels), 45, np.float64), random((n * n, 3), 46, np.float64)
    T = shadows(V, n, 47, np.float16) if shadowed else None
    found = Convolution(POINTS, FRAMES, kernel, T, axis=axis).radiance(light, **seen)
    local = local_views(seen) * [-1, -1, 1] if axis == "reflection" else np.array([[0.0, 0.0, 1.0]] * V)
    Y = oracles.real_harmonics(n - 1, np.einsum("vij,vj->vi", FRAMES.astype(float), local))
    degree = np.sqrt(np.arange(n * n)).astype(int)
    transferred = np.broadcast_to(light, (V, n * n, 3)) if T is None else T.astype(float) @ light
    expected = np.einsum("vj,jc,vjc->vc", Y, np.broadcast_to(kernel, (n, 3))[degree], transferred)
    # Gradients of degree n are n times the value, directions err by 3e-7
    assert_close(found, expected, 2e-6 * n * np.abs(expected).max())


def test_the_kernel_of_lambert_and_phong():
    """Lambert's is known, [RH01]: albedo times 1, 2/3, 1/4, 0, -1/24; Phong's by its integral."""
    expected = 0.7 * np.array([1, 2 / 3, 1 / 4, 0, -1 / 24])
    np.testing.assert_allclose(zonal_kernel(brdf.Lambert(0.7), 5)[:, 0], expected, atol=1e-6)
    s, x = 20.0, (np.arange(20000) + 0.5) / 20000
    for l, value in enumerate(zonal_kernel(brdf.Phong(s), 6)[:, 0]):
        legendre = np.polynomial.Legendre.basis(l)(x)
        assert value == pytest.approx(np.mean((s + 1) * x**s * legendre), abs=1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float16])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("n", [1, 3, 5, 8])
def test_diffuse_is_a_product_whatever_the_view(n, channels, dtype):
    rows, light = random((V, channels, n * n), 48, dtype), random((n * n, 3), 49, np.float64)
    lighting = Diffuse(rows)
    found = lighting.radiance(light)
    expected = np.einsum("vcj,jc->vc", np.broadcast_to(rows.astype(float), (V, 3, n * n)), light)
    assert_close(found, expected, 1e-6 * n * np.abs(expected).max())
    np.testing.assert_array_equal(lighting.radiance(light, eye=EYE), found)
