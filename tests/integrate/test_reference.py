"""shrm.integrate.angular: the exact sum, maps for a view, and what happens at the door."""

import numpy as np
import pytest
import shrm
from numpy.testing import assert_allclose
from shrm.integrate.angular import integrate, prefilter_angular
from support import oracles
from support.integrands import environment, isotropic, lambert, material, noise, phong, zonal

PIXELS = noise(16, 32)
ENV = environment(PIXELS)


@pytest.mark.parametrize("k", [1, 3])
def test_integrate_equals_the_oracle(k):
    normals, views = oracles.random_views(10, seed=1)
    for transfer in (oracles.ggx(0.3, [0.1, 0.5, 1.0]), oracles.beckmann(0.2), oracles.microfacet(0.3)):
        B = integrate(ENV, material(isotropic(transfer)), normals, views, subsamples=k)
        assert_allclose(B, oracles.reflected(PIXELS, transfer, normals, views, subsamples=k), rtol=1e-10)
    for lobe in (phong(9), lambert([0.5, 0.2, 1.0])):
        B = integrate(ENV, material(lobe), normals, views, subsamples=k)
        expected = oracles.reflected(PIXELS, lobe.transfer, normals, views, hemisphere=False, subsamples=k)
        assert_allclose(B, expected, rtol=1e-10)
    tangents, square, hair_views = oracles.random_hairs(10, seed=1)
    transfer = oracles.banks(0.3)
    B = integrate(ENV, material(zonal(transfer)), square, hair_views, tangents, subsamples=k)
    expected = oracles.reflected(
        PIXELS, transfer, square, hair_views, tangents, frame="tangent", hemisphere=False, subsamples=k
    )
    assert_allclose(B, expected, rtol=1e-10)


@pytest.mark.slow
def test_a_material_is_the_sum_of_its_lobes():
    normals, views = oracles.random_views(10, seed=2)
    lobes = (phong(9), lambert(0.5), isotropic(oracles.ggx(0.3)))
    for reflect in (
        lambda m: integrate(ENV, m, normals, views),
        lambda m: prefilter_angular(ENV, m, subsamples=1).radiance(normals, views),
    ):
        assert_allclose(reflect(material(*lobes)), sum(reflect(material(lobe)) for lobe in lobes), rtol=1e-5)


def test_radiance_and_integrate_agree_from_behind():
    # Interpolated normals may face away: two-sided about the reflection, else held at the horizon.
    normals, views = oracles.random_views(20, seed=3)
    m = material(isotropic(oracles.microfacet(0.3), center="reflection"))
    result = prefilter_angular(ENV, m, subsamples=1)
    assert_allclose(result.radiance(-normals, views), result.radiance(normals, views), rtol=1e-6)
    for center in ("reflection", "lobe", "normal"):
        m = material(isotropic(oracles.microfacet(0.3), center=center))
        result = prefilter_angular(ENV, m, subsamples=1)
        assert_allclose(
            result.radiance(-normals, views), integrate(ENV, m, -normals, views), rtol=1e-4, atol=1e-6
        )


@pytest.mark.parametrize("center", ["reflection", "lobe", "normal"])
def test_reflection_maps_and_integrals_have_one_rule_behind_the_horizon(center):
    smooth = shrm.Environment(ENV.pixels)
    ggx = shrm.brdf.GGX(0.5).recentered(center)
    normals, views = oracles.random_views(40, seed=4)
    normals = normals - 1.3 * np.sum(normals * views, axis=1, keepdims=True) * views  # N.V < 0
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    cosine = np.sum(normals * views, axis=1, keepdims=True)
    assert np.all(cosine < 0)
    if center == "reflection":
        same_normals, same_views = -normals, views
    else:  # a hair above the horizon
        same_normals, same_views = normals, views - (cosine - 1e-6) * normals
        same_views /= np.linalg.norm(same_views, axis=1, keepdims=True)
    for reflect in (shrm.prefilter(smooth, ggx, orders=(16, 6)), prefilter_angular(smooth, ggx)):
        behind = reflect.radiance(normals, views)
        assert_allclose(behind, reflect.radiance(same_normals, same_views), rtol=2e-3)


def normal_for(center, C, view, gamma=None):
    """The normal whose center is C, by the definitions."""
    if center in ("normal", "tangent"):
        return C
    n = C + view
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


@pytest.mark.parametrize("center", ["reflection", "normal"])
def test_at_view_is_radiance_at_the_normal_of_the_center(center):
    view = np.array([0.6, 0.0, 0.8])
    lobe = isotropic(oracles.ggx(0.3), center)
    result = prefilter_angular(ENV, material(lobe), size=8)
    C = oracles.directions(8, 16).reshape(-1, 3)
    normals = normal_for(center, C, view)
    expected = result.radiance(normals, view)
    assert_allclose(result.at_view(view).reshape(-1, 3), expected, rtol=1e-4)


@pytest.mark.slow
def test_at_view_about_the_lobe():
    # Take normals, find the center as the mean direction of rho_hat^2, look it up in a fine map.
    view = np.array([0.0, 0.6, 0.8])
    transfer = oracles.ggx(0.4)
    smooth = 1 + np.sum(oracles.directions(32, 64) * [0.3, 0.2, 0.5], axis=-1, keepdims=True) * np.ones(3)
    result = prefilter_angular(environment(smooth), material(isotropic(transfer)), size=64)
    reflection_map = result.at_view(view)
    rng = np.random.default_rng(4)
    x, w = np.polynomial.legendre.leggauss(200)
    theta, phi = np.meshgrid((1 + x) * np.pi / 4, (np.arange(200) + 0.5) * np.pi / 100, indexing="ij")
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    wi, weight = wi.reshape(-1, 3), (w[:, None] * np.sin(theta)).ravel()
    for _ in range(5):
        normal = view + 0.7 * rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        if normal @ view < 0.3:
            continue
        frame = oracles.frames(normal[None], view[None])[0]
        C = frame @ ((weight * transfer(wi, (view @ frame)[None]) ** 2) @ wi)
        C /= np.linalg.norm(C)
        i, j = np.arccos(C[2]) * 64 / np.pi, (np.pi - np.arctan2(C[1], C[0])) * 64 / np.pi
        looked_up = reflection_map[int(i), int(j) % 128]
        # The nearest texel of a map of 0.05 rad: a slope of about 0.6 over half a texel.
        assert_allclose(looked_up, result.radiance(normal[None], view)[0], atol=0.03)


def test_at_view_about_the_tangent():
    view = np.array([0.0, 0.6, 0.8])
    result = prefilter_angular(ENV, material(zonal(oracles.kajiya_kay(8))), size=8)
    C = oracles.directions(8, 16).reshape(-1, 3)
    assert_allclose(result.at_view(view).reshape(-1, 3), result.radiance(C, view, C), rtol=1e-6)


def test_several_centers_have_a_map_each():
    m = material(lambert(0.5), phong(9), isotropic(oracles.ggx(0.4), "reflection"), lambert(0.25))
    result = prefilter_angular(ENV, m, size=8)
    maps = result.maps_at_view([0.0, 0.0, 1.0])
    assert set(maps) == {"normal", "reflection"}
    alone = prefilter_angular(ENV, material(lambert(0.75)), size=8, subsamples=result.subsamples).at_view(
        [0.0, 0.0, 1.0]
    )
    assert_allclose(maps["normal"], alone, rtol=1e-5)


@pytest.mark.slow
def test_the_other_center_only_indexes():
    m = material(isotropic(oracles.ggx(0.3)))
    normals, views = oracles.random_views(5, seed=5)
    a, b = (prefilter_angular(ENV, m, center=c, size=8) for c in ("reflection", None))
    assert np.array_equal(a.radiance(normals, views), b.radiance(normals, views))
    assert not np.allclose(a.at_view([0, 0, 1]), b.at_view([0, 0, 1]))


def test_faces_of_a_cube_are_opengls():
    # Light in one direction; a sharp lobe's map is brightest where its face shows that direction.
    result = prefilter_angular(environment(np.ones((8, 16, 3))), material(phong(8)), layout="cube", size=5)
    assert result.at_view([0, 0, 1]).shape == (6, 5, 5, 3)
    faces = [  # +X right, +Y up, +Z front in the world's axes
        (0, [0, -1, 0]),
        (1, [0, 1, 0]),
        (2, [0, 0, 1]),
        (3, [0, 0, -1]),
        (4, [1, 0, 0]),
        (5, [-1, 0, 0]),
    ]
    d = oracles.directions(64, 128)
    for face, axis in faces:
        spot = (d @ np.array(axis) > 0.99)[..., None] * np.ones(3)
        cube = prefilter_angular(environment(spot), material(phong(64)), layout="cube", size=5).at_view(
            [0, 0, 1]
        )
        assert np.unravel_index(np.argmax(cube[..., 0]), cube.shape[:3]) == (face, 2, 2)
    # OpenGL's table: on face +x, s grows along -z and t along -y; on +z, s along x and t along -y.
    # In the world's axes (x, y, z) = (Z, -X, Y), so (1, .4, -.8) of the cube is this:
    toward = np.array([-0.8, -1, 0.4]) / np.linalg.norm([1, 0.4, -0.8])
    cube = prefilter_angular(
        environment((d @ toward > 0.99)[..., None] * np.ones(3)), material(phong(64)), layout="cube", size=5
    ).at_view([0, 0, 1])
    assert np.unravel_index(np.argmax(cube[..., 0]), cube.shape[:3]) == (0, 1, 4)


def ok(**changed):
    arguments = {"normals": [[0.0, 0.0, 1.0]], "views": [[0.0, 0.0, 1.0]], "tangents": None} | changed
    return prefilter_angular(ENV, material(phong(8)), subsamples=1).radiance(**arguments)


@pytest.mark.parametrize(
    ("changed", "error", "text"),
    [
        ({"normals": [0.0, 0.0, 1.0]}, ValueError, r"normals must have the shape \(n, 3\), got \(3,\)"),
        (
            {"views": [[0.0, 0.0, 2.0]]},
            ValueError,
            r"views must be unit vectors, got 1 that are not.*length 2",
        ),
        (
            {"views": np.zeros((2, 3))},
            ValueError,
            r"views must have the shape \(1, 3\) or \(3,\), got \(2, 3\)",
        ),
        ({"normals": [[0.0, np.nan, 1.0]]}, ValueError, r"normals must be finite.*first at \(0, 1\)"),
        ({"normals": [["a", "b", "c"]]}, TypeError, "normals must be an array of real numbers"),
        ({"normals": [[0.0, 1.0], [1.0]]}, TypeError, "normals must be an array of real numbers"),
        ({"tangents": [[0.0, 1.0]]}, ValueError, r"tangents must have the shape .*, got \(1, 2\)"),
    ],
)
def test_bad_queries_are_refused_by_name(changed, error, text):
    with pytest.raises(error, match=text):
        ok(**changed)


@pytest.mark.parametrize(
    ("changed", "error", "text"),
    [
        ({"tolerance": 1.0}, ValueError, "tolerance must be above 0 and below 1, got 1"),
        ({"tolerance": float("nan")}, ValueError, "tolerance must be"),
        ({"tolerance": "x"}, TypeError, "tolerance must be a number, got 'x'"),
        ({"size": 0}, ValueError, r"size must be in \[1, 16384\], got 0"),
        ({"size": 2.5}, TypeError, "size must be a whole number"),
        ({"layout": "octahedral"}, ValueError, "layout must be one of latlong, cube, got 'octahedral'"),
        ({"center": "tangent"}, ValueError, "center must be one of lobe, reflection, normal, got 'tangent'"),
        ({"subsamples": 0}, ValueError, r"subsamples must be in \[1, 16\]"),
        ({"symmetry": 1}, TypeError, "symmetry must be True or False, got 1"),
    ],
)
def test_bad_options_are_refused_by_name(changed, error, text):
    with pytest.raises(error, match=text):
        prefilter_angular(ENV, material(phong(8)), **changed)


def test_bad_environments_and_missing_tangents():
    with pytest.raises(TypeError, match="env must be an Environment, got list"):
        prefilter_angular([[1.0]], material(phong(8)))
    with pytest.raises(TypeError, match=r"brdf must be a material of .*, got str"):
        prefilter_angular(ENV, "phong")
    with pytest.raises(TypeError, match=r"brdf must be a material of .*, got RadialLobe"):
        integrate(ENV, shrm.brdf.Phong(8).lobes[0], [[0, 0, 1]], [0, 0, 1])
    with pytest.raises(ValueError, match=r"tangents must have the shape .* about the tangent .* got None"):
        prefilter_angular(ENV, material(zonal(oracles.banks(0.2)))).radiance([[0, 0, 1]], [[0, 0, 1]])
    with pytest.raises(ValueError, match="view must be unit"):
        prefilter_angular(ENV, material(phong(8)), size=4).at_view([0, 0, 3])


def test_no_queries_give_no_answers():
    assert ok(normals=np.zeros((0, 3)), views=np.zeros((0, 3))).shape == (0, 3)


def test_the_smallest_picture():
    # Everything looks alike: the exact integral is the albedo.
    env = environment(np.full((2, 4, 3), 2.0))
    result = prefilter_angular(env, material(phong(2)))
    assert_allclose(result.radiance([[0, 0, 1]], [[0, 0, 1]]), 2, rtol=1e-3)


def test_maps_about_the_lobe_are_the_reflection_maps_texel_by_texel():
    """Both index their maps by the same central direction."""
    light = shrm.Environment(ENV.pixels)
    view = np.array([0.48, 0.6, 0.64])
    by_frequency = shrm.prefilter(light, shrm.brdf.GGX(0.5), orders=(16, 6), size=16)
    integrated = prefilter_angular(light, shrm.brdf.GGX(0.5), size=16)
    a, b = by_frequency.at_view(view), integrated.at_view(view)
    # the views that occur: theta_o up to theta_v = 80 degrees
    part = by_frequency.parts[0]
    most = np.radians(80) + np.interp(80 / 90, np.linspace(0, 1, len(part.gamma)), part.gamma)
    seen = np.arccos(np.clip(part.directions() @ view, -1, 1)) < most
    # texels by the edge of what is seen err more than the mean over all frames, which is what is predicted
    assert oracles.relative_rms(a[seen], b[seen]) < 3 * by_frequency.error + 2 * integrated.table_error
