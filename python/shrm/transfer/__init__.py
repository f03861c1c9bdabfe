"""Matrix radiance transfer: objects that shadow and light themselves, under light that turns [LK03].

`precompute` makes a `RadianceTransfer` of a mesh and a material, which is saved, loaded and lit:

>>> import shrm
>>> from shrm.render import Mesh
>>> mesh = Mesh.read("armadillo.obj")
>>> transfer = shrm.transfer.precompute(mesh, shrm.brdf.AshikhminShirley(40, 10))
>>> transfer.save("armadillo.shrt")
>>> light = shrm.Environment.daylight().coefficients(transfer.n - 1)
>>> radiance = transfer.radiance(light, eye=[-3, 0, 1])         # (V, 3), at the vertices

From a mesh to its file, in the order of the data:

    rays/           directions, occluders, visibility, bounces: what vertices see; stored: arrays on disk
    matrices/       product, materials, accuracy, vertex_matrices: what light becomes there
    compression/    components, pca, clusters, choice
    precompute, precomputation, radiance_transfer and its variants, quaternions, file

Bases and matrices that these share: directional_basis, brdf_matrix, tangent_frames;
at run time, lighting/: surface, tents, earlier.
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
from shrm.transfer.precompute import precompute
from shrm.transfer.radiance_transfer import RadianceTransfer
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
