"""Matrix radiance transfer: objects that shadow and light themselves, under light that turns [LK03].

`precompute` makes a `RadianceTransfer` of a mesh and a material, which is saved, loaded and lit:

>>> import shrm
>>> from shrm.render import Mesh
>>> mesh = Mesh.read("armadillo.obj")
>>> transfer = shrm.transfer.precompute(mesh, shrm.brdf.AshikhminShirley(40, 10))
>>> transfer.save("armadillo.shrt")
>>> light = shrm.Environment.daylight().coefficients(transfer.n - 1)
>>> radiance = transfer.radiance(light, eye=[-3, 0, 1])         # (V, 3), at the vertices

From a mesh to its file, in the order of the data: `directions`, `rays`, `visibility`, `bounces`; `product`,
`accuracy`, `materials`, `stored`, `matrices`; `components`, `compression`, `clusters`; `precompute`,
`object`, `quaternions`, `file`. At run time: `surface`, `tents`, `earlier`, `lighting`.
"""

from shrm.transfer.lighting import (
    Compressed,
    Convolution,
    Diffuse,
    FixedLight,
    FixedView,
    Lighting,
    Projection,
    Tents,
)
from shrm.transfer.matrices.product import Route, published
from shrm.transfer.object import RadianceTransfer
from shrm.transfer.precompute import precompute
from shrm.transfer.variant import Variant

__all__ = [
    "Compressed",
    "Convolution",
    "Diffuse",
    "FixedLight",
    "FixedView",
    "Lighting",
    "Projection",
    "RadianceTransfer",
    "Route",
    "Tents",
    "Variant",
    "precompute",
    "published",
]
