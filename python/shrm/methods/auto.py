"""Prefiltering by one method or another: in frequency space, by integration, or by what costs least."""

from __future__ import annotations

from typing import Literal, get_args, overload

from shrm.brdf import BRDF
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.frequency import prefilter as prefiltering
from shrm.frequency.orders import F_MAX, P_MAX, Criterion, require_orders, require_tolerance
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.request import Window
from shrm.integrate.angular import DEFAULT_SIZE, AngularReflection, prefilter_angular
from shrm.integrate.hierarchical import HierarchicalReflection, prefilter_hierarchical
from shrm.lobes.reflection import Layout
from shrm.methods.cost import ANGULAR_SHARE, cheapest
from shrm.validation import one_of, whole_number

Reflection = ReflectionMap | AngularReflection | HierarchicalReflection
Method = Literal["frequency", "angular", "hierarchical", "auto"]


@overload
def prefilter(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float = ...,
    orders: tuple[int, int] | None = ...,
    criterion: Criterion = ...,
    size: int | None = ...,
    layout: Layout = ...,
    center: Center | None = ...,
    F_max: int = ...,
    P_max: int = ...,
    window: Window | None = ...,
    clamp: bool = ...,
    half: bool = ...,
    residual: Literal["auto"] | None = ...,
    method: Literal["frequency"] = ...,
    views: int = ...,
) -> ReflectionMap: ...


@overload
def prefilter(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float = ...,
    size: int | None = ...,
    layout: Layout = ...,
    center: Center | None = ...,
    F_max: int = ...,
    P_max: int = ...,
    method: Literal["angular", "hierarchical", "auto"],
    views: int = ...,
) -> Reflection: ...


def prefilter(
    env: Environment,
    brdf: BRDF,
    *,
    tolerance: float = 0.05,
    orders: tuple[int, int] | None = None,
    criterion: Criterion = "light",
    size: int | None = None,
    layout: Layout = "latlong",
    center: Center | None = None,
    F_max: int = F_MAX,
    P_max: int = P_MAX,
    window: Window | None = None,
    clamp: bool = False,
    half: bool = False,
    residual: Literal["auto"] | None = None,
    method: Method = "frequency",
    views: int = 1,
) -> Reflection:
    """Prefilter an environment with a material.

    Parameters
    ----------
    env : Environment
        The light.
    brdf : BRDF
        The material, of one lobe or several.
    tolerance : float
        The error wanted, in (0, 1); by default the relative RMS of the reflected radiance.
    orders, criterion, size, layout, center, F_max, P_max, window, clamp, half, residual
        As in `shrm.frequency.prefilter.prefilter`.
    method : {"frequency", "angular", "hierarchical", "auto"}
        In frequency space; by integration (`shrm.prefilter_angular`), for sharp lobes; by integration in a
        pyramid (`shrm.prefilter_hierarchical`), for sharp lobes under large pictures; or whichever is
        predicted to cost least at the tolerance (`shrm.methods.cost`). Integration knows no orders, criteria,
        windows, clamping, halves or residuals.
    views : int
        For how many views a map is wanted, for the prediction.

    Returns
    -------
    ReflectionMap, AngularReflection or HierarchicalReflection
        All have `radiance`, `at_view`, `size` and `layout`.

    Warns
    -----
    ToleranceWarning
        If the method is "frequency" and cannot meet the tolerance within the caps.

    Raises
    ------
    TypeError, ValueError
        If an argument is of another type or out of its range, or does not go with the method.
    """
    one_of("method", method, get_args(Method))
    whole_number("views", views, 1)
    if method == "frequency":
        return prefiltering.prefilter(
            env,
            brdf,
            tolerance=tolerance,
            orders=orders,
            criterion=criterion,
            size=size,
            layout=layout,
            center=center,
            F_max=F_max,
            P_max=P_max,
            window=window,
            clamp=clamp,
            half=half,
            residual=residual,
        )
    if orders is not None or criterion != "light" or window is not None or clamp or half or residual:
        raise ValueError(
            f"method {method!r} takes no orders, criterion, window, clamp, half or residual: "
            "use method='frequency'"
        )
    if not isinstance(brdf, BRDF):
        raise TypeError(f"brdf must be a material of shrm.brdf, got {type(brdf).__name__}")
    require_tolerance(tolerance)
    require_orders(F_max, P_max, names=("F_max", "P_max"))
    if size is not None:
        whole_number("size", size, 2, 8192)
    one_of("layout", layout, get_args(Layout))
    chosen: Method = method
    material = brdf if center is None else brdf.recentered(center)
    if method == "auto":
        edge = DEFAULT_SIZE[layout] if size is None else size
        chosen = cheapest(
            env, material, tolerance, size=edge, layout=layout, views=views, F_max=F_max, P_max=P_max
        )
        if chosen == "frequency":
            return prefiltering.prefilter(
                env,
                brdf,
                tolerance=tolerance,
                size=size,
                layout=layout,
                center=center,
                F_max=F_max,
                P_max=P_max,
            )
    if chosen == "hierarchical":
        return prefilter_hierarchical(env, material, error=tolerance, size=size, layout=layout)
    return prefilter_angular(env, material, tolerance=ANGULAR_SHARE * tolerance, size=size, layout=layout)
