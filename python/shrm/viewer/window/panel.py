"""The panel beside the picture: what is shown, how well, how fast."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from slimgui import imgui

from shrm.environment.layouts import LAYOUTS
from shrm.frequency.reflection_map import ReflectionMap
from shrm.viewer.window.choices import (
    BUTTONS,
    BY_PATH,
    OF_LIGHT,
    OF_VIEW,
    SHOWN,
    TECHNIQUES,
    VIEWERS,
    Action,
)
from shrm.viewer.window.object_panel import draw_objects
from shrm.viewer.window.opening import absolute, with_file
from shrm.viewer.window.prefiltering import DAYLIGHT, F_MAX, P_MAX, PrefilteredScene
from shrm.viewer.window.state import UNTURNED, State
from shrm.viewer.window.transfer_panel import draw_transfer
from shrm.viewer.window.widgets import GREY, RED, WIDTH, YELLOW, Widgets, disabled, explain, wrapped

RECOGNISED = "automatic"
MOST_CHARACTERS = 78  # of a message: two lines

SEE_THROUGH = (0.4, 0.65, 1.0, 0.45)  # the handles of sliders, which stand on what they say


@dataclass(frozen=True)
class Facts:
    """What the panel reports.

    Attributes
    ----------
    result : PrefilteredScene or None
        What is drawn.
    working : bool
        Whether newer maps are on their way.
    frame_seconds : float
        What a frame took to draw.
    fault, done : str
        What went wrong last, and what was done last; empty if nothing.
    refused : str
        A picture that could not be read as it was meant to be; empty if there is none.
    integrated : str
        How far the integration is; empty if none is asked for.
    lighting_seconds : float
        What lighting the vertices of an object with transfer took.
    """

    result: PrefilteredScene | None
    working: bool
    frame_seconds: float
    fault: str
    done: str
    refused: str
    integrated: str
    lighting_seconds: float


class Panel:
    """Draws the panel, and says what was changed in it.

    Attributes
    ----------
    widgets : Widgets
        Where its controls are.
    """

    def __init__(self) -> None:
        self.widgets = Widgets()
        imgui.style_colors_dark()
        style = imgui.get_style()
        style.font_scale_main = 1.15
        style.grab_min_size = 5.0  # narrow: what a slider says stays readable
        style.window_rounding, style.frame_rounding, style.window_border_size = 0.0, 3.0, 0.0

    def draw(self, state: State, facts: Facts, height: float) -> tuple[State, list[Action]]:
        """Draw it along the left side of a window; return the state as changed, and what was asked for."""
        self.widgets.places.clear()
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
        if state.transfer is None:
            state = draw_objects(self.widgets, state, facts.result)
            state = self._accuracy(state, facts)
            state = self._technique(state, facts)
        else:
            state = draw_transfer(self.widgets, state, facts.result, facts.integrated)
        state = self._picture(state, actions)
        self._times(facts)
        imgui.separator_text("Mouse, over the picture")
        imgui.text_colored(GREY, "left: orbit   right: rotate the light")
        imgui.text_colored(GREY, "middle: pan   wheel: zoom")
        if self.widgets.button("All keys (?)"):
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
        text = "Drop a picture (.hdr, .exr, .png) here,\na mesh (.ply, .obj, .glb, .stl) or a .shrt."
        reading = facts.result is not None and facts.result.request.environment != state.environment
        coming = f"reading {Path(state.environment).name} ..." if reading and facts.working else ""
        messages = ((YELLOW, " ".join(notes)), (GREY, facts.done), (RED, facts.fault), (GREY, coming))
        for other, message in messages:
            color, text = (other, message) if message else (color, text)
        wrapped(color, text if color == GREY and not facts.done else _shortened(text))
        explain(text)
        imgui.set_cursor_pos_y(top + 2.4 * imgui.get_text_line_height())

    def _light(self, state: State, refused: str) -> State:
        imgui.separator_text("Light")
        shown = state.environment if state.environment == DAYLIGHT else Path(state.environment).name
        meaning = f"{state.environment}\n'{DAYLIGHT}', or a picture: {BY_PATH}"
        typed = self.widgets.entered("environment", shown, meaning)
        if typed is not None:
            if typed == DAYLIGHT:
                state = replace(state, environment=DAYLIGHT, layout=None, border=None)
            else:
                state = with_file(state, absolute(typed))
        source = refused or state.environment  # what is said of it can make a picture that was refused good
        whose = "Of pictures: " if source == DAYLIGHT else f"Of {Path(source).name}: "
        with disabled(source == DAYLIGHT):
            known = [RECOGNISED, *LAYOUTS]
            current = RECOGNISED if refused else state.layout or RECOGNISED
            changed, chosen = imgui.combo("layout", known.index(current), known)
            self.widgets.place("layout")
            explain(
                f"{whose}how it unrolls the sphere: lat-long, cross or strip of a cube's faces, mirror ball, "
                "probe and others. Choose one where the picture's shape does not tell."
            )
            if changed:
                layout = known[chosen] if chosen else None
                state = replace(state, environment=source, layout=layout, border=None)
        if self.widgets.button("Daylight", "An analytic sky with its sun, in place of a picture."):
            state = replace(state, environment=DAYLIGHT, layout=None, border=None)
        imgui.same_line()
        with disabled(state.light == UNTURNED):
            if self.widgets.button(
                "Reset light (R)",
                "Undo the rotation of the light, which dragging with the right button changes.",
            ):
                state = replace(state, light=UNTURNED)
        imgui.same_line()
        repaired = f"{whose}replace texels that are not finite by their neighbours; otherwise it is refused."
        if self.widgets.check("repair", "repair", state.repair, repaired):
            state = replace(state, environment=source, repair=not state.repair)
        meaning = "Rotate the light about the vertical, once in 12 seconds. (Key T)"
        if self.widgets.check("turning", "auto-rotate (T)", state.turning, meaning):
            state = replace(state, turning=not state.turning)
        return state

    def _accuracy(self, state: State, facts: Facts) -> State:
        imgui.separator_text("Accuracy")
        if self.widgets.radio("by tolerance", state.orders is None):
            state = replace(state, orders=None)
        explain("F and P are chosen for each object, for the tolerance.")
        imgui.same_line()
        mine = None if facts.result is None else _of(facts.result.maps, state.selected)
        if self.widgets.radio("orders F, P", state.orders is not None) and state.orders is None:
            state = replace(state, orders=(12, 2) if mine is None else (mine.F, mine.P))
        explain("F and P as they are set, the same for all objects, whatever error they leave.")
        if state.orders is None:
            flags = imgui.SliderFlags.LOGARITHMIC | imgui.SliderFlags.CLAMP_ON_INPUT
            changed, percent = imgui.slider_float(
                "tolerance", 100.0 * state.tolerance, 1.0, 50.0, "%.1f %%", flags
            )
            self.widgets.place("tolerance")
            explain("Relative RMS error of the reflected light over all normals and views.")
            if changed:
                state = replace(state, tolerance=round(percent / 100.0, 4))
        else:
            state = self._orders(state, *state.orders)
        if mine is None or facts.result is None:
            imgui.text_colored(GREY, "prefiltering ...\n ")
            return state
        drawn = facts.result.drawn[min(state.selected, len(facts.result.drawn) - 1)]
        parts = (
            drawn.parts
            if isinstance(drawn, ReflectionMap)
            else [layer for lobe in drawn.lobes for layer in lobe.layers]
        )
        maps = sum(part.rings.shape[1] for part in parts)
        word = "map" if maps == 1 else "maps"
        whose = f"object {state.selected + 1}: " if len(state.materials) > 1 else ""
        if state.filter is not None:
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
        self.widgets.place("F")
        explain(OF_LIGHT)
        imgui.same_line()
        _, P = imgui.slider_int("P", P, 0, P_MAX, "%d", clamp)
        self.widgets.place("P")
        explain(OF_VIEW)
        imgui.pop_item_width()
        return state if state.orders == (F, P) else replace(state, orders=(F, P))

    def _predicted(self, state: State, mine: ReflectionMap, errors: tuple[float, ...] | None) -> None:
        if state.technique != "shrm":
            imgui.text_colored(GREY, "error: not predicted for this technique")
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

    def _technique(self, state: State, facts: Facts) -> State:
        imgui.separator_text("Technique")
        choices, labels, meanings = zip(*TECHNIQUES, strict=True)
        current = choices.index((state.technique, state.filter))
        changed, chosen = imgui.combo("technique", current, list(labels))
        self.widgets.place("technique")
        explain(f"What the maps hold of the reflected light. {labels[current]}: {meanings[current]}")
        if changed:
            technique, filter = choices[chosen]
            state = replace(state, technique=technique, filter=filter)
        viewer = self.widgets.choice("viewer", VIEWERS, state.viewer)
        shown = self.widgets.choice("shown ", SHOWN, state.shown)
        imgui.text_colored(GREY, facts.integrated or " ")
        return replace(state, viewer=viewer, shown=shown)

    def _picture(self, state: State, actions: list[Action]) -> State:
        imgui.separator_text("Picture")
        changed, stops = imgui.slider_float("exposure", state.exposure, -12.0, 12.0, "%+.2f stops")
        self.widgets.place("exposure")
        explain("Twice as bright for each stop.")
        if changed:
            state = replace(state, exposure=stops, automatic=False)
        meaning = "Choose the exposure anew when light, material or shape change; E does so at any time."
        if self.widgets.check("auto", "auto (E)", state.automatic, meaning):
            state = replace(state, automatic=not state.automatic)
        imgui.same_line()
        meaning = "Show the environment behind the objects."
        if self.widgets.check("background", "background (B)", state.background, meaning):
            state = replace(state, background=not state.background)
        for index, (action, label, meaning) in enumerate(BUTTONS):
            if index:
                imgui.same_line()
            if self.widgets.button(label, meaning):
                actions.append(action)
        return state

    def _times(self, facts: Facts) -> None:
        imgui.separator_text("Time")
        drawing = facts.frame_seconds
        prefiltering = 0.0 if facts.result is None else facts.result.seconds
        rate = f" ({1.0 / drawing:.0f} frames/s)" if drawing > 0.0 else ""
        imgui.text(f"drawing      {1e3 * drawing:6.1f} ms{rate}")
        explain("The last frame, by OpenGL.")
        working = " (working ...)" if facts.working else ""
        if facts.result is not None and facts.result.transferred is not None:
            imgui.text(f"lighting     {1e3 * facts.lighting_seconds:6.1f} ms{working}")
            explain("From the light's coefficients to radiance at all vertices, when one changed last.")
            return
        imgui.text(f"prefiltering {1e3 * prefiltering:6.1f} ms{working}")
        explain("From light and material to maps, for all objects, when one of them changed last.")


def _of(maps: tuple[ReflectionMap, ...], index: int) -> ReflectionMap | None:
    """The map of an object, if it is there yet."""
    return maps[index] if index < len(maps) else None


def _shortened(text: str) -> str:
    """Text without what stands in parentheses at its end, and a path in front of it as a name."""
    head, colon, rest = text.partition(" (")[0].partition(": ")
    short = f"{Path(head).name}: {rest}" if colon and "/" in head else head + colon + rest
    return short if len(short) <= MOST_CHARACTERS else f"{short[: MOST_CHARACTERS - 3]}..."
