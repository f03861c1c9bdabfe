"""Texts, explanations and controls of the panel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

from slimgui import imgui

WIDTH = 380  # of the panel

T = TypeVar("T")

RED, YELLOW, GREY = (1.0, 0.35, 0.3, 1.0), (1.0, 0.8, 0.3, 1.0), (0.62, 0.64, 0.68, 1.0)


def wrapped(color: tuple[float, float, float, float], text: str) -> None:
    """A text of several lines in a color."""
    imgui.push_style_color(imgui.Col.TEXT, color)
    imgui.text_wrapped(text)
    imgui.pop_style_color()


def explain(text: str) -> None:
    """Explain the last control beside the panel, where nothing of it is covered."""
    if (
        text
        and not imgui.is_item_active()
        and imgui.is_item_hovered(imgui.HoveredFlags.DELAY_NORMAL | imgui.HoveredFlags.ALLOW_WHEN_DISABLED)
    ):
        imgui.set_next_window_pos((WIDTH + 8.0, imgui.get_item_rect_min()[1]))
        imgui.begin_tooltip()
        imgui.push_text_wrap_pos(380.0)
        imgui.text(text)
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


@contextmanager
def disabled(whether: bool) -> Iterator[None]:
    """Grey out the controls within, which cannot be used then."""
    imgui.begin_disabled(whether)
    yield
    imgui.end_disabled()


class Widgets:
    """Controls whose places are kept.

    Attributes
    ----------
    places : dict of str to (x, y, x, y)
        Corners of each control of the last frame, in the window's units.
    """

    def __init__(self) -> None:
        self.places: dict[str, tuple[float, float, float, float]] = {}

    def place(self, name: str) -> None:
        """Keep the place of the last control."""
        self.places[name] = (*imgui.get_item_rect_min(), *imgui.get_item_rect_max())

    def entered(self, label: str, text: str, meaning: str) -> str | None:
        """A line of text; return another one that was typed in its place, once Enter is pressed."""
        flags = imgui.InputTextFlags
        entered, typed = imgui.input_text(label, text, flags.ENTER_RETURNS_TRUE | flags.AUTO_SELECT_ALL)
        self.place(label)
        explain(meaning)
        return typed.strip() or None if entered and typed != text else None

    def button(self, label: str, meaning: str = "") -> bool:
        """A button; whether it was pressed."""
        pressed = imgui.button(label)
        self.place(label)
        explain(meaning)
        return pressed

    def radio(self, label: str, active: bool) -> bool:
        """One of several choices; whether it was chosen."""
        pressed = imgui.radio_button(label, active)
        self.place(label)
        return pressed

    def choice(self, title: str, options: Sequence[tuple[T, str, str]], chosen: T) -> T:
        """A line of choices: what each stands for, its label and meaning; return the one chosen."""
        imgui.align_text_to_frame_padding()
        imgui.text(title)
        for option, label, meaning in options:
            imgui.same_line()
            if self.radio(label, chosen == option):
                chosen = option
            explain(meaning)
        return chosen

    def check(self, name: str, label: str, checked: bool, meaning: str) -> bool:
        """A box to be checked, whose place has a name; whether it was clicked."""
        clicked, _ = imgui.checkbox(label, checked)
        self.place(name)
        explain(meaning)
        return clicked
