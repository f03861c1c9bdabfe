"""Arrows run one way: data flows through the rooms from top to bottom, and no two modules import each other.

The rooms are the modules and folders of the package. One that is not in ROOMS fails the test: put it where
the data flows through it. Imports inside functions count like all others.
"""

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ROOT / "python"

# Each room may import only those above it.
ROOMS = [
    "version",
    "bibliography",
    "arrays",
    "vectors",
    "threads",
    "_core",
    "validation",
    "files",
    "color",
    "image_io",
    "environment",
    "brdf",
    "lobes",
    "sh",
    "integrate",
    "frequency",
    "methods",
    "prefiltered",
    "result_files",
    "transfer",
    "render",
    "viewer",
    "cli",
]

# The same of the folders of a room.
INNER_ROOMS = {
    "transfer": ["rays", "matrices", "compression", "lighting"],
    "viewer": ["gpu", "window"],
}

# The integrators judge frequency space, so they may use nothing of it.
UNKNOWN_TO_THE_JUDGES = {"sh", "frequency", "methods"}

# Who may import what lies outside the package.
ONLY_IN = {
    "OpenImageIO": {"image_io"},
    **{library: {"viewer"} for library in ("moderngl", "glfw", "OpenGL", "slimgui")},
    **{library: {"render", "transfer"} for library in ("trimesh", "embreex")},
}
WITHOUT_THE_CORE = {
    "version",
    "bibliography",
    "arrays",
    "vectors",
    "threads",
    "validation",
    "files",
    "color",
    "image_io",
    "methods",
    "result_files",
    "render",
    "viewer",
    "cli",
}


def module_name(path: Path) -> str:
    """The dotted name of a file's module."""
    return ".".join(path.relative_to(PACKAGES).with_suffix("").parts).removesuffix(".__init__")


FILES = {module_name(path): path for path in sorted(PACKAGES.rglob("*.py"))}
MODULES = {name for name in FILES if name.split(".")[0] == "shrm"} - {"shrm"}
OF_PAPERS = {name for name in FILES if name.split(".")[0] == "shrm_papers"} - {"shrm_papers"}

# shrm_papers, in the order that its docstring gives; the papers stand in one line of it.
PAPERS = ["rh02", "kvhs00", "lk03"]
PAPERS_DOC = ast.get_docstring(ast.parse(FILES["shrm_papers"].read_text())) or ""
ORDER_OF_PAPERS = re.findall(r"^    (\w+)(?=  |/)", PAPERS_DOC, re.M)


def imports(path: Path) -> set[str]:
    """Absolute dotted names of everything a file imports, inside functions too."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports by a relative name"
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


def imported_modules(path: Path) -> set[str]:
    """The modules of the project that a file imports, packages as the modules of their `__init__`."""
    return {name if name in FILES else name.rpartition(".")[0] for name in imports(path)} & set(FILES)


def room_of(module: str) -> str:
    """The name in ROOMS of a module of shrm."""
    return module.split(".")[1]


def test_the_rooms_are_those_that_there_are() -> None:
    assert len(ROOMS) == len(set(ROOMS))
    assert {room_of(module) for module in MODULES} == set(ROOMS)


@pytest.mark.parametrize("module", sorted(MODULES))
def test_arrows_run_one_way(module: str) -> None:
    own = {name for name in imported_modules(FILES[module]) if name.startswith("shrm.")}
    later = {name for name in own if ROOMS.index(room_of(name)) > ROOMS.index(room_of(module))}
    assert not later, f"{module} imports {sorted(later)}, which come after it"
    if room_of(module) == "integrate":
        assert not {room_of(name) for name in own} & UNKNOWN_TO_THE_JUDGES
    assert "shrm" not in imported_modules(FILES[module]), f"{module} imports the package's front door"


@pytest.mark.parametrize("room", INNER_ROOMS)
def test_arrows_run_one_way_inside_a_room(room: str) -> None:
    order = [f"shrm.{room}.{folder}" for folder in INNER_ROOMS[room]]
    assert {module.rpartition(".")[0] for module in MODULES if room_of(module) == room} == {
        "shrm",
        f"shrm.{room}",
        *order,
    }
    for place, folder in enumerate(order):
        later = tuple(f"{name}." for name in order[place + 1 :])
        for module in (name for name in MODULES if f"{name}.".startswith(f"{folder}.")):
            imported = [name for name in imported_modules(FILES[module]) if f"{name}.".startswith(later)]
            assert not later or not imported, f"{module} imports {imported}, which come after it"


def test_no_two_modules_import_each_other() -> None:
    graph = {name: imported_modules(path) - {name} for name, path in FILES.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"modules import each other: {' -> '.join(error.args[1])}")


def test_the_order_of_shrm_papers_is_that_of_its_docstring() -> None:
    assert {room_of(module) for module in OF_PAPERS} == {*ORDER_OF_PAPERS, *PAPERS}


@pytest.mark.parametrize("module", sorted(OF_PAPERS))
def test_papers_know_what_they_share_and_not_each_other(module: str) -> None:
    place = {room: ORDER_OF_PAPERS.index(room) for room in ORDER_OF_PAPERS}
    place |= dict.fromkeys(PAPERS, place["rh02"])
    room = room_of(module)
    own = {name for name in imported_modules(FILES[module]) if name.startswith("shrm_papers")}
    assert "shrm_papers" not in own, f"{module} imports the package's front door"
    others = {room_of(name) for name in own} - {room}
    assert {other for other in others if place[other] >= place[room]} == set()


def test_nothing_of_the_library_imports_the_papers() -> None:
    """`shrm reproduce` does, when it runs."""
    importers = {
        name
        for name in MODULES
        if any(imported.split(".")[0] == "shrm_papers" for imported in imports(FILES[name]))
    }
    assert importers == {"shrm.cli.reproduce"}


@pytest.mark.parametrize("module", sorted(MODULES))
def test_each_library_is_behind_one_room(module: str) -> None:
    names = imports(FILES[module])
    if room_of(module) in WITHOUT_THE_CORE:
        assert "shrm._core" not in imported_modules(FILES[module])
    for library in {name.split(".")[0] for name in names}:
        allowed = ONLY_IN.get(library, {room_of(module)})
        assert room_of(module) in allowed, f"{module} imports {library}: only {allowed} may"


def test_oracles_share_no_code_with_their_subject() -> None:
    path = ROOT / "tests" / "support" / "oracles.py"
    assert not re.search(r"^\s*(import|from)\s+shrm", path.read_text(), re.MULTILINE)


@pytest.mark.parametrize("module", sorted(FILES))
def test_a_file_is_one_idea_with_a_name(module: str) -> None:
    assert len(FILES[module].read_text().splitlines()) <= 450
    assert not re.search(r"util|helper|manager|misc|common", FILES[module].stem)
