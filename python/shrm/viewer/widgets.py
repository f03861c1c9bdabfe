"""Texts, explanations and disabled controls of the panel."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from slimgui import imgui

WIDTH = 380  # of the panel


def wrapped(color: tuple[float, float, float, float], text: str) -> None:
    """A text of several lines in a colour."""
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
