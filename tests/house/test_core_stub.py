"""The core's stub says what the built module has: names, parameters, their order and kinds, defaults, types.

mypy's stubtest does not do it: it has no signatures of pybind11's functions, which stand in their docstrings.
"""

import ast
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from shrm import _core

STUB = Path(_core.__file__).with_suffix(".pyi").read_text()

# How the stub writes pybind11's types.
TYPES = {
    "typing.SupportsInt | typing.SupportsIndex": "int",
    "typing.SupportsFloat | typing.SupportsIndex": "float",
    "typing.Annotated[collections.abc.Sequence[int], 'FixedSize(3)']": "tuple[int, ...]",
    "numpy.typing.NDArray[numpy.bool]": "Bool",
    **{
        f"numpy.typing.NDArray[numpy.{kind}{bits}]": f"{kind[0].upper()}{bits}"
        for kind in ("float", "int")
        for bits in (16, 32, 64)
    },
}

Signature = dict[str, str]
"""How each parameter is passed, whether it has a default, and its type; what is returned."""


def signature(function: ast.FunctionDef, written: Callable[[ast.expr], str]) -> Signature:
    """What callers see of a function, its own object aside."""
    arguments = function.args
    positional = [*arguments.posonlyargs, *arguments.args]
    kinds = ["positional"] * len(arguments.posonlyargs) + ["either"] * len(arguments.args)
    defaults = [None] * (len(positional) - len(arguments.defaults)) + list(arguments.defaults)
    keywords = zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    of_all = [
        *zip(positional, kinds, defaults, strict=True),
        *((argument, "keyword", default) for argument, default in keywords),
    ]
    result = {
        argument.arg: f"{kind}, {'optional' if default else 'required'}, "
        + (written(argument.annotation) if argument.annotation else "")
        for argument, kind, default in of_all
        if argument.arg != "self"
    }
    return result | {"return": written(function.returns) if function.returns else ""}


def of_stub(annotation: ast.expr) -> str:
    return ast.unparse(annotation)


def of_core(annotation: ast.expr) -> str:
    """A type of pybind11's as the stub would write it."""
    text = re.sub(r"\bshrm\._core\.\w+\.", "", ast.unparse(annotation))
    for pybind, stub in TYPES.items():
        text = text.replace(pybind, stub)
    return text


def of_docstring(function: object) -> list[Signature]:
    """The signatures of one of the core's functions, several if it is overloaded."""
    lines = (function.__doc__ or "").splitlines()
    overloads = [line.partition(" ")[2] for line in lines if re.match(r"\d+\. \w+\(", line)]
    parsed = [ast.parse(f"def {line}: ...").body[0] for line in overloads or lines[:1]]
    return [signature(function, of_core) for function in parsed if isinstance(function, ast.FunctionDef)]


def names_of(owner: object) -> set[str]:
    return {name for name in vars(owner) if not name.startswith("_") or name == "__init__"}


def any_array(text: str) -> str:
    return re.sub(r"\bF\d\d( \| F\d\d)*", "numpy.ndarray", text)


def agrees(stub: Signature, core: Signature) -> bool:
    """Whether the stub tells the truth where it tells more: which arrays, or a tuple of what."""
    told = {
        name: any_array(text) if "numpy.ndarray" in core.get(name, "") else text
        for name, text in stub.items()
    }
    if core["return"] == "tuple" and told["return"].startswith("tuple["):
        told["return"] = "tuple"
    return list(told.items()) == list(core.items())


def function_differences(name: str, function: ast.FunctionDef, core: object) -> list[str]:
    stub, overloads = signature(function, of_stub), of_docstring(core)
    if len(overloads) > 1:  # the stub's types hold all of theirs
        names = [list(overload) for overload in overloads]
        return [] if all(list(stub) == each for each in names) else [f"{name}: {list(stub)}, not {names}"]
    return [] if agrees(stub, overloads[0]) else [f"{name}: {stub}, not {overloads[0]}"]


def body_differences(where: str, body: list[ast.stmt], owner: object, present: set[str]) -> list[str]:
    """What the statements of a stub or of one of its classes have wrong."""
    found: list[str] = []
    declared: set[str] = set()
    for statement in body:
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
            name = statement.target.id
            value = getattr(owner, name, None)
            if type(value).__name__ != ast.unparse(statement.annotation):
                found.append(
                    f"{where}{name}: {ast.unparse(statement.annotation)}, not {type(value).__name__}"
                )
        elif isinstance(statement, ast.FunctionDef | ast.ClassDef):
            name = statement.name
        else:
            continue
        declared.add(name)
        core = getattr(owner, name, None)
        if core is None:
            continue
        if isinstance(statement, ast.ClassDef):
            found += body_differences(f"{name}.", statement.body, core, names_of(core))
        elif isinstance(statement, ast.FunctionDef) and not statement.decorator_list:
            found += function_differences(where + name, statement, core)
        elif isinstance(statement, ast.FunctionDef) and not isinstance(core, property):
            found.append(f"{where}{name}: a property, not {type(core).__name__}")
    found += [f"{where}{name}: only in the stub" for name in sorted(declared - present)]
    return found + [f"{where}{name}: not in the stub" for name in sorted(present - declared)]


def differences(stub: str) -> list[str]:
    present = names_of(_core._build) | {"INSTRUCTION_SET"}
    return body_differences("", ast.parse(stub).body, _core, present)


def test_the_stub_is_what_the_core_has() -> None:
    assert differences(STUB) == []


@pytest.mark.parametrize(
    ("told", "instead"),
    [
        ("cube: bool, zonal: bool, direction", "cube: bool, direction"),
        ("zonal: bool, direction: F64", "zonal: bool, view: F64"),
        ("F: int, areas: bool) -> F64", "areas: bool, F: int) -> F64"),
        ("def fejer_weights(*, H: int)", "def fejer_weights(H: int)"),
        ("above: float = ...", "above: float"),
        ("halves: F16, /)", "halves: F16)"),
        ("def cube_directions(*, N: int) -> F64", "def cube_directions(*, N: int) -> F32"),
        ("def to_half(", "def to_halves("),
        ("CUBE_BORDER: int\n", ""),
        ("def levels(", "def depth("),
    ],
)
def test_what_is_wrong_in_the_stub_is_found(told: str, instead: str) -> None:
    assert STUB.count(told) == 1
    assert differences(STUB.replace(told, instead)) != []
