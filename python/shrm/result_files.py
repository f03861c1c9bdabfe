"""Reading files of any result of prefiltering, whose content tells which it is."""

from __future__ import annotations

from typing import Literal

from shrm import image_io
from shrm.files import PathLike
from shrm.frequency.reflection_map import ReflectionMap
from shrm.image_io import ImageError
from shrm.integrate.angular import AngularReflection
from shrm.integrate.file import METHOD_KEY, VERSION_KEY
from shrm.integrate.hierarchical import HierarchicalReflection
from shrm.prefiltered import Prefiltered

Kind = Literal["reflection map", "prefiltered", "angular", "hierarchical"]
"""Content of a file: a map in frequency space, maps of earlier techniques, or tables of an integrator."""

Result = ReflectionMap | Prefiltered | AngularReflection | HierarchicalReflection
"""A result that comes from a file."""

CLASSES: dict[Kind, type[Result]] = {
    "reflection map": ReflectionMap,
    "prefiltered": Prefiltered,
    "angular": AngularReflection,
    "hierarchical": HierarchicalReflection,
}


def kind_of(path: PathLike) -> Kind | None:
    """Return the kind of result in a picture file; None if it holds no result of prefiltering.

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


def load(path: PathLike) -> Result:
    """Read any result that was saved; its content tells the class.

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
