"""Prefiltering on the graphics hardware, as often as the environment changes.

Three filters of a dual-paraboloid map. Those of [KVHS00] section 5.2 shrink it through its mip-map until the
lobe, clamped, fits into a small kernel in texture space: ``one-pass`` with the lobe as it is in the middle of
a face, ``two-pass`` also as it is at the rim, both blended by d^2. ``exact`` is what has become possible
since: for each texel a sum over taps on the sphere, each of which reads the mip-map where a texel is as
large as the tap's share of the lobe.

Any lobe of a profile about the reflection or the normal goes through them. Other lobes are taken as those of
Kautz and McCool of two dimensions [KM00]: such a profile times a factor, which multiplies what is looked up.

Sources: [HS98].
"""

from __future__ import annotations

from typing import Any, Literal

import moderngl
import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array
from shrm.brdf.lobe import RadialLobe
from shrm.brdf.material import BRDF
from shrm.environment import Environment
from shrm.lobes.factored import FactoredLobe, as_factored
from shrm.prefiltered.paraboloid import ParaboloidMap, ParaboloidMaps
from shrm.validation import flag, one_of, positive, require_instance, whole_number
from shrm.validation import rotation as require_rotation
from shrm.viewer.gpu.context import Context, ContextError, offscreen
from shrm.viewer.gpu.environment_texture import largest_texture
from shrm.viewer.gpu.paraboloid_filters import FilteredLobe, KernelFilter, TapsFilter
from shrm.viewer.gpu.paraboloid_kernels import TextureFilter, texture_filters
from shrm.viewer.gpu.paraboloid_textures import Faces, ParaboloidEnvironment, Texels

Filter = Literal["exact", "two-pass", "one-pass"]
FILTERS: tuple[Filter, ...] = ("exact", "two-pass", "one-pass")

Source = Environment | moderngl.Texture | moderngl.TextureCube | moderngl.Framebuffer

UNTURNED = np.eye(3)
LARGEST_SIZE = 8192
LARGEST_KERNEL = 63
MOST_TAPS = 8192


class HardwarePrefilter:
    """A material's dual-paraboloid maps, filtered by OpenGL: a material for `shrm.viewer.Renderer`.

    Maps are of floats, not clamped to [0, 1] as those of [KVHS00] were. What it holds on the GPU stays there
    until `release`, or to the end of a `with` statement.

    Parameters
    ----------
    brdf : shrm.brdf.BRDF or shrm.brdf.lobe.RadialLobe
        A material, or one radial lobe. Each lobe has a map of its own: exact for radial ones, as those of
        `Phong` and `Lambert` are, else of the nearest `shrm.lobes.factored.factored` lobe.
    size : int
        Texels across the disc of each face, 4 to 8192.
    border : int, optional
        Texels beyond the disc on each side, 1 to size / 2; by default an eighth of `size`, as in the paper.
    filter : {"exact", "two-pass", "one-pass"}
        See this module.
    taps : int
        Of the exact filter, for each texel: 1 to 8192.
    clamp : float
        Of the other two, in (0, 1): where the lobe is less than this part of its maximum it is left out, and
        the rest made brighter for it.
    largest_kernel : int
        Of these, texels across to which map and lobe are shrunk: 3 to 63.
    half : bool
        Texels of 16-bit floats, half of the memory; what is larger than 65504 becomes 65504.
    context : Context, optional
        Where to filter, and the caller's to release: the renderer's, to be drawn by it. By default one of its
        own.

    Attributes
    ----------
    brdf : str
        The material's name.
    size, border : int
    filter : {"exact", "two-pass", "one-pass"}
    texture_filters : tuple of (TextureFilter, TextureFilter)
        The small and the large filter of each lobe; empty for the exact filter.

    Raises
    ------
    ContextError
        If there is no OpenGL, it cannot draw into textures of floats, or the prefilter was released.
    TypeError, ValueError
        If an argument is not as described.
    """

    def __init__(
        self,
        brdf: BRDF | RadialLobe,
        *,
        size: int = 256,
        border: int | None = None,
        filter: Filter = "exact",
        taps: int = 128,
        clamp: float = 0.1,
        largest_kernel: int = 7,
        half: bool = False,
        context: Context | None = None,
    ) -> None:
        lobes = _factored_lobes(brdf)
        self.brdf = brdf.name if isinstance(brdf, BRDF) else "radial lobe"
        self.size = whole_number("size", size, 4, LARGEST_SIZE)
        self.border = (
            max(1, self.size // 8) if border is None else whole_number("border", border, 1, self.size // 2)
        )
        one_of("filter", filter, FILTERS)
        self.filter: Filter = filter
        count = whole_number("taps", taps, 1, MOST_TAPS)
        positive("clamp", clamp, below=1.0)
        whole_number("largest_kernel", largest_kernel, 3, LARGEST_KERNEL)
        self.texture_filters: tuple[tuple[TextureFilter, TextureFilter], ...] = ()
        if filter != "exact":
            self.texture_filters = tuple(
                texture_filters(part.lobe.profile, size, clamp, largest_kernel) for part in lobes
            )
        flag("half", half)
        if context is not None:
            require_instance("context", context, Context)
        self._owns_context = context is None
        self._released, self._filled = False, False
        self.context = offscreen() if context is None else context
        self.context.activate()
        try:
            self._make(lobes, count, "f2" if half else "f4")
        except Exception:
            if self._owns_context:
                self.context.release()
            raise

    def _make(self, lobes: tuple[FactoredLobe, ...], taps: int, texels: Texels) -> None:
        """Make what is needed on the GPU."""
        gl, side = self.context.gl, self.size + 2 * self.border
        if side > largest_texture(gl):
            raise ValueError(f"size + 2 border must be at most {largest_texture(gl)} here, got {side}")
        self._environment = ParaboloidEnvironment(gl, self.size, self.border, texels)
        self._lobes: list[FilteredLobe] = []
        for k, lobe in enumerate(lobes):
            faces = Faces(gl, side, texels)
            if self.filter == "exact":
                self._lobes.append(TapsFilter(gl, lobe, faces, taps))
            else:
                used = self.texture_filters[k] if self.filter == "two-pass" else self.texture_filters[k][:1]
                self._lobes.append(KernelFilter(gl, lobe, faces, used, 0.5 * self.size))

    def update(self, source: Source, rotation: npt.ArrayLike = UNTURNED) -> None:
        """Filter an environment.

        Parameters
        ----------
        source : Environment, moderngl.Texture, moderngl.TextureCube or moderngl.Framebuffer
            A texture is of this context, of three or four components of floats (or of normalised numbers) and
            read linearly between its texels: a lat-long picture whose first row of texels is about +z, or a
            cube map with OpenGL's axes, +Z front (+x), +X right (-y), +Y up (+z). (Of a cube map without a
            mip-map each texel takes 8 x 8 samples at the most.) Of a framebuffer its first attachment is
            taken.
        rotation : (3, 3) array_like, optional
            R, by which it is turned before: L'(w) = L(R^T w).

        Raises
        ------
        ContextError
            If this was released.
        TypeError, ValueError
            If it is none of these, or of another context, or R no rotation.
        """
        self.set_light(source, rotation)
        self.apply_filter()

    def set_light(self, source: Source, rotation: npt.ArrayLike = UNTURNED) -> None:
        """Make the unfiltered map of an environment: the first half of `update`."""
        R = require_rotation("rotation", rotation)
        self._activate()
        attached = source.color_attachments if isinstance(source, moderngl.Framebuffer) else ()
        light = attached[0] if attached else source
        if isinstance(light, Environment):
            self._environment.upload(light.pixels, R)
        elif isinstance(light, moderngl.Texture | moderngl.TextureCube):
            _require_readable(light)
            if light.ctx is not self.context.gl:
                raise ValueError("source must be of the prefilter's OpenGL context, got one of another")
            self._environment.take(light, R)
        else:
            raise TypeError(
                "source must be an Environment, a moderngl Texture or TextureCube, or a Framebuffer with a "
                f"texture, got {type(source).__name__}"
            )
        self._filled = True

    def apply_filter(self) -> None:
        """Filter the map that was taken last: the second half of `update`."""
        self._require_light()
        for lobe in self._lobes:
            lobe.filter(self._environment.faces, 0.5 * self.size)

    @property
    def lobes(self) -> tuple[FilteredLobe, ...]:
        """Each lobe's center, factor and map: two layers of size + 2 border texels to a side."""
        self._require_light()
        return tuple(self._lobes)

    def unfiltered(self) -> Float32Array:
        """Read back the environment's own map: (2, side, side, 3)."""
        self._require_light()
        return self._environment.faces.read()

    def maps(self) -> ParaboloidMaps:
        """Read back the filtered maps."""
        self._require_light()
        return ParaboloidMaps(
            [ParaboloidMap(lobe.faces.read(), self.border, lobe.center, lobe.factor) for lobe in self._lobes]
        )

    def radiance(
        self, normals: npt.ArrayLike, views: npt.ArrayLike, tangents: npt.ArrayLike | None = None
    ) -> Float32Array:
        """Return the reflected radiance from maps read back; see `ParaboloidMaps.radiance`."""
        return self.maps().radiance(normals, views, tangents)

    def _activate(self) -> None:
        if self._released:
            raise ContextError("the prefilter was released: it cannot filter any more")
        self.context.activate()

    def _require_light(self) -> None:
        self._activate()
        if not self._filled:
            raise ValueError("nothing was filtered yet: call update with an environment first")

    def release(self) -> None:
        """Free what it holds on the GPU, and its context unless it was given one; it cannot filter then."""
        released, self._released = self._released or self.context.released, True
        if released:
            return
        self.context.activate()
        self._environment.release()
        for lobe in self._lobes:
            lobe.release()
        if self._owns_context:
            self.context.release()

    def __repr__(self) -> str:
        return f"<HardwarePrefilter {self.brdf}: {self.filter}, {self.size} texels, {self.context!r}>"

    def __enter__(self) -> HardwarePrefilter:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def _require_readable(texture: moderngl.Texture | moderngl.TextureCube) -> None:
    """Refuse what a shader would read as something else."""
    if isinstance(texture.mglo, moderngl.InvalidObject):
        raise ValueError("source must be a texture, got one that was released")
    what = f"got one of {texture.components} components of {texture.dtype}"
    if texture.components < 3 or texture.dtype[0] not in "fn":
        raise ValueError(f"source must be a texture of three or four components of floats, {what}")
    if isinstance(texture, moderngl.Texture) and (texture.samples or texture.depth):
        raise ValueError("source must be a texture of one sample and of colors, got several or depths")


def _factored_lobes(brdf: Any) -> tuple[FactoredLobe, ...]:
    if isinstance(brdf, RadialLobe):
        return (as_factored(brdf),)
    if not isinstance(brdf, BRDF):
        raise TypeError(f"brdf must be a material of shrm.brdf or a RadialLobe, got {type(brdf).__name__}")
    if any(lobe.center == "tangent" for lobe in brdf.lobes):
        raise ValueError(
            f"brdf must have lobes about the reflection or the normal, got {brdf.name} with one about the "
            "tangent, whose map has three dimensions: use shrm.prefiltered.Anisotropic"
        )
    return tuple(as_factored(lobe) for lobe in brdf.lobes)
