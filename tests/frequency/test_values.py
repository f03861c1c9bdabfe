"""What is public in frequency space pickles, says what it is in a line, and computes nothing twice."""

import inspect
import pickle
from collections import Counter

import numpy as np
import pytest
from shrm import Environment, Prefilter, ReflectionMap, brdf, sh
from shrm.frequency import analysis, prediction, prefilter, request
from shrm.prefiltered import explicit
from support import oracles

TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def env() -> Environment:
    return Environment.daylight(size=32)


def copied(value):
    return pickle.loads(pickle.dumps(value))


@pytest.fixture
def truncations(monkeypatch) -> list[object]:
    """The calls that measure what orders leave out."""
    calls: list[object] = []
    error_of = prediction.error_of
    monkeypatch.setattr(
        prediction, "error_of", lambda *given, **named: calls.append(given) or error_of(*given, **named)
    )
    return calls


def test_a_map_pickles_before_its_error_is_known(env, truncations):
    rm = prefilter.prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16)
    back = copied(rm)
    assert not truncations
    N, V = oracles.random_views(10, seed=1)
    np.testing.assert_array_equal(back.radiance(N, V), rm.radiance(N, V))
    assert back.error == rm.error
    assert len(truncations) == 2


def test_an_error_is_measured_once_and_the_light_let_go(env, truncations):
    rm = prefilter.prefilter(env, brdf.GGX(0.4), size=16)
    assert rm.error == rm.error == copied(rm).error
    assert len(truncations) == 1
    chosen = prefilter.prefilter(env, brdf.GGX(0.4))  # the size is chosen by the error
    assert chosen.error > 0
    assert len(truncations) == 2
    assert len(pickle.dumps(rm)) < len(pickle.dumps(prefilter.prefilter(env, brdf.GGX(0.4), size=16)))


@pytest.mark.parametrize("half", [False, True])
def test_a_prefilter_pickles_and_follows_the_light_as_before(env, half):
    relit = Prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16, half=half)
    relit.update(rotation=TURN)
    back = copied(relit)
    np.testing.assert_array_equal(back.map.parts[0].rings, relit.map.parts[0].rings)
    other = Environment(np.ascontiguousarray(env.pixels[::-1]))
    for change in ({}, {"rotation": TURN @ TURN}, {"env": other}, {"brdf": brdf.GGX(0.5)}):
        mine, theirs = relit.update(**change), back.update(**change)
        np.testing.assert_array_equal(theirs.parts[0].rings, mine.parts[0].rings)
        assert theirs.error == mine.error


def test_a_plan_pickles():
    plan = sh.Plan((8, 16), 3, channels=2, areas=True)
    c = np.random.default_rng(1).normal(size=(16, 2))
    back = copied(plan)
    assert (back.shape, back.F, back.channels, back.areas) == (plan.shape, 3, 2, True)
    np.testing.assert_array_equal(back.synthesis(c), plan.synthesis(c))


def test_each_says_in_one_line_what_it_is(env):
    rm = prefilter.prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16)
    views = explicit.grid_views(4).reshape(-1, 3)
    fitted = explicit.fit(explicit.maps_at_views(rm, views), views, P=1, center="normal")
    texts = {
        repr(rm): "ReflectionMap ggx",
        repr(rm.parts[0]): "Part about the lobe: F=6 P=2 latlong 16",
        repr(fitted.parts[0]): "CoefficientMaps about the normal: P=1 latlong 16",
        repr(Prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16)): "Prefilter of 32 x 64 texels",
        repr(sh.Plan((8, 16), 3)): "Plan of 8 x 16 samples, F=3, 3 channels",
        repr(request.Request(env, brdf.GGX(0.4))): "Request",
        repr(rm.prediction): "Prediction",
    }
    for text, start in texts.items():
        assert text.startswith(f"<{start}")
        assert "\n" not in text
        assert len(text) < 200


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "options"),
    [
        (brdf.GGX(0.3) + brdf.Lambert(0.5), {}),
        (brdf.GGX(0.1), {"tolerance": 0.01}),
        (brdf.GGX(0.05), {"residual": "auto", "F_max": 24, "P_max": 4}),
    ],
)
@pytest.mark.filterwarnings("ignore::shrm.ToleranceWarning")
def test_nothing_is_analysed_twice(env, material, options, monkeypatch):
    """Neither within a call, nor in a second one."""
    analysed: Counter[tuple[object, ...]] = Counter()
    for name in ("_analyse_radial", "_analyse_isotropic"):
        analyse = getattr(analysis, name)
        monkeypatch.setattr(
            analysis, name, lambda lobe, *to, of=analyse: analysed.update([(lobe, *to)]) or of(lobe, *to)
        )
    analysis.analyse.cache_clear()
    first = prefilter.prefilter(env, material, **options)
    assert first.error > 0
    assert analysed
    assert max(analysed.values()) == 1
    count = sum(analysed.values())
    again = prefilter.prefilter(env, material, **options)
    assert again.error == first.error
    assert sum(analysed.values()) == count


def test_arguments_are_listed_once_and_shown_everywhere():
    own = list(inspect.signature(request.Request).parameters)
    assert own[:4] == ["env", "brdf", "tolerance", "orders"]
    assert list(inspect.signature(prefilter.prefilter).parameters) == own
    assert list(inspect.signature(Prefilter).parameters) == own
    for name in own:
        assert name in prefilter.prefilter.__doc__


def test_a_loaded_map_knows_its_error(env, tmp_path):
    rm = prefilter.prefilter(env, brdf.GGX(0.4), orders=(4, 1), size=8)
    rm.save(tmp_path / "map.exr")
    back = copied(ReflectionMap.load(tmp_path / "map.exr"))
    assert back.error == pytest.approx(rm.error, rel=1e-6)


def test_a_strip_is_a_cube(env):
    """As pictures, cube maps are strips of faces: the name is taken here too."""
    cube, strip = (
        prefilter.prefilter(env, brdf.GGX(0.4), orders=(4, 1), size=8, layout=layout)
        for layout in ("cube", "strip")
    )
    assert strip.layout == "cube"
    np.testing.assert_array_equal(strip.parts[0].rings, cube.parts[0].rings)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"orders": 5}, "orders must be a pair"),
        ({"orders": (4, 25)}, r"P must be in \[0, 24\]"),
        ({"size": 9}, "size must be even, got 9"),
        ({"layout": "sphere"}, "layout must be one of latlong, cube, got 'sphere'"),
        ({"half": 1}, "half must be True or False, got 1"),
        ({"F_max": -1}, "F_max must be"),
        ({"criterion": "brdf", "residual": "auto"}, "residual='auto' is for"),
        ({"center": "middle"}, "center must be one of"),
        ({"tolerance": 0}, "tolerance must be above 0"),
        ({"method": "angular"}, "unexpected keyword argument 'method'"),
    ],
)
def test_a_request_is_refused_before_anything_is_computed(env, options, text, monkeypatch):
    monkeypatch.setattr(prefilter, "expansion_for", lambda _: pytest.fail("computed"))
    for function in (prefilter.prefilter, Prefilter):
        with pytest.raises((TypeError, ValueError), match=text):
            function(env, brdf.GGX(0.4), **options)
