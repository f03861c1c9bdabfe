"""The rooms of the C++ core: their order, who may include what, and that none includes itself."""

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORE = ROOT / "cpp" / "shrm"

# Files of a room include files of that room and of those before it. The first is the top folder itself.
ROOMS = [
    "",
    "simd",
    "pictures",
    "sh",
    "brdf",
    "reflection",
    "angular",
    "hierarchical",
    "transfer",
]
# The integrators judge the harmonics, so they may use nothing of them.
JUDGES = {"angular", "hierarchical"}
NEUTRAL = {"", "simd", "pictures"}

FILES = sorted(CORE.rglob("*.[ch]pp"))


def name_of(path: Path) -> str:
    return path.relative_to(CORE).as_posix()


def room_of(name: str) -> str:
    """The room of a file, named as it is included after ``shrm/``."""
    return name.rpartition("/")[0]


def includes(path: Path) -> set[str]:
    """The core's own files that a file includes, named as after ``shrm/``."""
    quoted = re.findall(r'^\s*#\s*include\s*"(.+?)"', path.read_text(), re.MULTILINE)
    unrooted = [name for name in quoted if not name.startswith("shrm/")]
    assert not unrooted, f"{name_of(path)} includes {unrooted}: write shrm/ROOM/FILE"
    return {name.removeprefix("shrm/") for name in quoted}


def test_every_folder_is_a_room_and_every_room_a_folder() -> None:
    folders = {name_of(path) for path in CORE.rglob("*") if path.is_dir()}
    assert folders == set(ROOMS) - {""}
    assert len(ROOMS) == len(set(ROOMS))
    assert {room_of(name_of(path)) for path in FILES} == set(ROOMS)


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_arrows_run_one_way(path: Path) -> None:
    room = room_of(name_of(path))
    included = includes(path)
    missing = sorted(name for name in included if not (CORE / name).is_file())
    assert not missing, f"{name_of(path)} includes {missing}, which are not there"
    later = sorted(name for name in included if ROOMS.index(room_of(name)) > ROOMS.index(room))
    assert not later, f"{name_of(path)} includes {later}, whose rooms come after its own"
    if room in JUDGES:
        assert {room_of(name) for name in included} <= NEUTRAL | JUDGES, f"{name_of(path)} is a judge"


def test_no_file_includes_itself_by_way_of_others() -> None:
    TopologicalSorter({name_of(path): includes(path) for path in FILES}).prepare()  # CycleError if one does


@pytest.mark.parametrize("path", FILES, ids=name_of)
def test_a_file_is_one_idea_with_a_name(path: Path) -> None:
    text = path.read_text()
    assert len(text.splitlines()) <= 450
    assert not re.search(r"util|helper|manager|misc|common", path.stem)
    assert not re.search(r"pybind11|Python\.h", text), "the core knows no Python"


def test_the_first_file_names_every_other() -> None:
    text = (CORE / "core.hpp").read_text()
    index = re.sub(r"//\s*", " ", text[text.index("// ROOMS") : text.index("#pragma once")])
    words = set(re.findall(r"[\w/]+", index))
    assert {path.stem for path in FILES} - {"core"} <= words
    assert {f"{room}/" for room in ROOMS if room} <= words
