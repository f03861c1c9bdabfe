"""Real time: the renderer on the GPU, and the interactive window.

In the order of what uses what:

    gpu/       context (EGL, or osmesa), programs and resources; environment_texture; the filters of every
               frame, paraboloid_... -> hardware_prefilter; geometry and maps -> scene -> renderer
    window/    state, what is shown and how; worker, prefiltering and integration, which work beside the
               window; panel and its parts; drawing; window -> app
"""

from shrm.prefiltered.paraboloid import ParaboloidMap, ParaboloidMaps
from shrm.viewer.gpu.context import Context, ContextError, offscreen
from shrm.viewer.gpu.hardware_prefilter import HardwarePrefilter
from shrm.viewer.gpu.renderer import Renderer
from shrm.viewer.gpu.scene import Scene

__all__ = [
    "Context",
    "ContextError",
    "HardwarePrefilter",
    "ParaboloidMap",
    "ParaboloidMaps",
    "Renderer",
    "Scene",
    "offscreen",
]
