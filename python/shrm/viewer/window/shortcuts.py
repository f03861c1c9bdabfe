"""What keys do: to the state, or as actions of the window."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import glfw

from shrm.viewer.window.choices import TECHNIQUES, Action
from shrm.viewer.window.relit import Choice
from shrm.viewer.window.state import UNTURNED, Shown, State

ACTIONS: Mapping[int, Action] = {
    glfw.KEY_ESCAPE: "close help",
    glfw.KEY_Q: "quit",
    glfw.KEY_F: "fit",
    glfw.KEY_S: "screenshot",
    glfw.KEY_TAB: "panel",
    glfw.KEY_E: "expose",
}
QUIET: tuple[Action, ...] = ("close help", "panel", "expose", "quit")
"""Actions that leave the message of the panel."""

WITH_CONTROL: Mapping[int, Action] = {glfw.KEY_S: "save", glfw.KEY_O: "open"}

SHOWN: Mapping[int, Shown] = {
    glfw.KEY_1: "maps",
    glfw.KEY_2: "integration",
    glfw.KEY_3: "difference",
}


def keyed(state: State, key: int, choice: Choice | None) -> State:
    """Return a state after a key was pressed; the same one if the key means nothing to it.

    `choice` is what is used of an object with transfer, if one is shown.
    """
    if key == glfw.KEY_R:
        return replace(state, light=UNTURNED)
    if key == glfw.KEY_T:
        return replace(state, turning=not state.turning)
    if key == glfw.KEY_B:
        return replace(state, background=not state.background)
    if key == glfw.KEY_M:
        return with_next_technique(state)
    if key == glfw.KEY_H and choice is not None:
        return replace(state, variant=choice.other_shadows or state.variant)
    if key == glfw.KEY_I and choice is not None:
        return replace(state, variant=choice.other_bounces or state.variant)
    if key == glfw.KEY_W and choice is not None:
        return replace(state, window=None if state.window else "lanczos")
    if key in SHOWN:
        return replace(state, shown=SHOWN[key])
    return state


def with_next_technique(state: State) -> State:
    """Return a state with the next technique, or GPU filter, of the panel's list."""
    choices = [choice for choice, _, _ in TECHNIQUES]
    technique, filter = choices[(choices.index((state.technique, state.filter)) + 1) % len(choices)]
    return replace(state, technique=technique, filter=filter)
