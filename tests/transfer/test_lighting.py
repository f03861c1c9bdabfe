"""What all ways of lighting an object have in common, and input that they refuse."""

import numpy as np
import pytest
from shrm import brdf
from shrm.transfer.lighting import (
    Compressed,
    Convolution,
    Diffuse,
    FixedLight,
    FixedView,
    Projection,
    Tents,
    zonal_kernel,
)
from support.transfer_vertices import (
    EYE,
    FRAMES,
    POINTS,
    VIEW,
    V,
    assert_close,
    random,
    shadows,
    some_of,
)


def all_methods() -> dict:
    T, samples = shadows(V, 5, 50), random((17, 17, 1, 25), 51)
    tents = some_of("tents", 1)
    return {
        "tents": tents,
        "tents, halves, 3 channels": some_of("halves", 3),
        "compressed": some_of("compressed", 3),
        "clustered": some_of("clustered", 1),
        "fixed light": FixedLight(tents),
        "fixed view": FixedView(tents),
        "projection": Projection(POINTS, FRAMES, samples, T),
        "prerotated": Projection(POINTS, FRAMES, samples, T, prerotated=True),
        "projection, no shadows": Projection(POINTS, FRAMES, samples),
        "convolution": Convolution(POINTS, FRAMES, np.linspace(1, 0.2, 5), T),
        "convolution, no shadows": Convolution(POINTS, FRAMES, np.linspace(1, 0.2, 5)),
        "diffuse": Diffuse(random((V, 1, 25), 52)),
    }


METHODS = all_methods()
EACH = pytest.mark.parametrize("lighting", METHODS.values(), ids=METHODS.keys())


@EACH
def test_radiance_is_linear_in_the_light(lighting):
    one, two = random((2, 25, 3), 53, np.float64)
    found = [lighting.radiance(light, eye=EYE).astype(float) for light in (one, two, 0.3 * one - 2 * two)]
    assert_close(np.float32(0.3 * found[0] - 2 * found[1]), found[2], 1e-6 * np.abs(found[2]).max())


@EACH
def test_the_result_goes_where_it_is_wanted(lighting):
    light, out = random((25, 3), 54, np.float64), np.full((V, 3), np.nan, dtype=np.float32)
    assert lighting.radiance(light, view=VIEW, out=out) is out
    np.testing.assert_array_equal(out, lighting.radiance(light, view=VIEW))


@EACH
def test_calls_that_make_no_sense_are_refused(lighting):
    light = np.zeros((25, 3))
    for wrong, message in {
        "light": r"light must have the shape \(25, 3\), got \(16, 3\)",
        "eye": r"eye must have the shape \(3,\), got \(2,\)",
        "view": "view must be unit vectors",
        "both": "eye or view must be given, got both",
        "out": rf"out must have the shape \({V}, 3\)",
        "nan": "light must be finite",
        "far": "eye must be within the range of float32, got 1e",
    }.items():
        arguments: dict = {"light": light, "eye": EYE}
        if wrong == "light":
            arguments["light"] = np.zeros((16, 3))
        elif wrong == "nan":
            arguments["light"] = np.full((25, 3), np.nan)
        elif wrong == "eye":
            arguments["eye"] = [0, 1]
        elif wrong == "far":
            arguments["eye"] = [0, 1e39, 0]
        elif wrong == "out":
            arguments["out"] = np.zeros((3, V), dtype=np.float32)
        else:
            arguments["view"] = [0, 0, 2]
        if wrong == "view":
            del arguments["eye"]
        if wrong == "both":
            arguments["view"] = VIEW
        with pytest.raises(ValueError, match=message):
            lighting.radiance(**arguments)


def test_an_eye_is_needed():
    with pytest.raises(ValueError, match="eye or view must be given, got neither"):
        METHODS["tents"].radiance(np.zeros((25, 3)))


BAD = {
    "vertices must have the shape": lambda: Tents(POINTS[:, :2], FRAMES, np.zeros((V, 9, 1, 4))),
    r"vertices must be finite, got 3 values that are not, the first at \(3, 0\)": lambda: Tents(
        np.where(np.arange(V)[:, None] == 3, np.nan, POINTS), FRAMES, np.zeros((V, 9, 1, 4))
    ),
    "frames must have the shape": lambda: Tents(POINTS, FRAMES[1:], np.zeros((V, 9, 1, 4))),
    "frames must be rotations": lambda: Tents(POINTS, -FRAMES, np.zeros((V, 9, 1, 4))),
    r"matrices must have M\^2 tents, M in \[2, 33\], got 8": lambda: Tents(
        POINTS, FRAMES, np.zeros((V, 8, 1, 4))
    ),
    r"matrices must have n\^2 coefficients of light, n in \[1, 10\], got 5": lambda: Tents(
        POINTS, FRAMES, np.zeros((V, 9, 1, 5))
    ),
    "matrices must have 1 or 3 channels, got 2": lambda: Tents(POINTS, FRAMES, np.zeros((V, 9, 2, 4))),
    "matrices must have the shape": lambda: Tents(POINTS, FRAMES, np.zeros((V - 1, 9, 1, 4))),
    "matrices must be finite": lambda: Tents(POINTS, FRAMES, np.full((V, 9, 1, 4), np.inf)),
    "matrices must be within the range of float32, got 1e": lambda: Tents(
        POINTS, FRAMES, np.full((V, 9, 1, 4), 1e300)
    ),
    r"K must be in \[1, 4\], got 5": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((4, 9, 1, 4)), K=5
    ),
    "components must have the shape": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((3, 9, 1, 4))
    ),
    r"clusters must be in \[0, 2\), got 531 that are not, from 2 to 2": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((2, 4, 9, 1, 4)), np.full(V, 2)
    ),
    r"clusters must have the shape": lambda: Compressed(
        POINTS, FRAMES, np.zeros((V, 4)), np.zeros((2, 4, 9, 1, 4)), np.zeros(3, dtype=int)
    ),
    "transfer must have the shape": lambda: Projection(
        POINTS, FRAMES, np.zeros((8, 8, 1, 4)), np.zeros((V, 4, 9))
    ),
    "transfer must be given": lambda: Projection(POINTS, FRAMES, np.zeros((8, 8, 1, 4)), prerotated=True),
    "rows must have the shape": lambda: Projection(POINTS, FRAMES, np.zeros((8, 9, 1, 4))),
    "axis must be one of reflection, normal, got 'view'": lambda: Convolution(
        POINTS, FRAMES, np.ones(3), axis="view"
    ),
    "kernel must have 1 or 3 channels": lambda: Convolution(POINTS, FRAMES, np.ones((3, 2))),
    "brdf must have one lobe": lambda: zonal_kernel(brdf.GGX(0.3), 5),
}


@pytest.mark.parametrize("message", BAD.keys())
def test_bad_input_is_one_line_that_names_the_argument(message):
    with pytest.raises(ValueError, match=message) as caught:
        BAD[message]()
    assert "\n" not in str(caught.value)


def test_wrong_types_are_refused():
    with pytest.raises(TypeError, match="matrices must be an array of real numbers, got dtype complex128"):
        Tents(POINTS, FRAMES, np.zeros((V, 9, 1, 4), dtype=complex))
    with pytest.raises(TypeError, match="clusters must be an array of whole numbers"):
        Compressed(POINTS, FRAMES, np.zeros((V, 4)), np.zeros((2, 4, 9, 1, 4)), np.zeros(V))
    with pytest.raises(TypeError, match="lighting must be Tents or Compressed, got Diffuse"):
        FixedLight(METHODS["diffuse"])
    with pytest.raises(TypeError, match="brdf must be a material"):
        zonal_kernel("lambert", 5)
