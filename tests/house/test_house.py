"""Hygiene is a test: style, types and format, by the tools of the test extra."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.machine import tool

ROOT = Path(__file__).parents[2]
CPP = sorted(str(path) for path in [*ROOT.glob("cpp/**/*.[ch]pp"), *ROOT.glob("tests/*.cpp")])

CHECKS = {
    "ruff check": ["ruff", "check", "python", "tests", "bench"],
    "ruff format": ["ruff", "format", "--check", "python", "tests", "bench"],
    "mypy --strict": ["mypy"],
    "clang-format": ["clang-format", "--dry-run", "-Werror", *CPP],
}


@pytest.mark.parametrize("command", CHECKS.values(), ids=CHECKS.keys())
def test_the_tool_has_nothing_to_say(command: list[str]) -> None:
    done = subprocess.run(
        [tool(command[0]), *command[1:]], cwd=ROOT, capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_one_version_everywhere() -> None:
    version = re.search(r'^version = "(.+)"', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    cited = re.search(r"^version: (.+)", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    installed = re.search(
        r'^__version__ = "(.+)"', (ROOT / "python/shrm/version.py").read_text(), re.MULTILINE
    )
    assert version is not None
    assert installed is not None
    assert installed[1] == version[1]
    assert cited is not None
    assert cited[1] == version[1]
    assert re.search(
        rf"^## \[({re.escape(version[1])}|Unreleased)\]", (ROOT / "CHANGELOG.md").read_text(), re.M
    )


BIBLIOGRAPHIES = {
    "python": ("python/shrm/bibliography.py", r"^    \[(\w+)\] ", ["python/**/*.py", "tests/**/*.py"]),
    "core": ("cpp/shrm/core.hpp", r"^//   \[(\w+)\] ", ["cpp/**/*.[ch]pp", "tests/*.cpp"]),
}


@pytest.mark.parametrize(("place", "entry", "sources"), BIBLIOGRAPHIES.values(), ids=BIBLIOGRAPHIES)
def test_what_is_cited_is_in_the_bibliography_and_what_is_there_is_cited(
    place: str, entry: str, sources: list[str]
) -> None:
    text = (ROOT / place).read_text()
    entries = re.findall(entry, text, re.MULTILINE)
    key = re.compile(r"\[([A-Z][A-Za-z]*\d{2,3})(?=[\],; ])")
    paths = {path for pattern in sources for path in ROOT.glob(pattern)} - {ROOT / place}
    cited = {name for path in paths for name in key.findall(path.read_text())}
    if place.endswith(".hpp"):  # its conventions, after the bibliography or before, cite too
        cited |= set(key.findall(re.sub(entry, "", text, flags=re.MULTILINE)))
    assert len(entries) == len(set(entries))
    assert cited - set(entries) == set()
    assert set(entries) - cited == set()


def test_bibliographies_are_found_in_one_place_each() -> None:
    """Modules cite by key; who wants the title looks it up there."""
    for path in ROOT.glob("python/**/*.py"):
        assert not re.search(r"^ *References\n *-+$", path.read_text(), re.MULTILINE), path


@pytest.mark.parametrize("page", ["README.md", "bench/README.md", "docs/architecture.md"])
def test_files_that_a_page_names_are_there(page: str) -> None:
    folders = "bench|cpp|docs|examples|python|tests"
    for name in set(re.findall(rf"\b((?:{folders})/[\w/.-]*\w)", (ROOT / page).read_text())):
        assert (ROOT / name).exists() or list(ROOT.glob(f"{name}.*")), f"{page} names {name}"


@pytest.mark.slow
def test_the_benchmarks_can_be_collected() -> None:
    """Nothing else imports them: a name that has moved would show first when they are wanted."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "bench", "--collect-only", "--quiet"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_importing_the_package_and_the_command_is_light() -> None:
    """Plots, meshes, windows and progress bars are loaded by the commands that need them."""
    code = "import sys, json, shrm, shrm.cli; print(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {"matplotlib", "trimesh", "embreex", "moderngl", "scipy", "rich", "shrm.render", "shrm.viewer"}
    assert not heavy & set(json.loads(done.stdout))


@pytest.mark.parametrize(("room", "name"), [("render", "Mesh"), ("viewer", "Renderer")])
def test_pictures_and_the_viewer_are_attributes_of_the_package(room: str, name: str) -> None:
    """They are loaded when they are first asked for, and listed before that."""
    code = (
        f"import sys, shrm; assert 'shrm.{room}' not in sys.modules and '{room}' in dir(shrm) and "
        f"'{room}' in shrm.__all__; print(shrm.{room}.{name}.__name__); import shrm.{room} as again; "
        f"assert again is shrm.{room} and not hasattr(shrm, 'nothing'); "
        "assert {*dir(shrm)} == {*shrm.__all__, '__version__'}"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == name
