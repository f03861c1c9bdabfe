"""The window's materials filtered on the GPU, where they are drawn [KVHS00 section 5.2]."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from shrm import brdf
from shrm.environment import Environment
from shrm.viewer.gpu.context import Context
from shrm.viewer.gpu.hardware_prefilter import HardwarePrefilter
from shrm.viewer.gpu.renderer import Drawn
from shrm.viewer.window.prefiltering import PrefilteredScene
from shrm.viewer.window.state import Filter, Rows

SIZES = {"two-pass": 256, "exact": 128}
"""Texels across a face; taps take longer for each."""
BROAD_SIZE = 64
"""Texels across a face of lobes so broad that two passes would cut too much of them."""
CLAMP = 0.02
"""Share of a lobe's maximum below which two passes leave it out: microfacets have longer tails than Phong's
lobe, for which the paper takes a tenth."""


class FilteredMaterials:
    """A prefilter for each object, made anew when its material changes and filtered when the light does."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._held: dict[int, tuple[tuple[str, Filter], HardwarePrefilter]] = {}
        self._light: dict[int, tuple[Environment, Rows]] = {}

    def drawn_with(self, result: PrefilteredScene) -> tuple[Drawn, ...]:
        """Return what objects are drawn with: the maps there are, or those of the filter that is asked for.

        Raises
        ------
        ValueError
            If a material has a lobe about the tangent.
        ContextError
            If OpenGL cannot draw into textures of floats.
        """
        request = result.request
        if request.filter is None:
            return result.drawn
        return tuple(
            self._material(k, text, request.filter, result.environment, request.light)
            for k, text in enumerate(request.materials)
        )

    def _material(
        self, index: int, text: str, filter: Filter, environment: Environment, light: Rows
    ) -> HardwarePrefilter:
        """Return object `index`'s maps under a turned light, L'(w) = L(R^T w)."""
        held = self._held.get(index)
        if held is None or held[0] != (text, filter):
            if held is not None:
                held[1].release()
                del self._held[index]
            self._held[index] = held = (text, filter), _prefilter(brdf.parse(text), filter, self._context)
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


def _prefilter(material: brdf.BRDF, filter: Filter, context: Context) -> HardwarePrefilter:
    if filter == "two-pass":
        with suppress(ValueError):  # too broad for a kernel; about a tangent the next call refuses it, too
            return HardwarePrefilter(
                material, size=SIZES[filter], filter=filter, clamp=CLAMP, context=context
            )
    size = BROAD_SIZE if filter == "two-pass" else SIZES[filter]
    return HardwarePrefilter(material, size=size, filter="exact", context=context)
