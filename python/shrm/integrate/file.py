"""Results of the integrators as OpenEXR files: the light as a picture, and the tables of each lobe.

A multi-part file of 32-bit floats.

`light`
    The light as a lat-long picture; channels R, G, B. Its metadata says the rest in words and numbers under
    the prefix `shrm:`.
`k.NAME`
    The tables of lobe k under the names of its `to_arrays`; what float32 leaves of them is in `k.NAME.rest`
    (`shrm.image_io.tables`). Its kind, its center and its numbers are in the metadata as `shrm:k.NAME`,
    numbers as text of full precision.

What follows from these, such as the pyramid of the light, is computed again when a file is read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal, cast, get_args

import numpy as np

from shrm import image_io
from shrm.arrays import Float32Array
from shrm.brdf.lobe import Center
from shrm.files import PathLike, one_line
from shrm.image_io import ImageError
from shrm.integrate.queries import CENTERS, LARGEST_SIZE
from shrm.integrate.saved_arrays import NamedArrays, Parts, array_parts, arrays_of_parts
from shrm.lobes.reflection import Layout

VERSION = 1
"""Version of the format."""

VERSION_KEY = "shrm:integrated"
"""Name of the metadata with the version, which only these files have."""

METHOD_KEY = "shrm:method"
"""Name of the metadata with the method."""

MOST_LOBES = 1024
"""Most lobes of a file that is not taken for damaged."""

_AXES = "right-handed, z up; row 0 at +z, column centers at phi = pi - 2 pi (j + 1/2) / W from +x towards +y"
_WORDS = ("kind", "center")
"""Metadata of a lobe that are words, not numbers."""

SavedMethod = Literal["angular", "hierarchical"]


@dataclass(frozen=True, eq=False)
class SavedLobe:
    """A lobe as plain data.

    Attributes
    ----------
    kind : {"radial", "zonal", "isotropic"}
        Class of the lobe.
    center : {"lobe", "reflection", "normal", "tangent"}
        Direction that its maps are indexed by.
    arrays : {name: array}
        Tables of two axes, and numbers.
    """

    kind: str
    center: Center
    arrays: NamedArrays


@dataclass(frozen=True, eq=False)
class SavedIntegration:
    """The content of a file: plain data, from which the integrators' results are built.

    Attributes
    ----------
    method : {"angular", "hierarchical"}
        The integrator.
    brdf : str
        The material's name.
    pixels : (H, W, 3) float32
        The light, lat-long.
    layout : {"latlong", "cube"}
        The grid of maps.
    size : int
        Rows of a lat-long map, or of a cube's face.
    lobes : tuple of SavedLobe
        At least one.
    numbers : {name: float}
        Further parameters of the method.
    """

    method: SavedMethod
    brdf: str
    pixels: Float32Array
    layout: Layout
    size: int
    lobes: tuple[SavedLobe, ...]
    numbers: Mapping[str, float]


def write(path: PathLike, saved: SavedIntegration) -> None:
    """Write what an integrator needs; the file appears whole or not at all.

    Raises
    ------
    shrm.ImageError
        If the file cannot be written.
    """
    about: dict[str, str | int | float] = {
        "shrm:axes": _AXES,
        VERSION_KEY: VERSION,
        METHOD_KEY: saved.method,
        "shrm:brdf": saved.brdf,
        "shrm:layout": saved.layout,
        "shrm:size": saved.size,
        "shrm:lobes": len(saved.lobes),
        **{f"shrm:{name}": repr(float(value)) for name, value in saved.numbers.items()},
    }
    parts: list[image_io.Part] = []
    for k, lobe in enumerate(saved.lobes):
        about |= {f"shrm:{k}.kind": lobe.kind, f"shrm:{k}.center": lobe.center}
        tables, numbers = array_parts(lobe.arrays, f"{k}.", f"shrm:{k}.")
        parts += tables
        about |= numbers
    image_io.write_parts(path, [image_io.Part("light", saved.pixels, ["R", "G", "B"], about), *parts])


def read(path: PathLike, method: SavedMethod, numbers: Sequence[str]) -> SavedIntegration:
    """Read what `write` wrote.

    Parameters
    ----------
    path : path
    method : {"angular", "hierarchical"}
        The one whose result it must be.
    numbers : sequence of str
        Names of the method's numbers; those that the file does not have are left out.

    Raises
    ------
    shrm.ImageError
        If the file cannot be read, is damaged, or holds something else.
    """
    parts = {part.name: part for part in image_io.read_parts(path)}
    about = parts["light"].metadata if "light" in parts else {}
    if VERSION_KEY not in about:
        raise ImageError(f"{path}: no result of integration (it has no part light with shrm's metadata)")
    if str(about[VERSION_KEY]) != str(VERSION):
        raise ImageError(
            f"{path}: a result of integration of version {about[VERSION_KEY]}, this reads version {VERSION}"
        )
    if str(about.get(METHOD_KEY)) != method:
        raise ImageError(f"{path}: a result of {about.get(METHOD_KEY)} integration where it must be {method}")
    with refusing_damage(path):
        return _saved(parts, about, method, numbers)


@contextmanager
def refusing_damage(path: PathLike) -> Iterator[None]:
    """Tell of whatever does not fit while a result is made of a file: an `ImageError` that names the file."""
    try:
        yield
    except (KeyError, ValueError, TypeError, IndexError, OverflowError) as fault:
        raise ImageError(f"{path}: a damaged result of integration ({one_line(fault)})") from fault


def _saved(
    parts: Parts, about: Mapping[str, Any], method: SavedMethod, numbers: Sequence[str]
) -> SavedIntegration:
    """Return what the parts of a file hold; ValueError or KeyError if they are damaged."""
    # the light
    pixels = np.ascontiguousarray(parts["light"].pixels)
    H, W, channels = pixels.shape
    if channels != 3 or H < 2 or W < 4 or not np.isfinite(pixels).all():
        raise ValueError(f"light of shape {pixels.shape}, or not finite")

    # the grid of the maps
    layout, size, lobes = str(about["shrm:layout"]), int(about["shrm:size"]), int(about["shrm:lobes"])
    if layout not in get_args(Layout) or not 1 <= size <= LARGEST_SIZE:
        raise ValueError(f"layout {layout!r} of size {size}")
    if not 1 <= lobes <= MOST_LOBES:
        raise ValueError(f"shrm:lobes = {lobes}")
    return SavedIntegration(
        method,
        str(about["shrm:brdf"]),
        pixels,
        cast(Layout, layout),
        size,
        tuple(_lobe(parts, about, k) for k in range(lobes)),
        {name: float(about[f"shrm:{name}"]) for name in numbers if f"shrm:{name}" in about},
    )


def _lobe(parts: Parts, about: Mapping[str, Any], k: int) -> SavedLobe:
    kind, center = (str(about[f"shrm:{k}.{word}"]) for word in _WORDS)
    if center not in CENTERS[kind]:
        raise ValueError(f"{kind} lobe about the {center}")
    arrays = arrays_of_parts(parts, about, f"{k}.", f"shrm:{k}.", _WORDS)
    return SavedLobe(kind, center, arrays)
