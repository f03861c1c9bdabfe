"""The panel's section of objects: their materials as sliders and text, their shape."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from slimgui import imgui

from shrm import brdf
from shrm.render.transferred import is_transfer
from shrm.viewer.window.choices import BY_PATH, NAMED, TANGENTS
from shrm.viewer.window.materials import KINDS, exchanged, kind_of, value_of, with_value
from shrm.viewer.window.opening import absolute
from shrm.viewer.window.prefiltering import PrefilteredScene
from shrm.viewer.window.state import State
from shrm.viewer.window.widgets import Widgets, disabled, explain

SPHERE = "sphere"
MOST_OBJECTS = 8


def draw_objects(widgets: Widgets, state: State, result: PrefilteredScene | None) -> State:
    """Draw the section of objects, their materials and their shape; return the state as changed."""
    count = len(state.materials)
    imgui.separator_text("Object" if count == 1 else f"Object {state.selected + 1} of {count}")
    if count > 1:
        for index in range(count):
            if index:
                imgui.same_line()
            if imgui.radio_button(f"{index + 1}##object", index == state.selected):
                state = replace(state, selected=index)
            widgets.place(f"object {index + 1}")
            explain("Whose material this is; numbered from left to right, as they stand at first.")
    state = _material(widgets, state)
    with disabled(count == MOST_OBJECTS):
        if widgets.button(
            "Add object", f"A copy beside it, with a material of its own; {MOST_OBJECTS} at most."
        ):
            text = state.materials[state.selected]
            state = replace(state, materials=(*state.materials, text), selected=count)
    imgui.same_line()
    with disabled(count == 1):
        if widgets.button("Remove", "Take the chosen object away."):
            left = state.materials[: state.selected] + state.materials[state.selected + 1 :]
            state = replace(state, materials=left, selected=min(state.selected, len(left) - 1))
    imgui.same_line()
    with disabled(state.mesh is None):
        if widgets.button("Back to sphere", "All objects are spheres again."):
            state = replace(state, mesh=None)
    shown = SPHERE if state.mesh is None else Path(state.mesh).name
    typed = widgets.entered("shape", shown, f"{state.mesh or SPHERE}\n'{SPHERE}', or a mesh file: {BY_PATH}")
    if typed is not None:
        state = _with_shape(state, typed)
    return _tangents(widgets, state, result)


def _tangents(widgets: Widgets, state: State, result: PrefilteredScene | None) -> State:
    """The mesh's tangent field, where a material depends on it, or one is chosen that may not be had."""
    maps = () if result is None else result.maps
    about_tangent = any(part.center == "tangent" for rm in maps for part in rm.parts)
    if not about_tangent and (state.mesh is None or state.tangents == "axis"):
        return state
    fields, labels, meanings = zip(*TANGENTS, strict=True)
    with disabled(state.mesh is None):
        changed, chosen = imgui.combo("tangents", fields.index(state.tangents), labels)
        widgets.place("tangents")
        explain("\n".join(meanings))
    return replace(state, tangents=fields[chosen]) if changed else state


def _material(widgets: Widgets, state: State) -> State:
    text = state.materials[state.selected]
    try:
        material = brdf.parse(text)
    except (ValueError, OSError):  # it is said above, and the last good one comes back
        return state
    kind = kind_of(material)
    names = list(KINDS)
    labels = [KINDS[name].label for name in names] + ([] if kind else ["as in the text below"])
    current = names.index(kind) if kind else len(names)
    changed, chosen = imgui.combo("material", current, labels)
    widgets.place("material")
    explain("What the object is made of. Its parameters follow.")
    if changed and chosen < len(names):
        return state.with_material(state.selected, exchanged(material, KINDS[names[chosen]]))
    for parameter in KINDS[kind].parameters if kind else ():
        value = value_of(material, parameter)
        if isinstance(value, tuple):
            changed, new = imgui.color_edit3(parameter.label, value, imgui.ColorEditFlags.FLOAT)
            value = new
        else:
            scale = imgui.SliderFlags.LOGARITHMIC if parameter.logarithmic else imgui.SliderFlags.NONE
            changed, value = imgui.slider_float(
                parameter.label, value, parameter.low, parameter.high, "%.3g", scale
            )
        widgets.place(parameter.name)
        explain(parameter.meaning)
        if changed:
            state = state.with_material(state.selected, with_value(material, parameter, value))
    meaning = (
        "The material in words, as the command takes it: a name and its "
        "parameters, sums and multiples of "
        f"such, as 0.5*lambert:0.8 + ggx:0.2. Enter takes it. Names: {NAMED}."
    )
    typed = widgets.entered("as text", text, meaning)
    return state if typed is None else state.with_material(state.selected, typed)


def _with_shape(state: State, typed: str) -> State:
    """Return a state with the shape that was typed."""
    if typed == SPHERE:
        return replace(state, mesh=None)
    path = absolute(typed)
    return replace(state, transfer=path) if is_transfer(path) else replace(state, mesh=path)
