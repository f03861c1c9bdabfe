"""OpenGL contexts without a window: EGL, then OSMesa through GLFW, then a hidden window."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import moderngl

Route = Literal["egl", "osmesa", "window"]
ROUTES: tuple[Route, ...] = ("egl", "osmesa", "window")

VERSION = 330


class ContextError(RuntimeError):
    """No OpenGL context can be had; its text is one line that says what to install."""


@dataclass(frozen=True)
class Context:
    """An OpenGL context that is current.

    Attributes
    ----------
    gl : moderngl.Context
    route : {"egl", "osmesa", "window"}
        How it was made.
    window : object or None
        GLFW's window, if it belongs to one.
    """

    gl: moderngl.Context
    route: Route
    window: Any = None

    def activate(self) -> None:
        """Make it the one that OpenGL's calls go to."""
        if self.window is None:
            self.gl.mglo.__enter__()
        else:
            import glfw

            glfw.make_context_current(self.window)


def offscreen(routes: tuple[Route, ...] = ROUTES) -> Context:
    """Make a context that needs no display.

    Parameters
    ----------
    routes : sequence of {"egl", "osmesa", "window"}
        What to try, in this order. EGL draws on a GPU where there is one; Mesa 25 and later have no OSMesa.

    Raises
    ------
    ContextError
        If none of them works.
    """
    made: dict[Route, Callable[[], Context]] = {"egl": _egl, "osmesa": _osmesa, "window": _hidden_window}
    reasons = []
    for route in routes:
        try:
            return made[route]()
        except Exception as fault:  # each library has errors of its own
            reasons.append(f"{route}: {' '.join(str(fault).split())[:80]}")
    raise ContextError(
        "no OpenGL without a display: apt-get install libegl1 libgl1-mesa-dri (or libosmesa6) "
        f"({'; '.join(reasons)})"
    )


def _egl() -> Context:
    names: Any = {"backend": "egl", "libegl": "libEGL.so.1", "libgl": "libGL.so.1"}
    return Context(moderngl.create_context(standalone=True, require=VERSION, **names), "egl")


def _osmesa() -> Context:
    import glfw

    glfw.terminate()  # the platform is chosen when it is initialised
    glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_NULL)
    return _of_window(glfw.OSMESA_CONTEXT_API, "osmesa")


def _hidden_window() -> Context:
    import glfw

    glfw.terminate()
    glfw.init_hint(glfw.PLATFORM, glfw.ANY_PLATFORM)
    return _of_window(glfw.NATIVE_CONTEXT_API, "window")


def _of_window(api: int, route: Route) -> Context:
    import glfw

    if not glfw.init():
        raise ContextError(_glfw_says())
    for hint, value in context_hints(api).items():
        glfw.window_hint(hint, value)
    glfw.window_hint(glfw.VISIBLE, False)
    window = glfw.create_window(16, 16, "shrm", None, None)
    if not window:
        raise ContextError(_glfw_says())
    return attach(window, route)


def context_hints(api: int) -> dict[int, int]:
    """GLFW's window hints for a context of this package."""
    import glfw

    return {
        glfw.CONTEXT_CREATION_API: api,
        glfw.CONTEXT_VERSION_MAJOR: VERSION // 100,
        glfw.CONTEXT_VERSION_MINOR: VERSION % 100 // 10,
        glfw.OPENGL_PROFILE: glfw.OPENGL_CORE_PROFILE,
        glfw.OPENGL_FORWARD_COMPAT: int(api != glfw.OSMESA_CONTEXT_API),  # which OSMesa refuses
    }


def attach(window: Any, route: Route = "window") -> Context:
    """Take the OpenGL context of a GLFW window."""
    import glfw

    glfw.make_context_current(window)
    loader: Any = _Loader()
    return Context(moderngl.create_context(context=loader, require=VERSION), route, window)


class _Loader:
    """What moderngl asks for OpenGL's functions, answered by GLFW, whichever API made the context."""

    def load_opengl_function(self, name: str) -> int:
        import glfw

        address = glfw.get_proc_address(name)
        return (ctypes.cast(address, ctypes.c_void_p).value or 0) if address else 0

    load = load_opengl_function

    def __enter__(self) -> _Loader:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def release(self) -> None:
        """Nothing: the window owns the context."""


def _glfw_says() -> str:
    import glfw

    code, text = glfw.get_error()
    return (text or b"GLFW could not start").decode() if isinstance(text, bytes) else str(text or code)
