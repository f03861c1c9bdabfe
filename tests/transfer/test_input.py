"""Bad input of precomputation: refused in one line before any work, or computed all the same."""

from typing import Any

import numpy as np
import pytest
from shrm import brdf
from shrm.transfer.matrices.product import Route
from shrm.transfer.precompute import precompute
from support.precomputed import ALL, matrices, radiance, transferred
from support.transfer_meshes import Mesh, Surface, bumpy

VERTICES, FACES, NORMALS = MESH = bumpy(2)
COUNT = len(VERTICES)
TWO = (brdf.Lambert(0.5), brdf.GGX(0.4))


def with_value(array: np.ndarray, value: float) -> np.ndarray:
    array = np.array(array, np.float64)
    array[5, 1] = value
    return array


def refused(message: str, mesh: Surface, material: Any = TWO[0], **options: Any) -> None:
    steps: list[str] = []
    small = {"order": 2, "tents": 3, "route": Route(), "directions": 64, "components": 2}
    with pytest.raises((TypeError, ValueError), match=f"^{message}[^\n]*$"):
        precompute(mesh, material, progress=lambda *step: steps.append(str(step)), **{**small, **options})
    assert not steps


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"vertices": with_value(VERTICES, np.nan)},
            r"vertices must be finite, got 1 .* the first at \(5, 1\)",
        ),
        ({"vertices": with_value(VERTICES, np.inf)}, "vertices must be finite"),
        ({"vertices": VERTICES[:, :2]}, r"vertices must have the shape \(V, 3\), not empty, got \(162, 2\)"),
        (
            {"vertices": VERTICES[:0], "vertex_normals": NORMALS[:0]},
            r"vertices must have the shape \(V, 3\), not empty, got \(0, 3\)",
        ),
        ({"vertices": VERTICES.astype(complex)}, "vertices must be an array of real numbers"),
        ({"faces": FACES[:0]}, r"faces must have the shape \(T, 3\), not empty, got \(0, 3\)"),
        ({"faces": []}, "faces must be an array of whole numbers, got dtype float64"),
        ({"faces": FACES[:, :2]}, r"faces must have the shape \(T, 3\), not empty, got \(320, 2\)"),
        ({"faces": FACES + 1}, r"faces must be in \[0, 162\), got [0-9]+ that are not, from 1 to 162"),
        ({"faces": FACES - 1}, r"faces must be in \[0, 162\), got [0-9]+ that are not, from -1 to 160"),
        ({"faces": FACES.astype(float)}, "faces must be an array of whole numbers, got dtype float64"),
        ({"faces": [[0, 1], [2]]}, "faces must be an array of whole numbers, got rows of unequal length"),
        ({"vertex_normals": NORMALS[:5]}, r"vertex_normals must have the shape \(162, 3\), got \(5, 3\)"),
        ({"vertex_normals": with_value(NORMALS, np.nan)}, "vertex_normals must be finite"),
        ({"vertices": with_value(VERTICES, 1e300)}, "vertices must be within the range of float32, got 1e"),
        ({"uv": np.zeros((3, 2))}, r"uv must have the shape \(162, 2\), got \(3, 2\)"),
        ({"uv": with_value(VERTICES, np.nan)[:, :2]}, "uv must be finite"),
    ],
)
def test_broken_meshes_are_refused(change, message):
    refused(message, Surface(**{"vertices": VERTICES, "faces": FACES, "vertex_normals": NORMALS, **change}))


def test_what_is_no_mesh_is_refused():
    refused("mesh must have vertices, faces and vertex_normals, got tuple", MESH)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        *(
            ({"order": n}, r"order must be (in \[1, 10\]|a whole number), got ")
            for n in (0, 11, -1, 2.0, True, "2")
        ),
        *(({"tents": M}, r"tents must be (in \[2, 33\]|a whole number), got ") for M in (1, 34, 3.0, "3")),
        *(
            ({"components": K}, "components must be (at least 1|in|a whole number)")
            for K in (0, -1, 1.5, "2")
        ),
        *(({"clusters": Q}, r"clusters must be (in \[1, 162\]|a whole number)") for Q in (0, COUNT + 1, 1.0)),
        *(({"bounces": k}, r"bounces must be (in \[1, 1000\]|a whole number)") for k in (0, 1001, 2.0)),
        *(
            ({"accuracy": dB}, r"accuracy must be (in \[0, 60\]|a number), got ")
            for dB in (-1, 61.0, np.nan, np.inf, "20", True)
        ),
        *(
            ({"directions": D}, r"directions must be (in \[16, 65536\]|a whole number)")
            for D in (15, 65537, 64.0)
        ),
        *(
            ({"albedo": a}, "albedo must be in")
            for a in (1.01, -0.1, [0.5, 2, 0.5], np.full((COUNT, 3), 2.0))
        ),
        (
            {"albedo": [0.5, 0.5]},
            r"albedo must have the shape \(\) or \(3,\) or \(162,\) or \(162, 3\), got \(2,\)",
        ),
        ({"albedo": np.nan}, "albedo must be finite"),
        *(
            (
                {name: 1, "variants": held},
                f"variants must have interreflected where {name} is given, got {held}",
            )
            for name in ("bounces", "albedo")
            for held in ("unshadowed", "shadowed")
        ),
        ({"variants": ()}, "variants must name at least one"),
        ({"variants": ("shadowed", "lit")}, "variants must be one of unshadowed, shadowed, interreflected"),
        ({"variants": [1]}, "variants must be one of"),
        ({"tangents": np.ones((3, 3))}, r"tangents must have the shape \(162, 3\), got \(3, 3\)"),
        ({"tangents": with_value(NORMALS, np.nan)}, "tangents must be finite"),
        *(
            ({"material": m}, "brdf must be a material of shrm.brdf, or several")
            for m in ("lambert", 5, [], None)
        ),
        ({"material": [TWO[0], 3]}, "brdf must be a material of shrm.brdf, or several"),
        ({"material": TWO}, "shares must be given for 2 materials"),
        ({"route": "direct"}, "route must be a shrm.transfer.Route, got str"),
        ({"variants": 5}, "variants must be names, got 5"),
        ({"half": 1}, "half must be True or False, got 1"),
        ({"matrices": "yes"}, "matrices must be True or False, got 'yes'"),
    ],
)
def test_arguments_out_of_range_are_refused(options, message):
    refused(message, Surface(*MESH), **options)


@pytest.mark.parametrize(
    ("orders", "message"),
    [
        ({"inner": 0}, r"inner must be in \[1, 32\], got 0"),
        ({"inner": 33}, r"inner must be in \[1, 32\], got 33"),
        ({"inner": 3.5}, "inner must be a whole number"),
        ({"inner": "direct"}, "inner must be a whole number"),
        ({"inner": 3, "m": 0}, r"m must be in \[1, 32\], got 0"),
        ({"inner": 3, "m": 8.0}, "m must be a whole number"),
        ({"m": 8}, "m must be None without inner, got 8"),
        ({"inner": 3, "window_above": 5}, "window_above must be None without m, got 5"),
        ({"inner": 3, "m": 4, "window_above": 4}, r"window_above must be in \[0, 3\], got 4"),
        ({"inner": 3, "m": 4, "extension": "odd"}, "extension must be one of least-squares, even, zero"),
    ],
)
def test_routes_out_of_range_are_refused(orders, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}[^\n]*$"):
        Route(**orders)


@pytest.mark.parametrize(
    ("shares", "message"),
    [
        (np.ones((COUNT, 3)), r"shares must have the shape \(162, 2\), got \(162, 3\)"),
        (np.ones((COUNT - 1, 2)), r"shares must have the shape \(162, 2\)"),
        (np.ones(COUNT), r"shares must have the shape \(162, 2\)"),
        (with_value(np.ones((COUNT, 2)), np.nan), "shares must be finite"),
        (with_value(np.ones((COUNT, 2)), -1e-9), r"shares must be in \[0, 1e\+06\], got -1e-09 to 1"),
        (with_value(np.ones((COUNT, 2)), 1e300), r"shares must be in \[0, 1e\+06\], got 1 to 1e\+300"),
        ("half", "shares must be an array of real numbers"),
    ],
)
def test_shares_that_cannot_be_are_refused(shares, message):
    refused(message, Surface(*MESH), TWO, shares=shares)


def test_too_many_components_are_refused_before_rays_are_cast():
    steps = []
    with pytest.raises(ValueError, match=r"^components must be in \[1, 36\], got 37$"):
        precompute(
            Surface(*MESH),
            TWO[0],
            order=2,
            tents=3,
            route=Route(),
            directions=64,
            components=37,
            progress=lambda *s: steps.append(s[0]),
        )
    assert set(steps) == {"choosing tents"}


def test_tents_that_miss_the_accuracy_are_reported():
    with pytest.warns(UserWarning, match=r"^3 x 3 tents reach [0-9.]+ dB of the 40 asked for$"):
        precompute(Surface(*MESH), TWO[1], order=3, tents=3, directions=512, components=2, accuracy=40)


def test_a_work_folder_that_is_a_file_is_refused_at_once(tmp_path):
    (tmp_path / "work").write_bytes(b"")
    with pytest.raises(OSError, match="work"):
        precompute(
            Surface(*MESH), TWO[0], work=tmp_path / "work", progress=lambda *step: pytest.fail("begun")
        )


# ---- What is odd but no error


def broken() -> tuple[Mesh, slice]:
    """The mesh with vertices that coincide or have no face, and faces without area, twice and at edges."""
    extra = np.array([VERTICES[0], [0, 0, 0], [50.0, 0, -50], 0.5 * (VERTICES[0] + VERTICES[1])])
    k = COUNT
    flat = [[0, 0, 1], [2, 2, 2], [k, 0, k], [0, 1, k + 3]]
    double = np.r_[FACES[:5], FACES[5:9, ::-1]]
    faces = np.r_[FACES, flat, double]
    normals = np.r_[NORMALS, [NORMALS[0]], np.zeros((3, 3))]
    return (np.r_[VERTICES, extra], faces, normals), slice(0, k)


@pytest.mark.parametrize("route", [Route(), Route(3)], ids=str)
def test_broken_meshes_are_computed_all_the_same(route):
    """Faces without area and faces twice block what is blocked anyway."""
    mesh, good = broken()
    held = transferred(mesh, TWO[1], variants=ALL, route=route, albedo=0.5)
    clean = transferred(MESH, TWO[1], variants=ALL, route=route, albedo=0.5)
    for name in ALL:
        A, expected = matrices(held, name), matrices(clean, name)
        assert np.isfinite(A).all()
        close = np.abs(A[good] - expected).max(axis=(1, 2, 3)) < 1e-5 * np.abs(expected).max()
        assert close.mean() > (0.999 if name != "interreflected" else 0.9)
        np.testing.assert_allclose(A[COUNT], A[0], atol=2e-3 * np.abs(A).max())  # at the same place
    assert not matrices(held, "shadowed")[COUNT + 1].any()  # in the middle
    assert matrices(held, "shadowed")[COUNT + 2].any()  # far away, without a normal: the world's z
    np.testing.assert_array_equal(held.frames[COUNT + 2, :, 2], [0, 0, 1])


@pytest.mark.slow
def test_tangents_without_a_direction_do_not_matter_to_isotropic_materials():
    """They turn frames about the normal, and with them the rays and the tents: 1024 and 7 x 7, 25 dB each."""
    light, view = np.eye(9)[:, 1:4], np.array([0, 0, 1.0])
    options = {"tents": 7, "directions": 2048}
    expected = radiance(transferred(MESH, TWO[1], **options), "shadowed", light, view)
    for tangents in (0 * NORMALS, NORMALS, 1e-300 * NORMALS):
        held = transferred(MESH, TWO[1], tangents=tangents, **options)
        assert np.isfinite(held.frames).all()
        actual = radiance(held, "shadowed", light, view)
        assert np.linalg.norm(actual - expected) < 0.1 * np.linalg.norm(expected)


@pytest.mark.parametrize(
    "mesh",
    [
        (VERTICES[:3], [[0, 1, 2]], NORMALS[:3]),
        (VERTICES[:1], [[0, 0, 0]], NORMALS[:1]),
        (0 * VERTICES, FACES, NORMALS),
        (VERTICES, [[0, 0, 1], [2, 2, 2]], NORMALS),
        (VERTICES, FACES, 0 * NORMALS),
        (1e30 * VERTICES, FACES, NORMALS),
        (1e-30 * VERTICES, FACES, NORMALS),
        (VERTICES + 1e6, FACES, NORMALS),
    ],
    ids=["a triangle", "a vertex", "a point", "no area", "no normals", "huge", "tiny", "far"],
)
def test_extreme_meshes_are_computed(mesh):
    held = transferred(mesh, TWO[0], order=2, tents=3, variants=ALL, components=None, half=True)
    for name in ALL:
        assert np.isfinite(matrices(held, name)).all()
        assert np.isfinite(held.radiance(np.ones((4, 3)), view=[0, 0, 1.0], variant=name)).all()


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 10])
@pytest.mark.parametrize("directions", [16, 1000])
def test_extreme_orders_and_counts_are_computed(n, directions):
    held = transferred(MESH, TWO[1], order=n, tents=2, directions=directions, components=1, variants=ALL)
    for name in ALL:
        assert matrices(held, name).shape == (COUNT, 4, 1, n * n)
        assert np.isfinite(matrices(held, name)).all()


def test_black_materials_and_no_shares_are_black():
    for material, options in ((brdf.Lambert(0.0), {}), (TWO, {"shares": np.zeros((COUNT, 2))})):
        held = transferred(MESH, material, variants=ALL, clusters=2, components=2, half=True, **options)
        for name in ALL:
            assert not matrices(held, name).any()
            assert not held.radiance(np.ones((9, 3)), view=[0, 0, 1.0], variant=name).any()
