"""The window's materials filtered on the GPU, where they are drawn [KVHS00 section 5.2]."""

from __future__ import annotations

import numpy as np

from shrm import brdf
from shrm.environment import Environment
from shrm.viewer.gpu.context import Context
from shrm.viewer.gpu.hardware_prefilter import HardwarePrefilter
from shrm.viewer.gpu.renderer import Drawn
from shrm.viewer.window.lighting import Prefiltered
from shrm.viewer.window.state import Rows

SIZE, BROAD_SIZE = 256, 64
"""Texels across a face, and across one for lobes so broad that two passes would cut too much of them."""
CLAMP = 0.02
"""Of a lobe's maximum, what is left out: for microfacets' long tails less than the paper's tenth."""


class FilteredMaterials:
    """A prefilter for each object, made anew when its material changes and filtered when the light does."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._held: dict[int, tuple[str, HardwarePrefilter]] = {}
        self._light: dict[int, tuple[Environment, Rows]] = {}

    def drawn_with(self, result: Prefiltered) -> tuple[Drawn, ...]:
        """Return what objects are drawn with: the maps there are, or, by the method "hardware", its own.

        Raises
        ------
        ValueError
            If a material has a lobe about the tangent.
        ContextError
            If OpenGL cannot draw into textures of floats.
        """
        request = result.request
        if request.method != "hardware":
            return result.drawn
        return tuple(
            self._material(k, text, result.environment, request.light)
            for k, text in enumerate(request.materials)
        )

    def _material(self, index: int, text: str, environment: Environment, light: Rows) -> HardwarePrefilter:
        """Object `index`'s maps under a turned light, L'(w) = L(R^T w)."""
        held = self._held.get(index)
        if held is None or held[0] != text:
            if held is not None:
                held[1].release()
                del self._held[index]
            self._held[index] = held = text, _prefilter(brdf.parse(text), self._context)
            self._light.pop(index, None)
        if self._light.get(index) != (environment, light):
            held[1].update(environment, rotation=np.asarray(light, np.float64))
            self._light[index] = environment, light
        return held[1]

    def release(self) -> None:
        """Free what they hold on the GPU."""
        for _, prefilter in self._held.values():
            prefilter.release()
        self._held.clear()


def _prefilter(material: brdf.BRDF, context: Context) -> HardwarePrefilter:
    try:
        return HardwarePrefilter(material, size=SIZE, method="two-pass", clamp=CLAMP, context=context)
    except ValueError:
        if any(lobe.center == "tangent" for lobe in material.lobes):
            raise
        return HardwarePrefilter(material, size=BROAD_SIZE, method="exact", context=context)
