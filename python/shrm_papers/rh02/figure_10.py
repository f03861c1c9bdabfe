"""[RH02] figure 10: SHRMs and Cabral's icosahedral interpolation, for sharp and for anisotropic reflection.

Two materials: GGX with the Fresnel term of a dielectric, which reflects most near grazing, and the fibres of
Kajiya and Kay about the tangent. Cabral's twelve maps are integrated directly, at the size of the SHRM's, and
both are looked up by cubic interpolation: what differs is how they go from view to view.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shrm.brdf import BRDF, GGX, KajiyaKay
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.frequency.prefilter import prefilter
from shrm.integrate.angular import AngularReflection, prefilter_angular
from shrm.prefiltered import Cabral
from shrm.prefiltered.explicit import icosahedral_maps
from shrm.prefiltered.icosahedron import faces, icosahedron

from shrm_papers.comparison import COLUMNS, Block, Frames, Judged, Representation, Truth, draw_blocks
from shrm_papers.result import Cell, Result, Settings
from shrm_papers.spheres import View, brightest, view_turned

NAME = "rh02-figure-10"
AZIMUTH, ELEVATION = 120.0, 10.0
"""The viewer's direction, about: degrees from the brightest light, and above the horizon."""

F = 32

ROWS = 48
"""Rows of the light that is prefiltered and integrated: every texel of the twelve maps sums all of it."""


@dataclass(frozen=True)
class Material:
    """A material of the figure.

    Attributes
    ----------
    name : str
    brdf : BRDF
    shrms : tuple of (center, P)
        Center and order of the reflection maps to make; the first two are drawn.
    explicit : "reflection" or "tangent"
        The direction by which Cabral's maps are looked up.
    """

    name: str
    brdf: BRDF
    shrms: tuple[tuple[Center, int], ...]
    explicit: Center


MATERIALS = (
    Material(
        "GGX .3, dielectric",
        GGX(0.3, 0.04),
        (
            *(("lobe", 8), ("reflection", 8), ("lobe", 5), ("reflection", 5)),
            *(("lobe", 3), ("reflection", 3), ("lobe", 2), ("reflection", 2)),
        ),
        "reflection",
    ),
    Material(
        "Kajiya-Kay, s = 32",
        KajiyaKay(32),
        (("tangent", 11), ("tangent", 8), ("tangent", 5), ("tangent", 2)),
        "tangent",
    ),
)
CENTERS = {"reflection": "R", "lobe": "the lobe", "tangent": "T"}


def make(settings: Settings) -> Result:
    """Draw both materials in every representation, and compare with the integral."""
    quick = settings.quick
    rows, size, pixels, samples = (12, 16, 16, 100) if quick else (ROWS, 80, 192, 4000)
    env = settings.env.resized((rows, 2 * rows))
    view = farthest_from_vertices(view_turned(brightest(env), AZIMUTH, ELEVATION))
    frames = Frames.drawn(samples)
    blocks: list[Block] = []
    table: list[list[Cell]] = []
    for material in MATERIALS:
        center = None if material.explicit == "tangent" else material.explicit
        exact = prefilter_angular(env, material.brdf, size=size, center=center)
        truth = Truth(exact, view, pixels, frames)
        shrms = [
            truth.judge(shrm(env, material, center, P, size))
            for center, P in (material.shrms[-2:] if quick else material.shrms)
        ]
        cabral = truth.judge(icosahedral(exact, material.explicit))
        columns = [(title(judged), judged) for judged in (*shrms[:2], cabral)]
        blocks.append(Block(material.name, truth, columns))
        table += [[material.name, *judged.cells] for judged in (*shrms, cabral)]
    return Result(
        NAME,
        f"SHRM and Cabral's icosahedral interpolation, {settings.env_name}",
        ("material", *COLUMNS),
        table,
        _NOTES,
        draw_blocks(blocks),
    )


_NOTES = (
    "Cabral's twelve maps are integrated for the views of an icosahedron's vertices and blended by spherical "
    "barycentric weights. Each is looked up at R (Kajiya-Kay: at T), which is the warp of [CON99].",
    "The viewer of the pictures stands where the twelve views are farthest, 37 degrees from three of them; "
    "random frames have N, V and the tangent of any direction. Errors are relative RMS, colors pooled.",
    f"F = {F}; the correct pictures are integrals over the same light, of {ROWS} rows. Both look up maps of "
    "one size by cubic interpolation, which favours Cabral's: hardware of its time was bilinear. MB are of "
    "float32 RGB.",
    "[RH02] gives no numbers, and of its materials names Kajiya-Kay only; its SHRMs are about R (or T). The "
    "energy of a dielectric near grazing lies where V and R are nearly opposite, which takes a high P about "
    "R. The lobe center is not in the paper.",
)


def shrm(env: Environment, material: Material, center: Center, P: int, size: int) -> Representation:
    """Make a reflection map of an order."""
    rm = prefilter(env, material.brdf, orders=(F, P), center=center, size=size)
    (part,) = rm.parts
    return Representation(f"SHRM, P = {P}", CENTERS[center], part.rings.shape[1], part.rings.nbytes, rm)


def icosahedral(exact: AngularReflection, center: Center) -> Representation:
    """Integrate Cabral's twelve maps."""
    maps = Cabral.fitted(icosahedral_maps(exact), center)
    return Representation("Cabral et al.", CENTERS[center], len(maps.maps), maps.nbytes, maps)


def title(judged: Judged) -> str:
    """Return the title of a picture: the method, its center and number of maps."""
    form = judged.representation
    return f"{form.name}\nabout {form.center}, {form.maps} maps"


def farthest_from_vertices(view: View) -> View:
    """Return the center of the icosahedron's face nearest to a view: there Cabral interpolates farthest."""
    centers = icosahedron()[faces()].sum(axis=1)
    centers /= np.linalg.norm(centers, axis=1, keepdims=True)
    x, y, z = centers[np.argmax(centers @ np.asarray(view))]
    return float(x), float(y), float(z)
