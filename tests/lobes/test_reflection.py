"""What all results of prefiltering have in common."""

from collections.abc import Callable

import numpy as np
import pytest
import shrm
from shrm import brdf, prefiltered
from shrm.lobes.reflection import Reflection

Make = Callable[[shrm.Environment, str], Reflection]

MAKERS: list[Make] = [
    lambda env, layout: shrm.prefilter(env, brdf.Lambert(0.5), layout=layout),
    lambda env, layout: shrm.Prefilter(env, brdf.Lambert(0.5), layout=layout).map,
    lambda env, layout: shrm.prefilter_angular(env, brdf.Lambert(0.5), layout=layout, size=4),
    lambda env, layout: shrm.prefilter_hierarchical(env, brdf.Lambert(0.5), layout=layout, size=4),
    lambda env, layout: prefiltered.prefilter(env, brdf.Lambert(0.5), layout=layout, size=4),
    lambda env, layout: prefiltered.Diffuse.prefilter(env, brdf.Lambert(0.5), layout=layout, size=4),
]


@pytest.mark.parametrize("make", MAKERS)
def test_layouts_have_the_same_names_everywhere(make: Make) -> None:
    env = shrm.Environment(np.ones((8, 16, 3), np.float32))
    assert {layout: make(env, layout).layout for layout in ("latlong", "cube", "strip")} == {
        "latlong": "latlong",
        "cube": "cube",
        "strip": "cube",
    }
    with pytest.raises(ValueError, match="layout must be one of latlong, cube, got 'angular'"):
        make(env, "angular")


def test_the_cheapest_method_is_asked_for_by_the_same_names() -> None:
    env = shrm.Environment(np.ones((8, 16, 3), np.float32))
    assert shrm.cheapest(env, brdf.GGX(0.3), layout="strip") == shrm.cheapest(
        env, brdf.GGX(0.3), layout="cube"
    )
    with pytest.raises(ValueError, match="layout must be one of"):
        shrm.cheapest(env, brdf.GGX(0.3), layout="angular")
