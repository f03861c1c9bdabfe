"""The filters of one lobe over a dual-paraboloid map, in shaders."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence

import moderngl

from shrm.lobes.factored import FactoredLobe
from shrm.prefiltered.paraboloid import RadialCenter
from shrm.viewer.gpu.paraboloid_kernels import TextureFilter, taps, texture_kernel
from shrm.viewer.gpu.paraboloid_textures import Faces, LayersPass


class FilteredLobe(ABC):
    """A lobe's map, and how it is made.

    Attributes
    ----------
    center : {"reflection", "normal"}
        What the map is looked up in.
    faces : Faces
        The map.
    factor : (T, 1 or 3) float64
        What it is multiplied by where it is looked up, over theta_v.
    """

    def __init__(self, part: FactoredLobe, faces: Faces) -> None:
        self.center: RadialCenter = "normal" if part.lobe.center == "normal" else "reflection"
        self.faces, self.factor = faces, part.factor

    @abstractmethod
    def filter(self, light: Faces, radius: float) -> None:
        """Make the map of the mip-map of an environment, whose disc has that radius in texels."""

    @abstractmethod
    def release(self) -> None:
        """Free what it holds."""


class TapsFilter(FilteredLobe):
    """A sum over `count` taps on the sphere."""

    def __init__(self, gl: moderngl.Context, part: FactoredLobe, faces: Faces, count: int) -> None:
        super().__init__(part, faces)
        self._count = count
        self._taps = gl.texture((count, 2), 4, taps(part.lobe.profile, count), dtype="f4")
        self._sum = LayersPass(gl, "paraboloid.glsl", "layer.glsl", "lobe_taps.frag")

    def filter(self, light: Faces, radius: float) -> None:
        """Make the map; see `FilteredLobe`."""
        self._sum.draw(
            self.faces,
            radius,
            light=light.texture,
            taps=self._taps,
            count=self._count,
            last_level=max(0.0, math.log2(light.side) - 2.0),  # of 4 texels to a side
        )

    def release(self) -> None:
        """Free what it holds."""
        for held in (self._taps, self._sum, self.faces):
            held.release()


class KernelFilter(FilteredLobe):
    """Convolution in texture space by one filter, or by two that are blended [KVHS00 section 5.2]."""

    def __init__(
        self,
        gl: moderngl.Context,
        part: FactoredLobe,
        faces: Faces,
        used: Sequence[TextureFilter],
        radius: float,
    ) -> None:
        super().__init__(part, faces)
        self._convolve = LayersPass(gl, "layer.glsl", "texture_kernel.frag")
        self._blend = LayersPass(gl, "layer.glsl", "blend_kernels.frag")
        self._steps: list[tuple[int, moderngl.Texture, Faces]] = []
        for texture_filter in used:
            level = min(texture_filter.shrink, faces.side).bit_length() - 1
            shrunk = Faces(gl, faces.side >> level, faces.texels)
            # The shrunk map's texels are a little larger where its sides are odd.
            kernel = texture_kernel(part.lobe.profile, texture_filter, faces.side / shrunk.side / radius)
            texture = gl.texture(kernel.shape[:2], 3, kernel, dtype="f4", alignment=1)
            self._steps.append((level, texture, shrunk))

    def filter(self, light: Faces, radius: float) -> None:
        """Make the map; see `FilteredLobe`."""
        for level, kernel, shrunk in self._steps:
            self._convolve.draw(shrunk, radius, light=light.texture, kernel=kernel, level=level)
        small, large = self._steps[0][2], self._steps[-1][2]
        self._blend.draw(
            self.faces,
            radius,
            small=small.texture,
            large=large.texture,
            two_passes=len(self._steps) == 2,
            side=float(self.faces.side),
        )

    def release(self) -> None:
        """Free what it holds."""
        for _, kernel, shrunk in self._steps:
            kernel.release()
            shrunk.release()
        for held in (self._convolve, self._blend, self.faces):
            held.release()
