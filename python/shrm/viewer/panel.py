"""The panel beside the picture: what is shown, how well, how fast."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from slimgui import imgui

from shrm import brdf
from shrm.layouts import LAYOUTS
from shrm.reflection_map import ReflectionMap
from shrm.viewer.choices import (
    BUTTONS,
    MESHES,
    METHODS,
    NAMED,
    OF_LIGHT,
    OF_VIEW,
    SHOWN,
    TANGENTS,
    VIEWERS,
    Action,
)
from shrm.viewer.lighting import DAYLIGHT, F_MAX, P_MAX, Prefiltered
from shrm.viewer.materials import KINDS, exchanged, kind_of, value_of, with_value
from shrm.viewer.state import UNTURNED, State
from shrm.viewer.widgets import WIDTH, disabled, explain, wrapped

SPHERE = "sphere"
RECOGNISED = "as recognised"
BY_PATH = "type its path and Enter, or drop it here."
MOST_OBJECTS = 8
MOST_CHARACTERS = 78  # of a message: two lines

RED, YELLOW, GREY = (1.0, 0.35, 0.3, 1.0), (1.0, 0.8, 0.3, 1.0), (0.62, 0.64, 0.68, 1.0)

SEE_THROUGH = (0.4, 0.65, 1.0, 0.45)  # the handles of sliders, which stand on what they say


@dataclass(frozen=True)
class Facts:
    """What the panel reports.

    Attributes
    ----------
    result : Prefiltered or None
        What is drawn.
    working : bool
        Whether newer maps are on their way.
    frame_seconds : float
        What a frame took to draw.
    fault, said : str
        What went wrong last, and what was done last; empty if nothing.
    refused : str
        A picture that could not be read as it was meant to be; empty if there is none.
    integrated : str
        How far the integration is; empty if none is asked for.
    """

    result: Prefiltered | None
    working: bool
    frame_seconds: float
    fault: str
    said: str
    refused: str
    integrated: str


class Panel:
    """Draws the panel, and says what was changed in it.

    Attributes
    ----------
    places : dict of str to (x, y, x, y)
        Corners of each control of the last frame, in the window's units.
    """

    def __init__(self) -> None:
        self.places: dict[str, tuple[float, float, float, float]] = {}
        imgui.style_colors_dark()
        style = imgui.get_style()
        style.font_scale_main = 1.15
        style.grab_min_size = 5.0  # narrow: what a slider says stays readable
        style.window_rounding, style.frame_rounding, style.window_border_size = 0.0, 3.0, 0.0

    def draw(self, state: State, facts: Facts, height: float) -> tuple[State, list[Action]]:
        """Draw it along the left side of a window; return the state as changed, and what was asked for."""
        self.places.clear()
        actions: list[Action] = []
        flags = imgui.WindowFlags
        imgui.set_next_window_pos((0.0, 0.0))
        imgui.set_next_window_size((WIDTH, height))
        fixed = flags.NO_TITLE_BAR | flags.NO_RESIZE | flags.NO_MOVE | flags.NO_SAVED_SETTINGS
        imgui.begin("shrm", flags=fixed)
        imgui.push_item_width(-125.0)
        imgui.push_style_color(imgui.Col.SLIDER_GRAB, SEE_THROUGH)
        self._messages(state, facts)
        state = self._light(state, facts.refused)
        state = self._objects(state, facts)
        state = self._accuracy(state, facts)
        state = self._method(state, facts)
        state = self._picture(state, actions)
        self._times(facts)
        imgui.separator_text("Mouse, over the picture")
        imgui.text_colored(GREY, "left: orbit   right: turn the light")
        imgui.text_colored(GREY, "middle: pan   wheel: zoom")
        if self._button("All keys (?)"):
            actions.append("help")
        imgui.pop_style_color()
        imgui.pop_item_width()
        imgui.end()
        return state, actions

    # ---- Sections

    def _messages(self, state: State, facts: Facts) -> None:
        """Say the most important thing in a place that is always as high: nothing below it moves."""
        notes = () if facts.result is None else facts.result.notes
        top, color = imgui.get_cursor_pos_y(), GREY
        text = "Drop a picture (.hdr, .exr, .png) or a mesh (.ply, .obj, .glb, .stl) here."
        reading = facts.result is not None and facts.result.request.environment != state.environment
        coming = f"reading {Path(state.environment).name} ..." if reading and facts.working else ""
        said = ((YELLOW, " ".join(notes)), (GREY, facts.said), (RED, facts.fault), (GREY, coming))
        for other, message in said:
            color, text = (other, message) if message else (color, text)
        wrapped(color, text if color == GREY and not facts.said else _shortened(text))
        explain(text)
        imgui.set_cursor_pos_y(top + 2.4 * imgui.get_text_line_height())

    def _light(self, state: State, refused: str) -> State:
        imgui.separator_text("Light")
        shown = state.environment if state.environment == DAYLIGHT else Path(state.environment).name
        meaning = f"{state.environment}\n'{DAYLIGHT}', or a picture: {BY_PATH}"
        typed = self._entered("environment", shown, meaning)
        if typed is not None:
            path = typed if typed == DAYLIGHT else _absolute(typed)
            if Path(path).suffix.lower() in MESHES:
                state = replace(state, mesh=path)
            else:
                state = replace(state, environment=path, layout=None)
        source = refused or state.environment  # what is said of it can make a picture that was refused good
        whose = "Of pictures: " if source == DAYLIGHT else f"Of {Path(source).name}: "
        with disabled(source == DAYLIGHT):
            known = [RECOGNISED, *LAYOUTS]
            current = RECOGNISED if refused else state.layout or RECOGNISED
            changed, chosen = imgui.combo("layout", known.index(current), known)
            self._place("layout")
            explain(
                f"{whose}how it unrolls the sphere: lat-long, cross or strip of a cube's faces, mirror ball, "
                "probe and others. Choose one where the picture's shape does not tell."
            )
            if changed:
                state = replace(state, environment=source, layout=known[chosen] if chosen else None)
        if self._button("Daylight", "An analytic sky with its sun, in place of a picture."):
            state = replace(state, environment=DAYLIGHT, layout=None)
        imgui.same_line()
        with disabled(state.light == UNTURNED):
            if self._button(
                "Turn light back (R)",
                "Turn the light back to where its picture has it. Dragging with the right button turns it.",
            ):
                state = replace(state, light=UNTURNED)
        imgui.same_line()
        changed, repair = imgui.checkbox("repair", state.repair)
        self._place("repair")
        explain(f"{whose}replace texels that are not finite by their neighbours; otherwise it is refused.")
        return replace(state, environment=source, repair=repair) if changed else state

    def _objects(self, state: State, facts: Facts) -> State:
        count = len(state.materials)
        imgui.separator_text("Object" if count == 1 else f"Object {state.selected + 1} of {count}")
        if count > 1:
            for index in range(count):
                if index:
                    imgui.same_line()
                if imgui.radio_button(f"{index + 1}##object", index == state.selected):
                    state = replace(state, selected=index)
                self._place(f"object {index + 1}")
                explain("Whose material this is; numbered from left to right, as they stand at first.")
        state = self._material(state)
        with disabled(count == MOST_OBJECTS):
            if self._button(
                "Add object", f"A copy beside it, with a material of its own; {MOST_OBJECTS} at most."
            ):
                text = state.materials[state.selected]
                state = replace(state, materials=(*state.materials, text), selected=count)
        imgui.same_line()
        with disabled(count == 1):
            if self._button("Remove", "Take the chosen object away."):
                left = state.materials[: state.selected] + state.materials[state.selected + 1 :]
                state = replace(state, materials=left, selected=min(state.selected, len(left) - 1))
        imgui.same_line()
        with disabled(state.mesh is None):
            if self._button("Back to sphere", "All objects are spheres again."):
                state = replace(state, mesh=None)
        shown = SPHERE if state.mesh is None else Path(state.mesh).name
        typed = self._entered(
            "shape of all", shown, f"{state.mesh or SPHERE}\n'{SPHERE}', or a mesh file: {BY_PATH}"
        )
        if typed is not None:
            state = replace(state, mesh=None if typed == SPHERE else _absolute(typed))
        return self._tangents(state, facts)

    def _tangents(self, state: State, facts: Facts) -> State:
        """The mesh's tangent field, where a material depends on it, or one is chosen that may not be had."""
        maps = () if facts.result is None else facts.result.maps
        about_tangent = any(part.center == "tangent" for rm in maps for part in rm.parts)
        if not about_tangent and (state.mesh is None or state.tangents == "axis"):
            return state
        fields, labels, meanings = zip(*TANGENTS, strict=True)
        with disabled(state.mesh is None):
            changed, chosen = imgui.combo("tangents", fields.index(state.tangents), labels)
            self._place("tangents")
            explain("\n".join(meanings))
        return replace(state, tangents=fields[chosen]) if changed else state

    def _material(self, state: State) -> State:
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
        self._place("material")
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
            self._place(parameter.name)
            explain(parameter.meaning)
            if changed:
                state = state.with_material(state.selected, with_value(material, parameter, value))
        meaning = (
            "The material in words, as the command takes it: a name and its "
            "parameters, sums and multiples of "
            f"such, as 0.5*lambert:0.8 + ggx:0.2. Enter takes it. Names: {NAMED}."
        )
        typed = self._entered("as text", text, meaning)
        return state if typed is None else state.with_material(state.selected, typed)

    def _accuracy(self, state: State, facts: Facts) -> State:
        imgui.separator_text("Accuracy")
        if self._radio("by tolerance", state.orders is None):
            state = replace(state, orders=None)
        explain("F and P are chosen for each object, by the error that is wanted.")
        imgui.same_line()
        mine = None if facts.result is None else _of(facts.result.maps, state.selected)
        if self._radio("orders F, P", state.orders is not None) and state.orders is None:
            state = replace(state, orders=(12, 2) if mine is None else (mine.F, mine.P))
        explain("F and P as they are set, the same for all objects, whatever error they leave.")
        if state.orders is None:
            flags = imgui.SliderFlags.LOGARITHMIC | imgui.SliderFlags.CLAMP_ON_INPUT
            changed, percent = imgui.slider_float(
                "tolerance", 100.0 * state.tolerance, 1.0, 50.0, "%.1f %%", flags
            )
            self._place("tolerance")
            explain("Relative RMS error of the reflected light over all normals and views.")
            if changed:
                state = replace(state, tolerance=round(percent / 100.0, 4))
        else:
            state = self._orders(state, *state.orders)
        if mine is None or facts.result is None:
            imgui.text_colored(GREY, "prefiltering ...\n ")
            return state
        drawn = facts.result.drawn[min(state.selected, len(facts.result.drawn) - 1)]
        held = (
            drawn.parts
            if isinstance(drawn, ReflectionMap)
            else [p for one in drawn.lobes for p in one.layers]
        )
        maps = sum(part.rings.shape[1] for part in held)
        word = "map" if maps == 1 else "maps"
        whose = f"object {state.selected + 1}: " if len(state.materials) > 1 else ""
        if state.method == "hardware":
            imgui.text(f"{whose}one dual-paraboloid map a lobe")
            explain(
                "Two round pictures of opposite halves of the sphere, filtered by the GPU for every light."
            )
        else:
            imgui.text(f"{whose}F = {mine.F}, P = {mine.P}: {maps} {word}, 6 x {mine.size} x {mine.size}")
            explain(
                f"F: {OF_LIGHT}\nP: {OF_VIEW}\nMaps are cubes of six faces; together "
                "they hold what the object reflects."
            )
        self._predicted(state, mine, facts.result.errors)
        return state

    def _orders(self, state: State, F: int, P: int) -> State:
        clamp = imgui.SliderFlags.CLAMP_ON_INPUT
        imgui.push_item_width(150.0)
        _, F = imgui.slider_int("F", F, 0, F_MAX, "%d", clamp)
        self._place("F")
        explain(OF_LIGHT)
        imgui.same_line()
        _, P = imgui.slider_int("P", P, 0, P_MAX, "%d", clamp)
        self._place("P")
        explain(OF_VIEW)
        imgui.pop_item_width()
        return state if state.orders == (F, P) else replace(state, orders=(F, P))

    def _predicted(self, state: State, mine: ReflectionMap, errors: tuple[float, ...] | None) -> None:
        if state.method != "shrm":
            imgui.text_colored(GREY, "error: not predicted for this method")
        elif errors is None or state.selected >= len(errors):
            imgui.text_colored(GREY, "predicted error: ...")
        else:
            error = errors[state.selected]
            text = f"predicted error: {100.0 * error:.2g} %"
            if state.orders is None and error > 1.01 * state.tolerance:
                most = f"P = {P_MAX}" if mine.P >= P_MAX else f"F = {F_MAX}"
                imgui.text_colored(YELLOW, f"{text} (at most {most} here)")
            else:
                imgui.text(text)
        explain(
            "Relative RMS of what this object reflects, over all normals and "
            "views. (For the picture itself, see "
            f"'shown' below.) This window takes F up to {F_MAX} and P up to "
            f"{P_MAX}, so as to stay fast: where "
            "that is not enough, take a rougher material or a softer light, or shrm render."
        )

    def _method(self, state: State, facts: Facts) -> State:
        imgui.separator_text("Method")
        names, labels, meanings = zip(*METHODS, strict=True)
        current = names.index(state.method)
        changed, chosen = imgui.combo("method", current, list(labels))
        self._place("method")
        explain(f"How the reflected light is approximated. {labels[current]}: {meanings[current]}")
        if changed:
            state = replace(state, method=names[chosen])
        imgui.align_text_to_frame_padding()
        imgui.text("viewer")
        for viewer, label, meaning in VIEWERS:
            imgui.same_line()
            if self._radio(label, state.viewer == viewer):
                state = replace(state, viewer=viewer)
            explain(meaning)
        imgui.align_text_to_frame_padding()
        imgui.text("shown ")
        for shown, label, meaning in SHOWN:
            imgui.same_line()
            if self._radio(label, state.shown == shown):
                state = replace(state, shown=shown)
            explain(meaning)
        imgui.text_colored(GREY, facts.integrated or " ")
        return state

    def _picture(self, state: State, actions: list[Action]) -> State:
        imgui.separator_text("Picture")
        changed, stops = imgui.slider_float("exposure", state.exposure, -12.0, 12.0, "%+.2f stops")
        self._place("exposure")
        explain("Twice as bright for each stop.")
        if changed:
            state = replace(state, exposure=stops, automatic=False)
        changed, automatic = imgui.checkbox("auto (E)", state.automatic)
        self._place("auto")
        explain("Found from the picture when light, material or shape change; E finds it at any time.")
        if changed:
            state = replace(state, automatic=automatic)
        imgui.same_line()
        changed, background = imgui.checkbox("background (B)", state.background)
        self._place("background")
        explain("Show the light itself behind the objects.")
        if changed:
            state = replace(state, background=background)
        for index, (action, label, meaning) in enumerate(BUTTONS):
            if index:
                imgui.same_line()
            if self._button(label, meaning):
                actions.append(action)
        return state

    def _times(self, facts: Facts) -> None:
        imgui.separator_text("Time")
        drawing = facts.frame_seconds
        prefiltering = 0.0 if facts.result is None else facts.result.seconds
        rate = f" ({1.0 / drawing:.0f} frames/s)" if drawing > 0.0 else ""
        imgui.text(f"drawing      {1e3 * drawing:6.1f} ms{rate}")
        explain("The last frame, by OpenGL.")
        imgui.text(f"prefiltering {1e3 * prefiltering:6.1f} ms{' (working ...)' if facts.working else ''}")
        explain("From light and material to maps, for all objects, when one of them changed last.")

    # ---- Controls whose places are kept

    def _place(self, name: str) -> None:
        self.places[name] = (*imgui.get_item_rect_min(), *imgui.get_item_rect_max())

    def _entered(self, label: str, text: str, meaning: str) -> str | None:
        """A line of text; return another one that was typed in its place, once Enter is pressed."""
        flags = imgui.InputTextFlags
        entered, typed = imgui.input_text(label, text, flags.ENTER_RETURNS_TRUE | flags.AUTO_SELECT_ALL)
        self._place(label)
        explain(meaning)
        return typed.strip() or None if entered and typed != text else None

    def _button(self, label: str, meaning: str = "") -> bool:
        pressed = imgui.button(label)
        self._place(label)
        explain(meaning)
        return pressed

    def _radio(self, label: str, active: bool) -> bool:
        pressed = imgui.radio_button(label, active)
        self._place(label)
        return pressed


def _of(maps: tuple[ReflectionMap, ...], index: int) -> ReflectionMap | None:
    """The map of an object, if it is there yet."""
    return maps[index] if index < len(maps) else None


def _absolute(path: str) -> str:
    return str(Path(path).expanduser().absolute())


def _shortened(text: str) -> str:
    """Text without what stands in parentheses at its end, and a path in front of it as a name."""
    head, colon, rest = text.partition(" (")[0].partition(": ")
    short = f"{Path(head).name}: {rest}" if colon and "/" in head else head + colon + rest
    return short if len(short) <= MOST_CHARACTERS else f"{short[: MOST_CHARACTERS - 3]}..."
