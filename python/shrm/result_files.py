"""Files of results of prefiltering: what they hold, by their content, and one function that reads any."""

from __future__ import annotations

from typing import Literal

from shrm import image_io
from shrm.files import PathLike
from shrm.frequency.reflection_map import ReflectionMap
from shrm.image_io import ImageError
from shrm.integrate.angular import AngularReflection
from shrm.integrate.file import METHOD_KEY, VERSION_KEY
from shrm.integrate.hierarchical import HierarchicalReflection
from shrm.lobes.reflection import Reflection
from shrm.prefiltered import Prefiltered

Kind = Literal["reflection map", "prefiltered", "angular", "hierarchical"]
"""What a file holds: a map in frequency space, maps of earlier techniques, or what an integrator needs."""

CLASSES: dict[
    Kind, type[ReflectionMap] | type[Prefiltered] | type[AngularReflection] | type[HierarchicalReflection]
] = {
    "reflection map": ReflectionMap,
    "prefiltered": Prefiltered,
    "angular": AngularReflection,
    "hierarchical": HierarchicalReflection,
}


def kind_of(path: PathLike) -> Kind | None:
    """Return what a picture file holds, None if that is no result of prefiltering.

    Raises
    ------
    shrm.ImageError
        If it is no picture, or cannot be read.
    """
    about = image_io.read_metadata(path)
    if "shrm:prefiltered" in about:
        return "prefiltered"
    if VERSION_KEY in about:
        return "hierarchical" if str(about.get(METHOD_KEY)) == "hierarchical" else "angular"
    return "reflection map" if "shrm:version" in about else None


def load(path: PathLike) -> Reflection:
    """Read any result that was saved: content tells the class.

    Parameters
    ----------
    path : path
        An OpenEXR file that `save` of a result wrote.

    Returns
    -------
    ReflectionMap, Prefiltered, AngularReflection or HierarchicalReflection
        A map of one lobe by an earlier technique comes as a `Prefiltered` of it.

    Raises
    ------
    shrm.ImageError
        If the file cannot be read, is damaged, or holds something else.
    """
    kind = kind_of(path)
    if kind is None:
        raise ImageError(f"{path}: no result of prefiltering (it has none of shrm's metadata)")
    return CLASSES[kind].load(path)
