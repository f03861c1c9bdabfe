"""A file is one idea, and a function can be seen at once: their lengths, here, in the tests and in bench."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = [path for folder in ("python", "tests", "bench") for path in sorted((ROOT / folder).rglob("*.py"))]


def lengths(path: Path) -> Iterator[tuple[str, int]]:
    """Yield the name of each function and the lines of its body, its docstring left out."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            body = node.body[ast.get_docstring(node) is not None :]
            yield node.name, 1 + body[-1].end_lineno - body[0].lineno if body else 0


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_functions_have_at_most_60_lines_and_files_450(path: Path) -> None:
    name = path.relative_to(ROOT).as_posix()
    too_long = {f"{name}:{function}" for function, lines in lengths(path) if lines > 60}
    assert not too_long
    assert len(path.read_text().splitlines()) <= 450
