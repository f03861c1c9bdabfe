"""The interactive window: what its events do to the state, and a frame."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import glfw

from shrm.files import PathLike, one_line
from shrm.render.tonemap import automatic_exposure
from shrm.viewer.gpu.renderer import Renderer
from shrm.viewer.window.choices import Action
from shrm.viewer.window.comparison import Comparison, question_of
from shrm.viewer.window.drag import Drag, begun, dragged
from shrm.viewer.window.drawing import Drawing, Faults
from shrm.viewer.window.keys import draw_keys
from shrm.viewer.window.opening import with_file
from shrm.viewer.window.orbit import spun_light
from shrm.viewer.window.panel import Facts, Panel
from shrm.viewer.window.prefiltering import PrefilteredScene, Prefiltering, Request
from shrm.viewer.window.relit import Choice
from shrm.viewer.window.screen import Screen
from shrm.viewer.window.screenshot import save_screenshot
from shrm.viewer.window.shortcuts import ACTIONS, QUIET, WITH_CONTROL, keyed
from shrm.viewer.window.state import State
from shrm.viewer.window.widgets import WIDTH
from shrm.viewer.window.window import Controls, listen, open_window
from shrm.viewer.window.worker import Worker

TITLE = "shrm: environment maps in frequency space"
STATE_FILE = "shrm-view.json"


class Application:
    """A window and everything in it.

    Parameters
    ----------
    state : State
    shape : (H, W)
        Rows and columns of the window, the panel included.
    visible : bool
        Whether it appears on the screen.
    folder : path
        Where screenshots go.
    state_file : path
        What is saved and opened by keys.

    Attributes
    ----------
    state : State
    result : PrefilteredScene or None
        What is drawn.
    fault : str
        The line that the panel shows in red.
    clock : callable
        The seconds by which light turns by itself.

    Raises
    ------
    ContextError
        If no window can be opened.
    """

    def __init__(
        self,
        state: State,
        shape: tuple[int, int] = (900, 1280),
        *,
        visible: bool = True,
        folder: PathLike = ".",
        state_file: PathLike | None = None,
    ) -> None:
        self.state = state
        self.folder = Path(folder)
        self.state_file = self.folder / STATE_FILE if state_file is None else Path(state_file)
        self.context = open_window(shape, TITLE, visible)
        self.window = self.context.window
        self.renderer = Renderer((16, 16), context=self.context)
        self.panel_shown, self.keys_shown = True, False
        self.screen = Screen(self.context.gl, self._picture_shape(least=1))
        self.drawing = Drawing(self.renderer, self.screen)
        self.controls = Controls(self.window)
        self.panel = Panel()
        self.prefiltering: Worker[Request, PrefilteredScene] = Worker(Prefiltering(), glfw.post_empty_event)
        self.comparison = Comparison(glfw.post_empty_event)
        self.result: PrefilteredScene | None = None
        self.fault = self.done = self.refused = ""
        self._asked: Request | None = None
        self._expose = self._fit = False
        self._keep_eye = True  # a state that was read says where from its objects are seen
        self._frame_seconds = 0.0
        self.clock: Callable[[], float] = time.perf_counter
        self._turned_at: float | None = None  # by the clock, while the light turns by itself
        self._cursor = (0.0, 0.0)
        self._drag: Drag | None = None
        self._lively = 3  # frames to be drawn though nothing happens: the panel needs some to settle
        listen(self.window, self)

    # ---- Frames

    def run(self) -> None:
        """Draw frames until the window is closed.

        Raises
        ------
        OSError, ValueError, RuntimeError, MemoryError
            If there is nothing to draw: the first light, material or mesh is at fault.
        """
        while not glfw.window_should_close(self.window):
            self.frame()
            self._lively = max(0, self._lively - 1)
            visible = min(self._picture_shape()) > 0
            sampling = visible and self.result is not None and not self.screen.complete
            if self._lively or sampling or self.state.turning:
                glfw.poll_events()
            else:  # until something happens, or a worker has something
                over_panel = self.controls.io.want_capture_mouse  # whose explanations come after a while
                glfw.wait_events_timeout(0.2 if over_panel else 1.0)

    def frame(self) -> None:
        """Take what the workers have, draw, and show it."""
        self.draw()
        glfw.swap_buffers(self.window)

    def draw(self) -> None:
        """Draw a frame that is not shown yet."""
        self.context.activate()
        self._take()
        self._turn()
        start = time.perf_counter()
        sampled = self._draw_picture()
        self._draw_controls()
        self.context.gl.screen.clear(0.1, 0.1, 0.1)
        if self.result is not None:
            self.screen.display(self.context.gl.screen, self._panel_pixels(), self.state.exposure)
        self.controls.draw()
        self.context.gl.finish()
        if sampled:
            self._frame_seconds = time.perf_counter() - start
        self._ask()

    def close(self) -> None:
        """End the workers, free what is on the GPU, close the window."""
        self.prefiltering.close()
        self.comparison.worker.close()
        self.context.activate()
        self.controls.close()
        self.screen.release()
        self.drawing.filtered.release()
        self.renderer.release()
        self.context.release()

    def _ask(self) -> None:
        """Ask for maps if the state wants others than those asked for last."""
        request, asked = Request.of(self.state), self._asked
        if request == asked:
            return
        light_only = asked is not None and request == replace(asked, light=request.light)
        if light_only and self.state.turning and self.prefiltering.working:
            return  # light that turns by itself must not outrun its maps: these are drawn first
        self._asked = request
        self.prefiltering.submit(request)

    def _turn(self) -> None:
        """Turn the light on by the time that has passed since the last frame, if it turns by itself."""
        now = self.clock() if self.state.turning else None
        if now is not None and self._turned_at is not None:
            self.state = self.state.with_light(spun_light(self.state.R, now - self._turned_at))
        self._turned_at = now

    def _take(self) -> None:
        """Take newer maps, or the fault that there is instead."""
        try:
            result = self.prefiltering.take()
        except Faults as fault:
            if self.result is None:
                raise
            self._say_fault(one_line(fault))
            self._refuse(self.result.request)
            return
        if result is None:
            return
        last, self.result = self.result, result
        if last is None or last.source != result.source:
            self.fault = self.refused = ""
            self._expose = not self._keep_eye or self.state.eye is None  # a state that was read says it
        self._lively = 3
        if last is None or last.placing != result.placing:
            self._fit = not self._keep_eye
        if result.request == self._asked:
            self._keep_eye = False

    def _refuse(self, request: Request) -> None:
        """Return to what is drawn; what turned or moved meanwhile stays."""
        if self._asked is not None and self._asked.environment != request.environment:
            self.refused = self._asked.environment
        self.state = replace(
            self.state,
            **{item.name: getattr(request, item.name) for item in fields(request) if item.name != "light"},
            selected=min(self.state.selected, len(request.materials) - 1),
        )
        self._asked = Request.of(self.state)
        if self.state.light != request.light:
            self._asked = None

    def _draw_picture(self) -> bool:
        """Draw linear radiance, or a further sample of it until there are enough; whether it was."""
        result = self.result
        shape = self._picture_shape()
        if result is None or min(shape) < 1:
            return False
        self.state = self.drawing.sample(result, self.state, shape, self._fit)
        self._fit = False
        if self.drawing.fault:
            self._say_fault(self.drawing.fault)
        self._show(result, shape)
        if self._expose and self.state.automatic:
            picture = self.screen.drawn_picture()
            stops = automatic_exposure(picture.radiance, picture.coverage)
            self.state = replace(self.state, exposure=round(stops, 2))
        self._expose = False
        return self.drawing.sampled

    def _draw_controls(self) -> None:
        width, height = glfw.get_window_size(self.window)
        self.controls.begin()
        actions: list[Action] = []
        if self.panel_shown:
            facts = Facts(
                self.result,
                self.prefiltering.working,
                self._frame_seconds,
                self.fault,
                self.done,
                self.refused,
                "" if self.state.shown == "maps" else self.comparison.says,
                self.drawing.relit.seconds,
            )
            before = self.state
            self.state, actions = self.panel.draw(self.state, facts, height)
            self._expose |= self.state.automatic and not before.automatic
            if self.state != before:
                self.fault = self.done = ""
        if self.keys_shown:
            left = WIDTH if self.panel_shown else 0
            draw_keys(left, width - left, height)
        self.controls.end()
        for action in actions:
            self.act(action)

    def _show(self, result: PrefilteredScene, shape: tuple[int, int]) -> None:
        """Choose what is shown of what was drawn."""
        if self.state.shown == "maps" or self.state.eye is None:
            self.screen.show_drawn()
            return
        question = question_of(result, self.state, self.state.eye.camera, shape)
        try:
            self.comparison.show(question, self.state.shown == "difference", self.screen, self.drawing.seen)
        except Faults as fault:
            self._say_fault(one_line(fault))
            self.state = replace(self.state, shown="maps")
            self.screen.show_drawn()

    # ---- What happens in the window

    def on_mouse_button(self, button: int, action: int, mods: int) -> None:
        """A button was pressed or released."""
        self._lively = 3
        self.controls.on_mouse_button(button, action, mods)
        if action == glfw.RELEASE:
            self._drag = None
        elif self._over_picture():
            self._drag = begun(button, mods)

    def on_cursor(self, x: float, y: float) -> None:
        """The pointer moved: a drag goes on."""
        self._lively = 3
        self.controls.on_cursor(x, y)
        dx, dy = x - self._cursor[0], y - self._cursor[1]
        self._cursor = x, y
        height = max(1, glfw.get_window_size(self.window)[1])
        self.state = dragged(self.state, self._drag, dx, dy, height)

    def on_scroll(self, dx: float, dy: float) -> None:
        """The wheel turned: zoom."""
        self._lively = 3
        self.controls.on_scroll(dx, dy)
        if self._over_picture() and self.state.eye is not None:
            self.state = replace(self.state, eye=self.state.eye.zoomed(dy))

    def on_key(self, key: int, scancode: int, action: int, mods: int) -> None:
        """A key was pressed or released."""
        self._lively = 3
        self.controls.on_key(key, scancode, action, mods)
        if action != glfw.PRESS or self.controls.io.want_text_input:
            return
        control = bool(mods & glfw.MOD_CONTROL)
        action_of_key = (WITH_CONTROL if control else ACTIONS).get(key)
        if action_of_key is not None:
            self.act(action_of_key)
        elif not control:
            self.state = keyed(self.state, key, self._choice())

    def on_char(self, char: int) -> None:
        """A character was typed."""
        self._lively = 3
        self.controls.on_char(char)
        if chr(char) == "?" and not self.controls.io.want_text_input:
            self.act("help")

    def on_drop(self, paths: list[str]) -> None:
        """Files were dropped: a mesh, a saved window, or else an environment."""
        self._lively = 3
        self.fault = self.done = ""
        for path in paths:
            if Path(path).suffix.lower() == ".json":
                self._open(path)
            else:
                self.state = with_file(self.state, path)

    def on_resize(self, width: int, height: int) -> None:
        """The window has another size: the next frame has it too."""
        self._lively = 3

    def act(self, action: Action) -> None:
        """Do what a key or a button asks for."""
        does: dict[Action, Callable[[], None]] = {
            "fit": lambda: setattr(self, "_fit", True),
            "help": lambda: setattr(self, "keys_shown", not self.keys_shown),
            "close help": lambda: setattr(self, "keys_shown", False),
            "panel": lambda: setattr(self, "panel_shown", not self.panel_shown),
            "expose": self._expose_always,
            "screenshot": self._save_picture,
            "save": self._save,
            "open": lambda: self._open(self.state_file),
            "quit": self.quit,
        }
        if action not in QUIET:
            self.fault = self.done = ""
        try:
            does[action]()
        except Faults as fault:
            self._say_fault(one_line(fault))

    def quit(self) -> None:
        """Close the window after this frame."""
        glfw.set_window_should_close(self.window, True)

    # ---- Details

    def _choice(self) -> Choice | None:
        """Return what is used of the object with transfer that is drawn, if one is."""
        drawn = None if self.result is None else self.result.transferred
        return None if drawn is None else Choice.of(self.state, drawn.transfer)

    def _expose_always(self) -> None:
        self.state = replace(self.state, automatic=True)
        self._expose = True

    def _open(self, path: PathLike) -> None:
        try:
            state = State.load(path)
        except Faults as fault:
            self._say_fault(one_line(fault))
            return
        self.state, self.done, self._keep_eye = state, f"opened {path}", True

    def _save(self) -> None:
        self.state.save(self.state_file)
        self.done = f"saved {self.state_file}"

    def _save_picture(self) -> None:
        if self.result is None:
            return
        alpha = not self.state.background
        png = save_screenshot(self.folder, self.screen.picture(), self.state.exposure, alpha)
        self.done = f"saved {png} and .exr"

    def _say_fault(self, line: str) -> None:
        self.done, self.fault = "", line

    def _over_picture(self) -> bool:
        over_panel = self.panel_shown and self._cursor[0] < WIDTH
        return not over_panel and not self.controls.io.want_capture_mouse

    def _panel_pixels(self) -> int:
        window, pixels = glfw.get_window_size(self.window)[0], glfw.get_framebuffer_size(self.window)[0]
        return round(WIDTH * pixels / max(1, window)) if self.panel_shown else 0

    def _picture_shape(self, least: int = 0) -> tuple[int, int]:
        """Return the rows and columns of the picture beside the panel; those of a tiny window are `least`."""
        width, height = glfw.get_framebuffer_size(self.window)
        return max(least, height), max(least, width - self._panel_pixels())
