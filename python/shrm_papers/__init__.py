"""The tables and figures of [RH02], [KVHS00] and [LK03], made again with the papers' own numbers beside them.

Each result is a module of its paper's package with `NAME` and `make(settings) -> Result`; `RESULTS` lists
them. The papers share these modules, each of which may import those above it; no paper imports another, and
none of these imports a paper:

    result          a table with its notes and picture, and what it is made from
    machine         the processor and its threads
    errors          relative RMS errors
    exponents       power laws fitted to times
    single_thread   times in a process of one thread
    plotting        the look of graphs
    grid_meshes     torus, knot, sphere, pot
    spheres         pictures of spheres and their exposure
    comparison      representations held against direct integration, and figures of pictures in rows
    rh02/ kvhs00/ lk03/
    index           the page that joins all results
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

from shrm_papers.result import Result, Settings

__all__ = ["RESULTS", "Result", "Settings", "make"]

RESULTS: Mapping[str, str] = {
    "rh02-table-2": "representations of the reflected light: bytes, error, time",
    "rh02-table-3": "exponents of the cost of prefiltering",
    "rh02-table-4": "Phong's lobe by integration and in frequency space",
    "rh02-table-5": "10 x 10 maps of a microfacet lobe by integration and from SHRMs",
    "rh02-figure-1": "an object of five materials in the light of four places",
    "rh02-figure-5": "blurred light on blurred materials",
    "rh02-figure-6": "accuracy against the order F, measured and estimated",
    "rh02-figure-7": "a microfacet sphere with P = 0 to 3",
    "rh02-figure-8": "how much of measured materials F = 30 and P = 0 to 5 hold",
    "rh02-figure-9": "a fabric with azimuth and without",
    "rh02-figure-10": "SHRMs and Cabral's icosahedral interpolation",
    "kvhs00-table-1": "Phong's lobe by brute force and by hierarchical descent",
    "kvhs00-table-2": "frames per second when OpenGL filters for every frame",
    "kvhs00-figure-3": "distortion of circles in paraboloid maps",
    "kvhs00-figure-4": "filters compared at exponent 100",
    "kvhs00-figure-5": "a glossy torus filtered for every frame",
    "kvhs00-figure-6": "a brushed pot by Banks' model",
    "lk03-table-1": "frames per second of methods that light an object by transfer",
    "lk03-figure-2": "what the change from harmonics to tents loses",
    "lk03-figure-3": "what principal components lose",
    "lk03-figure-4": "an object by matrices and by tents",
    "lk03-figure-5": "an object from few and many principal components",
}
"""Subject of each result by its name, in the papers' order; the module rh02.table_2 makes "rh02-table-2"."""


def make(name: str, settings: Settings) -> Result:
    """Make one result.

    Its module is imported here, not before: plotting libraries are slow to load.

    Parameters
    ----------
    name : str
        One of `RESULTS`.
    settings : Settings
        The light, files and options that it is made with.

    Raises
    ------
    ValueError
        If there is no result of that name.
    """
    if name not in RESULTS:
        raise ValueError(f"name must be one of {', '.join(RESULTS)}, got {name!r}")
    paper, _, number = name.partition("-")
    module = import_module(f"shrm_papers.{paper}.{number.replace('-', '_')}")
    result: Result = module.make(settings)
    return result
