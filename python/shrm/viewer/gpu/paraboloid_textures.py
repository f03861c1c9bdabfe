"""Dual-paraboloid maps as textures of two layers, and the passes that draw into both.

Sources: [HS98].
"""

from __future__ import annotations

import math
from typing import Any, Literal

import moderngl
import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.viewer.gpu.context import ContextError, leave_framebuffers
from shrm.viewer.gpu.environment_texture import EnvironmentTexture
from shrm.viewer.gpu.programs import layers_program, screen_program, set_uniforms

Texels = Literal["f4", "f2"]

LARGEST: dict[Texels, float] = {"f4": float(np.finfo(np.float32).max), "f2": float(np.finfo(np.float16).max)}
"""The largest finite number in a texel."""

MOST_SAMPLES = 8
"""Most samples of an environment to a side of a paraboloid's texel; finer ones come through their mip-map."""

MOST_COLUMNS = 32
"""Most columns of a lat-long picture that are averaged along a row for one sample beside a pole."""


class Faces:
    """Two layers of floats that can be drawn into: not clamped to [0, 1], as they were in 2000.

    Attributes
    ----------
    texture : moderngl.TextureArray
    target : moderngl.Framebuffer
    side : int
    texels : {"f4", "f2"}

    Raises
    ------
    ContextError
        If this OpenGL cannot draw into textures of floats.
    """

    def __init__(self, gl: moderngl.Context, side: int, texels: Texels) -> None:
        self._gl, self.side, self.texels = gl, side, texels
        self.texture = gl.texture_array((side, side, 2), 4, dtype=texels)
        self.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.texture.repeat_x = self.texture.repeat_y = False
        try:
            self.target = gl.framebuffer([self.texture])
        except moderngl.Error as fault:
            self.texture.release()
            bits = {"f4": 32, "f2": 16}[texels]
            raise ContextError(
                f"this OpenGL cannot draw into textures of {bits}-bit floats, which hardware prefiltering "
                f"needs: {' '.join(str(fault).split())}"
            ) from None

    def read(self) -> Float32Array:
        """Read the texels back: (2, side, side, 3)."""
        kind = np.float32 if self.texels == "f4" else np.float16
        texels = np.frombuffer(self.texture.read(), kind).reshape(2, self.side, self.side, 4)
        return np.ascontiguousarray(texels[..., :3], np.float32)

    def release(self) -> None:
        """Free them."""
        leave_framebuffers(self._gl)
        self.target.release()
        self.texture.release()


class LayersPass:
    """A program whose fragments fill both layers of a target."""

    def __init__(self, gl: moderngl.Context, *parts: str) -> None:
        self._gl = gl
        self._program = layers_program(gl, *parts)
        self._array = gl.vertex_array(self._program, [])

    def draw(self, faces: Faces, radius: float, **values: Any) -> None:
        """Fill a target whose disc has that radius in texels; of the values, textures become samplers."""
        faces.target.use()
        self._gl.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        samplers = 0
        for name, value in values.items():
            if isinstance(value, moderngl.Texture | moderngl.TextureArray | moderngl.TextureCube):
                value.use(samplers)
                value, samplers = samplers, samplers + 1
            set_uniforms(self._program, **{name: value})
        set_uniforms(self._program, radius=radius, largest=LARGEST[faces.texels])
        self._array.render(moderngl.TRIANGLES, vertices=3, instances=2)

    def release(self) -> None:
        """Free it."""
        self._array.release()
        self._program.release()


class _WeightedPicture:
    """A lat-long picture times its texels' solid angles, with its mip-map."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._program = screen_program(gl, "latlong_weighted.frag")
        self._array = gl.vertex_array(self._program, [])
        self._target: moderngl.Framebuffer | None = None
        self.texture: moderngl.Texture | None = None

    def draw(self, picture: moderngl.Texture) -> moderngl.Texture:
        """Make it of a texture."""
        gl = self._gl
        if self.texture is None or self._target is None or self.texture.size != picture.size:
            self._free()
            self.texture = gl.texture(picture.size, 4, dtype="f4")
            self.texture.repeat_x, self.texture.repeat_y = True, False
            self._target = gl.framebuffer([self.texture])
        self._target.use()
        gl.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        picture.use(0)
        set_uniforms(self._program, picture=0)
        self._array.render(moderngl.TRIANGLES, vertices=3)
        self.texture.build_mipmaps()
        return self.texture

    def release(self) -> None:
        """Free it."""
        self._free()
        self._array.release()
        self._program.release()

    def _free(self) -> None:
        if self.texture is not None and self._target is not None:
            leave_framebuffers(self._gl)
            self._target.release()
            self.texture.release()


class ParaboloidEnvironment:
    """An environment as a dual-paraboloid map with its mip-map, remade as often as it changes.

    Attributes
    ----------
    faces : Faces
    """

    def __init__(self, gl: moderngl.Context, size: int, border: int, texels: Texels) -> None:
        self._gl, self._size = gl, size
        self.faces = Faces(gl, size + 2 * border, texels)
        common = ("paraboloid.glsl", "layer.glsl")
        self._from_latlong = LayersPass(gl, *common, "latlong_light.glsl", "paraboloid_source.frag")
        self._from_cube = LayersPass(gl, *common, "cube_light.glsl", "paraboloid_source.frag")
        self._weighted = _WeightedPicture(gl)
        self._uploaded: EnvironmentTexture | None = None

    def upload(self, pixels: Float32Array, rotation: FloatArray) -> None:
        """Take a lat-long picture (H, W, 3), turned."""
        if self._uploaded is None or not self._uploaded.renew(pixels):
            if self._uploaded is not None:
                self._uploaded.release()
            self._uploaded = EnvironmentTexture(self._gl, pixels)
        self.take(self._uploaded.texture, rotation)

    def take(self, environment: moderngl.Texture | moderngl.TextureCube, rotation: FloatArray) -> None:
        """Take what is in a texture, a lat-long picture or a cube map, turned: L'(w) = L(R^T w)."""
        # The widest texels, in the middles of faces, take samples no farther apart than the environment's.
        if isinstance(environment, moderngl.TextureCube):
            step, into_paraboloid = 2.0 / environment.size[0], self._from_cube
        else:
            step, into_paraboloid = math.pi / environment.height, self._from_latlong
            environment = self._weighted.draw(environment)
        widest = 4.0 / self._size
        samples = min(math.ceil(widest / step), MOST_SAMPLES)
        into_paraboloid.draw(
            self.faces,
            0.5 * self._size,
            environment=environment,
            side=float(self.faces.side),
            samples=samples,
            light_from_world=rotation.T,
            most_columns=MOST_COLUMNS,
        )
        self.faces.texture.build_mipmaps()

    def release(self) -> None:
        """Free what it holds."""
        for held in (self.faces, self._from_latlong, self._from_cube, self._weighted, self._uploaded):
            if held is not None:
                held.release()
