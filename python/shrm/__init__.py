"""shrm: frequency-space environment map rendering.

An environment map and a material become a spherical harmonic reflection map, from which any object can be
rendered in real time:

>>> import shrm
>>> env = shrm.Environment.daylight()
>>> rm = shrm.prefilter(env, shrm.brdf.GGX(0.3), tolerance=0.05)
>>> radiance = rm.radiance([[0.0, 0.0, 1.0]], [0.6, 0.0, 0.8])

The modules in the order of the data: `image_io`, `environment`, `brdf`, `sh`, `orders`, `reflection_map`,
`explicit`, `reference`, `hierarchical`, `cost`, `prefiltering`, `prefiltered`, `methods`, `relighting`,
`directional_basis`, `brdf_matrix`, `tangent_frames`, `transfer`, `render`.
"""

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
from shrm.version import __version__ as __version__

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
    "orders",
    "prefilter",
    "prefilter_angular",
    "prefilter_hierarchical",
    "prefiltered",
    "sh",
    "transfer",
]
