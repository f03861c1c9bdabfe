"""Transfer matrices against rays that know no expansion: what is asked for is what is there.

The relative SNR of radiance, over white light of order 5, the views above the horizon and some vertices.
The materials are those of Ashikhmin and Shirley [AS00 eqs. 4 and 6], with phi the azimuth of the half vector
H and Rs = 1: sqrt((nu + 1) (nv + 1)) / (8 pi) (N.H)^(nu cos^2 phi + nv sin^2 phi) / ((H.L) max(N.L, N.V)).
The oracle's own error is some 35 dB below the radiance of the sharpest, as half of its rays tell.
"""

from functools import cache

import numpy as np
import pytest
from shrm import brdf
from shrm.transfer.lighting import Tents
from shrm.transfer.matrices.product import Route, published
from shrm.transfer.precompute import precompute
from shrm.transfer.radiance_transfer import RadianceTransfer
from support import oracles
from support.data import require
from support.directions import sphere
from support.transfer_meshes import Mesh, Surface, ball, grid, simplified, together
from support.transfer_oracle import BruteForce, first_hits, snr, spiral

MESHES = {"bunny": ("mesh/trimesh_bunny.ply", 20), "armadillo": ("mesh/armadillo.obj", 24)}
VIEWS = sphere(64, 1)

SPREAD = 2.0
"""In dB. The energy that is lost differs between vertices by some 60%, so sums over 24 of them differ from
those over the 48 that are reported by 15% or .65 dB; this is three times that."""


@cache
def read(name: str) -> Mesh:
    path, cells = MESHES[name]
    return simplified(require(path), cells)


def transferred(mesh: Mesh, material: brdf.BRDF, **options: object) -> RadianceTransfer:
    """Few components: what is looked at are the matrices."""
    kept = {"variants": ("shadowed",), "components": 4, "matrices": True}
    return precompute(Surface(*mesh), material, **{**kept, **options})


def some_vertices(mesh: Mesh, count: int) -> np.ndarray:
    return np.sort(np.random.default_rng(2).choice(len(mesh[0]), count, replace=False))


def found(transfer: RadianceTransfer, name: str, vertices: np.ndarray) -> np.ndarray:
    """Radiance (vertices, VIEWS, n^2) under each harmonic, three at a time as R, G and B."""
    n2 = transfer.n**2
    A = np.array(transfer.variants[name].matrices[vertices])
    lighting = Tents(transfer.vertices[vertices], transfer.frames[vertices], A)
    lights = np.eye(n2, -(-n2 // 3) * 3)
    return np.concatenate(
        [
            np.stack([lighting.radiance(lights[:, j : j + 3], view=view) for view in VIEWS], axis=1)
            for j in range(0, n2, 3)
        ],
        axis=2,
    )[:, :, :n2]


def expected(
    mesh: Mesh, vertices: np.ndarray, transfer: oracles.Transfer, n: int, albedo: float | None = None
) -> list[np.ndarray]:
    """The same by brute force at each vertex, towards the views above it; the tangent around the vertical."""
    rays = BruteForce(*mesh)
    normals = mesh[2][vertices]
    return [
        rays.radiance(p, VIEWS[VIEWS @ N > 0], np.cross([0.0, 0.0, 1.0], N), transfer, n, albedo)
        for p, N in zip(vertices, normals, strict=True)
    ]


def above(mesh: Mesh, vertices: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Those of rows (vertices, VIEWS, n^2) whose view is above the vertex's horizon."""
    return rows[mesh[2][vertices] @ VIEWS.T > 0]


def measured(mesh: Mesh, transfer: RadianceTransfer, by_rays: oracles.Transfer) -> float:
    vertices = some_vertices(mesh, 24)
    B = np.concatenate(expected(mesh, vertices, by_rays, transfer.n))
    return snr(B, above(mesh, vertices, found(transfer, "shadowed", vertices)))


@pytest.mark.slow
def test_the_oracles_rays_are_those_of_moeller_and_trumbore():
    mesh = read("bunny")
    rays, d = BruteForce(*mesh), spiral(512, np.eye(3))
    for p in some_vertices(mesh, 4):
        up = d[d @ mesh[2][p] > 0]
        origins = np.tile(mesh[0][p] + rays.above * mesh[2][p], (len(up), 1))
        # A ray that runs along an edge may go either way
        differ = rays.caster.intersects_any(origins, up) != (first_hits(origins, up, mesh)[1] >= 0)
        assert np.count_nonzero(differ) <= 1


@pytest.mark.slow
@pytest.mark.parametrize(("name", "exponents"), [("bunny", (40.0, 10.0)), ("armadillo", (40.0, 40.0))])
def test_glossy_objects_with_shadows_have_the_default_accuracy(name, exponents):
    mesh = read(name)
    transfer = transferred(mesh, brdf.AshikhminShirley(*exponents))
    reached = measured(mesh, transfer, oracles.ashikhmin_shirley(*exponents))
    assert reached >= 24
    assert transfer.report["SNR of matrices"] == pytest.approx(reached, abs=SPREAD)


@pytest.mark.slow
@pytest.mark.parametrize("name", MESHES)
def test_diffuse_objects_with_shadows_have_40_dB(name):
    mesh = read(name)
    assert measured(mesh, transferred(mesh, brdf.Lambert(1.0)), oracles.lambert()) >= 40


@pytest.mark.slow
def test_the_published_way_loses_most_of_it():
    """Transferred radiance of order 5: 11.5 to 14.4 dB on meshes such as these."""
    mesh = read("bunny")
    transfer = transferred(mesh, brdf.AshikhminShirley(40, 40), tents=11, route=published(5))
    assert 10 < measured(mesh, transfer, oracles.ashikhmin_shirley(40, 40)) < 16


@pytest.mark.slow
def test_more_is_had_for_more():
    mesh = read("bunny")
    transfer = transferred(mesh, brdf.GGX(0.4), accuracy=30.0)
    assert measured(mesh, transfer, oracles.ggx(0.4)) >= 30


@pytest.mark.slow
def test_a_bounce_is_that_of_rays_that_go_on():
    """A ball above a floor. Tents of M = 9 hold this material to some 30 dB, and its bounces alike.

    Irradiance between vertices is interpolated: on the floor under the ball, in steps of a third of its
    radius, to a few in a hundred, a part of the light that is a tenth of all.
    """
    mesh = together(grid(12, [-2, -2, -1.4], [4, 0, 0], [0, 4, 0]), ball(3))
    glossy = {"nu": 20.0, "nv": 20.0, "Rs": 0.5, "Rd": 0.5}
    transfer = transferred(
        mesh,
        brdf.AshikhminShirley(**glossy),
        variants=("shadowed", "interreflected"),
        albedo=0.8,
        order=4,
        tents=9,
        route=Route(),
    )
    vertices = some_vertices(mesh, 8)
    by_rays = oracles.ashikhmin_shirley(**glossy)
    straight, total = (np.concatenate(expected(mesh, vertices, by_rays, 4, a)) for a in (None, 0.8))
    direct, both = (above(mesh, vertices, found(transfer, name, vertices)) for name in transfer.variants)
    assert np.linalg.norm(total - straight) > 0.1 * np.linalg.norm(straight)
    assert snr(total, both) > 28
    assert snr(total - straight, both - direct) > 25
