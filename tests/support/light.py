"""Light for the tests whose spectrum is known."""

import numpy as np
from shrm import sh
from shrm.environment import Environment


def band_limited_environment(F: int, seed: int, H: int = 64) -> Environment:
    """A positive picture whose samples are band-limited."""
    c = np.random.default_rng(seed).normal(size=((F + 1) ** 2, 3)) / (F + 1)
    c[0] = 8
    return Environment(sh.synthesis(c, (H, 2 * H)))
