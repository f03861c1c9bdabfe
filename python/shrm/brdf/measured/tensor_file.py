r"""The container of the RGL/EPFL material database: named arrays one after another in a file, little-endian.

    "tensor_file\0"    12 bytes
    1, 0              the version, a byte each
    fields            uint32, how many; then for each of them
        length        uint16 of its name, and the name
        dimensions    uint16
        type          one byte, a key of `_TYPES`
        offset        uint64, of its values from the start of the file
        shape         uint64 for each dimension; the last one is contiguous

Nothing larger than the header is read before everything in it has been compared with the size of the file.
The database has its own reader in Python, github.com/rgl-epfl/brdf-loader.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

MAGIC = b"tensor_file\0"

_TYPES = ("u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8")  # keys from 1
_MOST_FIELDS = 64
_MOST_DIMENSIONS = 8
_LONGEST_HEADER = 1 << 16
_LARGEST = 1e30  # of floating point values: sums of them hold in float32
_LARGEST_FIELD = 1 << 26  # bytes; the largest of an isotropic material of the database is of a tenth of that


@dataclass(frozen=True)
class Field:
    """Where an array lies in its file."""

    dtype: np.dtype[Any]
    offset: int
    shape: tuple[int, ...]

    @property
    def nbytes(self) -> int:
        """Its size; exact, however large the shape."""
        return self.dtype.itemsize * math.prod(self.shape)


@dataclass(frozen=True)
class TensorFile:
    """The fields of a file, by name; values are read when asked for."""

    path: Path
    fields: dict[str, Field]

    def read(self, name: str, dtype: str, ndim: int) -> npt.NDArray[Any]:
        """Return the values of a field, which must be there, of this type and finite, below 1e30.

        Parameters
        ----------
        name : str
            The field.
        dtype : str
            Its type, such as "f4".
        ndim : int
            How many dimensions it must have.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If there is no such field, or it is of another kind, empty, too large or not finite.
        """
        if name not in self.fields:
            raise ValueError(f"{self.path}: has no field {name!r}, only {', '.join(self.fields)}")
        field = self.fields[name]
        if field.dtype != np.dtype(dtype) or len(field.shape) != ndim:
            raise ValueError(
                f"{self.path}: {name} must have {ndim} dimensions of type {dtype}, got {len(field.shape)} "
                f"of type {field.dtype.str[1:]}"
            )
        if not 0 < field.nbytes <= _LARGEST_FIELD:
            raise ValueError(
                f"{self.path}: {name} must have 1 to {_LARGEST_FIELD} bytes, got shape {field.shape}"
            )
        with self.path.open("rb") as file:
            file.seek(field.offset)
            data = file.read(field.nbytes)
        if len(data) < field.nbytes:  # it has become shorter since
            raise ValueError(f"{self.path}: is truncated within {name}")
        values = np.frombuffer(data, field.dtype.newbyteorder("<")).reshape(field.shape)
        if values.dtype.kind == "f" and (wrong := ~(np.abs(values) < _LARGEST)).any():  # NaN too
            raise ValueError(
                f"{self.path}: {name} must be finite and below {_LARGEST:g}, got {np.sum(wrong)} values that "
                f"are not, the first {values[wrong][0]:g}"
            )
        return values.astype(field.dtype, copy=False)


def open_tensor_file(path: Path) -> TensorFile:
    """Read the header of a file.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is no tensor file, is truncated, or its fields are absurd, overlap or leave the file.
    """
    with path.open("rb") as file:
        head = file.read(_LONGEST_HEADER)
        size = file.seek(0, 2)
    if not head.startswith(MAGIC):
        raise ValueError(f"{path}: is no tensor file, it starts with {head[:12]!r}")
    try:
        fields, end = _fields(head)
    except struct.error:
        where = "the header is truncated" if size <= len(head) else f"a header of over {len(head)} bytes"
        raise ValueError(f"{path}: {where}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    for name, field in sorted(fields.items(), key=lambda item: item[1].offset):
        if field.offset < end:
            raise ValueError(f"{path}: {name} starts at byte {field.offset}, within what ends at {end}")
        end = field.offset + field.nbytes
        if end > size:
            raise ValueError(
                f"{path}: {name}, shape {field.shape}, ends at byte {end}, but the file has {size}: "
                "it is truncated or damaged"
            )
    return TensorFile(path, fields)


def _fields(head: bytes) -> tuple[dict[str, Field], int]:
    """The fields that a header lists, and where it ends; struct.error where it is cut off."""
    *version, count = struct.unpack_from("<BBI", head, len(MAGIC))
    if version != [1, 0]:
        raise ValueError(f"must be a tensor file of version 1.0, got {version[0]}.{version[1]}")
    if count > _MOST_FIELDS:
        raise ValueError(f"must have at most {_MOST_FIELDS} fields, got {count}")
    fields: dict[str, Field] = {}
    at = len(MAGIC) + struct.calcsize("<BBI")
    for _ in range(count):
        (length,) = struct.unpack_from("<H", head, at)
        (raw,) = struct.unpack_from(f"{length}s", head, at + 2)
        at += 2 + length
        if not (raw.isascii() and (name := raw.decode("ascii")).isidentifier()):
            raise ValueError(f"the name of a field must be an ASCII identifier, got {raw[:32]!r}")
        if name in fields:
            raise ValueError(f"has two fields {name!r}")
        dimensions, kind, offset = struct.unpack_from("<HBQ", head, at)
        at += struct.calcsize("<HBQ")
        if dimensions > _MOST_DIMENSIONS:
            raise ValueError(f"{name} must have at most {_MOST_DIMENSIONS} dimensions, got {dimensions}")
        if not 1 <= kind <= len(_TYPES):
            raise ValueError(f"{name} must be of a type from 1 to {len(_TYPES)}, got {kind}")
        shape = struct.unpack_from(f"<{dimensions}Q", head, at)
        at += 8 * dimensions
        fields[name] = Field(np.dtype(_TYPES[kind - 1]), offset, shape)
    return fields, at
