"""An array with a row for every vertex, on disk: computed part by part, and continued after a stop.

    NAME.npy     numpy's format, mapped into memory
    NAME.json    what it was computed from, how many of its rows are finished, and their CRC-32

NAME.json is written after the rows that it counts; those beyond its count are computed again.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from shrm.arrays import Float32Array
from shrm.files import write_bytes

VERSION = 1
"""The version of these files; those of another are computed again."""

_BLOCK_BYTES = 1 << 24
"""Bytes of an array whose checksum is taken at once."""


def stored(
    path: Path,
    about: dict[str, Any],
    shape: tuple[int, ...],
    parts: Iterable[slice],
    make: Callable[[slice], Float32Array],
    progress: Callable[[int, int], None],
) -> Float32Array:
    """Return an array mapped from a file, to be read only; rows that it lacks are computed.

    Parameters
    ----------
    path : path
        NAME, without an extension. A file about something else, or a damaged one, is replaced; arrays that
        are mapped from it stay as they are.
    about : dict
        What the array depends on, as JSON has it.
    shape : tuple of int
        Shape of the whole array.
    parts : iterable of slice
        Slices of the first axis, in order and without gaps.
    make : callable
        Called with a part; returns its rows.
    progress : callable
        Called with the rows done and their number; what it raises ends the computation and loses nothing.

    Raises
    ------
    OSError
        If the file cannot be written, or there is no room for the whole of it.
    """
    data, state = path.with_name(path.name + ".npy"), path.with_name(path.name + ".json")
    about = {**about, "version": VERSION, "shape": list(shape)}

    # A new file, with room for all of it
    finished, crc = _finished(data, state, about)
    if finished == 0:
        state.unlink(missing_ok=True)
        data.unlink(missing_ok=True)
        np.lib.format.open_memmap(data, mode="w+", dtype=np.float32, shape=shape)
        with data.open("r+b") as file:  # a mapped file that outgrows the disk would end the process
            os.posix_fallocate(file.fileno(), 0, file.seek(0, os.SEEK_END))

    # The rows that are missing
    progress(finished, shape[0])
    if finished < shape[0]:
        for part in parts:
            if part.stop <= finished:
                continue
            rows = make(part)
            # Mapped anew for each part: pages that stay mapped count as the memory of the process
            array = np.lib.format.open_memmap(data, mode="r+")
            array[part] = rows
            array.flush()
            new = array[max(part.start, finished) : part.stop]
            crc = zlib.crc32(new.data.cast("B"), crc)
            write_bytes(state, json.dumps({"about": about, "finished": part.stop, "crc32": crc}).encode())
            progress(part.stop, shape[0])
    return np.lib.format.open_memmap(data, mode="r")


def read(array: Float32Array, part: slice) -> Float32Array:
    """Return rows of an array of `stored`, in memory: none of its pages is mapped for them."""
    if not isinstance(array, np.memmap) or array.filename is None:
        return array[part]
    start, stop, _ = part.indices(len(array))
    row = array[:1]
    values = np.fromfile(
        array.filename, array.dtype, (stop - start) * row.size, offset=array.offset + start * row.nbytes
    )
    return np.asarray(values, np.float32).reshape(stop - start, *array.shape[1:])


def _finished(data: Path, state: Path, about: dict[str, Any]) -> tuple[int, int]:
    """Return how many rows there are of this very array, and their CRC-32; 0 of a damaged one, or none."""
    try:
        saved = json.loads(state.read_bytes())
        if not isinstance(saved, dict) or saved.get("about") != about:
            return 0, 0
        array = np.lib.format.open_memmap(data, mode="r")
    except Exception:  # numpy raises whatever a broken file makes it raise
        return 0, 0

    # The array, and rows of it that have the checksum
    finished, crc = saved.get("finished"), 0
    if array.dtype != np.float32 or not array.flags.c_contiguous or list(array.shape) != about["shape"]:
        return 0, 0
    if not isinstance(finished, int) or not 0 <= finished <= len(array):
        return 0, 0
    step = max(1, _BLOCK_BYTES // array[:1].nbytes)
    for start in range(0, finished, step):
        crc = zlib.crc32(array[start : min(start + step, finished)].data.cast("B"), crc)
    return (finished, crc) if crc == saved.get("crc32") else (0, 0)
