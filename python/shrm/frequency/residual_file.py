"""The residual of a reflection map in its file: the light, and the tables of each core.

`residual.light`
    The light as a lat-long picture; channels R, G, B.
`residual.rotation`
    The rotation of the light, 3 x 3.
`residual.k.NAME`
    The tables of core k under the names of `shrm.integrate.residual.Core.to_arrays`: `gamma`, `envelope`,
    `ratio` and `caps` of an isotropic lobe, `profile` and `within` of a radial one, `albedo` and `mirror` of
    what is looked up. The numbers are in the metadata of `residual.light` as `shrm:k.NAME`, as text of full
    precision.

Tables that are not of float32 have a part `residual.k.NAME.rest` besides (`shrm.image_io.tables`). Files of
version 2 have `residual.k.centre` for what is `residual.k.gamma` now.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast, get_args

import numpy as np

from shrm import image_io
from shrm.arrays import FloatArray
from shrm.brdf.lobe import Center
from shrm.integrate.residual import LARGEST_CUT, Core, Light, Residual
from shrm.integrate.saved_arrays import Parts, array_parts, arrays_of_parts, table
from shrm.lobes.reflection import Layout

LIGHT = "residual.light"
"""Name of the part that holds the light, and the metadata of the cores."""

_OLD_NAMES = {"centre": "gamma"}
"""Names of tables by their names in files of version 2."""

_WORDS = ("map", "center")
"""Metadata of a core that are words, not numbers."""


def residual_parts(residual: Residual) -> list[image_io.Part]:
    """Return the parts of a file that hold a residual."""
    about: dict[str, str | int | float] = {"shrm:cut": residual.light.cut, "shrm:cores": len(residual.cores)}
    parts = image_io.table_parts("residual.rotation", residual.rotation[:, :, None])
    for k, (name, core) in enumerate(residual.cores):
        about |= {f"shrm:{k}.map": name, f"shrm:{k}.center": core.descent.center}
        tables, numbers = array_parts(core.to_arrays(), f"residual.{k}.", f"shrm:{k}.")
        parts += tables
        about |= numbers
    light = image_io.Part(LIGHT, residual.light.pixels, ["R", "G", "B"], about)
    return [light, *parts]


def read_residual(
    images: Parts, maps: Sequence[tuple[str, Center, FloatArray]], layout: Layout, size: int
) -> Residual:
    """Read what `residual_parts` wrote.

    Parameters
    ----------
    images : {name: part}
        The parts of the file.
    maps : sequence of (name, center, gamma)
        The names of the reflection map's parts, and their centers.
    layout, size
        The grid of its maps.

    Raises
    ------
    KeyError, TypeError, ValueError
        If they are damaged.
    """
    # The light and its texels
    light = images[LIGHT]
    about, pixels = light.metadata, np.ascontiguousarray(light.pixels, np.float32)
    H, W, channels = pixels.shape
    cut = int(cast(int, about["shrm:cut"]))
    if channels != 3 or not np.isfinite(pixels).all() or H < 2 or W < 4:
        raise ValueError(f"{LIGHT} of shape {pixels.shape}, or not finite")
    if not 1 <= cut <= max(LARGEST_CUT // max(H, W), 1):
        raise ValueError(f"shrm:cut = {cut}")
    rotation = table(
        {"rotation": image_io.table_values(images, "residual.rotation")[:, :, 0]}, "rotation", (3, 3)
    )
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-5:
        raise ValueError("residual.rotation is none")

    # The cores, each of one of the maps
    by_name = {name: (center, gamma) for name, center, gamma in maps}
    count = int(cast(int, about["shrm:cores"]))
    if not 1 <= count <= len(maps):
        raise ValueError(f"shrm:cores = {count}")
    cores = tuple(_core(images, about, k, by_name) for k in range(count))
    return Residual(Light(pixels, cut), cores, layout, size, rotation)


def _core(
    images: Parts, about: Mapping[str, Any], k: int, maps: Mapping[str, tuple[Center, FloatArray]]
) -> tuple[str, Core]:
    """Return core k, with the name of its map."""
    name, own_center = (str(about[f"shrm:{k}.{word}"]) for word in _WORDS)
    if own_center not in get_args(Center):
        raise ValueError(f"center {own_center!r}")
    arrays = arrays_of_parts(images, about, f"residual.{k}.", f"shrm:{k}.", _WORDS)
    arrays = {_OLD_NAMES.get(key, key): array for key, array in arrays.items()}
    return name, Core.from_arrays(*maps[name], cast(Center, own_center), arrays)
