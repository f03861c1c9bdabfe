"""The request for a prefiltered map: one list of arguments, checked once."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import wraps
from typing import Any, Concatenate, Literal, ParamSpec, TypeVar, get_args

from shrm.brdf import BRDF, require_brdf
from shrm.brdf.lobe import Center
from shrm.environment import Environment, require_environment
from shrm.frequency.orders import (
    F_MAX,
    P_MAX,
    Criterion,
    require_lobes,
    require_orders,
)
from shrm.lobes.reflection import Layout, map_layout
from shrm.validation import flag, one_of, positive, whole_number

Window = Literal["hann", "lanczos"]

LARGEST_SIZE = 8192
"""Most rows of a map, or of a cube's face."""


@dataclass(frozen=True, eq=False, repr=False)
class Request:
    """The arguments of `shrm.prefilter`, whose documentation describes them; checked, and in one form each.

    Attributes
    ----------
    brdf : BRDF
        The material with its lobes about the centers that they are to have.
    orders : (int, int) or None
        A pair of Python's own numbers.
    layout : {"latlong", "cube"}
        The grid of the maps; "strip" has become "cube".
    env, tolerance, criterion, size, center, F_max, P_max, window, clamp, half, residual
        The arguments as they were given.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type or out of its range, or a residual does not go with others.
    """

    env: Environment
    brdf: BRDF
    _: KW_ONLY
    tolerance: float = 0.05
    orders: tuple[int, int] | None = None
    criterion: Criterion = "light"
    size: int | None = None
    layout: Layout = "latlong"
    center: Center | None = None
    F_max: int = F_MAX
    P_max: int = P_MAX
    window: Window | None = None
    clamp: bool = False
    half: bool = False
    residual: Literal["auto"] | None = None

    def __post_init__(self) -> None:
        # What is only checked
        require_environment(self.env)
        require_brdf(self.brdf)
        one_of("criterion", self.criterion, get_args(Criterion))
        if self.window is not None:
            one_of("window", self.window, get_args(Window))
        if self.residual is not None:
            one_of("residual", self.residual, ("auto",))
            if self.criterion != "light" or self.window is not None:
                raise ValueError("residual='auto' is for criterion='light' without a window")
        require_orders(self.F_max, self.P_max, names=("F_max", "P_max"))

        # What is kept in one form
        self._set("brdf", centered(self.brdf, self.center))
        self._set("layout", map_layout(self.layout))
        self._set("size", None if self.size is None else _even_size(self.size))
        self._set("clamp", flag("clamp", self.clamp))
        self._set("half", flag("half", self.half))
        self._set("tolerance", positive("tolerance", self.tolerance, 1.0))
        if self.orders is None:
            require_lobes(self.brdf, self.criterion)
        else:
            self._set("orders", _pair(self.orders))

    def __repr__(self) -> str:
        return f"<Request of {self.brdf.name}: {self.layout} {self.size or 'of any size'}>"

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)


def centered(brdf: BRDF, center: Center | None) -> BRDF:
    """Return a material with its lobes about a center; None leaves them about their own."""
    return brdf if center is None else brdf.recentered(center)


def _even_size(size: int) -> int:
    """Return an even number of rows."""
    rows = whole_number("size", size, 2, LARGEST_SIZE)
    if rows % 2:
        raise ValueError(f"size must be even, got {rows}")
    return rows


def _pair(orders: tuple[int, int]) -> tuple[int, int]:
    """Return a pair of orders as Python's own numbers."""
    try:
        F, P = orders
    except (TypeError, ValueError):
        raise ValueError(f"orders must be a pair (F, P), got {orders!r}") from None
    require_orders(F, P)
    return int(F), int(P)


Arguments = ParamSpec("Arguments")
Self = TypeVar("Self")
Result = TypeVar("Result")


def takes(
    request: Callable[Arguments, Request],
) -> Callable[[Callable[[Request], Result]], Callable[Arguments, Result]]:
    """Give a function of a request the request's own arguments, in help and to type checkers too."""
    signature = inspect.signature(request)

    def decorated(function: Callable[[Request], Result]) -> Callable[Arguments, Result]:
        @wraps(function)
        def with_arguments(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
            return function(_requested(request, signature, function.__name__, args, kwargs))

        _show_arguments(with_arguments, signature)
        return with_arguments

    return decorated


def method_takes(
    request: Callable[Arguments, Request],
) -> Callable[[Callable[[Self, Request], Result]], Callable[Concatenate[Self, Arguments], Result]]:
    """Do for a method what `takes` does for a function."""
    signature = inspect.signature(request)

    def decorated(
        method: Callable[[Self, Request], Result],
    ) -> Callable[Concatenate[Self, Arguments], Result]:
        @wraps(method)
        def with_arguments(self: Self, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
            return method(self, _requested(request, signature, method.__qualname__, args, kwargs))

        _show_arguments(
            with_arguments, signature, inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
        )
        return with_arguments

    return decorated


def _requested(
    request: Callable[..., Request],
    signature: inspect.Signature,
    caller: str,
    args: tuple[Any, ...],
    kwargs: dict[str, Any],
) -> Request:
    """Return the request of these arguments; refuse those that it has not by the name of what was called."""
    try:
        return request(*args, **kwargs)
    except TypeError:
        try:  # only now: binding them takes a quarter of the time of a small map
            signature.bind(*args, **kwargs)
        except TypeError as fault:
            raise TypeError(f"{caller}() {fault}") from None
        raise


def _show_arguments(function: Any, signature: inspect.Signature, *first: inspect.Parameter) -> None:
    """Make `help` show the arguments of a request, after others, and what the function returns."""
    parameters = [*first, *signature.parameters.values()]
    returns = function.__annotations__.get("return", inspect.Signature.empty)
    function.__signature__ = inspect.Signature(parameters, return_annotation=returns)
