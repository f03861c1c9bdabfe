"""Names in figures: any script, dollars, lines and lengths are drawn, and nothing is warned of."""

import io

import matplotlib
import pytest
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager
from shrm.render import drawn_text as module
from shrm.render.drawn_text import LONGEST, drawn_text

NAMES = [
    "",
    "oak, waxed",
    "木の板",
    "나무 판자",
    "木板",
    "лак Ωμέγα",
    "خشب עץ",
    "price $5 and $6_7^8$",
    "two\nlines\tand a tab",
    "bell \x07, lone \ud800, private \ue000",
    "\U0001f9ea test tube",
    "a very long name " * 40,
    "木" * 500,
]


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_any_name_is_drawn_without_a_warning(name):
    """Warnings are errors here: matplotlib has one for each letter it has no glyph for."""
    drawn = drawn_text(name)
    assert "\n" not in drawn.text
    assert len(drawn.text) <= LONGEST
    figure = Figure()
    figure.suptitle(drawn.text, parse_math=False, family=drawn.family)
    figure.savefig(io.BytesIO(), format="png")


def test_plain_names_stay_as_they_are():
    name = "0.5*lambert(albedo=0.8) + ggx(alpha=0.2): $_naïve_$"
    assert drawn_text(name).text == name


def test_letters_that_no_font_has_are_escaped(monkeypatch):
    monkeypatch.setattr(module, "_fonts", lambda: ())
    assert drawn_text("木 board").text == r"\u6728 board"
    assert drawn_text("\U0001f9ea").text == r"\U0001f9ea"


def test_letters_are_drawn_with_a_font_that_has_them(monkeypatch):
    """An installed one stands for one of another script: the first is taken to have a and b alone."""
    entry = next(entry for entry in fontManager.ttflist if entry.name == "DejaVu Serif")
    monkeypatch.setattr(module, "_letters_of_family", lambda family: frozenset(b"ab"))
    monkeypatch.setattr(module, "_fonts", lambda: (entry,))
    drawn = drawn_text("abcd")
    assert drawn.text == "abcd"
    assert drawn.family[1:] == ("DejaVu Serif",)


def test_the_middle_of_long_names_is_left_out_and_no_escape_is_cut(monkeypatch):
    assert drawn_text("material " * 30 + "end").text.endswith("end")
    monkeypatch.setattr(module, "_fonts", lambda: ())
    text = drawn_text("木" * 50).text
    assert set(text.replace("...", "").split(r"\u")) == {"", "6728"}


def test_the_style_is_left_alone():
    """Fonts are given to the text: the family that others draw with stays what it was."""
    before = dict(matplotlib.rcParams)
    drawn_text("木の板")
    assert dict(matplotlib.rcParams) == before
