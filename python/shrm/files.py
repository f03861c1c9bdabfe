"""Writing files whole or not at all, and reporting in one line what went wrong."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PathLike = str | os.PathLike[str]
"""A path to a file."""


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a new name in the same folder to write to; the file written there then takes the place of `path`.

    So `path` is the old file or the whole new one, even if the machine stops. Nothing is left under the new
    name, `.NAME.xxxxxxxx.part`, unless the process is killed.

    Raises
    ------
    OSError
        If the file cannot be written or renamed; it names `path`.
    """
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        yield beside
        descriptor = os.open(beside, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        os.replace(beside, path)
    except OSError as fault:
        if fault.errno is None:
            raise
        raise type(fault)(fault.errno, fault.strerror, str(path)) from None
    finally:
        with suppress(OSError):  # where it cannot even be named it is not there
            beside.unlink(missing_ok=True)


def write_bytes(path: Path, content: bytes | memoryview) -> None:
    """Write a file whole; see `replacing`."""
    with replacing(path) as beside:
        beside.write_bytes(content)


def one_line(fault: BaseException) -> str:
    """Describe a fault in one line; one of the operating system begins with the name of the file."""
    if isinstance(fault, OSError) and fault.filename is not None and fault.strerror:
        return f"{fault.filename}: {fault.strerror}"
    if isinstance(fault, MemoryError):
        return "not enough memory"
    return " ".join(str(fault).split()) or type(fault).__name__
