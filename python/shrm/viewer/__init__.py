"""Real time: the renderer on the GPU.

context -> geometry, maps, programs, resources -> scene -> renderer
"""

from shrm.viewer.context import Context, ContextError, offscreen
from shrm.viewer.renderer import Renderer
from shrm.viewer.scene import Scene

__all__ = ["Context", "ContextError", "Renderer", "Scene", "offscreen"]
