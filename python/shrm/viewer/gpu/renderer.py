"""The renderer on the GPU: what `shrm.render.render` draws, as fast as OpenGL can."""

from __future__ import annotations

from functools import partial
from typing import Any

import moderngl
import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.frequency.reflection_map import ReflectionMap, require_no_residual
from shrm.frequency.rings import BORDER
from shrm.prefiltered import Prefiltered, PrefilteredMap
from shrm.prefiltered.paraboloid import ParaboloidMaps
from shrm.render.mesh import Mesh
from shrm.render.picture import Background, Object, Picture
from shrm.render.vertex_radiance import VertexRadiance
from shrm.validation import picture_shape, whole_number
from shrm.viewer.gpu.context import Context, ContextError, leave_framebuffers, offscreen
from shrm.viewer.gpu.environment_texture import EnvironmentTexture, largest_texture
from shrm.viewer.gpu.geometry import Geometry, RadiantGeometry, clip_from_world
from shrm.viewer.gpu.hardware_prefilter import HardwarePrefilter
from shrm.viewer.gpu.maps import LayeredLobe, Lobe, LobeMaps, ParaboloidLobe, UploadedParaboloidLobe
from shrm.viewer.gpu.programs import (
    Maps,
    Surface,
    object_program,
    screen_program,
    set_uniforms,
    vertex_radiance_program,
)
from shrm.viewer.gpu.resources import Resources
from shrm.viewer.gpu.scene import Scene

Drawn = ReflectionMap | Prefiltered | ParaboloidMaps | HardwarePrefilter
"""Maps that materials are drawn with."""

SEAMLESS = 0x884F  # GL_TEXTURE_CUBE_MAP_SEAMLESS
LARGEST = 16384


class Renderer:
    """Draws scenes with OpenGL, without a window.

    What it holds on the GPU stays there until `release`, or to the end of a `with` statement.

    Parameters
    ----------
    shape : (H, W)
        Rows and columns of the pictures; at most 16384.
    samples : int
        samples x samples points to a pixel, averaged, at the places where `shrm.render.render` has them.
    map_size : int
        Edge of the cubes' faces that lat-long maps are made anew for.
    context : Context, optional
        Where to draw, and the caller's to release; by default one of its own without a display
        (`shrm.viewer.gpu.context.offscreen`).

    Attributes
    ----------
    shape : (H, W)
    samples, map_size : int
    context : Context

    Raises
    ------
    ContextError
        If there is no OpenGL, or the renderer was released.
    TypeError, ValueError
        If an argument is not as described.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        *,
        samples: int = 1,
        map_size: int = 64,
        context: Context | None = None,
    ) -> None:
        self.shape = H, W = picture_shape("shape", shape, most=LARGEST)
        self.samples = whole_number("samples", samples, 1, 64)
        self.map_size = whole_number("map_size", map_size, 1, 4096)
        self._owns_context = context is None
        self._released = False
        self.context = offscreen() if context is None else context
        self.context.activate()
        gl = self.gl = self.context.gl
        gl.enable_direct(SEAMLESS)
        self.resources = Resources()
        self._programs: dict[tuple[Surface, Maps], moderngl.Program] = {}
        self._background = screen_program(gl, "background.frag")
        self._vertex_radiance = vertex_radiance_program(gl)
        self._screen = gl.vertex_array(self._background, [])
        self._white = _texture(gl, np.ones((1, 1, 3), np.float32))
        self._target = gl.framebuffer([gl.texture((W, H), 4, dtype="f4")], gl.depth_renderbuffer((W, H)))

    def render(self, scene: Scene) -> Picture:
        """Draw a scene.

        Returns
        -------
        shrm.render.Picture
            Linear radiance and coverage, as `shrm.render.render` has them.

        Raises
        ------
        TypeError, ValueError
            If a material is no reflection map, a shape is neither a mesh nor a sphere, or a texture is larger
            than OpenGL's can be here. (A background is averaged down to fit.)
        """
        self._check()
        self.context.activate()
        n, (H, W) = self.samples, self.shape
        total = np.zeros((H, W, 4), np.float32)
        for row in range(n):
            for column in range(n):
                # The point of a pixel that is drawn is its middle: move the picture under it.
                shift = ((n - 1 - 2 * column) / (n * W), (2 * row + 1 - n) / (n * H))
                self.draw(scene, self._target, shift)
                total += self._read()
        self.resources.end_frame()
        total /= n * n
        radiance = np.ascontiguousarray(total[..., :3])
        if n > 1 and scene.background is None:
            radiance[total[..., 3] == 0] = 0
        return Picture(radiance, np.ascontiguousarray(total[..., 3]))

    def _read(self) -> Float32Array:
        pixels = np.frombuffer(self._target.read(components=4, dtype="f4"), np.float32)
        return pixels.reshape(*self.shape, 4)[::-1]  # OpenGL's rows run upwards

    def _check(self) -> None:
        if self._released:
            raise ContextError("the renderer was released: it cannot draw any more")

    def release(self) -> None:
        """Free what it holds on the GPU, and its context unless it was given one; it cannot draw then."""
        released, self._released = self._released or self.context.released, True
        if released:
            return
        self.context.activate()
        leave_framebuffers(self.gl)
        self.resources.release()
        for program in (*self._programs.values(), self._background, self._vertex_radiance):
            program.release()
        for held in (self._screen, self._white, *self._target.color_attachments, self._target):
            held.release()
        if self._owns_context:
            self.context.release()

    def __repr__(self) -> str:
        H, W = self.shape
        return f"<Renderer: {H} x {W} pixels, {self.samples} x {self.samples} samples, {self.context!r}>"

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    # ---- Drawing

    def draw(
        self, scene: Scene, target: moderngl.Framebuffer, shift: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        """Draw linear radiance into a framebuffer of floats with depth; alpha is the coverage.

        The renderer's context must be current (`Context.activate`).
        """
        self._check()
        gl = self.gl
        target.use()
        gl.disable(moderngl.BLEND)
        target.depth_mask = True
        target.clear(0.0, 0.0, 0.0, 0.0, depth=1.0)
        aspect = target.width / target.height
        if scene.background is not None:
            self._draw_background(scene, scene.background, aspect, shift)
        gl.enable(moderngl.DEPTH_TEST)
        shapes = [obj.shape for obj in scene.objects]
        eye = {
            "clip_from_world": clip_from_world(scene.camera, aspect, shift, shapes),
            "orthographic": scene.camera.height is not None,
            "eye": tuple(scene.camera.position),
            "forward": tuple(scene.camera.forward),
            "distant": scene.viewer == "distant",
        }
        view = -scene.camera.forward[None]
        for index, obj in enumerate(scene.objects):
            self._draw_object(index, obj, view, eye, target)
        gl.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)

    def _draw_background(
        self, scene: Scene, light: Background, aspect: float, shift: tuple[float, float]
    ) -> None:
        gl, camera = self.gl, scene.camera
        texture = self.resources.get(
            "background", light.pixels, lambda pixels: EnvironmentTexture(gl, pixels)
        )
        right, up, forward = camera.axes
        reach = 0.0 if camera.height is not None else float(np.tan(np.radians(camera.fov) / 2.0))
        texture.texture.use(0)
        set_uniforms(
            self._background,
            environment=0,
            poles=texture.poles,
            light_from_world=np.asarray(scene.rotation, np.float64).T,
            forward=tuple(forward),
            right=tuple(reach * aspect * right),
            up=tuple(reach * up),
            shift=shift,
        )
        gl.disable(moderngl.DEPTH_TEST)
        self._screen.render(moderngl.TRIANGLES, vertices=3)

    def _draw_object(
        self, index: int, obj: Object, view: FloatArray, eye: dict[str, Any], target: moderngl.Framebuffer
    ) -> None:
        gl, get = self.gl, self.resources.get
        material = obj.material
        if isinstance(material, VertexRadiance):
            self._draw_vertices(index, obj, material, eye)
            return
        if isinstance(material, PrefilteredMap):
            material = Prefiltered((material,))
        if not isinstance(material, Drawn):
            raise TypeError(
                "material must be a ReflectionMap, one of shrm.prefiltered, a VertexRadiance, a "
                f"HardwarePrefilter or ParaboloidMaps to be drawn by the GPU, got {type(material).__name__}"
            )
        if isinstance(material, ReflectionMap):
            require_no_residual(material, "the GPU")
        lobes = self._lobes(index, material)
        shape = get(("shape", index), obj.shape, lambda shape: Geometry(gl, shape))
        self._texture_of(index, obj).use(2)
        program = self._program(shape, lobes[0].distant if eye["distant"] else lobes[0].near)
        set_uniforms(
            program,
            **eye,
            sphere=shape.sphere,
            reflection_map=0,
            maps=0,
            gamma=1,
            picture=2,
            border=BORDER,
            clamped=isinstance(material, ReflectionMap) and material.clamp,
            axis=tuple(map(float, obj.axis)),
        )
        # A sphere's pixels are those of the far side of its box.
        (gl.disable if shape.sphere is None else gl.enable)(moderngl.CULL_FACE)
        gl.blend_func = moderngl.ONE, moderngl.ONE
        for k, lobe in enumerate(lobes):
            (lobe.dynamic(view) if eye["distant"] else lobe.layered()).use(0)
            lobe.bind()
            set_uniforms(program, **lobe.uniforms, first_lobe=k == 0)
            if k == 1:  # further lobes are added where the first one is seen
                gl.enable(moderngl.BLEND)
                gl.depth_func = "=="
                target.depth_mask = False
            shape.draw(program)
        gl.disable(moderngl.BLEND)
        gl.depth_func = "<"
        target.depth_mask = True

    def _draw_vertices(self, index: int, obj: Object, material: VertexRadiance, eye: dict[str, Any]) -> None:
        """Draw a mesh, both sides of it, with radiance that its vertices have."""
        gl, mesh = self.gl, obj.shape
        assert isinstance(mesh, Mesh)  # an object's radiance is at its vertices
        shape = self.resources.get(("radiant", index), mesh, lambda mesh: RadiantGeometry(gl, mesh))
        shape.take(material)
        self._texture_of(index, obj).use(2)
        set_uniforms(self._vertex_radiance, clip_from_world=eye["clip_from_world"], picture=2)
        gl.disable(moderngl.CULL_FACE)
        shape.draw(self._vertex_radiance)

    def _texture_of(self, index: int, obj: Object) -> moderngl.Texture:
        """An object's texture; a white one for those without."""
        if obj.texture is None:
            return self._white
        return self.resources.get(("texture", index), obj.texture, lambda pixels: _texture(self.gl, pixels))

    def _lobes(self, index: int, material: Drawn) -> list[Lobe]:
        """The maps of an object's lobes on the GPU."""
        if isinstance(material, ParaboloidMaps | HardwarePrefilter):
            return self._paraboloids(index, material)
        gl, size, get = self.gl, self.map_size, self.resources.get
        lobes: list[Lobe] = []
        key: tuple[object, ...]
        if isinstance(material, ReflectionMap):
            for k, part in enumerate(material.parts):
                key = ("lobe", index, k, part.rings.shape)
                lobes.append(get(key, part, lambda part: LobeMaps(gl, part, size), LobeMaps.renew))
        else:
            for k, lobe in enumerate(material.lobes):
                key = ("layered", index, k, len(lobe.layers), lobe.layers[0].rings.shape)
                lobes.append(get(key, lobe, lambda lobe: LayeredLobe(gl, lobe, size), LayeredLobe.renew))
        return lobes

    def _paraboloids(self, index: int, material: ParaboloidMaps | HardwarePrefilter) -> list[Lobe]:
        """The dual-paraboloid maps of an object's lobes, uploaded or as they were filtered on the GPU."""
        gl, get = self.gl, self.resources.get
        if isinstance(material, ParaboloidMaps):
            upload = partial(UploadedParaboloidLobe, gl)
            return [get(("paraboloid", index, k), map, upload) for k, map in enumerate(material.maps)]
        if material.context is not self.context:
            raise ValueError(
                "context must be the renderer's for a HardwarePrefilter to be drawn by it, got another: "
                "make it with context=renderer.context"
            )
        return [
            get(
                ("filtered", index, k, lobe.center),
                lobe.faces.texture,
                partial(ParaboloidLobe, gl, lobe.center, material.border, lobe.factor),
            )
            for k, lobe in enumerate(material.lobes)
        ]

    def _program(self, shape: Geometry, maps: Maps) -> moderngl.Program:
        key = shape.surface, maps
        if key not in self._programs:
            self._programs[key] = object_program(self.gl, *key)
        return self._programs[key]


def _texture(gl: moderngl.Context, pixels: Float32Array) -> moderngl.Texture:
    """A repeating picture, (u, v) = (0, 1) its upper left corner."""
    H, W = pixels.shape[:2]
    if max(H, W) > largest_texture(gl):
        raise ValueError(
            f"texture must have at most {largest_texture(gl)} texels to a side here, got {W} x {H}"
        )
    texture = gl.texture((W, H), 3, np.ascontiguousarray(pixels[::-1], np.float32), dtype="f4")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    return texture
