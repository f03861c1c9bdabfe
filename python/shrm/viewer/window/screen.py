"""The picture between renderer and window: linear radiance of its size, what is shown of it, tone mapping."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from shrm.arrays import Float32Array
from shrm.render.picture import Picture
from shrm.viewer.gpu.programs import screen_program, set_uniforms

NEAREST = (moderngl.NEAREST, moderngl.NEAREST)

AMPLIFIED = 8.0
"""Factor by which differences are shown brighter: errors of some percent are seen then."""

# Places of the samples of a pixel, in pixels from its middle; the middle comes first.
PLACES = ((0.0, 0.0), *((x / 3, y / 3) for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y))


class Screen:
    """Float pictures of one size on the GPU, and the way to the window.

    A picture that stays gets further samples in every pixel, from frame to frame.

    Attributes
    ----------
    drawn : moderngl.Framebuffer
        What `Renderer.draw` draws a sample into.
    samples : int
        How many of `PLACES` the picture has.
    """

    def __init__(self, gl: moderngl.Context, shape: tuple[int, int]) -> None:
        self._gl = gl
        self._mean_of = _Pass(gl, "mean.frag")
        self._combine = _Pass(gl, "combine.frag")
        self._display = _Pass(gl, "display.frag")
        self._integrated: moderngl.Texture | None = None
        self.samples = 0
        self._make(shape)

    def _make(self, shape: tuple[int, int]) -> None:
        self.drawn = self._target(shape, self._gl.depth_renderbuffer(shape[::-1]))
        self._mean, self._next_mean, self._combined = (self._target(shape) for _ in range(3))
        self._shown = self._mean

    def _target(
        self, shape: tuple[int, int], depth: moderngl.Renderbuffer | None = None
    ) -> moderngl.Framebuffer:
        picture = self._gl.texture(shape[::-1], 4, dtype="f4")
        picture.filter = NEAREST
        return self._gl.framebuffer([picture], depth)

    def resize(self, shape: tuple[int, int]) -> None:
        """Take another shape (H, W); the picture is empty then."""
        if shape != self.shape:
            self._free()
            self._make(shape)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, (H, W)."""
        return self.drawn.height, self.drawn.width

    @property
    def shift(self) -> tuple[float, float]:
        """Shift of the picture of the next sample, for `Renderer.draw`."""
        x, y = PLACES[self.samples]
        return 2.0 * x / self.drawn.width, 2.0 * y / self.drawn.height

    def add_sample(self) -> None:
        """Take what was drawn as a further sample of every pixel."""
        self.samples += 1
        self._mean_of.draw(self._next_mean, drawn=self.drawn, before=self._mean, weight=1.0 / self.samples)
        self._mean, self._next_mean = self._next_mean, self._mean

    @property
    def complete(self) -> bool:
        """Whether every pixel has all its samples."""
        return self.samples == len(PLACES)

    def keep_integrated(self, picture: Picture) -> None:
        """Put a picture by integration, of any size, on the GPU in place of the last one."""
        pixels = np.concatenate([picture.radiance, picture.coverage[..., None]], axis=2)[::-1]
        H, W = pixels.shape[:2]
        content = np.ascontiguousarray(pixels, np.float32)
        if self._integrated is not None:
            self._integrated.release()
        self._integrated = self._gl.texture((W, H), 4, content, dtype="f4")
        if self.shape == (H, W):
            self._integrated.filter = NEAREST
        self._integrated.repeat_x = self._integrated.repeat_y = False

    def show_drawn(self) -> None:
        """Show what was drawn."""
        self._shown = self._mean

    def show_integrated(self, difference: bool) -> None:
        """Show the picture by integration, or its difference from what was drawn."""
        assert self._integrated is not None
        self._combine.draw(
            self._combined,
            drawn=self._mean,
            integrated=self._integrated,
            difference=difference,
            amplified=AMPLIFIED,
        )
        self._shown = self._combined

    def display(self, window: moderngl.Framebuffer, left: int, exposure: float) -> None:
        """Tone-map what is shown into the window, `left` pixels from its left side."""
        gain = float(np.float32(2.0 ** np.clip(exposure, -100.0, 100.0)))
        window.viewport = (left, 0, *self.shape[::-1])
        self._display.draw(window, drawn=self._shown, gain=gain)

    def picture(self) -> Picture:
        """Read back what is shown, linear."""
        return _read(self._shown)

    def drawn_picture(self) -> Picture:
        """Read back what was drawn, linear."""
        return _read(self._mean)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        self._free()
        for held in (self._mean_of, self._combine, self._display, self._integrated):
            if held is not None:
                held.release()

    def _free(self) -> None:
        for target in (self.drawn, self._mean, self._next_mean, self._combined):
            for held in (*target.color_attachments, target.depth_attachment, target):
                if held is not None:
                    held.release()


class _Pass:
    """A program that fills a picture."""

    def __init__(self, gl: moderngl.Context, name: str) -> None:
        self._program = screen_program(gl, name)
        self._array = gl.vertex_array(self._program, [])

    def draw(self, target: moderngl.Framebuffer, **values: Any) -> None:
        """Fill a target; of the values, pictures and textures become samplers."""
        target.use()
        textures = 0
        for name, value in values.items():
            if isinstance(value, moderngl.Framebuffer):
                value = value.color_attachments[0]
            if isinstance(value, moderngl.Texture):
                value.use(textures)
                value, textures = textures, textures + 1
            set_uniforms(self._program, **{name: value})
        self._array.render(moderngl.TRIANGLES, vertices=3)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        self._array.release()
        self._program.release()


def _read(target: moderngl.Framebuffer) -> Picture:
    pixels: Float32Array = np.frombuffer(target.read(components=4, dtype="f4"), np.float32)
    pixels = pixels.reshape(target.height, target.width, 4)[::-1]  # OpenGL's rows run upwards
    return Picture(np.ascontiguousarray(pixels[..., :3]), np.ascontiguousarray(pixels[..., 3]))
