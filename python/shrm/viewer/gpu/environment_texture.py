"""Lat-long environments as textures."""

from __future__ import annotations

import moderngl
import numpy as np

from shrm.arrays import Float32Array
from shrm.environment import Environment


def largest_texture(gl: moderngl.Context) -> int:
    """Return how many texels a texture may have to a side."""
    return int(gl.info["GL_MAX_TEXTURE_SIZE"])


class EnvironmentTexture:
    """A lat-long picture on the GPU, and the mean radiance of its first and last row.

    Where it is larger than a texture can be, it is averaged down to fit.

    Attributes
    ----------
    texture : moderngl.Texture
        Its first row is the picture's.
    poles : list of (R, G, B)
    """

    def __init__(self, gl: moderngl.Context, pixels: Float32Array) -> None:
        self._largest = largest_texture(gl)
        pixels = self._fitting(pixels)
        self.texture = gl.texture(
            pixels.shape[1::-1], 3, np.ascontiguousarray(pixels, np.float32), dtype="f4"
        )
        self.texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.texture.repeat_x, self.texture.repeat_y = True, False
        self.poles = [tuple(map(float, pixels[row].mean(axis=0))) for row in (0, -1)]

    def _fitting(self, pixels: Float32Array) -> Float32Array:
        H, W = (min(side, self._largest) for side in pixels.shape[:2])
        return pixels if pixels.shape[:2] == (H, W) else Environment(pixels).resized((H, W)).pixels

    def renew(self, pixels: Float32Array) -> bool:
        """Take another picture, and say whether it could: it must have the size of the texture."""
        pixels = self._fitting(pixels)
        if pixels.shape[1::-1] != self.texture.size:
            return False
        self.texture.write(np.ascontiguousarray(pixels, np.float32))
        self.poles = [tuple(map(float, pixels[row].mean(axis=0))) for row in (0, -1)]
        return True

    def release(self) -> None:
        """Free it."""
        self.texture.release()
