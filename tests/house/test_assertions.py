"""Every test can fail: it asserts something, or calls what asserts, or a process that must succeed."""

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
FILES = sorted(TESTS.rglob("test_*.py"))

# What they call must not raise: that is all that they are about.
MUST_NOT_RAISE = {"test_materials_and_environments_pass"}


def asserts(function: ast.FunctionDef, others: set[str]) -> bool:
    """Say whether a function asserts, itself or by one of the other functions, which do."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assert):
            return True
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func)
            if (
                called in others
                or "assert" in called
                or called in ("pytest.raises", "pytest.warns", "pytest.fail")
            ):
                return True
            if called.endswith(".prepare") or (
                called == "subprocess.run" and "check=True" in ast.unparse(node)
            ):
                return True
    return False


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(TESTS).as_posix())
def test_every_test_asserts(path: Path) -> None:
    functions = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.FunctionDef)]
    helpers: set[str] = set()
    for _ in range(3):  # helpers of helpers
        helpers |= {node.name for node in functions if asserts(node, helpers)}
    tests = [node for node in functions if node.name.startswith("test_")]
    assert {node.name for node in tests if not asserts(node, helpers)} <= MUST_NOT_RAISE
