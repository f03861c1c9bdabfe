"""Drives the window without a person: a display, what hands do, and what the window looks like then."""

import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import glfw
import numpy as np
import numpy.typing as npt
from OpenGL import GL
from shrm.image_io import write_image
from shrm.viewer.window.app import Application
from shrm.viewer.window.state import State
from shrm.viewer.window.widgets import WIDTH

from support.machine import require

SCREENSHOTS = Path(__file__).parents[2] / "build" / "screenshots"

SECONDS = 100.0
SHAPE = (240, WIDTH + 200)
WHOLE_PANEL = 900  # rows, so that no control is scrolled out of sight
MIDDLE = (WIDTH + 100.0, 120.0)
Pixels = npt.NDArray[np.uint8]


@contextmanager
def display() -> Iterator[None]:
    """Have a display: the one that is there, or one of our own that nobody sees."""
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        yield
        return
    server = shutil.which("Xvfb")
    require(server, "a display, or Xvfb to make one (apt-get install xvfb)")
    read, write = os.pipe()
    running = subprocess.Popen(
        [server, "-displayfd", str(write), "-screen", "0", "1280x960x24", "-nolisten", "tcp"],
        pass_fds=(write,),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
    with os.fdopen(read) as told:
        number = told.readline().strip()
    os.environ["DISPLAY"] = f":{number}"
    try:
        yield
    finally:
        glfw.terminate()
        del os.environ["DISPLAY"]
        running.terminate()
        running.wait()


class Hands:
    """Drives an application as a person does, and looks at it.

    Attributes
    ----------
    app : Application
    seen : (H, W, 3) uint8 or None
        The whole window at the last look.
    """

    def __init__(self, app: Application) -> None:
        self.app = app
        self.seen: Pixels | None = None

    def settle(self) -> None:
        """Draw frames until nothing is on its way."""
        end = time.monotonic() + SECONDS
        quiet = 0
        while quiet < 3:
            assert time.monotonic() < end
            self.app.frame()
            glfw.poll_events()
            # What a worker answered before it fell silent is taken by the next of the quiet frames.
            comparing = self.app.state.shown != "maps" and self.app.comparison.worker.working
            busy = self.app.prefiltering.working or comparing or not self.app.screen.complete
            quiet = 0 if busy else quiet + 1
            if not quiet:
                time.sleep(0.005)
        assert GL.glGetError() == 0

    def look(self, *, whole: bool = False, away: bool = True) -> Pixels:
        """Return the window's pixels (H, W, 3) without the panel; with `away` the pointer leaves it first."""
        if away:  # an explanation of the control under it may lie over the picture
            self.app.on_cursor(WIDTH + 2.0, 2.0)
            self.app.draw()
        self.app.draw()
        width, height = glfw.get_framebuffer_size(self.app.window)
        GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, 0)
        GL.glReadBuffer(GL.GL_BACK)
        GL.glPixelStorei(GL.GL_PACK_ALIGNMENT, 1)
        content = GL.glReadPixels(0, 0, width, height, GL.GL_RGB, GL.GL_UNSIGNED_BYTE)
        pixels = np.frombuffer(content, np.uint8).reshape(height, width, 3)[::-1]
        glfw.swap_buffers(self.app.window)
        self.seen = np.array(pixels)
        left = WIDTH if self.app.panel_shown and not whole else 0
        return self.seen[:, left:]

    def drag(self, button: int, *path: tuple[float, float], mods: int = 0) -> None:
        """Press, move along points, release; a frame after each."""
        app = self.app
        app.on_cursor(*path[0])
        app.frame()
        app.on_mouse_button(button, glfw.PRESS, mods)
        for point in path:
            app.frame()
            app.on_cursor(*point)
        app.frame()
        app.on_mouse_button(button, glfw.RELEASE, mods)
        app.frame()

    def place(self, name: str, share: float = 0.5) -> tuple[float, float]:
        """A point of a control, at a share of its width."""
        x0, y0, x1, y1 = self.app.panel.widgets.places[name]
        return x0 + share * (x1 - x0), 0.5 * (y0 + y1)

    def click(self, name: str) -> None:
        self.drag(glfw.MOUSE_BUTTON_LEFT, self.place(name, 0.1))
        self.settle()

    def press(self, key: int, mods: int = 0) -> None:
        self.app.on_key(key, 0, glfw.PRESS, mods)
        self.app.on_key(key, 0, glfw.RELEASE, mods)
        self.settle()


Opened = Callable[..., Hands]


@contextmanager
def windows(sky: Path, folder: Path, test: str) -> Iterator[Opened]:
    """Open windows, which are closed afterwards; the last look at them stays in a file named by the test."""
    opened = []

    def open_(height: int = SHAPE[0], **changes: object) -> Hands:
        fields = {"environment": str(sky), "materials": ("ggx:0.4",), **changes}
        state = State(**fields)  # type: ignore[arg-type]
        hands = Hands(Application(state, (height, SHAPE[1]), visible=False, folder=folder))
        opened.append(hands)
        hands.settle()
        return hands

    try:
        yield open_
    finally:
        for hands in opened:
            if not hands.app.context.released:  # a test may have closed it
                hands.app.close()
            if hands.seen is not None:
                SCREENSHOTS.mkdir(parents=True, exist_ok=True)
                name = re.sub(r"[^\w.]+", "-", test).strip("-")  # without the brackets of parameters
                write_image(SCREENSHOTS / f"{name}.png", hands.seen)


def same(a: Pixels, b: Pixels) -> bool:
    return a.shape == b.shape and bool(np.array_equal(a, b))
