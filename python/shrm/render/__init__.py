"""Pictures without a GPU: spheres and meshes whose materials are prefiltered.

camera -> shapes, mesh -> lookup -> tonemap -> picture
"""

from .camera import Camera
from .lookup import environment_lookup, texture_lookup
from .mesh import Mesh
from .picture import Object, Picture, Reflection, render, tangents_around
from .shapes import Hits, Shape, Sphere
from .tonemap import automatic_exposure, display, srgb

__all__ = [
    "Camera",
    "Hits",
    "Mesh",
    "Object",
    "Picture",
    "Reflection",
    "Shape",
    "Sphere",
    "automatic_exposure",
    "display",
    "environment_lookup",
    "render",
    "srgb",
    "tangents_around",
    "texture_lookup",
]
