"""An array with a row for every vertex, on disk: computed block by block, and continued after a stop.

    NAME.npy     numpy's format, mapped into memory
    NAME.json    what it was computed from, and how many of its rows are finished

Rows count from when NAME.json says so, which is written after them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.transfer.visibility import write_whole

Float32Array = npt.NDArray[np.float32]


def stored(
    path: Path,
    about: dict[str, Any],
    shape: tuple[int, ...],
    parts: Iterable[slice],
    make: Callable[[slice], Float32Array],
    progress: Callable[[int, int], None],
) -> Float32Array:
    """Return an array mapped from a file; rows that it lacks are computed.

    Parameters
    ----------
    path : path
        NAME, without an extension. A file about something else is replaced.
    about : dict
        What the array depends on, as JSON has it.
    shape : tuple of int
        Of the whole array.
    parts : iterable of slice
        Of the first axis, in order and without gaps.
    make : callable
        A part's rows.
    progress : callable
        Called with the rows done and their number; what it raises ends the computation and loses nothing.
    """
    data, state = path.with_name(path.name + ".npy"), path.with_name(path.name + ".json")
    about = {**about, "shape": list(shape)}
    finished = _finished(data, state, about)
    if finished == 0:
        state.unlink(missing_ok=True)
        array = np.lib.format.open_memmap(data, mode="w+", dtype=np.float32, shape=shape)
    else:
        array = np.lib.format.open_memmap(data, mode="r+")
    progress(finished, shape[0])
    for part in parts:
        if part.stop <= finished:
            continue
        array[part] = make(part)
        array.flush()
        write_whole(state, json.dumps({"about": about, "finished": part.stop}).encode())
        progress(part.stop, shape[0])
    return array


def _finished(data: Path, state: Path, about: dict[str, Any]) -> int:
    """How many rows are there of this very array; 0 if there is none, or its files are damaged."""
    try:
        found = json.loads(state.read_bytes())
        shape = np.lib.format.open_memmap(data, mode="r").shape
    except (OSError, ValueError):
        return 0
    if not isinstance(found, dict) or found.get("about") != about or list(shape) != about["shape"]:
        return 0
    finished = found.get("finished")
    return finished if isinstance(finished, int) and 0 <= finished <= shape[0] else 0
