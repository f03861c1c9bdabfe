"""Real time: the renderer on the GPU, and the interactive window.

osmesa -> context -> geometry, maps, programs, resources -> scene -> renderer
orbit -> state -> worker -> lighting, integration -> screen, comparison -> materials, panel -> window -> app
"""

from shrm.viewer.context import Context, ContextError, offscreen
from shrm.viewer.renderer import Renderer
from shrm.viewer.scene import Scene

__all__ = ["Context", "ContextError", "Renderer", "Scene", "offscreen"]
