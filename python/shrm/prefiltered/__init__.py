"""Prefiltered environment maps: what is left of L(v, n, t) without some dependencies [KVHS00 sections 3, 4].

    class              keeps              layers of its map
    Diffuse            (n)                one
    Phong              (r_v)              one
    KautzMcCool3D      (r_v, n.r_v)       one for each of some angles, linear between them
    KautzMcCool2D      (r_v), F(n.r_v)    one for each lobe, times a factor
    Cabral             (v, n)             one for each of twelve views, blended between them
    Anisotropic        (t, v.t)           one for each of some angles, linear between them

Each layer is a reflection map over the central direction C that the class keeps; what is reflected is a sum
of layers, looked up at C, in shares that depend on what else it keeps. Where n.r_v stands in the paper, here
the angle theta_o between C and V does. Layers are made by any of the integrators, and all hold the cosine.

    layers      how layers are integrated, and their grid
    maps        the classes
    material    the maps of a material of several lobes, from an environment or from a SHRM
    file        their files

Sources: [KM00], [CON99].
"""

from shrm.prefiltered.maps import (
    Anisotropic,
    Cabral,
    Diffuse,
    KautzMcCool2D,
    KautzMcCool3D,
    Phong,
    PrefilteredMap,
)
from shrm.prefiltered.material import Prefiltered, Technique, of_reflection_map, prefilter

__all__ = [
    "Anisotropic",
    "Cabral",
    "Diffuse",
    "KautzMcCool2D",
    "KautzMcCool3D",
    "Phong",
    "Prefiltered",
    "PrefilteredMap",
    "Technique",
    "of_reflection_map",
    "prefilter",
]
