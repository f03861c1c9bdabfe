"""Pictures without a GPU: spheres and meshes whose materials are prefiltered, objects with transfer.

camera -> line_field, tangents, placement -> shapes, mesh -> tonemap, vertex_radiance -> picture
transferred, row, turntable, output; drawn_text -> material_figure
"""

from shrm.environment.lookup import environment_lookup, texture_lookup
from shrm.render.camera import Camera, Viewer
from shrm.render.line_field import tangents_around
from shrm.render.mesh import Mesh
from shrm.render.output import write_picture
from shrm.render.picture import Background, Object, Picture, Shading, SupportsRadiance, render
from shrm.render.placement import Placement, about_vertical
from shrm.render.row import row_camera, row_shape
from shrm.render.shapes import Hits, Shape, Sphere
from shrm.render.tangents import Tangents, principal_tangents, uv_tangents
from shrm.render.tonemap import automatic_exposure, display, srgb
from shrm.render.transferred import TransferredMesh
from shrm.render.turntable import numbered, turned_camera
from shrm.render.vertex_radiance import VertexRadiance

__all__ = [
    "Background",
    "Camera",
    "Hits",
    "Mesh",
    "Object",
    "Picture",
    "Placement",
    "Shading",
    "Shape",
    "Sphere",
    "SupportsRadiance",
    "Tangents",
    "TransferredMesh",
    "VertexRadiance",
    "Viewer",
    "about_vertical",
    "automatic_exposure",
    "display",
    "environment_lookup",
    "numbered",
    "principal_tangents",
    "render",
    "row_camera",
    "row_shape",
    "srgb",
    "tangents_around",
    "texture_lookup",
    "turned_camera",
    "uv_tangents",
    "write_picture",
]
