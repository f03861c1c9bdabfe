"""shrm: frequency-space environment map rendering."""

from . import brdf

__all__ = ["brdf"]
