"""Small objects with transfer, precomputed from meshes, and what their arrays say."""

from typing import Any

import numpy as np
from shrm.transfer.lighting import Tents
from shrm.transfer.matrices.product import Route
from shrm.transfer.precompute import precompute
from shrm.transfer.radiance_transfer import RadianceTransfer

from support.transfer_meshes import Mesh, Surface, bumpy

BUMPY = bumpy(3)
ALL = ("unshadowed", "shadowed", "interreflected")


def transferred(mesh: Mesh, material: Any, **options: Any) -> RadianceTransfer:
    """Something small, all of it fixed and kept, unless options say otherwise."""
    small = {
        "order": 3,
        "tents": 5,
        "route": Route(),
        "directions": 256,
        "components": 8,
        "half": False,
        "matrices": True,
    }
    return precompute(Surface(*mesh), material, **{**small, **options})


def matrices(held: RadianceTransfer, name: str = "shadowed") -> np.ndarray:
    return np.array(held.variants[name].matrices)


def radiance(held: RadianceTransfer, name: str, light: np.ndarray, view: np.ndarray) -> np.ndarray:
    """From the matrices, not from their components."""
    return Tents(held.vertices, held.frames, matrices(held, name)).radiance(light, view=view)


def rebuilt(held: RadianceTransfer, name: str, K: int) -> np.ndarray:
    variant = held.variants[name]
    weights, components = (np.asarray(a, np.float64) for a in (variant.weights, variant.components))
    if variant.clusters is None:
        return np.einsum("pk,ktcj->ptcj", weights[:, :K], components[:K])
    return np.einsum("pk,pktcj->ptcj", weights[:, :K], components[variant.clusters][:, :K])
