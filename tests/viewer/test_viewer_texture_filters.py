"""The filters of textures by which OpenGL prefilters: the paper's sizes, and no energy lost."""

import numpy as np
import pytest
from shrm import brdf
from shrm.viewer.gpu.paraboloid_kernels import integral, taps, texture_filters, texture_kernel

SIZE, BORDER = 64, 8


def profile(material: brdf.BRDF):
    return material.lobes[0].profile


@pytest.mark.parametrize(
    ("exponent", "small", "large"),
    [
        (10, (174, 32), (260, 64)),
        (50, (78, 16), (136, 32)),
        (100, (56, 8), (100, 16)),
        (250, (36, 8), (66, 16)),
        (500, (26, 4), (48, 8)),
    ],
)
def test_sizes_and_shrink_factors_are_those_of_the_paper(exponent, small, large):
    found = texture_filters(profile(brdf.Phong(exponent)), 512, 0.1, 7)
    assert [(f.size, f.shrink) for f in found] == [small, large]
    assert 1.4 < found[1].radius / found[0].radius < 2.0


@pytest.mark.parametrize("material", [brdf.Phong(10), brdf.Lambert((0.8, 0.5, 0.2))], ids=lambda m: m.name)
def test_kernels_and_taps_sum_to_the_integral_of_the_lobe(material):
    # Of the lobe itself: 1, or the albedo.
    wanted = np.broadcast_to(integral(profile(material)), 3)
    np.testing.assert_allclose(
        wanted, 1.0 if material.name.startswith("phong") else (0.8, 0.5, 0.2), rtol=1e-6
    )
    for found in texture_filters(profile(material), 128, 0.1, 7):
        kernel = texture_kernel(profile(material), found, 2.0 * found.shrink / 128)
        assert kernel.shape[0] == kernel.shape[1] <= 7
        assert kernel.min() >= 0
        np.testing.assert_allclose(kernel.sum(axis=(0, 1)), wanted, rtol=1e-5)
        np.testing.assert_array_equal(kernel, kernel.transpose(1, 0, 2))
    for count in (1, 7, 256):
        directions, weights = taps(profile(material), count)
        np.testing.assert_allclose(weights[:, :3].sum(axis=0), wanted, rtol=1e-5)
        np.testing.assert_allclose(np.linalg.norm(directions[:, :3], axis=1), 1.0, atol=1e-6)
    # By the solid angles of many taps the hemisphere is covered as far as the lobe reaches.
    areas = 4.0 ** taps(profile(brdf.Lambert(1.0)), 4096)[0, :, 3]
    assert areas.sum() == pytest.approx(2 * np.pi, rel=0.1)


def test_a_lobe_wider_than_a_face_has_no_filter():
    with pytest.raises(ValueError, match=r"fall to 0\.1 of its maximum within 90 degrees .* exact filter"):
        texture_filters(profile(brdf.Phong(0)), 128, 0.1, 7)
