"""OpenGL by Mesa's off-screen library, which draws into memory and needs neither display nor GPU."""

from __future__ import annotations

import ctypes
import functools
from typing import Any

LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6")
SIDE = 16  # of the picture that belongs to it; what is drawn goes elsewhere

# Names of osmesa.h and gl.h.
RGBA, UNSIGNED_BYTE = 0x1908, 0x1401
FORMAT, PROFILE, CORE_PROFILE, MAJOR_VERSION, MINOR_VERSION = 0x22, 0x33, 0x34, 0x36, 0x37


class OSMesa:
    """A context, with the methods by which moderngl asks for functions and makes it current.

    Parameters
    ----------
    version : int
        Of OpenGL, 330 for 3.3.

    Raises
    ------
    OSError
        If there is no such library, as with Mesa 25 and later.
    RuntimeError
        If it has no OpenGL of this version.
    """

    def __init__(self, version: int) -> None:
        self._library = _load()
        attributes = {
            FORMAT: RGBA,
            PROFILE: CORE_PROFILE,
            MAJOR_VERSION: version // 100,
            MINOR_VERSION: version % 100 // 10,
        }
        flat = [number for pair in attributes.items() for number in pair]
        self._context = self._library.OSMesaCreateContextAttribs((ctypes.c_int * 9)(*flat), None)
        if not self._context:
            raise RuntimeError(f"OSMesa has no OpenGL {version / 100:.1f}")
        self._picture = ctypes.create_string_buffer(4 * SIDE * SIDE)

    def load_opengl_function(self, name: str) -> int:
        """Return the address of one of OpenGL's functions, 0 if there is none."""
        return self._library.OSMesaGetProcAddress(name.encode()) or 0

    load = load_opengl_function

    def __enter__(self) -> OSMesa:
        if not self._library.OSMesaMakeCurrent(self._context, self._picture, UNSIGNED_BYTE, SIDE, SIDE):
            raise RuntimeError("OSMesa cannot make its context current")
        return self

    def __exit__(self, *_: object) -> None:
        self._library.OSMesaMakeCurrent(None, None, UNSIGNED_BYTE, 0, 0)

    def release(self) -> None:
        """Destroy it."""
        self._library.OSMesaDestroyContext(self._context)


@functools.cache
def _load() -> Any:
    for name in LIBRARIES:
        try:
            library = ctypes.CDLL(name)
        except OSError:
            continue
        pointer, number = ctypes.c_void_p, ctypes.c_int
        for function, result, arguments in (
            ("OSMesaCreateContextAttribs", pointer, [pointer, pointer]),
            ("OSMesaMakeCurrent", ctypes.c_ubyte, [pointer, pointer, ctypes.c_uint, number, number]),
            ("OSMesaGetProcAddress", pointer, [ctypes.c_char_p]),
            ("OSMesaDestroyContext", None, [pointer]),
        ):
            entry = getattr(library, function)
            entry.restype, entry.argtypes = result, arguments
        return library
    raise OSError(f"there is no {' or '.join(LIBRARIES)}")
