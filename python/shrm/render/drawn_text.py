"""Names as figures can draw them: on one line, short enough, in letters that a font has.

Names come from files and users, in any script. Letters that matplotlib's own font lacks are drawn with one of
the system's that has them; where there is none, as Python escapes them: no name is lost in boxes.
"""

from __future__ import annotations

import unicodedata
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.font_manager import FontEntry

LONGEST = 90
"""Characters of a name that are drawn, about what a figure is wide; escapes count as they are written."""
_PLACEHOLDERS = "Last Resort"
"""Fonts of this name have a box for every letter."""


class DrawnText(NamedTuple):
    """A text and the font families that have its letters, the first of them matplotlib's own."""

    text: str
    family: tuple[str, ...]


def drawn_text(name: str, longest: int = LONGEST) -> DrawnText:
    """Return what is drawn of a name; draw it with `parse_math=False`, as dollars are letters here.

    Parameters
    ----------
    name : str
        Any text.
    longest : int
        Characters at most; of a longer one the middle is left out.

    Returns
    -------
    DrawnText
    """
    from matplotlib import rcParams

    line = " ".join(name.split())
    own = str(rcParams["font.family"][0])
    missing = {letter for letter in line if ord(letter) not in _letters_of_family(own)}
    family = [own]
    for entry in _fonts() if any(map(_is_shown, missing)) else ():
        found = {letter for letter in missing if _is_shown(letter) and ord(letter) in _letters(entry.fname)}
        if found:
            family.append(entry.name)
            missing -= found
    shown = [_escape(letter) if letter in missing else letter for letter in line]
    return DrawnText(_shortened(shown, longest), tuple(family))


def _is_shown(letter: str) -> bool:
    """Whether a letter is more than a control, a surrogate or one that nobody has defined."""
    return unicodedata.category(letter)[0] != "C"


def _escape(letter: str) -> str:
    """Return a letter as Python escapes it."""
    return letter.encode("unicode_escape", "surrogatepass").decode("ascii")


def _shortened(parts: list[str], longest: int) -> str:
    """Join letters and escapes, none of which is cut, without the middle of what is too long."""
    if sum(map(len, parts)) <= longest:
        return "".join(parts)
    room = longest - len("...")
    head = tail = 0
    used = 0
    while used + len(parts[head]) <= room * 2 // 3:
        used += len(parts[head])
        head += 1
    while used + len(parts[-1 - tail]) <= room:
        used += len(parts[-1 - tail])
        tail += 1
    return "".join(parts[:head]) + "..." + "".join(parts[len(parts) - tail :])


@cache
def _letters_of_family(family: str) -> frozenset[int]:
    """Return the code points that matplotlib's font for a family has letters for."""
    from matplotlib.font_manager import FontProperties, findfont

    return _letters(findfont(FontProperties(family=[family])))


@cache
def _letters(path: str) -> frozenset[int]:
    """Return the code points that a font file has letters for."""
    from matplotlib.font_manager import get_font

    try:
        return frozenset(get_font(path).get_charmap())
    except (OSError, RuntimeError):  # a file that went away or is damaged
        return frozenset()


@cache
def _fonts() -> tuple[FontEntry, ...]:
    """Return the installed fonts that are upright and of normal weight, those without serifs first."""
    from matplotlib.font_manager import fontManager

    fonts = {
        entry.name: entry
        for entry in fontManager.ttflist
        if entry.style == "normal" and str(entry.weight) in ("400", "normal", "regular", "book")
    }
    kept = [entry for name, entry in fonts.items() if not name.startswith(_PLACEHOLDERS)]
    return tuple(sorted(kept, key=lambda entry: ("Sans" not in entry.name, entry.name)))
