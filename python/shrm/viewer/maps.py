"""Reflection maps on the GPU: one dynamic cube map for a distant viewer, all coefficient maps for a near one.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
"""

from __future__ import annotations

import moderngl
import numpy as np

from shrm.reflection_map import Part
from shrm.render.camera import FloatArray
from shrm.rings import BORDER, Float32Array

CENTERS = {"reflection": 0, "normal": 1, "tangent": 2, "lobe": 3}


def as_cube(part: Part, size: int) -> Part:
    """Return a lobe's maps on a cube: as they are, or made again from their coefficients.

    Raises
    ------
    ValueError
        If they are lat-long and have no coefficients.
    """
    if part.layout == "cube":
        return part
    if part.F < 0:
        raise ValueError("lat-long maps without coefficients cannot be drawn by the GPU: use cube maps")
    return part.resized(size, "cube")


class LobeMaps:
    """The maps of one lobe, as textures that are made when they are first drawn with.

    Parameters
    ----------
    gl : moderngl.Context
    part : Part
    size : int
        Edge of the faces that lat-long maps are made anew for.

    Attributes
    ----------
    part : Part
        The maps on a cube.
    """

    def __init__(self, gl: moderngl.Context, part: Part, size: int) -> None:
        self._gl, self._size = gl, size
        self.part = as_cube(part, size)
        self.gamma = self._gamma()
        self._dynamic: moderngl.TextureCube | None = None
        self._factored: moderngl.TextureArray | None = None
        self._pixels = np.empty(self.part.shape, np.float32)
        self._written: Part | None = None  # what `_factored` holds

    def renew(self, part: Part) -> None:
        """Take other maps of the same shape."""
        self.part = as_cube(part, self._size)
        self.gamma.release()
        self.gamma = self._gamma()

    def _gamma(self) -> moderngl.Texture:
        """The angle between C and N over theta_v, a texture of one row."""
        table = self.part.gamma if len(self.part.gamma) else np.zeros(2)
        return self._gl.texture((len(table), 1), 1, table.astype(np.float32).tobytes(), dtype="f4")

    def dynamic(self, view: FloatArray) -> moderngl.TextureCube:
        """Return the map for a distant viewer, view (1, 3) unit, an ordinary cube map [RH02 eq. 12]."""
        N = self.part.size
        if self._dynamic is None:
            self._dynamic = self._gl.texture_cube((N, N), 3, dtype="f4")
            self._dynamic.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self.part.sum_for_view(view, self._pixels)
        for face in range(6):
            self._dynamic.write(face, self._pixels[face])
        return self._dynamic

    def factored(self) -> moderngl.TextureArray:
        """Return all maps, with their borders, for a near viewer: layer face * maps + z."""
        if self._written is not self.part:
            layers = self._layers()
            if self._factored is None:
                self._factored = self._gl.texture_array((*layers.shape[2:0:-1], len(layers)), 3, dtype="f4")
                self._factored.filter = (moderngl.LINEAR, moderngl.LINEAR)
            self._factored.write(layers)
            self._written = self.part
        assert self._factored is not None
        return self._factored

    def _layers(self) -> Float32Array:
        """(6 maps, side, side, 3)."""
        side, maps = self.part.size + 2 * BORDER, self.part.rings.shape[1]
        faces = self.part.rings.reshape(6, side, maps, 3, side)
        layers = faces.transpose(0, 2, 1, 4, 3).reshape(6 * maps, side, side, 3)
        return np.ascontiguousarray(layers, np.float32)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        for texture in (self.gamma, self._dynamic, self._factored):
            if texture is not None:
                texture.release()
