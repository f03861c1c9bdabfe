"""Environment maps: pictures of light from all sides.

layouts       the layouts of pictures, and area-exact conversion between them
paraboloid    borders of dual paraboloids
daylight      an analytic sky with its sun
lookup        bilinear look-ups in pictures and textures
environment   the class `Environment`
"""

from shrm.environment.environment import Environment, require_environment

__all__ = ["Environment", "require_environment"]
