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
_MOST_FIELDS = 64  # five times as many as the files of the database have
_MOST_DIMENSIONS = 8  # their fields have at most 5
_LONGEST_HEADER = 1 << 16  # bytes; theirs are below 4 KiB
_LARGEST = 1e30  # of floating point values: sums of them hold in float32
_LARGEST_FIELD = 1 << 26  # bytes; ten times the largest of an isotropic material of the database


@dataclass(frozen=True)
class Field:
    """The place of an array in its file, and its type and shape."""

    dtype: np.dtype[Any]
    offset: int
    shape: tuple[int, ...]

    @property
    def nbytes(self) -> int:
        """Size in bytes; exact, however large the shape."""
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
        # The field, as its type and size are declared
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

        # Its values
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
    # The header
    with path.open("rb") as file:
        head = file.read(_LONGEST_HEADER)
        size = file.seek(0, 2)
    if not head.startswith(MAGIC):
        raise ValueError(f"{path}: is no tensor file, it starts with {head[:12]!r}")
    try:
        fields, end = _fields(head)
    except struct.error:
        fault = "the header is truncated" if size <= len(head) else f"a header of over {len(head)} bytes"
        raise ValueError(f"{path}: {fault}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None

    # Fields lie one after another behind it, within the file.
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
    """Return the fields that a header lists, and its length, bytes; struct.error where it is cut off."""
    *version, count = struct.unpack_from("<BBI", head, len(MAGIC))
    if version != [1, 0]:
        raise ValueError(f"must be a tensor file of version 1.0, got {version[0]}.{version[1]}")
    if count > _MOST_FIELDS:
        raise ValueError(f"must have at most {_MOST_FIELDS} fields, got {count}")

    fields: dict[str, Field] = {}
    offset_in_head = len(MAGIC) + struct.calcsize("<BBI")
    for _ in range(count):
        # The name
        (length,) = struct.unpack_from("<H", head, offset_in_head)
        (raw,) = struct.unpack_from(f"{length}s", head, offset_in_head + 2)
        offset_in_head += 2 + length
        if not (raw.isascii() and (name := raw.decode("ascii")).isidentifier()):
            raise ValueError(f"the name of a field must be an ASCII identifier, got {raw[:32]!r}")
        if name in fields:
            raise ValueError(f"has two fields {name!r}")

        # Type, shape and place
        dimensions, kind, offset = struct.unpack_from("<HBQ", head, offset_in_head)
        offset_in_head += struct.calcsize("<HBQ")
        if dimensions > _MOST_DIMENSIONS:
            raise ValueError(f"{name} must have at most {_MOST_DIMENSIONS} dimensions, got {dimensions}")
        if not 1 <= kind <= len(_TYPES):
            raise ValueError(f"{name} must be of a type from 1 to {len(_TYPES)}, got {kind}")
        shape = struct.unpack_from(f"<{dimensions}Q", head, offset_in_head)
        offset_in_head += 8 * dimensions
        fields[name] = Field(np.dtype(_TYPES[kind - 1]), offset, shape)
    return fields, offset_in_head
