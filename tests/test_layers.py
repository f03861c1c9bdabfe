"""Arrows run one way: the order of modules, and who may import what.

A module that is not in these lists fails the test: put it where the data flows through it.
"""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "python" / "shrm"

# Each stage may import only those above it; a name stands for a module or a package's whole folder.
PYTHON_ORDER = [
    ["_core"],
    ["validation", "faults", "lookup"],
    ["color"],
    ["image_io"],
    ["layouts"],
    ["daylight", "paraboloid"],
    ["environment"],
    ["brdf"],
    ["lobe_split"],
    ["lobe_quadrature"],
    ["central_direction"],
    ["measurement_quality"],
    ["sh"],
    ["brdf_analysis"],
    ["orders"],
    ["split_orders"],
    ["rings"],
    ["radial_table"],
    ["lobe_tables"],
    ["lobe_integrals"],
    ["reference"],
    ["lobe_descents"],
    ["hierarchical"],
    ["lobe_frames"],
    ["residual"],
    ["reflection_map", "reflection_file", "residual_file"],  # a map's save and load are the file's
    ["map_interpolation"],
    ["icosahedral"],
    ["explicit"],
    ["cost"],
    ["prefiltering"],
    ["kautz_mccool"],
    ["prefiltered"],
    ["methods"],
    ["relighting"],
    ["directional_basis"],
    ["brdf_matrix"],
    ["tangent_frames"],
    ["transfer"],
    ["render"],
    ["material_figure"],
    ["export"],
    ["demo"],
    ["viewer"],
    ["reproduce"],
    ["cli"],
]


def stages(order: list[list[str]]) -> dict[str, int]:
    return {part: index for index, parts in enumerate(order) for part in parts}


PYTHON_STAGE = stages(PYTHON_ORDER)

# The integrators judge the harmonics, so they may use nothing of them.
PYTHON_JUDGES = {
    "radial_table",
    "lobe_tables",
    "lobe_integrals",
    "reference",
    "lobe_descents",
    "hierarchical",
}
PYTHON_NEUTRAL = {
    "_core",
    "validation",
    "image_io",
    "layouts",
    "environment",
    "brdf",
    "lobe_split",
    "lobe_quadrature",
    "central_direction",
}

# Each wraps its part of the core.
CORE_WRAPPERS = {
    "_core",
    "layouts",
    "environment",
    "brdf",
    "sh",
    "lobe_quadrature",
    "brdf_analysis",
    "rings",
    "reflection_map",
    "explicit",
    "lobe_descents",
    "hierarchical",
    "residual",
    "relighting",
    "lobe_integrals",
    "reference",
    "directional_basis",
    "transfer",
}
ONLY_IN = {
    "OpenImageIO": {"image_io"},
    **{library: {"viewer"} for library in ("moderngl", "glfw", "OpenGL", "slimgui")},
    **{library: {"render", "transfer"} for library in ("trimesh", "embreex")},
}

PYTHON_FILES = sorted(PACKAGE.rglob("*.py"))


def unit_of(path: Path) -> str:
    """The name in PYTHON_ORDER that a file of the package belongs to."""
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imports(path: Path) -> set[str]:
    """Absolute dotted names of everything a file imports, inside functions too."""
    package = ("shrm", *path.relative_to(PACKAGE).parent.parts)
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join([*base, *([node.module] if node.module else [])])
            names.update(f"{module}.{alias.name}" for alias in node.names)
    return names


def own_units(path: Path) -> set[str]:
    """The units of the package that a file imports."""
    parts = [name.split(".") for name in imports(path)]
    return {part[1] for part in parts if part[0] == "shrm" and len(part) > 1 and part[1] in PYTHON_STAGE}


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", PYTHON_FILES, ids=name_of)
def test_python_arrows_run_one_way(path: Path) -> None:
    unit = unit_of(path)
    if unit == "__init__":  # the package's front door shows what lies behind it
        return
    assert unit in PYTHON_STAGE, f"{unit} is not in PYTHON_ORDER"
    later = {other for other in own_units(path) if PYTHON_STAGE[other] > PYTHON_STAGE[unit]}
    assert not later, f"{name_of(path)} imports {sorted(later)}, which come after it"
    assert unit not in PYTHON_JUDGES or own_units(path) <= PYTHON_NEUTRAL | PYTHON_JUDGES


@pytest.mark.parametrize("path", PYTHON_FILES, ids=name_of)
def test_each_library_is_behind_one_module(path: Path) -> None:
    unit = unit_of(path)
    assert "_core" not in own_units(path) or unit in CORE_WRAPPERS, f"{name_of(path)} imports _core"
    for name in {name.split(".")[0] for name in imports(path)}:
        assert unit in ONLY_IN.get(name, {unit}), f"{name_of(path)} imports {name}: only {ONLY_IN[name]} may"


def test_oracles_share_no_code_with_their_subject() -> None:
    path = ROOT / "tests" / "oracles.py"
    if not path.exists():
        pytest.skip("there are no oracles yet")
    assert not re.search(r"^\s*(import|from)\s+shrm", path.read_text(), re.MULTILINE)


@pytest.mark.parametrize("path", PYTHON_FILES, ids=name_of)
def test_a_file_is_one_idea_with_a_name(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= 450
    assert not re.search(r"util|helper|manager|misc|common", path.stem)
