"""The interactive window: what its events do to the state, and a frame."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, get_args

import glfw

from shrm.faults import one_line
from shrm.render.picture import Object
from shrm.render.tonemap import automatic_exposure
from shrm.viewer.choices import MESHES, Action
from shrm.viewer.comparison import Comparison
from shrm.viewer.drag import Drag, begun, dragged
from shrm.viewer.filtered import FilteredMaterials
from shrm.viewer.geometry import bounds
from shrm.viewer.integration import Question
from shrm.viewer.keys import draw_keys
from shrm.viewer.lighting import Lighting, Prefiltered, Request
from shrm.viewer.orbit import Orbit
from shrm.viewer.panel import Facts, Panel
from shrm.viewer.renderer import Renderer
from shrm.viewer.scene import Scene
from shrm.viewer.screen import Screen
from shrm.viewer.screenshot import save_screenshot
from shrm.viewer.state import UNTURNED, Method, State
from shrm.viewer.widgets import WIDTH
from shrm.viewer.window import Controls, listen, open_window
from shrm.viewer.worker import Worker

TITLE = "shrm: environment maps in frequency space"
STATE_FILE = "shrm-view.json"
METHODS = get_args(Method)

Faults = (OSError, ValueError, TypeError, RuntimeError, MemoryError)


class Application:
    """A window and everything in it.

    Parameters
    ----------
    state : State
    width, height : int
        Of the window, the panel included.
    visible : bool
        Whether it appears on the screen.
    folder : path
        Where screenshots go.
    state_file : path
        What is saved and opened by keys.

    Attributes
    ----------
    state : State
    result : Prefiltered or None
        What is drawn.
    fault : str
        The line that the panel shows in red.

    Raises
    ------
    ContextError
        If no window can be opened.
    """

    def __init__(
        self,
        state: State,
        width: int = 1280,
        height: int = 900,
        *,
        visible: bool = True,
        folder: str | Path = ".",
        state_file: str | Path | None = None,
    ) -> None:
        self.state = state
        self.folder = Path(folder)
        self.state_file = self.folder / STATE_FILE if state_file is None else Path(state_file)
        self.context = open_window(width, height, TITLE, visible)
        self.window = self.context.window
        self.renderer = Renderer(16, context=self.context)
        self.filtered = FilteredMaterials(self.context)
        self.panel_shown, self.keys_shown = True, False
        self.screen = Screen(self.context.gl, *(max(1, side) for side in self._picture_extent()))
        self.controls = Controls(self.window)
        self.panel = Panel()
        self.lighting: Worker[Request, Prefiltered] = Worker(Lighting(), glfw.post_empty_event)
        self.comparison = Comparison(glfw.post_empty_event)
        self.result: Prefiltered | None = None
        self.fault = self.said = self.refused = ""
        self._asked: Request | None = None
        self._drawn: tuple[object, ...] = ()
        self._expose = self._fit = False
        self._keep_eye = True  # a state that was read says where from its objects are seen
        self._frame_seconds = 0.0
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
            visible = min(self._picture_extent()) > 0
            sampling = visible and self.result is not None and not self.screen.complete
            if self._lively or sampling:
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
        self.lighting.close()
        self.comparison.worker.close()
        self.context.activate()
        self.controls.close()
        self.screen.release()
        self.filtered.release()
        self.renderer.release()
        self.context.release()

    def _ask(self) -> None:
        """Ask for maps if the state wants others than those asked for last."""
        request = Request.of(self.state)
        if request != self._asked:
            self._asked = request
            self.lighting.submit(request)

    def _take(self) -> None:
        """Take newer maps, or the fault that there is instead."""
        try:
            result = self.lighting.take()
        except Faults as fault:
            if self.result is None:
                raise
            self._say_fault(fault)
            self._refuse(self.result.request)
            return
        if result is None:
            return
        last, self.result = self.result, result
        if last is None or _source(last) != _source(result):
            self.fault = self.refused = ""
            self._expose = not self._keep_eye or self.state.eye is None  # a state that was read says it
        self._lively = 3
        if last is None or _placing(last) != _placing(result):
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
        width, height = self._picture_extent()
        if result is None or width < 1 or height < 1:
            return False
        self.screen.resize(width, height)
        eye = self.state.eye
        if self._fit or eye is None:
            eye = (eye or Orbit()).fitted([bounds(shape) for shape in result.shapes], width / height)
            self.state, self._fit = replace(self.state, eye=eye), False
        background = result.environment if self.state.background else None
        request = result.request
        seen = (result.drawn, request.method, request.light, result.shapes)
        decides = (*seen, eye, self.state.viewer, width, height, background)
        if decides != self._drawn:
            self._drawn, self.screen.samples = decides, 0
        sampled = not self.screen.complete
        if sampled:
            try:
                materials = self.filtered.drawn_with(result)
            except Faults as fault:
                materials = result.drawn
                self._say_fault(fault)
                self._set(method="shrm")
            scene = Scene(
                [Object(*pair) for pair in zip(result.shapes, materials, strict=True)],
                eye.camera,
                background,
                self.state.viewer,
                replace(self.state, light=request.light).R,
            )
            try:
                self.renderer.draw(scene, self.screen.drawn, self.screen.shift)
            except ValueError as fault:  # more maps than textures have layers
                if self.state.viewer == "distant":
                    raise
                self._say_fault(fault)
                self._set(viewer="distant")
            self.renderer.resources.end_frame()
            self.screen.add_sample()
        self._show(result, (width, height))
        if self._expose and self.state.automatic:
            picture = self.screen.drawn_picture()
            stops = automatic_exposure(picture.radiance, picture.coverage)
            self.state = replace(self.state, exposure=round(stops, 2))
        self._expose = False
        return sampled

    def _draw_controls(self) -> None:
        width, height = glfw.get_window_size(self.window)
        self.controls.begin()
        actions: list[Action] = []
        if self.panel_shown:
            facts = Facts(
                self.result,
                self.lighting.working,
                self._frame_seconds,
                self.fault,
                self.said,
                self.refused,
                "" if self.state.shown == "maps" else self.comparison.says,
            )
            before = self.state
            self.state, actions = self.panel.draw(self.state, facts, height)
            self._expose |= self.state.automatic and not before.automatic
            if self.state != before:
                self.fault = self.said = ""
        if self.keys_shown:
            left = WIDTH if self.panel_shown else 0
            draw_keys(left, width - left, height)
        self.controls.end()
        for action in actions:
            self.act(action)

    def _show(self, result: Prefiltered, extent: tuple[int, int]) -> None:
        """Choose what is shown of what was drawn."""
        if self.state.shown == "maps" or self.state.eye is None:
            self.screen.show_drawn()
            return
        request, camera = result.request, self.state.eye.camera
        question = Question(
            result.environment,
            request.light,
            request.materials,
            result.shapes,
            camera,
            self.state.viewer,
            *extent,
        )
        try:
            self.comparison.show(question, self.state.shown == "difference", self.screen, self._drawn)
        except Faults as fault:
            self._say_fault(fault)
            self._set(shown="maps")
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
        if mods & glfw.MOD_CONTROL:
            commands: dict[int, Action] = {glfw.KEY_S: "save", glfw.KEY_O: "open"}
            if key in commands:
                self.act(commands[key])
            return
        named: dict[int, Callable[[], None]] = {
            glfw.KEY_ESCAPE: lambda: setattr(self, "keys_shown", False),
            glfw.KEY_Q: self.quit,
            glfw.KEY_F: lambda: self.act("fit"),
            glfw.KEY_S: lambda: self.act("screenshot"),
            glfw.KEY_TAB: lambda: setattr(self, "panel_shown", not self.panel_shown),
            glfw.KEY_R: lambda: self._set(light=UNTURNED),
            glfw.KEY_B: lambda: self._set(background=not self.state.background),
            glfw.KEY_E: self._expose_always,
            glfw.KEY_M: self._next_method,
            glfw.KEY_1: lambda: self._set(shown="maps"),
            glfw.KEY_2: lambda: self._set(shown="integration"),
            glfw.KEY_3: lambda: self._set(shown="difference"),
        }
        if key in named:
            named[key]()

    def on_char(self, char: int) -> None:
        """A character was typed."""
        self._lively = 3
        self.controls.on_char(char)
        if chr(char) == "?" and not self.controls.io.want_text_input:
            self.act("help")

    def on_drop(self, paths: list[str]) -> None:
        """Files were dropped: a mesh, a saved window, or else an environment."""
        self._lively = 3
        self.fault = self.said = ""
        for path in paths:
            suffix = Path(path).suffix.lower()
            if suffix in MESHES:
                self._set(mesh=path)
            elif suffix == ".json":
                self._open(path)
            else:
                self._set(environment=path, layout=None)

    def on_resize(self, width: int, height: int) -> None:
        """The window has another size: the next frame has it too."""
        self._lively = 3

    def act(self, action: Action) -> None:
        """Do what a key or a button asks for."""
        self.fault = self.said = ""
        try:
            if action == "fit":
                self._fit = True
            elif action == "help":
                self.keys_shown = not self.keys_shown
            elif action == "screenshot":
                self._save_picture()
            elif action == "save":
                self.state.save(self.state_file)
                self.said = f"saved {self.state_file}"
            elif action == "open":
                self._open(self.state_file)
        except Faults as fault:
            self._say_fault(fault)

    def quit(self) -> None:
        """Close the window after this frame."""
        glfw.set_window_should_close(self.window, True)

    # ---- Details

    def _set(self, **changes: Any) -> None:
        self.state = replace(self.state, **changes)

    def _next_method(self) -> None:
        self._set(method=METHODS[(METHODS.index(self.state.method) + 1) % len(METHODS)])

    def _expose_always(self) -> None:
        self._set(automatic=True)
        self._expose = True

    def _open(self, path: str | Path) -> None:
        try:
            state = State.load(path)
        except Faults as fault:
            self._say_fault(fault)
            return
        self.state, self.said, self._keep_eye = state, f"opened {path}", True

    def _save_picture(self) -> None:
        if self.result is None:
            return
        alpha = not self.state.background
        png = save_screenshot(self.folder, self.screen.picture(), self.state.exposure, alpha)
        self.said = f"saved {png} and .exr"

    def _say_fault(self, fault: BaseException) -> None:
        self.said, self.fault = "", one_line(fault)

    def _over_picture(self) -> bool:
        over_panel = self.panel_shown and self._cursor[0] < WIDTH
        return not over_panel and not self.controls.io.want_capture_mouse

    def _panel_pixels(self) -> int:
        window, pixels = glfw.get_window_size(self.window)[0], glfw.get_framebuffer_size(self.window)[0]
        return round(WIDTH * pixels / max(1, window)) if self.panel_shown else 0

    def _picture_extent(self) -> tuple[int, int]:
        width, height = glfw.get_framebuffer_size(self.window)
        return width - self._panel_pixels(), height


def _placing(result: Prefiltered) -> tuple[object, ...]:
    """What the positions of the objects depend on."""
    return result.request.mesh, result.request.up, len(result.shapes)


def _source(result: Prefiltered) -> tuple[object, ...]:
    """What the exposure depends on."""
    return result.environment, result.request.materials, result.shapes
