"""A window on the screen with an OpenGL context and the controls' library in it."""

from __future__ import annotations

from typing import Any, Protocol

import glfw
from slimgui import imgui
from slimgui.integrations import glfw as controls

from shrm.viewer.gpu.context import Context, ContextError, of_window

NO_WINDOW = (
    "no window can be opened: set DISPLAY to a screen with OpenGL (apt-get install libgl1 libgl1-mesa-dri), "
    "or draw without one by shrm render --gpu"
)


class Listener(Protocol):
    """What happens in the window; positions in its units, y down from the top."""

    def on_mouse_button(self, button: int, action: int, mods: int) -> None:
        """A button was pressed or released."""

    def on_cursor(self, x: float, y: float) -> None:
        """The pointer moved."""

    def on_scroll(self, dx: float, dy: float) -> None:
        """The wheel turned."""

    def on_key(self, key: int, scancode: int, action: int, mods: int) -> None:
        """A key was pressed or released."""

    def on_char(self, char: int) -> None:
        """A character was typed."""

    def on_drop(self, paths: list[str]) -> None:
        """Files were dropped."""

    def on_resize(self, width: int, height: int) -> None:
        """The window's picture has another size, in pixels."""


def open_window(shape: tuple[int, int], title: str, visible: bool) -> Context:
    """Open a window of a shape (H, W) and take its OpenGL context.

    Raises
    ------
    ContextError
        If there is no display or no OpenGL on it; the text is one line.
    """
    try:
        return of_window(shape, title, visible=visible)
    except ContextError:
        raise ContextError(NO_WINDOW) from None


def listen(window: Any, listener: Listener) -> None:
    """Tell a listener what happens in a window."""
    glfw.set_mouse_button_callback(window, lambda _, *happened: listener.on_mouse_button(*happened))
    glfw.set_cursor_pos_callback(window, lambda _, *happened: listener.on_cursor(*happened))
    glfw.set_scroll_callback(window, lambda _, *happened: listener.on_scroll(*happened))
    glfw.set_key_callback(window, lambda _, *happened: listener.on_key(*happened))
    glfw.set_char_callback(window, lambda _, *happened: listener.on_char(*happened))
    glfw.set_drop_callback(window, lambda _, *happened: listener.on_drop(*happened))
    glfw.set_framebuffer_size_callback(window, lambda _, *happened: listener.on_resize(*happened))


class Controls:
    """The library that draws the panel, in one window."""

    def __init__(self, window: Any) -> None:
        self._window = window
        self._platform: Any
        self._context = imgui.create_context()
        imgui.set_current_context(self._context)
        self.io = imgui.get_io()
        self.io.ini_filename = None  # no file of positions in the current folder
        make: Any = controls.GlfwRenderer
        self._platform = make(window, attach_callbacks=False)

    def begin(self) -> None:
        """Begin a frame."""
        imgui.set_current_context(self._context)
        self._platform.new_frame()
        new_frame: Any = imgui.new_frame
        new_frame()

    def end(self) -> None:
        """End it; `draw` can follow."""
        imgui.render()

    def draw(self) -> None:
        """Draw the last frame into the window."""
        self._platform.render(imgui.get_draw_data())

    def on_mouse_button(self, button: int, action: int, mods: int) -> None:
        """A button was pressed or released."""
        self._platform.mouse_button_callback(self._window, button, action, mods)

    def on_cursor(self, x: float, y: float) -> None:
        """The pointer moved."""
        self._platform.mouse_pos_callback(self._window, x, y)

    def on_scroll(self, dx: float, dy: float) -> None:
        """The wheel turned."""
        self._platform.scroll_callback(self._window, dx, dy)

    def on_key(self, key: int, scancode: int, action: int, mods: int) -> None:
        """A key was pressed or released."""
        self._platform.keyboard_callback(self._window, key, scancode, action, mods)

    def on_char(self, char: int) -> None:
        """A character was typed."""
        self._platform.char_callback(self._window, char)

    def close(self) -> None:
        """Free what it holds on the GPU."""
        imgui.set_current_context(self._context)
        self._platform.shutdown()
        imgui.destroy_context(self._context)
