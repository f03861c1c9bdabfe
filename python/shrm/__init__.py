"""shrm: frequency-space environment map rendering."""

from shrm.environment import Environment as Environment
from shrm.image_io import ImageError as ImageError
from shrm.image_io import ImageWarning as ImageWarning
