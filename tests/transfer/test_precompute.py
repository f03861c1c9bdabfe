"""From a mesh and a material to an object with transfer: energy, symmetry, and reports that are measured."""

import numpy as np
import pytest
import trimesh
from shrm import brdf, prefilter, sh
from shrm.environment import Environment
from shrm.render import Mesh
from shrm.transfer.matrices.product import Route
from shrm.transfer.precompute import precompute
from support import oracles
from support.data import require
from support.directions import sphere
from support.precomputed import ALL, BUMPY, matrices, radiance, rebuilt, transferred
from support.transfer_meshes import Mesh as Arrays
from support.transfer_meshes import Surface, ball, bowl, bumpy, moved, random_rotation

WHITE = np.sqrt(4 * np.pi)
GLOSSY = brdf.GGX(0.4, f0=(1.0, 0.7, 0.3))


def white(n: int) -> np.ndarray:
    light = np.zeros((n * n, 3))
    light[0] = WHITE
    return light


def random_light(n: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(n * n, 3))


# ---- Energy


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("route", [Route(), Route(3), Route(5, m=8, extension="even")], ids=str)
def test_a_convex_white_object_under_white_light_is_white(name, route):
    """Lambert does not depend on the view: tents hold it, and an even extension with even m + l too.

    What is left is the rows' quadrature, 1e-4 of them, and float32.
    """
    held = transferred(ball(2), brdf.Lambert(1.0), variants=(name,), route=route)
    for view in sphere(5, 1):
        np.testing.assert_allclose(radiance(held, name, white(3), view), 1, atol=2e-4)


@pytest.mark.slow
def test_a_convex_object_under_white_light_has_the_directional_albedo():
    """To what tents of this M keep of it, by the report."""
    mesh, alpha = ball(2), 0.5
    held = transferred(mesh, brdf.GGX(alpha), tents=9)
    error = 10 ** (-held.report["SNR of matrices"] / 20)
    view = np.array([0.0, 0.6, 0.8])
    actual = radiance(held, "shadowed", white(3), view)
    up = np.flatnonzero(mesh[2] @ view > 0.05)[::6]
    cosines = mesh[2][up] @ view
    albedos = [oracles.albedo(oracles.ggx(alpha), np.array([np.sqrt(1 - c * c), 0, c])) for c in cosines]
    assert oracles.relative_rms(actual[up, 0], np.array(albedos)) < error
    np.testing.assert_array_equal(actual[:, 0], actual[:, 2])


def test_shadows_take_and_bounces_give():
    mesh = bowl(4)
    held = transferred(mesh, brdf.Lambert(0.8), variants=ALL, bounces=40)
    free, dark, both = (radiance(held, name, white(3), np.array([0, 0, 1.0]))[:, 0] for name in ALL)
    np.testing.assert_allclose(free, 0.8, atol=2e-4)
    assert (dark < free).all()
    assert (both > dark).all()
    assert (both < free).all()
    # a half integrating sphere: half of the light, and then .4 of it again and again
    assert np.median(dark) == pytest.approx(0.4, rel=0.03)
    assert np.median(both) == pytest.approx(0.4 / (1 - 0.4), rel=0.03)
    assert held.report["bounces"] == 40


def test_a_closed_room_is_black_and_says_so_quietly():
    """No light at all: nothing to compress, nothing to measure, and no warning of numpy's."""
    vertices, faces, normals = ball(1)
    held = precompute(Surface(vertices, faces[:, ::-1], -normals), brdf.Lambert(0.5), directions=64, order=2)
    assert not held.radiance(white(2), view=[0, 0, 1.0]).any()


# ---- Plain shading


def unshadowed_expected(
    mesh: Arrays, transfer: oracles.Transfer, light: np.ndarray, view: np.ndarray
) -> np.ndarray:
    """Radiance (V, 3) by Gauss-Legendre in the cosine and equal steps in azimuth about each normal."""
    x, w = np.polynomial.legendre.leggauss(48)
    z, steps = (1 + x) / 2, 96
    phi = 2 * np.pi * (np.arange(steps) + 0.5) / steps
    r = np.sqrt(1 - z**2)[:, None]
    local = np.stack([r * np.cos(phi), r * np.sin(phi), np.repeat(z[:, None], steps, 1)], axis=2)
    local, weights = local.reshape(-1, 3), np.repeat(w / 2 * 2 * np.pi / steps, steps)
    frames = oracles.frames(mesh[2], np.cross([0.0, 0.0, 1.0], mesh[2]))
    F = round(np.sqrt(len(light))) - 1
    result = np.zeros((len(frames), 3))
    for p, frame in enumerate(frames):
        wo = view @ frame
        if wo[2] > 0:
            rho = transfer(local, wo[None]) * weights
            result[p] = rho @ (oracles.real_harmonics(F, local @ frame.T) @ light)
    return result


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "transfer"),
    [
        (brdf.GGX(0.4), oracles.ggx(0.4)),
        (brdf.AshikhminShirley(30, 8, 0.6, 0.4), oracles.ashikhmin_shirley(30, 8, 0.6, 0.4)),
    ],
    ids=["ggx", "ashikhmin-shirley"],
)
def test_without_occlusion_it_is_plain_shading(material, transfer):
    """Within the error of the basis that is reported, which is over white light and all views."""
    mesh, variants = moved(ball(1), random_rotation(4)), ("unshadowed", "shadowed")
    held = transferred(mesh, material, order=4, tents=7, variants=variants)
    lost, whole = dict.fromkeys(variants, 0.0), 0.0
    for k, view in enumerate(sphere(6, 5)):
        light = random_light(4, 10 + k)
        expected, up = unshadowed_expected(mesh, transfer, light, view), mesh[2] @ view > 0
        whole += (expected[up] ** 2).sum()
        for name in variants:
            lost[name] += ((expected - radiance(held, name, light, view))[up] ** 2).sum()
    # 6 views of 42 vertices and 18 random lights: their energies spread by 10%, .4 dB
    for energy_lost in lost.values():
        assert 10 * np.log10(whole / energy_lost) > held.report["SNR of matrices"] - 1
    assert held.report["SNR of matrices"] > 20


def test_it_is_what_prefiltering_says():
    mesh, view = moved(ball(2), random_rotation(6)), np.array([0.6, 0.0, 0.8])
    pixels = sh.synthesis(white(5) + 0.3 * random_light(5, 7), (64, 128))
    environment = Environment(pixels.astype(np.float32))
    up = mesh[2] @ view > 0.1
    reflection = prefilter(environment, brdf.GGX(0.4), tolerance=0.01)
    expected = reflection.radiance(mesh[2][up], np.tile(view, (up.sum(), 1)))
    held = transferred(mesh, brdf.GGX(0.4), order=5, tents=9, variants=("unshadowed",))
    actual = radiance(held, "unshadowed", environment.coefficients(4), view)[up]
    error = 10 ** (-held.report["SNR of matrices"] / 20)
    assert oracles.relative_rms(actual, expected) < error + 2 * reflection.error


# ---- Linearity and rotation


@pytest.mark.parametrize("half", [False, True])
def test_radiance_is_linear_in_the_light(half):
    held = transferred(BUMPY, GLOSSY, half=half)
    a, b = random_light(3, 8), random_light(3, 9)
    for view in sphere(3, 10):
        parts = [held.radiance(light, view=view).astype(np.float64) for light in (a, b, 2 * a - 3 * b)]
        scale = 2 * np.abs(parts[0]).max() + 3 * np.abs(parts[1]).max()
        assert np.abs(2 * parts[0] - 3 * parts[1] - parts[2]).max() < 1e-6 * scale


@pytest.mark.slow
def test_object_and_light_turn_together():
    mesh, R = BUMPY, random_rotation(11)
    tangents = np.random.default_rng(12).normal(size=mesh[0].shape)
    light, view = random_light(3, 13), sphere(1, 14)[0]
    options = {"variants": ALL, "directions": 1024}
    material = brdf.AshikhminShirley(20, 5)
    first = transferred(mesh, material, tangents=tangents, **options)
    second = transferred(moved(mesh, R, 2.0, 0.1), material, tangents=tangents @ R.T, **options)
    for name in ALL:
        before, after = radiance(first, name, light, view), radiance(second, name, turned(light, R), R @ view)
        same = np.abs(before - after).max(axis=1) < 1e-5 * np.abs(before).max()
        if name == "unshadowed":
            assert same.all()
            continue
        # A few rays in ten thousand run along edges and go either way. Each is one of a vertex's 512.
        assert same.mean() > 0.9
        assert oracles.relative_rms(after, before) < 2e-3


def turned(light: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Coefficients of L(R^T w), from its values at many directions."""
    F, w = round(np.sqrt(len(light))) - 1, sphere(200, 15)
    return np.linalg.lstsq(oracles.real_harmonics(F, w @ R.T), oracles.real_harmonics(F, w) @ light)[0]


# ---- What is reported is measured


def gram(M: int) -> np.ndarray:
    """Of the tents: 2 pi times that of tents on the unit square."""
    h = 1 / (M - 1)
    one = h / 6 * (4 * np.eye(M) + np.eye(M, k=1) + np.eye(M, k=-1))
    one[0, 0] = one[-1, -1] = h / 3
    return 2 * np.pi * np.kron(one, one)


def energy(A: np.ndarray) -> float:
    """Of the radiance that matrices (V, M^2, C, n^2) make of white light."""
    G = gram(round(np.sqrt(A.shape[1])))
    return float(np.einsum("ptcj,ts,pscj->", A, G, A, optimize=True))


@pytest.mark.parametrize("route", [Route(), Route(4)], ids=str)
@pytest.mark.parametrize("material", [GLOSSY, brdf.GGX(0.4)], ids=["color", "grey"])
@pytest.mark.parametrize(
    "options", [{"components": 12}, {"half": True, "accuracy": 20.0, "components": None}, {"clusters": 5}]
)
def test_the_snr_of_components_is_that_of_all_matrices(route, material, options):
    held = transferred(BUMPY, material, variants=ALL, tents=4, route=route, **options)
    assert list(held.report["compression"]) == list(held.variants)
    for name, report in held.report["compression"].items():
        A, K = matrices(held, name), held.variants[name].K
        assert report["K"] == K
        for k in {1, K // 2, K}:
            snr = 10 * np.log10(energy(A) / energy(A - rebuilt(held, name, k)))
            assert report["SNR of 1 to K"][k - 1] == pytest.approx(snr, abs=0.02)
        assert report["SNR"] == report["SNR of 1 to K"][-1]
        if options.get("components", 1) is None:
            assert report["SNR of 1 to K"][-1] >= 20 > report["SNR of 1 to K"][-2]
        held_as = np.float16 if options.get("half") else np.float32
        assert held.variants[name].weights.dtype == held_as


def test_what_is_asked_for_is_there():
    mesh = bumpy(2)
    held = transferred(
        mesh, brdf.GGX(0.5), order=2, tents=4, components=7, clusters=3, variants=ALL, half=True
    )
    assert (held.n, held.M, held.channels, held.material) == (2, 4, 1, brdf.GGX(0.5).name)
    np.testing.assert_array_equal(held.faces, mesh[1])
    np.testing.assert_array_equal(held.vertices, mesh[0].astype(np.float32))
    for variant in held.variants.values():
        assert variant.weights.shape == (len(mesh[0]), 7)
        assert variant.components.shape == (3, 7, 16, 1, 4)
        assert variant.matrices.shape == (len(mesh[0]), 16, 1, 4)
        assert set(variant.clusters) == {0, 1, 2}


@pytest.mark.parametrize("textured", [False, True])
def test_a_mesh_of_trimesh_is_taken_as_it_is(textured):
    vertices, faces, _ = bumpy(2, subdivisions=1)
    uv = np.random.default_rng(3).uniform(size=(len(vertices), 2)) if textured else None
    visual = trimesh.visual.TextureVisuals(uv=uv) if textured else None
    mesh = trimesh.Trimesh(vertices, faces, process=False, visual=visual)
    options = {"order": 2, "tents": 3, "route": Route(), "directions": 64, "components": 4}
    found = precompute(mesh, brdf.Lambert(0.5), **options)
    same = Surface(np.array(mesh.vertices), np.array(mesh.faces), np.array(mesh.vertex_normals), uv)
    expected = precompute(same, brdf.Lambert(0.5), **options)
    for name in ("vertices", "faces", "frames", "uv"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    for name, variant in expected.variants.items():
        np.testing.assert_array_equal(found.variants[name].weights, variant.weights)
        np.testing.assert_array_equal(found.variants[name].components, variant.components)


def test_variants_come_in_their_order_whatever_is_asked():
    held = transferred(bumpy(2), brdf.Lambert(0.5), order=1, tents=2, components=1, variants=ALL[::-1])
    assert tuple(held.variants) == ALL


def test_seams_of_textures_do_not_show():
    """Vertices at one place, with one normal, have the matrices of one; but for rays that run along edges."""
    mesh = Mesh.read(require("mesh/spot.obj"))
    options = {"order": 2, "tents": 2, "route": Route(), "directions": 512, "components": 4, "matrices": True}
    held = precompute(mesh, brdf.Lambert(0.8), variants=("interreflected",), **options)
    np.testing.assert_array_equal(held.uv, mesh.uv.astype(np.float32))
    _, first, place = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    assert len(first) < len(mesh.vertices) - 200
    A = matrices(held, "interreflected").reshape(len(mesh.vertices), -1)
    # 256 rays; a few of them may go either way
    difference = np.linalg.norm(A - A[first[place.ravel()]], axis=1)
    assert difference.max() < 3 / 256 * np.linalg.norm(A, axis=1).max()
