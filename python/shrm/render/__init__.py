"""Pictures without a GPU: spheres and meshes whose materials are prefiltered.

camera -> shapes, mesh -> lookup -> tonemap -> picture -> row, turntable, output
"""

from shrm.render.camera import Camera
from shrm.render.lookup import environment_lookup, texture_lookup
from shrm.render.mesh import Mesh
from shrm.render.output import write_picture
from shrm.render.picture import Object, Picture, Reflection, render, tangents_around
from shrm.render.row import row_camera, row_picture
from shrm.render.shapes import Hits, Shape, Sphere
from shrm.render.tonemap import automatic_exposure, display, srgb
from shrm.render.turntable import about_vertical, numbered, turned_camera

__all__ = [
    "Camera",
    "Hits",
    "Mesh",
    "Object",
    "Picture",
    "Reflection",
    "Shape",
    "Sphere",
    "about_vertical",
    "automatic_exposure",
    "display",
    "environment_lookup",
    "numbered",
    "render",
    "row_camera",
    "row_picture",
    "srgb",
    "tangents_around",
    "texture_lookup",
    "turned_camera",
    "write_picture",
]
