"""What drags of the mouse do to what is shown."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import glfw

from shrm.viewer.window.orbit import turned_light
from shrm.viewer.window.state import State

Drag = Literal["orbit", "pan", "light"]


def begun(button: int, mods: int) -> Drag | None:
    """Return the drag that a button begins, if it does."""
    drags: dict[int, Drag] = {
        glfw.MOUSE_BUTTON_LEFT: "pan" if mods & glfw.MOD_SHIFT else "orbit",
        glfw.MOUSE_BUTTON_MIDDLE: "pan",
        glfw.MOUSE_BUTTON_RIGHT: "light",
    }
    return drags.get(button)


def dragged(state: State, drag: Drag | None, dx: float, dy: float, height: int) -> State:
    """Return a state after a movement of (dx, dy) pixels, y down, in a picture so many pixels high."""
    eye = state.eye
    if drag is None or eye is None:
        return state
    if drag == "light":
        return state.with_light(turned_light(state.R, dx, dy, eye.camera))
    return replace(state, eye=eye.orbited(dx, dy) if drag == "orbit" else eye.panned(dx, dy, height))
