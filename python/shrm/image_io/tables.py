"""Tables of float64 in files of float32, exact to the last bit.

The part NAME holds a table as float32. What that leaves of its values, if anything, is in a part NAME.rest:
two more channels for each channel, to be added. Where there is one, `shrm:rest` in the metadata of NAME is 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.image_io.image import Part

_REST = "shrm:rest"


def table_parts(name: str, values: npt.NDArray[Any], channels: Sequence[str] = ("Y",)) -> list[Part]:
    """Return the parts of a file that hold a table.

    Parameters
    ----------
    name : str
        The name of the first part.
    values : (H, W, C) float32 or float64
        Within the range of float32.
    channels : sequence of C str
        The channels of the first part.

    Returns
    -------
    list of Part
        One, or two where the values are not all float32.
    """
    nearest = np.ascontiguousarray(values, np.float32)
    rest = values.astype(np.float64) - nearest
    if not rest.any():
        return [Part(name, nearest, tuple(channels))]
    # 24 bits of a value, 24 more, and the last 5 of its 53
    middle = rest.astype(np.float32)
    last = (rest - middle).astype(np.float32)
    names = [f"{channel}.{k}" for k in (1, 2) for channel in channels]
    return [
        Part(name, nearest, tuple(channels), {_REST: 1}),
        Part(f"{name}.rest", np.concatenate([middle, last], axis=2), names),
    ]


def table_values(parts: Mapping[str, Part], name: str) -> FloatArray:
    """Return a table that `table_parts` made parts of.

    Parameters
    ----------
    parts : {name: Part}
        The parts of the file.
    name : str
        The name of the first part.

    Returns
    -------
    (H, W, C) float64
        Perhaps not finite, if the file is damaged.

    Raises
    ------
    KeyError, ValueError
        If a part is missing, or what is in NAME.rest does not fit.
    """
    first = parts[name]
    values: FloatArray = first.pixels.astype(np.float64)
    if first.metadata.get(_REST):
        rest = parts[f"{name}.rest"].pixels.astype(np.float64)
        H, W, C = values.shape
        if rest.shape != (H, W, 2 * C):
            raise ValueError(f"the rest of {name} has the shape {rest.shape}")
        values += rest[:, :, :C] + rest[:, :, C:]
    return values
