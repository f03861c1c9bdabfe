"""OpenGL contexts: without a window by EGL, OSMesa or a hidden window; or a window's.

EGL, GLX and OSMesa know nothing of each other, and GLX ends the process where EGL has a context that is
current: here every context is let go before another one is made or made current.
"""

from __future__ import annotations

import ctypes
import functools
import threading
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import moderngl

from shrm.viewer.gpu.osmesa import OSMesa

Route = Literal["egl", "osmesa", "window"]
ROUTES: tuple[Route, ...] = ("egl", "osmesa", "window")

VERSION = 330

_thread = threading.local()  # .current: the Context that OpenGL's calls of this thread go to


class ContextError(RuntimeError):
    """No OpenGL context can be had, or it was released; the text is one line."""


@dataclass(frozen=True, eq=False)
class Context:
    """An OpenGL context.

    Attributes
    ----------
    gl : moderngl.Context
    route : {"egl", "osmesa", "window"}
        How it was made.
    window : object or None
        GLFW's window, if it belongs to one.
    handle : int or None
        EGL's own name of it.
    """

    gl: moderngl.Context
    route: Route
    window: Any = None
    handle: int | None = None

    def __repr__(self) -> str:
        driver = "released" if self.released else str(self.gl.info["GL_RENDERER"])
        return f"<Context {self.route}: {driver}>"

    @property
    def released(self) -> bool:
        """Whether it was released."""
        return isinstance(self.gl.mglo, moderngl.InvalidObject)

    def activate(self) -> None:
        """Make it the one that OpenGL's calls of this thread go to.

        Raises
        ------
        ContextError
            If it was released.
        """
        if self.released:
            raise ContextError(f"the OpenGL context ({self.route}) was released: nothing can be drawn in it")
        if _current() is not self:
            leave()
        self.gl.mglo.__enter__()
        if self.route == "egl" and _egl_current() != self.handle:  # glcontext does not say so
            raise ContextError(
                "the OpenGL context (egl) cannot be made current: another thread draws in it, or another "
                "library's context is current in this one"
            )
        _thread.current = self

    def release(self) -> None:
        """Free it with all that is on the GPU, and close its window; further calls do nothing."""
        if self.released:
            return
        if _current() is self:
            leave()
        self.gl.release()


def leave() -> None:
    """Let go of the context that is current in this thread; it can be used again after `activate`."""
    current = _current()
    if current is not None:
        _thread.current = None
        if not current.released:  # in another thread, or by whoever took its moderngl context
            current.gl.mglo.__exit__(None, None, None)


def leave_framebuffers(gl: moderngl.Context) -> None:
    """Draw into none that was made: of one that is drawn into when it is freed, the next call is a fault."""
    (gl.screen or gl.detect_framebuffer(0)).use()


def _current() -> Context | None:
    return getattr(_thread, "current", None)


def offscreen(routes: tuple[Route, ...] = ROUTES) -> Context:
    """Make a context that needs no display; it is current then.

    Parameters
    ----------
    routes : sequence of {"egl", "osmesa", "window"}
        What to try, in this order. EGL draws on a GPU where there is one; Mesa 25 and later have no OSMesa.

    Raises
    ------
    ContextError
        If none of them works.
    """
    makers: dict[Route, Callable[[], Context]] = {"egl": _egl, "osmesa": _osmesa, "window": _hidden_window}
    reasons = []
    for route in routes:
        leave()
        try:
            return makers[route]()
        except Exception as fault:  # each library has errors of its own
            reasons.append(f"{route}: {' '.join(str(fault).split())[:80]}")
    raise ContextError(
        "no OpenGL without a display: apt-get install libegl1 libgl1-mesa-dri (or libosmesa6) "
        f"({'; '.join(reasons)})"
    )


def _egl() -> Context:
    names: Any = {"backend": "egl", "libegl": "libEGL.so.1", "libgl": "libGL.so.1"}
    gl = moderngl.create_context(standalone=True, require=VERSION, **names)
    context = Context(gl, "egl", handle=_egl_current())
    _thread.current = context
    return context


def _egl_current() -> int | None:
    """EGL's name of the context that is current in this thread."""
    name: int | None = _egl_get_current_context()()
    return name


@functools.cache
def _egl_get_current_context() -> Any:
    function = ctypes.CDLL("libEGL.so.1").eglGetCurrentContext
    function.restype = ctypes.c_void_p
    return function


def _osmesa() -> Context:
    return _taken(OSMesa(VERSION), "osmesa")


def _hidden_window() -> Context:
    return of_window((16, 16), "shrm", visible=False)


def of_window(shape: tuple[int, int], title: str, *, visible: bool) -> Context:
    """Open a window of a shape (H, W) and take its OpenGL context; it is current then.

    Raises
    ------
    ContextError
        If GLFW cannot open one.
    """
    import glfw

    leave()  # GLFW makes the new one current
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW's own: the error says it
        if not glfw.init():
            raise ContextError(_glfw_says())
        glfw.default_window_hints()
        glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, VERSION // 100)
        glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, VERSION % 100 // 10)
        glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
        glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, True)
        glfw.window_hint(glfw.VISIBLE, visible)
        window = glfw.create_window(shape[1], shape[0], title, None, None)
        if not window:
            raise ContextError(_glfw_says())
    return _taken(_Window(window), "window", window)


class _Window:
    """A GLFW window's context, with the methods by which moderngl asks for functions and makes it current."""

    def __init__(self, window: Any) -> None:
        self._window = window

    def load_opengl_function(self, name: str) -> int:
        import glfw

        address = glfw.get_proc_address(name)
        return (ctypes.cast(address, ctypes.c_void_p).value or 0) if address else 0

    load = load_opengl_function

    def __enter__(self) -> _Window:
        import glfw

        glfw.make_context_current(self._window)
        return self

    def __exit__(self, *_: object) -> None:
        import glfw

        none: Any = None
        glfw.make_context_current(none)

    def release(self) -> None:
        """Close the window, which owns the context."""
        import glfw

        glfw.destroy_window(self._window)


def _taken(maker: OSMesa | _Window, route: Route, window: Any = None) -> Context:
    """Make current what was made, and give it to moderngl."""
    loader: Any = maker
    maker.__enter__()
    try:
        context = Context(moderngl.create_context(context=loader, require=VERSION), route, window)
    except Exception:
        maker.__exit__()
        maker.release()
        raise
    _thread.current = context
    return context


def _glfw_says() -> str:
    import glfw

    code, text = glfw.get_error()
    return (text or b"GLFW could not start").decode() if isinstance(text, bytes) else str(text or code)
