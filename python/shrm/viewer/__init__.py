"""Real time: the renderer on the GPU, and the interactive window.

osmesa -> context -> programs, resources -> environment_texture
paraboloid, paraboloid_kernels -> paraboloid_textures -> paraboloid_filters -> hardware_prefilter
geometry, maps -> scene -> renderer
orbit -> state -> worker -> lighting, integration -> screen, comparison -> materials, panel -> window -> app
"""

from shrm.viewer.context import Context, ContextError, offscreen
from shrm.viewer.hardware_prefilter import HardwarePrefilter
from shrm.viewer.paraboloid import ParaboloidMap, ParaboloidMaps
from shrm.viewer.renderer import Renderer
from shrm.viewer.scene import Scene

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
