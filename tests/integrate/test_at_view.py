"""Maps for a view hold what `radiance` says, each at its own central direction, in every class that has them.

The central directions are found here from their definitions, and a map is read at one by a fit to the texels
around it: nothing is shared with what names, merges or indexes the maps.
"""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from shrm import brdf, explicit
from shrm.frequency.prefilter import prefilter
from shrm.integrate.angular import prefilter_angular
from shrm.integrate.hierarchical import prefilter_hierarchical
from support import oracles
from support.light import band_limited_environment

DEGREE = 3
"""Of the light, and so of its reflections."""
CORE_TOLERANCE = 0.01
ENV = band_limited_environment(DEGREE, seed=5, H=32)
VIEW = np.array([0.48, -0.36, 0.8])

MATERIALS = {
    "ggx": brdf.GGX(0.3),
    "two lobe centers": 0.5 * brdf.GGX(0.15) + 0.5 * brdf.GGX(0.6),
    "three lobe centers, one colored": brdf.GGX(0.2) + (0.9, 0.5, 0.1) * brdf.GGX(0.7) + brdf.GGX(0.4),
    "lambert and ggx": brdf.Lambert(0.5) + brdf.GGX(0.3),
    "phong and lambert": brdf.Phong(20) + brdf.Lambert((0.7, 0.5, 0.2)),
    "one center twice": brdf.Phong(8) + 0.3 * brdf.Phong(40),
    "about the reflection": (brdf.GGX(0.2) + brdf.GGX(0.6)).recentered("reflection"),
    "hair": brdf.KajiyaKay(8),
    "hair and a lobe center": brdf.KajiyaKay(8) + brdf.GGX(0.5) + brdf.GGX(0.2),
}
REFLECTIONS = {
    "frequency": lambda material, **grid: prefilter(ENV, material, orders=(DEGREE, 2), **grid),
    "clamped, of half floats": lambda material, **grid: prefilter(
        ENV, material, orders=(DEGREE, 1), clamp=True, half=True, **grid
    ),
    "with a residual": lambda material, **grid: prefilter(
        ENV, material, orders=(DEGREE, 1), residual="auto", tolerance=CORE_TOLERANCE, **grid
    ),
    "angular": lambda material, **grid: prefilter_angular(ENV, material, subsamples=1, **grid),
    "hierarchical": lambda material, **grid: prefilter_hierarchical(ENV, material, threshold=0.0, **grid),
}
WITH_CORES = ("two lobe centers", "phong and lambert", "one center twice", "lambert and ggx")
LAYOUTS = {"latlong": 32, "cube": 20}
"""And rows, or the edge of a face."""


def cases():
    """Method, material and layout: both layouts, or by turns where tables of lobes take their time."""
    for method in REFLECTIONS:
        names = list(WITH_CORES if method == "with a residual" else MATERIALS)
        by_turns = method in ("with a residual", "angular", "hierarchical")
        first = method == "hierarchical"  # of the materials that are integrated, each has both layouts
        for k, name in enumerate(names):
            for turn, layout in enumerate(LAYOUTS):
                if not by_turns or turn == (k + first) % 2:
                    yield method, name, layout


def texels(layout, size):
    """Directions of the texels, (n, 3): OpenGL's faces in the order +X -X +Y -Y +Z -Z, or lat-long."""
    if layout == "latlong":
        return oracles.directions(size, 2 * size).reshape(-1, 3)
    along = 2 * (np.arange(size) + 0.5) / size - 1
    t, s = np.meshgrid(along, along, indexing="ij")  # t down the face, s to its right
    one = np.ones_like(s)
    faces = [(one, -t, -s), (-one, -t, s), (s, one, t), (s, -one, -t), (s, -t, one), (-s, -t, -one)]
    # OpenGL's axes in the world: (x, y, z) = (Z, -X, Y)
    C = np.stack([np.stack([Z, -X, Y], axis=-1) for X, Y, Z in faces]).reshape(-1, 3)
    return C / np.linalg.norm(C, axis=1, keepdims=True)


def read(pixels, directions, C):
    """A map at directions C (n, 3): quadratics fitted to the texels around each."""
    flat = pixels.reshape(-1, 3)
    result = []
    for c in C:
        near = np.argsort(-(directions @ c))[:16]
        frame = oracles.frames(c[None], np.roll(c, 1)[None])[0]
        x, y, _ = (directions[near] @ frame).T
        basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
        result.append(np.linalg.lstsq(basis, flat[near], rcond=None)[0][0])
    return np.array(result)


@cache
def nodes():
    """Lights about the normal, and their weights."""
    u, w = np.polynomial.legendre.leggauss(160)
    theta, phi = np.meshgrid((1 + u) * np.pi / 4, (np.arange(160) + 0.5) * np.pi / 80, indexing="ij")
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    return wi.reshape(-1, 3), (w[:, None] * np.sin(theta)).ravel()


@cache
def central_directions(lobe):
    """C of a lobe by the definition of its center, for the normals and tangents of `queries`; (n, 3)."""
    N, T = queries()
    if lobe.center == "normal":
        return N
    if lobe.center == "tangent":
        return T
    if lobe.center == "reflection":
        return 2 * (N @ VIEW)[:, None] * N - VIEW
    wi, weight = nodes()
    frames = oracles.frames(N, np.broadcast_to(VIEW, N.shape))
    means = []
    for frame in frames:
        rho = lobe.transfer(wi, np.broadcast_to(VIEW @ frame, wi.shape)).reshape(len(wi), -1)
        means.append(frame @ ((weight * (rho**2).sum(axis=1)) @ wi))
    return np.array(means) / np.linalg.norm(means, axis=1, keepdims=True)


def from_table(gamma, N):
    """C at the angles gamma from normals, away from the view; (n, 3)."""
    angle = np.interp(np.arccos(N @ VIEW), np.linspace(0, np.pi / 2, len(gamma)), gamma)[:, None]
    across = VIEW - (N @ VIEW)[:, None] * N
    return np.cos(angle) * N - np.sin(angle) * across / np.linalg.norm(across, axis=1, keepdims=True)


@cache
def queries():
    """Normals that the view sees, and tangents."""
    N, T = np.random.default_rng(3).normal(size=(2, 60, 3))
    N /= np.linalg.norm(N, axis=1, keepdims=True)
    N *= np.sign(N @ VIEW)[:, None]
    T = np.cross(N, T)
    T /= np.linalg.norm(T, axis=1, keepdims=True)
    seen = N @ VIEW > 0.3
    return N[seen], T[seen]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::shrm.ToleranceWarning")  # two orders are few: what they hold is read
@pytest.mark.parametrize(("method", "name", "layout"), [*cases()])
def test_maps_for_a_view_sum_to_the_radiance(method, name, layout):
    size = LAYOUTS[layout]
    material = MATERIALS[name]
    reflection = REFLECTIONS[method](material, layout=layout, size=size)
    maps = reflection.maps_at_view(VIEW)
    N, T = queries()
    # The direction that each map is read at: lobes that share one share the map.
    centers, lobe_centers = {}, 0
    for k, lobe in enumerate(material.lobes):
        lobe_centers += lobe.center == "lobe"
        which = f"lobe {lobe_centers}" if lobe.center == "lobe" and lobe_centers > 1 else lobe.center
        centers[which] = central_directions(lobe)
        if method == "with a residual" and lobe.center == "lobe":  # its map is about what the orders hold
            centers[which] = from_table(reflection.parts[k].gamma, N)
    assert list(maps) == list(centers)
    directions = texels(layout, size)
    total = sum(read(pixels, directions, centers[which]) for which, pixels in maps.items())
    # What quadratics leave of a degree l between texels a distance h apart, (l h)^3 / 6 or less: 0.004.
    # Descents of cores differ from place to place by their error, as much as is asked for.
    allowed = 5e-3 + (CORE_TOLERANCE if method == "with a residual" else 0.0)
    assert oracles.relative_rms(total, reflection.radiance(N, VIEW, T)) < allowed

    if len(maps) == 1:
        assert_array_equal(reflection.at_view(VIEW), *maps.values())
        assert_array_equal(explicit.maps_at_views(reflection, VIEW[None])[0], *maps.values())
    else:
        with pytest.raises(ValueError, match=f"must have one center, got {', '.join(maps)}: maps_at_view"):
            reflection.at_view(VIEW)


@pytest.mark.parametrize("layout", ["latlong", "cube"])
def test_an_explicit_set_is_a_map_for_each_view_of_a_grid(layout):
    integral = prefilter_angular(ENV, brdf.GGX(0.4), size=8, layout=layout, subsamples=1)
    maps = explicit.reflection_maps(integral, 3)
    # The view of entry (0, 1): colatitude pi/6, azimuth pi - 2 pi/3 (1 + 1/2) = 0.
    view = np.array([0.5, 0.0, np.sqrt(0.75)])
    np.testing.assert_allclose(maps[0, 1], integral.at_view(view), rtol=1e-5)
    assert maps.shape == (3, 3, *integral.at_view(view).shape)


@pytest.mark.filterwarnings("ignore::shrm.ToleranceWarning")
@pytest.mark.parametrize("prefiltered", REFLECTIONS.values(), ids=REFLECTIONS)
def test_views_that_are_none_are_refused(prefiltered):
    reflection = prefiltered(brdf.Phong(9), size=8)
    for call in (reflection.at_view, reflection.maps_at_view):
        with pytest.raises(ValueError, match="view must be"):
            call([0.0, 0.0, 3.0])
