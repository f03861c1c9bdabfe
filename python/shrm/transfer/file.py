"""Transfer in one file, `.shrt`, whose arrays are mapped into memory and not read.

All numbers are little-endian, all arrays in C order.

    bytes     type        what
    0 to 7    8 bytes     magic: 89 'S' 'H' 'R' 'T' 0D 0A 1A (hexadecimal; letters are ASCII)
    8 to 11   uint32      version: 1
    12 to 15  uint32      length of the header text, at most 2^24
    16 to 23  uint64      total size of the file
    24 to 27  uint32      CRC-32 (zlib) of bytes 0 to 23 and of the header text
    28 to 31  uint32      0
    32 ...    UTF-8       header text: JSON, below, without NaN and infinities
    D ...     arrays      each at the first multiple of 64 after what is before it, zeros between; D is the
                          first multiple of 64 after the header text; the file ends with the last array

The header is an object with

    n, M, channels        whole numbers: order of the light, tents along a side, 1 or 3
    material, report      text; an object with whatever its maker says
    arrays                a list, in the order in which they lie, of objects: name; dtype, "<f4", "<f2" or
                          "<i4"; shape; offset from D; size in bytes; crc32, 8 hexadecimal digits

and the arrays are, V vertices and T faces,

    vertices <f4 (V, 3)     faces <i4 (T, 3)     uv <f4 (V, 2), maybe
    quaternions <f4 (V, 4)  frames, w x y z, of length 1 to 1e-5
    NAME/weights            <f4 or <f2 (V, K)
    NAME/components         <f4 or <f2 (K, M^2, channels, n^2); with clusters (Q, K, M^2, channels, n^2)
    NAME/clusters           <i4 (V,)
    NAME/matrices           <f4 or <f2 (V, M^2, channels, n^2)

where NAME is one of "unshadowed", "shadowed", "interreflected", and has weights and components, or matrices,
or both. Matrices are M^2 tents (index j M + i) from light in the real basis of `shrm.sh`, index l(l+1)+m, in
global coordinates; z is up, see DirectionalBasis for the tents.
"""

from __future__ import annotations

import json
import math
import os
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, Int32Array
from shrm.files import PathLike, replacing
from shrm.transfer.described import Described
from shrm.transfer.quaternions import from_rotations, to_rotations
from shrm.transfer.variant import Variant

Array = npt.NDArray[Any]

MAGIC = b"\x89SHRT\r\n\x1a"
"""The first bytes of a file, which text modes and seven bits would damage."""

VERSION = 1
"""The version of the format that is written and read."""

LONGEST_HEADER = 1 << 24
"""Bytes of the longest header: those of a file that says more are damaged, and are not read."""

_FIXED = struct.Struct("<8sIIQ")
"""The magic, the version, the header's length and the file's size, at the start of a file."""

_CHECK = struct.Struct("<II")
"""The checksum, and zeros, after those."""

_ALIGNMENT = 64
"""Bytes to whose multiples arrays are aligned: a line of the caches."""

_BLOCK_BYTES = 1 << 26
"""Bytes of an array that are copied at once."""

_DTYPES = {
    "vertices": ("<f4",),
    "faces": ("<i4",),
    "quaternions": ("<f4",),
    "uv": ("<f4",),
    "weights": ("<f4", "<f2"),
    "components": ("<f4", "<f2"),
    "clusters": ("<i4",),
    "matrices": ("<f4", "<f2"),
}
"""What arrays may be made of, by the last part of their names."""


class TransferFileError(ValueError):
    """Error of a transfer file that cannot be read or written: its name and the fault, in one line."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Saved(Described):
    """Content of a file: the fields of `shrm.transfer.RadianceTransfer`, as they are read.

    What the arrays must be to fit each other is for that class to check.
    """

    shown = ("vertices", "faces", "n", "M", "channels", "variants", "material")

    vertices: Float32Array
    faces: Int32Array
    frames: Float32Array
    n: int
    M: int
    channels: int
    variants: dict[str, Variant]
    uv: Float32Array | None = None
    material: str = ""
    report: dict[str, Any] = field(default_factory=dict)


def write(path: PathLike, saved: Saved) -> None:
    """Write what a file holds; the file appears whole or not at all.

    Parameters
    ----------
    path : path
        Name of the file, by custom with the extension `.shrt`.
    saved : Saved
        Matrices that are mapped from disk are copied a part at a time.

    Raises
    ------
    TransferFileError
        If the file cannot be written.
    ValueError
        If the report holds what JSON does not.
    """
    path = Path(path)
    try:
        with replacing(path) as beside, beside.open("xb") as file:
            _write(file, saved)
    except OSError as error:
        raise TransferFileError(f"{path}: cannot be written ({error.strerror or error})") from None


def read(path: PathLike, *, verify: bool = False) -> Saved:
    """Read what `write` wrote: arrays are read-only and mapped, frames alone are computed.

    Parameters
    ----------
    path : path
    verify : bool
        Whether to compare uncompressed matrices with their checksum too, which reads them whole.

    Raises
    ------
    TransferFileError
        If the file cannot be read, is cut short, damaged, or of another version.
    """
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise TransferFileError(f"{path}: is no file")
        header, data, start = _opened(path)
        return _saved(header, _arrays(header, data, start, verify))
    except OSError as error:
        raise TransferFileError(f"{path}: cannot be read ({error.strerror or error})") from None
    except TransferFileError:
        raise
    except _ContentError as fault:
        raise TransferFileError(f"{path}: {fault}") from None
    except (KeyError, ValueError, TypeError, OverflowError, RecursionError) as fault:
        raise damaged(path, fault) from fault


def damaged(path: PathLike, fault: Exception) -> TransferFileError:
    """Return the error of a file whose content a fault shows to be damaged, in one line."""
    text = " ".join(str(fault).split())
    return TransferFileError(f"{path}: damaged transfer file ({text[:150]})")


class _ContentError(ValueError):
    """Fault of a file whose name is not known here."""


# ---- Writing


def _write(file: BinaryIO, saved: Saved) -> None:
    """Write the arrays, then the header before them, which has their checksums."""
    arrays = {
        name: array.astype(array.dtype.newbyteorder("<"), copy=False)
        for name, array in _named_arrays(saved).items()
    }

    # Where each array lies
    entries: list[dict[str, Any]] = []
    end = 0
    for name, array in arrays.items():
        offset = _aligned(end)
        entries.append(
            {
                "name": name,
                "dtype": array.dtype.str,
                "shape": list(array.shape),
                "offset": offset,
                "size": array.nbytes,
                "crc32": "0" * 8,
            }
        )
        end = offset + array.nbytes
    header = {
        "n": saved.n,
        "M": saved.M,
        "channels": saved.channels,
        "material": saved.material,
        "report": saved.report,
        "arrays": entries,
    }
    length = len(_text(header))
    if length > LONGEST_HEADER:
        raise ValueError(f"report must fit in a header of {LONGEST_HEADER} bytes, got {length} in all")

    # The arrays, whose checksums are as long as the zeros that they replace
    start = _aligned(_FIXED.size + _CHECK.size + length)
    for entry, array in zip(entries, arrays.values(), strict=True):
        file.seek(start + entry["offset"])
        entry["crc32"] = f"{_write_array(file, array):08x}"

    # The header
    text = _text(header)
    fixed = _FIXED.pack(MAGIC, VERSION, length, start + end)
    file.seek(0)
    file.write(fixed + _CHECK.pack(zlib.crc32(text, zlib.crc32(fixed)), 0) + text)
    file.flush()
    os.fsync(file.fileno())


def _named_arrays(saved: Saved) -> dict[str, Array]:
    """Return the arrays of a file by their names, in the order in which they lie."""
    arrays: dict[str, Array | None] = {
        "vertices": saved.vertices,
        "faces": saved.faces,
        "quaternions": from_rotations(saved.frames).astype(np.float32),
        "uv": saved.uv,
    }
    for name, variant in saved.variants.items():
        arrays[f"{name}/weights"] = variant.weights
        arrays[f"{name}/components"] = variant.components
        arrays[f"{name}/clusters"] = variant.clusters
        arrays[f"{name}/matrices"] = variant.matrices
    return {name: array for name, array in arrays.items() if array is not None}


def _write_array(file: BinaryIO, array: Array) -> int:
    """Write an array part by part, so that a mapped one is never in memory; return its checksum."""
    rows = max(1, _BLOCK_BYTES // max(1, array[:1].nbytes))
    crc = 0
    for start in range(0, len(array), rows):
        content = np.ascontiguousarray(array[start : start + rows]).data.cast("B")
        crc = zlib.crc32(content, crc)
        file.write(content)
    return crc


def _text(header: Mapping[str, Any]) -> bytes:
    """Return the header as JSON."""
    try:
        return json.dumps(header, allow_nan=False, separators=(",", ":")).encode()
    except (TypeError, ValueError) as fault:
        raise ValueError(f"report must hold text, finite numbers, lists and dicts ({fault})") from None


def _aligned(end: int) -> int:
    """Return the first multiple of the alignment from here on."""
    return -(-end // _ALIGNMENT) * _ALIGNMENT


# ---- Reading


def _opened(path: Path) -> tuple[dict[str, Any], npt.NDArray[np.uint8], int]:
    """Return the header, the file as mapped bytes, and where its arrays start; check all but those."""
    # The sizes, which must be those of the file
    actual = path.stat().st_size
    with path.open("rb") as file:
        fixed = file.read(_FIXED.size)
        if fixed[: len(MAGIC)] != MAGIC[: len(fixed)] or not fixed:
            raise _ContentError("is not a transfer file")
        check = file.read(_CHECK.size)
        if len(check) < _CHECK.size:
            raise _ContentError(f"is cut short: {actual} bytes")
        _, version, length, total = _FIXED.unpack(fixed)
        if version != VERSION:
            raise _ContentError(f"is a transfer file of version {version}, this reads version {VERSION}")
        if actual < total:
            raise _ContentError(f"is cut short: {actual} bytes of {total}")
        if length > LONGEST_HEADER or actual != total:
            raise _ContentError(
                f"damaged transfer file (a header of {length} bytes, {total} in all of {actual})"
            )
        text = file.read(length)

    # The text, which must be that of the checksum
    crc, zero = _CHECK.unpack(check)
    if len(text) != length or zero or crc != zlib.crc32(text, zlib.crc32(fixed)):
        raise _ContentError("damaged transfer file (the header's checksum does not match)")
    header = json.loads(text, parse_constant=_not_finite, parse_float=_finite)
    if not isinstance(header, dict):
        raise ValueError("the header is no object")
    return header, np.memmap(path, np.uint8, "r"), _aligned(_FIXED.size + _CHECK.size + length)


def _arrays(
    header: Mapping[str, Any], data: npt.NDArray[np.uint8], start: int, verify: bool
) -> dict[str, Array]:
    """Return the arrays by their names, mapped; they must lie one after the other as the header says."""
    arrays: dict[str, Array] = {}
    end = 0
    for entry in header["arrays"]:
        # What it is
        name, dtype, shape = str(entry["name"]), entry["dtype"], entry["shape"]
        if name in arrays or dtype not in _DTYPES.get(name.rpartition("/")[2], ()):
            raise ValueError(f"array {name!r} of type {dtype!r}")
        if not isinstance(shape, list) or len(shape) > 5 or not all(_whole(s, 1, len(data)) for s in shape):
            raise ValueError(f"{name} of shape {shape}")

        # Where it lies
        offset, size = _aligned(end), math.prod(shape) * np.dtype(dtype).itemsize
        end = offset + size
        if entry["offset"] != offset or entry["size"] != size or start + end > len(data):
            raise ValueError(f"{name} of {entry['size']} bytes at {entry['offset']}, {size} at {offset} fit")

        # What it holds; uncompressed matrices may be too large to be read for that
        content = data[start + offset : start + end]
        if (verify or not name.endswith("/matrices")) and f"{zlib.crc32(content.data):08x}" != entry["crc32"]:
            raise ValueError(f"the checksum of {name} does not match")
        arrays[name] = np.asarray(content).view(dtype).reshape(shape)
    if start + end != len(data):
        raise ValueError(f"{len(data)} bytes, of which {start + end} are used")
    return arrays


def _saved(header: Mapping[str, Any], arrays: dict[str, Array]) -> Saved:
    """Return the content of a file from its header and arrays."""
    material, report = header["material"], header["report"]
    if not isinstance(material, str) or not isinstance(report, dict):
        raise ValueError("material is no text, or report no object")

    # The frames
    quaternions = arrays.pop("quaternions")
    if quaternions.ndim != 2 or quaternions.shape[1] != 4:
        raise ValueError(f"quaternions of shape {quaternions.shape}")
    lengths = np.linalg.norm(quaternions, axis=1)
    if not (np.abs(lengths - 1) < 1e-5).all():
        raise ValueError("quaternions that are not of length 1")

    # The mesh; what is left are the variants'
    vertices, faces, uv = arrays.pop("vertices"), arrays.pop("faces"), arrays.pop("uv", None)
    variants: dict[str, dict[str, Array]] = {}
    for name, array in arrays.items():
        variant, _, what = name.rpartition("/")
        variants.setdefault(variant, {})[what] = array
    return Saved(
        vertices=vertices,
        faces=faces,
        frames=to_rotations(quaternions).astype(np.float32),
        n=header["n"],
        M=header["M"],
        channels=header["channels"],
        variants={name: Variant(**parts) for name, parts in variants.items()},
        uv=uv,
        material=material,
        report=report,
    )


def _whole(value: object, least: int, most: int) -> bool:
    """Tell whether a value is a whole number in [least, most]."""
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def _not_finite(text: str) -> NoReturn:
    """Refuse NaN and infinities, which Python's JSON knows and JSON does not."""
    raise ValueError(f"the header has the number {text}")


def _finite(text: str) -> float:
    """Read a number; refuse one that overflows."""
    value = float(text)
    return value if math.isfinite(value) else _not_finite(text)
