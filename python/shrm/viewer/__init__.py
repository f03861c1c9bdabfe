"""Real time: the renderer on the GPU, and the interactive window.

osmesa -> context -> programs, resources -> environment_texture
paraboloid, paraboloid_kernels -> paraboloid_textures -> paraboloid_filters -> hardware_prefilter
geometry, maps -> scene -> renderer
orbit -> state -> worker -> lighting, integration -> screen, comparison -> materials, panel -> window -> app
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
