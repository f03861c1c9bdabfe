"""The picture between renderer and window: linear radiance of its size, what is shown of it, tone mapping."""

from __future__ import annotations

import moderngl
import numpy as np

from shrm.render.picture import FloatPixels, Picture
from shrm.viewer.programs import screen_program, set_uniforms

NEAREST = (moderngl.NEAREST, moderngl.NEAREST)

AMPLIFIED = 8.0
"""By how much differences are."""


class Screen:
    """Float pictures of one size on the GPU, and the way to the window.

    Attributes
    ----------
    drawn : moderngl.Framebuffer
        What `Renderer.draw` draws into.
    """

    def __init__(self, gl: moderngl.Context, width: int, height: int) -> None:
        self._gl = gl
        self._combine = screen_program(gl, "combine.frag")
        self._display = screen_program(gl, "display.frag")
        self._combined_pass = gl.vertex_array(self._combine, [])
        self._display_pass = gl.vertex_array(self._display, [])
        self._integrated: moderngl.Texture | None = None
        self.drawn, self._combined = self._targets(width, height)
        self._shown = self.drawn

    def _targets(self, width: int, height: int) -> tuple[moderngl.Framebuffer, moderngl.Framebuffer]:
        gl, size = self._gl, (width, height)
        pictures = [gl.texture(size, 4, dtype="f4") for _ in range(2)]
        for picture in pictures:
            picture.filter = NEAREST
        return gl.framebuffer([pictures[0]], gl.depth_renderbuffer(size)), gl.framebuffer([pictures[1]])

    def resize(self, width: int, height: int) -> None:
        """Take another size."""
        if (width, height) == self.size:
            return
        _release(self.drawn)
        _release(self._combined)
        self.drawn, self._combined = self._targets(width, height)
        self._shown = self.drawn

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.drawn.width, self.drawn.height

    def keep_integrated(self, picture: Picture) -> None:
        """Put a picture by integration, of any size, on the GPU in place of the last one."""
        pixels = np.concatenate([picture.radiance, picture.coverage[..., None]], axis=2)[::-1]
        H, W = pixels.shape[:2]
        content = np.ascontiguousarray(pixels, np.float32)
        if self._integrated is not None:
            self._integrated.release()
        self._integrated = self._gl.texture((W, H), 4, content, dtype="f4")
        if self.size == (W, H):
            self._integrated.filter = NEAREST
        self._integrated.repeat_x = self._integrated.repeat_y = False

    def show_drawn(self) -> None:
        """Show what was drawn."""
        self._shown = self.drawn

    def show_integrated(self, difference: bool) -> None:
        """Show the picture by integration, or its difference from what was drawn."""
        assert self._integrated is not None
        self._combined.use()
        _texture(self.drawn).use(0)
        self._integrated.use(1)
        set_uniforms(self._combine, drawn=0, integrated=1, difference=difference, amplified=AMPLIFIED)
        self._combined_pass.render(moderngl.TRIANGLES, vertices=3)
        self._shown = self._combined

    def display(self, window: moderngl.Framebuffer, left: int, exposure: float) -> None:
        """Tone-map what is shown into the window, `left` pixels from its left side."""
        window.use()
        window.viewport = (left, 0, *self.size)
        _texture(self._shown).use(0)
        gain = float(np.float32(2.0 ** np.clip(exposure, -100.0, 100.0)))
        set_uniforms(self._display, drawn=0, gain=gain)
        self._display_pass.render(moderngl.TRIANGLES, vertices=3)

    def picture(self) -> Picture:
        """Read back what is shown, linear."""
        return _read(self._shown)

    def drawn_picture(self) -> Picture:
        """Read back what was drawn, linear."""
        return _read(self.drawn)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        _release(self.drawn)
        _release(self._combined)
        for held in (self._combined_pass, self._display_pass, self._combine, self._display):
            held.release()
        if self._integrated is not None:
            self._integrated.release()


def _read(target: moderngl.Framebuffer) -> Picture:
    pixels: FloatPixels = np.frombuffer(target.read(components=4, dtype="f4"), np.float32)
    pixels = pixels.reshape(target.height, target.width, 4)[::-1]  # OpenGL's rows run upwards
    return Picture(np.ascontiguousarray(pixels[..., :3]), np.ascontiguousarray(pixels[..., 3]))


def _texture(target: moderngl.Framebuffer) -> moderngl.Texture:
    picture = target.color_attachments[0]
    assert isinstance(picture, moderngl.Texture)
    return picture


def _release(target: moderngl.Framebuffer) -> None:
    for held in (*target.color_attachments, target.depth_attachment, target):
        if held is not None:
            held.release()
