"""shrm: frequency-space environment map rendering.

An environment map and a material become a spherical harmonic reflection map, from which any object can be
rendered in real time:

>>> import shrm
>>> env = shrm.Environment.daylight()
>>> rm = shrm.prefilter(env, shrm.brdf.GGX(0.3), tolerance=0.05)
>>> radiance = rm.radiance([[0.0, 0.0, 1.0]], [0.6, 0.0, 0.8])

The rooms in the order of the data: `image_io`, `environment`, `brdf`, `lobes`, `sh`, `integrate`,
`frequency`, `methods`, `prefiltered`, `transfer`, `render`, `viewer`. The last two, which need meshes and
OpenGL, are loaded when they are first asked for.
"""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import TYPE_CHECKING

from shrm import brdf, prefiltered, sh, transfer
from shrm.environment import Environment
from shrm.frequency import orders
from shrm.frequency.orders import ToleranceWarning
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.relight import Prefilter
from shrm.image_io import ImageError, ImageWarning
from shrm.integrate.angular import prefilter_angular
from shrm.integrate.hierarchical import prefilter_hierarchical
from shrm.methods.cost import cheapest
from shrm.prefiltered import explicit
from shrm.result_files import load
from shrm.version import __version__ as __version__

if TYPE_CHECKING:
    from shrm import render, viewer

__all__ = [
    "Environment",
    "ImageError",
    "ImageWarning",
    "Prefilter",
    "ReflectionMap",
    "ToleranceWarning",
    "brdf",
    "cheapest",
    "explicit",
    "load",
    "orders",
    "prefilter",
    "prefilter_angular",
    "prefilter_hierarchical",
    "prefiltered",
    "render",
    "sh",
    "transfer",
    "viewer",
]

_LOADED_LATER = ("render", "viewer")


def __getattr__(name: str) -> ModuleType:
    """Load `shrm.render` or `shrm.viewer` when it is first asked for."""
    if name in _LOADED_LATER:
        return importlib.import_module(f"shrm.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return the names that are for users, those that are loaded later among them."""
    return [*__all__, "__version__"]
