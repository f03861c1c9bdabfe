"""Everything that precomputing a small object decides and computes, to be compared between processes."""

import numpy as np
from shrm import brdf
from shrm.transfer.precompute import precompute
from shrm.transfer.radiance_transfer import RadianceTransfer

from support.precomputed import ALL, matrices, rebuilt
from support.transfer_meshes import Surface, bumpy


def computed() -> RadianceTransfer:
    material = brdf.Lambert((0.2, 0.4, 0.6)) + brdf.GGX(0.6)
    options = {"order": 3, "directions": 256, "accuracy": 14.0, "bounces": 2}
    return precompute(Surface(*bumpy(9, subdivisions=1)), material, variants=ALL, matrices=True, **options)


def results(held: RadianceTransfer) -> dict[str, np.ndarray]:
    """Return the sizes that were chosen, the matrices, and these rebuilt from components."""
    arrays = {"M": np.array(held.M), "K": np.array([held.variants[name].K for name in ALL])}
    for name in ALL:
        arrays[f"{name} matrices"] = matrices(held, name)
        arrays[f"{name} rebuilt"] = rebuilt(held, name, held.variants[name].K)
    return arrays
