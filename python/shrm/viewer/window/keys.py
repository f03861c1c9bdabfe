"""The list of keys, over the picture."""

from __future__ import annotations

from slimgui import imgui

from shrm.viewer.window.choices import KEYS

KEY_COLOR = (1.0, 0.8, 0.3, 1.0)


def draw_keys(left: float, width: float, height: float) -> None:
    """Draw the list of keys over the middle of the picture, which begins at `left`."""
    flags = imgui.WindowFlags
    imgui.set_next_window_pos((left + 0.5 * width, 0.5 * height), pivot=(0.5, 0.5))
    imgui.set_next_window_bg_alpha(0.9)
    kind = flags.NO_TITLE_BAR | flags.ALWAYS_AUTO_RESIZE | flags.NO_MOVE | flags.NO_SAVED_SETTINGS
    imgui.begin("keys", flags=kind | flags.NO_MOUSE_INPUTS | flags.NO_FOCUS_ON_APPEARING)
    if imgui.begin_table("keys", 2, imgui.TableFlags.SIZING_FIXED_FIT):
        for key, meaning in KEYS:
            imgui.table_next_row()
            imgui.table_next_column()
            imgui.text_colored(KEY_COLOR, key)
            imgui.table_next_column()
            imgui.text(meaning)
        imgui.end_table()
    imgui.end()
