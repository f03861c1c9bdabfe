"""Maps on the GPU: one dynamic cube map for a distant viewer, all maps of a lobe for a near one.

Lobes of fixed shape need neither: a dual-paraboloid map serves all viewers.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import moderngl
import numpy as np

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf.lobe import Center
from shrm.frequency.part import CoefficientMaps, Part
from shrm.frequency.rings import Rings
from shrm.prefiltered import Cabral, Diffuse, KautzMcCool2D, Phong, PrefilteredMap
from shrm.prefiltered.layers import largest_angle
from shrm.prefiltered.paraboloid import ParaboloidMap, RadialCenter
from shrm.viewer.gpu.programs import Maps

CENTERS: dict[Center, int] = {"reflection": 0, "normal": 1, "tangent": 2, "lobe": 3}


def as_cube(part: CoefficientMaps, size: int) -> CoefficientMaps:
    """Return a lobe's maps on a cube: as they are, or made again from their coefficients.

    Raises
    ------
    ValueError
        If they are lat-long and have no coefficients.
    """
    if part.layout != "cube" and isinstance(part, Part):
        return part.resized(size, "cube")
    require_cube(part)
    return part


def require_cube(maps: Rings) -> None:
    """Raise ValueError unless maps are on a cube."""
    if maps.layout != "cube":
        raise ValueError(
            "layout must be cube to be drawn by the GPU, got lat-long maps without coefficients: "
            "use layout='cube'"
        )


def factors_texture(gl: moderngl.Context, factors: FloatArray) -> moderngl.Texture:
    """Return factors (K, T, 1 or 3) over theta_v as a texture of K rows."""
    K, T = factors.shape[:2]
    return gl.texture((T, K), 3, np.broadcast_to(factors, (K, T, 3)).astype("f4").tobytes(), dtype="f4")


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

    def bind(self) -> None:
        """Put what its shader looks up where it looks, but for the maps."""
        self.gamma.use(1)

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

    def _take(self, part: Rings, **uniforms: Any) -> None:
        """Take the center of other maps, which have the shape of those before them."""
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
                        f"maps for a near viewer must be at most {most // 6} here, got {maps}: "
                        "use a smaller P, or a distant viewer"
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
        """All maps, as `shrm.frequency.rings` has them: (H, maps, 3, side)."""

    def release(self) -> None:
        """Free what it holds on the GPU."""
        super().release()
        for texture in (self._dynamic, self._layered):
            if texture is not None:
                texture.release()


class LobeMaps(CubeLobe):
    """The coefficient maps of a SHRM's lobe."""

    near = "factored"

    def __init__(self, gl: moderngl.Context, part: CoefficientMaps, size: int) -> None:
        super().__init__(gl, size)
        self.renew(part)

    def renew(self, part: CoefficientMaps) -> None:
        """Take other maps of the same shape."""
        self._part = as_cube(part, self._size)
        self._take(self._part, P=self._part.P, zonal=self._part.zonal)

    def _sum(self, view: FloatArray, pixels: Float32Array) -> None:
        self._part.sum_for_view(view, pixels)

    def _rings(self) -> Float32Array:
        return np.asarray(self._part.rings, np.float32)


class LayeredLobe(CubeLobe):
    """The layers of a prefiltered map."""

    near = "layered"

    def __init__(self, gl: moderngl.Context, map: PrefilteredMap, size: int) -> None:
        super().__init__(gl, size)
        self._factors: moderngl.Texture | None = None
        self.renew(map)

    def renew(self, map: PrefilteredMap) -> None:
        """Take other layers of the same shape."""
        self._map = map
        self._layers = map.layers
        for layer in self._layers:
            require_cube(layer)
        factors = map.factors if isinstance(map, KautzMcCool2D) else np.ones((1, 1, 1))
        kind = SHARES.get(type(map), SLICED)
        self._take(
            self._layers[0],
            shares=kind,
            layers=len(self._layers),
            largest=largest_angle(map.center),
            factors=3,
        )
        if self._factors is not None:
            self._factors.release()
        self._factors = factors_texture(self._gl, factors)
        self._places: tuple[FloatArray, Float32Array] | None = None

    def bind(self) -> None:
        """Put what its shader looks up where it looks."""
        super().bind()
        assert self._factors is not None
        self._factors.use(3)

    def _sum(self, view: FloatArray, pixels: Float32Array) -> None:
        if self._places is None:
            C = self._layers[0].directions().reshape(-1, 3)
            layers = np.stack([layer.maps[0].reshape(-1, 3) for layer in self._layers])
            self._places = C, np.ascontiguousarray(layers, np.float32)
        C, layers = self._places
        shares = self._map.shares(np.arccos(np.clip(C @ view[0], -1.0, 1.0)), view)
        flat = pixels.reshape(-1, 3)
        flat[:] = 0.0
        for k, layer in enumerate(layers):
            share = shares[:, k].reshape(len(shares), -1).astype(np.float32)
            if len(share) < len(flat):  # the same for all
                if share.any():
                    flat += share * layer
                continue
            near = np.flatnonzero(share.any(axis=1))
            flat[near] += share[near] * layer[near]

    def _rings(self) -> Float32Array:
        return np.concatenate([layer.rings for layer in self._layers], axis=1)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        super().release()
        if self._factors is not None:
            self._factors.release()


SLICED = 0
SHARES: dict[type, int] = {Diffuse: 1, Phong: 1, KautzMcCool2D: 1, Cabral: 2}
"""Rules by which layered_map.glsl finds shares, by the class of maps."""


class ParaboloidLobe(Lobe):
    """A lobe's dual-paraboloid map, for all viewers.

    Parameters
    ----------
    gl : moderngl.Context
    center : {"reflection", "normal"}
    border : int
        Texels beyond the disc.
    factor : (T, 1 or 3) float64
        What the map is multiplied by, over theta_v.
    texture : moderngl.TextureArray
        Two layers, and the caller's to release.
    """

    near = distant = "paraboloid"

    def __init__(
        self,
        gl: moderngl.Context,
        center: RadialCenter,
        border: int,
        factor: FloatArray,
        texture: moderngl.TextureArray,
    ) -> None:
        super().__init__(gl)
        self._texture, self._factors = texture, factors_texture(gl, factor[None])
        self.uniforms = {"center": CENTERS[center], "border": border, "factors": 3}

    def bind(self) -> None:
        """Put what its shader looks up where it looks."""
        super().bind()
        self._factors.use(3)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        super().release()
        self._factors.release()

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
        super().__init__(gl, part.center, part.border, part.factor, texture)

    def release(self) -> None:
        """Free what it holds on the GPU."""
        super().release()
        self._texture.release()
