"""Files and names that comments, docstrings and documents speak of are there."""

import pkgutil
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("cpp", "python", "tests", "bench", "docs")
TEXTS = {".py", ".pyi", ".cpp", ".hpp", ".frag", ".vert", ".glsl", ".md"}

FILE = re.compile(rf"(?<![\w/.])((?:{'|'.join(FOLDERS)})/[\w/-]+\.[a-z]+)\b")
"""A file, from the root."""
NAME = re.compile(r"(?<![\w./-])(shrm(?:_papers)?(?:\.[A-Za-z_]\w*)+)")
"""A module, or what is in it."""


def mentions(pattern: re.Pattern[str]) -> list[str]:
    """Return what the texts speak of, without the changelog, which names what is gone."""
    paths = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in TEXTS]
    paths = [path for path in [*paths, ROOT / "README.md"] if path != Path(__file__)]
    texts = [path.read_text(encoding="utf-8") for path in paths]
    return sorted({mention for text in texts for mention in pattern.findall(text)})


def resolves(name: str) -> bool:
    """Return whether a dotted name leads to a module, an attribute, or a field of a dataclass."""
    try:
        pkgutil.resolve_name(name)
    except AttributeError:
        owner, _, field = name.rpartition(".")
        return resolves(owner) and field in getattr(pkgutil.resolve_name(owner), "__dataclass_fields__", {})
    return True


def test_files_that_are_spoken_of_are_there() -> None:
    assert [path for path in mentions(FILE) if not (ROOT / path).is_file()] == []


def test_names_that_are_spoken_of_are_there() -> None:
    assert [name for name in mentions(NAME) if not resolves(name)] == []


def test_names_that_are_not_there_do_not_resolve() -> None:
    assert resolves("shrm.frequency.request.Request.tolerance")
    assert not resolves("shrm.frequency.request.Request.nothing")
    assert not resolves("shrm.no_module.name")
