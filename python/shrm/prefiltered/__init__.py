"""Prefiltered environment maps: what is left of L(v, n, t) without some dependencies [KVHS00 sections 3, 4].

    class              keeps              layers of its map
    Diffuse            (n)                one
    Phong              (r_v)              one
    KautzMcCool3D      (r_v, n.r_v)       one for each of some angles, linear between them
    KautzMcCool2D      (r_v), F(n.r_v)    one for each product of a shape and a factor
    Cabral             (v, n)             one for each of twelve views, blended between them
    Anisotropic        (t, v.t)           one for each of some angles, linear between them

Each layer is a reflection map over the central direction C that the class keeps; reflected radiance is a sum
of layers, looked up at C, in shares that depend on what else the class keeps. Where n.r_v stands in the
paper, here stands the angle theta_o between C and V. Layers are made by any method, and all hold the cosine.

    icosahedron      views and weights of [CON99]
    explicit         explicit sets of maps from reflection maps, and back
    layers           radiance over C, integrated by any method
    file             files of layers, as plain data
    prefiltered_map  the map of one lobe: what all classes share
    one_shape        Diffuse, Phong, KautzMcCool2D
    slices           KautzMcCool3D, Anisotropic
    cabral           Cabral
    material         the maps of all lobes of a material, from an environment or from a SHRM
    paraboloid       dual-paraboloid maps
"""

from shrm.prefiltered.cabral import Cabral
from shrm.prefiltered.material import Prefiltered, Technique, prefilter
from shrm.prefiltered.one_shape import Diffuse, KautzMcCool2D, Phong
from shrm.prefiltered.prefiltered_map import PrefilteredMap
from shrm.prefiltered.slices import Anisotropic, KautzMcCool3D

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
    "prefilter",
]
