"""Shapes as OpenGL draws them, and the camera as a matrix."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray, IntArray
from shrm.render.camera import Camera
from shrm.render.mesh import Mesh
from shrm.render.shapes import Shape, Sphere
from shrm.render.vertex_radiance import VertexRadiance
from shrm.viewer.gpu.programs import Surface

# A cube of side 2, seen from inside: its far side is drawn.
BOX = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
BOX_FACES = np.array(
    [
        [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
        [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
    ],
    np.int64,
)  # fmt: skip


class Geometry:
    """The vertices of a mesh or a sphere on the GPU.

    Attributes
    ----------
    surface : {"sphere", "mesh", "tangent_mesh"}
        The last is a mesh with a tangent field.
    sphere : (x, y, z, radius) or None
    """

    def __init__(self, gl: moderngl.Context, shape: Shape) -> None:
        self.surface: Surface = "sphere"
        self.sphere: tuple[float, ...] | None = None
        vertices: FloatArray
        if isinstance(shape, Mesh):
            self.surface = "mesh" if shape.tangents is None else "tangent_mesh"
            uv = np.zeros((len(shape.vertices), 2)) if shape.uv is None else shape.uv
            vertices = np.concatenate([shape.vertices, shape.vertex_normals, uv], axis=1)
            faces = along_curve(shape)
            attributes = {"position": 3, "normal": 3, "uv": 2}
            if shape.tangents is not None:  # each corner of a face has its own: none are shared
                vertices = np.concatenate([vertices[shape.faces], shape.tangents], axis=2)
                faces = np.arange(faces.size)
                attributes["tangent"] = 3
        else:
            assert isinstance(shape, Sphere)
            vertices, faces = BOX, BOX_FACES
            attributes = {"position": 3}
            self.sphere = (*shape.center, shape.radius)
        self._arrays = VertexArrays(gl, faces)
        self._arrays.add(vertices, attributes)

    def draw(self, program: moderngl.Program) -> None:
        """Draw with a program, whose uniforms are set."""
        self._arrays.draw(program)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        self._arrays.release()


class RadiantGeometry:
    """A mesh on the GPU whose vertices have radiance, which is renewed from frame to frame."""

    def __init__(self, gl: moderngl.Context, mesh: Mesh) -> None:
        uv = np.zeros((len(mesh.vertices), 2)) if mesh.uv is None else mesh.uv
        self._arrays = VertexArrays(gl, along_curve(mesh))
        self._arrays.add(np.concatenate([mesh.vertices, uv], axis=1), {"position": 3, "uv": 2})
        self._radiance = self._arrays.add(np.zeros_like(mesh.vertices), {"radiance": 3})
        self._taken: VertexRadiance | None = None

    def take(self, radiance: VertexRadiance) -> None:
        """Put radiance (V, 3) where that of the last frame was, if it is another."""
        if radiance is self._taken:
            return
        self._radiance.orphan()  # the driver need not wait until the last frame is drawn
        self._radiance.write(np.ascontiguousarray(radiance.values))
        self._taken = radiance

    def draw(self, program: moderngl.Program) -> None:
        """Draw with a program, whose uniforms are set."""
        self._arrays.draw(program)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        self._arrays.release()


class VertexArrays:
    """Attributes of vertices on the GPU, and the faces between them, for any program."""

    def __init__(self, gl: moderngl.Context, faces: npt.NDArray[np.integer]) -> None:
        self._gl = gl
        self._faces = gl.buffer(faces.astype(np.int32).tobytes())
        self._buffers: list[tuple[moderngl.Buffer, dict[str, int]]] = []
        self._made: dict[int, moderngl.VertexArray] = {}

    def add(self, values: FloatArray, attributes: dict[str, int]) -> moderngl.Buffer:
        """Upload what vertices have, as float32: attributes by name, with how many numbers each has."""
        buffer = self._gl.buffer(values.astype(np.float32).tobytes())
        self._buffers.append((buffer, attributes))
        return buffer

    def draw(self, program: moderngl.Program) -> None:
        """Draw with a program, whose uniforms are set."""
        if program.glo not in self._made:
            # A program may have no use for some of them.
            content = []
            for buffer, attributes in self._buffers:
                used = [name for name in attributes if name in program]
                layout = " ".join(f"{n}f" if name in used else f"{4 * n}x" for name, n in attributes.items())
                content.append((buffer, layout, *used))
            self._made[program.glo] = self._gl.vertex_array(program, content, self._faces)
        self._made[program.glo].render()

    def release(self) -> None:
        """Free what it holds on the GPU."""
        for array in self._made.values():
            array.release()
        for buffer in (self._faces, *(buffer for buffer, _ in self._buffers)):
            buffer.release()


def along_curve(mesh: Mesh) -> IntArray:
    """Return the faces in the order of a curve that fills space (Morton's), by their corners' mean.

    Neighbours follow each other, and a vertex that they share is still at hand: OpenGL transforms it once,
    where in the order of a file it may do so for every face.
    """
    center, radius = mesh.ball
    means = mesh.vertices[mesh.faces].mean(axis=1)
    cells = np.clip(512.0 + 511.0 * (means - center) / (radius or 1.0), 0.0, 1023.0).astype(np.int64)
    place = np.zeros(len(cells), np.int64)
    for bit in range(10):
        for axis in range(3):
            place |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return mesh.faces[np.argsort(place, kind="stable")]


def bounds(shape: Shape) -> tuple[FloatArray, float]:
    """Return the center (3,) and the radius of a ball that holds a mesh or a sphere.

    Raises
    ------
    TypeError
        If the shape is neither.
    """
    if isinstance(shape, Sphere):
        return np.asarray(shape.center, np.float64), shape.radius
    if not isinstance(shape, Mesh):
        raise TypeError(f"shape must be a Mesh or a Sphere to be drawn, got {type(shape).__name__}")
    return shape.ball


def clip_from_world(
    camera: Camera, aspect: float, shift: tuple[float, float], shapes: Sequence[Shape]
) -> FloatArray:
    """Return the matrix (4, 4) that takes world positions to OpenGL's clip space.

    Parameters
    ----------
    camera : Camera
    aspect : float
        Width of the picture by its height.
    shift : (x, y)
        By how much points move on the screen, whose sides are 2: for samples beside the middle of a pixel.
    shapes : sequence of shapes
        Lie between the near and the far plane, as far as they are in front of the eye.
    """
    axes, position = camera.axes, np.asarray(camera.position, np.float64)
    balls = [bounds(shape) for shape in shapes]
    middles = [float((c - position) @ axes[2]) for c, _ in balls] or [1.0]
    radii = [r for _, r in balls] or [0.5]
    far = max(1.01 * float(np.add(middles, radii).max()), 1e-6)
    near = float(np.subtract(middles, radii).min()) - 0.01 * abs(far)
    world = np.eye(4)
    world[:3, :3], world[:3, 3] = axes, -axes @ position  # right, up, forward

    clip = np.zeros((4, 4))
    if camera.height is not None:
        near = max(near, 0.0)  # rays begin in the plane of the eye
        clip[0, 0], clip[1, 1] = 2.0 / (camera.height * aspect), 2.0 / camera.height
        clip[2, 2], clip[2, 3] = 2.0 / (far - near), -(far + near) / (far - near)
        clip[3, 3] = 1.0
    else:
        near = max(near, 1e-3 * far)
        reach = np.tan(np.radians(camera.fov) / 2.0)
        clip[0, 0], clip[1, 1] = 1.0 / (reach * aspect), 1.0 / reach
        clip[2, 2], clip[2, 3] = (far + near) / (far - near), -2.0 * far * near / (far - near)
        clip[3, 2] = 1.0
    clip[0] += shift[0] * clip[3]
    clip[1] += shift[1] * clip[3]
    return clip @ world
