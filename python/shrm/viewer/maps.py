"""Maps on the GPU: one dynamic cube map for a distant viewer, all maps of a lobe for a near one.

Lobes of fixed shape need neither: a dual-paraboloid map serves all viewers.

References
----------
[RH02] R. Ramamoorthi, P. Hanrahan. Frequency Space Environment Map Rendering. ACM TOG 21(3), 2002.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import moderngl
import numpy as np

from shrm.brdf.lobe import Center
from shrm.icosahedral import IcosahedralMaps, weights
from shrm.reflection_map import Part
from shrm.render.camera import FloatArray
from shrm.rings import Float32Array
from shrm.viewer.paraboloid import ParaboloidMap, RadialCenter
from shrm.viewer.programs import Maps

CENTERS: dict[Center, int] = {"reflection": 0, "normal": 1, "tangent": 2, "lobe": 3}


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


class Lobe(ABC):
    """The maps of one lobe, as textures.

    Attributes
    ----------
    near, distant : Maps
        The programs that draw it for a near and for a distant viewer.
    gamma : moderngl.Texture
        The angle between C and N over theta_v, one row.
    uniforms : dict
        What the programs are told of it.
    """

    near: Maps
    distant: Maps

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self.gamma = self._gamma(np.zeros(2))
        self.uniforms: dict[str, Any] = {}

    def _gamma(self, table: FloatArray) -> moderngl.Texture:
        return self._gl.texture((len(table), 1), 1, table.astype(np.float32).tobytes(), dtype="f4")

    @abstractmethod
    def dynamic(self, view: FloatArray) -> moderngl.TextureCube | moderngl.TextureArray:
        """Return the map for a distant viewer, view (1, 3) unit."""

    @abstractmethod
    def layered(self) -> moderngl.TextureArray:
        """Return all maps, for a near viewer."""

    def release(self) -> None:
        """Free what it holds on the GPU."""
        self.gamma.release()


class CubeLobe(Lobe):
    """The cube maps of one lobe, made when they are first drawn with."""

    distant = "dynamic"

    def __init__(self, gl: moderngl.Context, size: int) -> None:
        """`size` is the edge of the faces that lat-long maps are made anew for."""
        super().__init__(gl)
        self._size = size
        self._dynamic: moderngl.TextureCube | None = None
        self._layered: moderngl.TextureArray | None = None
        self._written = False  # whether `_layered` holds the maps
        self._pixels: Float32Array = np.empty((6, 0, 0, 3), np.float32)

    def _take(self, part: Part, **uniforms: Any) -> None:
        """Take the centre of other maps, which have the shape of those before them."""
        self.gamma.release()
        self.gamma = self._gamma(part.gamma if len(part.gamma) else np.zeros(2))
        self.uniforms = {"center": CENTERS[part.center], **uniforms}
        self._written = False
        if self._pixels.shape != part.shape:
            self._pixels = np.empty(part.shape, np.float32)

    def dynamic(self, view: FloatArray) -> moderngl.TextureCube:
        """Return the map for a distant viewer, an ordinary cube map [RH02 eq. 12]."""
        N = self._pixels.shape[1]
        if self._dynamic is None:
            self._dynamic = self._gl.texture_cube((N, N), 3, dtype="f4")
            self._dynamic.filter = (moderngl.LINEAR, moderngl.LINEAR)
        self._sum(view, self._pixels)
        for face in range(6):
            self._dynamic.write(face, self._pixels[face])
        return self._dynamic

    def layered(self) -> moderngl.TextureArray:
        """Return all maps, with their borders: layer face * maps + z."""
        if not self._written:
            rings = self._rings()
            maps, side = rings.shape[1], rings.shape[3]
            faces = rings.reshape(6, side, maps, 3, side).transpose(0, 2, 1, 4, 3)
            if self._layered is None:
                most = self._gl.info["GL_MAX_ARRAY_TEXTURE_LAYERS"]
                if 6 * maps > most:
                    raise ValueError(
                        f"{maps} maps for a near viewer are {6 * maps} layers, and this OpenGL has {most} at "
                        "most: take a smaller P, or a distant viewer"
                    )
                self._layered = self._gl.texture_array((side, side, 6 * maps), 3, dtype="f4")
                self._layered.filter = (moderngl.LINEAR, moderngl.LINEAR)
            self._layered.write(np.ascontiguousarray(faces, np.float32))
            self._written = True
        assert self._layered is not None
        return self._layered

    @abstractmethod
    def _sum(self, view: FloatArray, pixels: Float32Array) -> None:
        """Put the map for a view into pixels (6, N, N, 3)."""

    @abstractmethod
    def _rings(self) -> Float32Array:
        """All maps, as `shrm.rings` has them: (H, maps, 3, side)."""

    def release(self) -> None:
        """Free what it holds on the GPU."""
        super().release()
        for texture in (self._dynamic, self._layered):
            if texture is not None:
                texture.release()


class LobeMaps(CubeLobe):
    """The coefficient maps of a SHRM's lobe."""

    near = "factored"

    def __init__(self, gl: moderngl.Context, part: Part, size: int) -> None:
        super().__init__(gl, size)
        self.renew(part)

    def renew(self, part: Part) -> None:
        """Take other maps of the same shape."""
        self._part = as_cube(part, self._size)
        self._take(self._part, P=self._part.P, zonal=self._part.zonal)

    def _sum(self, view: FloatArray, pixels: Float32Array) -> None:
        self._part.sum_for_view(view, pixels)

    def _rings(self) -> Float32Array:
        return np.asarray(self._part.rings, np.float32)


class IcosahedralLobe(CubeLobe):
    """Cabral's twelve maps of a lobe, number `index` of the material's."""

    near = "icosahedral"

    def __init__(self, gl: moderngl.Context, index: int, size: int, material: IcosahedralMaps) -> None:
        super().__init__(gl, size)
        self._index = index
        self.renew(material)

    def renew(self, material: IcosahedralMaps) -> None:
        """Take other maps of the same shape."""
        self._parts = [as_cube(rm.parts[self._index], self._size) for rm in material.maps]
        self._clamp = material.clamp
        self._take(self._parts[0])
        self._of_views: Float32Array | None = None

    def _sum(self, view: FloatArray, pixels: Float32Array) -> None:
        if self._of_views is None:
            self._of_views = np.empty((len(self._parts), *pixels.shape), np.float32)
            for part, of_view in zip(self._parts, self._of_views, strict=True):
                part.sum_for_view(view, of_view)  # P = 0: the same for all views
            if self._clamp:
                np.maximum(self._of_views, 0.0, out=self._of_views)
        pixels[:] = 0.0
        (shares,) = weights(view)
        for k in np.flatnonzero(shares):
            pixels += np.float32(shares[k]) * self._of_views[k]

    def _rings(self) -> Float32Array:
        constant = np.float32(1.0 / np.sqrt(4.0 * np.pi))  # Y_00
        return constant * np.concatenate([part.rings for part in self._parts], axis=1)


class ParaboloidLobe(Lobe):
    """A lobe's dual-paraboloid map, for all viewers.

    Parameters
    ----------
    gl : moderngl.Context
    center : {"reflection", "normal"}
    border : int
        Texels beyond the disc.
    texture : moderngl.TextureArray
        Two layers, and the caller's to release.
    """

    near = distant = "paraboloid"

    def __init__(
        self, gl: moderngl.Context, center: RadialCenter, border: int, texture: moderngl.TextureArray
    ) -> None:
        super().__init__(gl)
        self._texture = texture
        self.uniforms = {"center": CENTERS[center], "border": border}

    def dynamic(self, view: FloatArray) -> moderngl.TextureArray:
        """Return the map, which does not depend on the view."""
        return self._texture

    def layered(self) -> moderngl.TextureArray:
        """Return the map."""
        return self._texture


class UploadedParaboloidLobe(ParaboloidLobe):
    """A lobe's dual-paraboloid map from an array."""

    def __init__(self, gl: moderngl.Context, part: ParaboloidMap) -> None:
        side = part.pixels.shape[1]
        texture = gl.texture_array((side, side, 2), 3, part.pixels, dtype="f4")
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        super().__init__(gl, part.center, part.border, texture)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        super().release()
        self._texture.release()
