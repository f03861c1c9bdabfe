"""One picture to know a material: its lobes, its spectrum, what orders capture of it, and a lit sphere."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import BRDF
from shrm.brdf.lobe import refuse_anisotropic
from shrm.environment import Environment
from shrm.frequency.orders import analysed
from shrm.frequency.prefilter import prefilter
from shrm.frequency.reflection_map import ReflectionMap
from shrm.render import Camera, Object, Sphere, automatic_exposure, display, render
from shrm.render.drawn_text import drawn_text
from shrm.render.tonemap import LUMINANCE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

F, P = 60, 8
"""The largest orders that are looked at."""
VIEWS = (0, 30, 60, 80)
"""Angles of V to the normal, or the tangent, whose lobes are drawn, in degrees."""
COLORS = ("#0b6fb8", "#2e8b57", "#e08e0b", "#d1495b")
DECADES = 3.0
"""From the middle of the polar picture to the peak of the highest lobe."""
PIXELS = 256
LONGEST_LIGHT = 32
"""Characters of the light's name above the sphere."""


def material_figure(brdf: BRDF, env: Environment, env_name: str, tolerance: float = 0.03) -> Figure:
    """Draw a material.

    Parameters
    ----------
    brdf : BRDF
        Any that a reflection map can hold.
    env : Environment
        The light on the sphere.
    env_name : str
        What it is called.
    tolerance : float
        The error wanted of the sphere, whose mirror-like core is split off where it must be.

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    ValueError
        If a lobe is anisotropic.
    """
    from matplotlib.figure import Figure

    for lobe in brdf.lobes:
        refuse_anisotropic(lobe)
    energy, captured = _energies(brdf)
    rm = prefilter(env, brdf, tolerance=tolerance, residual="auto")
    figure = Figure(figsize=(11.0, 7.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(1.25, 1.0))
    _lobes(figure.add_subplot(grid[0, 0], projection="polar"), brdf)  # type: ignore[arg-type]
    _sphere(figure.add_subplot(grid[0, 1]), rm, env_name)
    _spectrum(figure.add_subplot(grid[1, 0]), energy, captured)
    _accuracy(figure.add_subplot(grid[1, 1]), energy, captured)
    name = drawn_text(brdf.name)
    figure.suptitle(name.text, fontsize=13, parse_math=False, family=name.family)
    return figure


def _energies(brdf: BRDF) -> tuple[FloatArray, FloatArray]:
    """Shares of the material's energy: of each degree (F+1,), and what P = 0, ... keeps of it (P+1, F+1).

    Lobes and channels together, cross terms between lobes left out.
    """
    lobes = analysed(brdf, F, P)
    total = sum(float(lobe.energy.sum()) for lobe in lobes) or 1.0
    degrees = sum(lobe.degree_energy().sum(axis=1) for lobe in lobes)
    kept = [sum(lobe.captured(p).sum(axis=1) for lobe in lobes) for p in range(P + 1)]
    return np.asarray(degrees) / total, np.asarray(kept) / total


def _lobes(axes: PolarAxes, brdf: BRDF) -> None:
    """rho_hat in the plane of V and the normal (or the tangent), its radius logarithmic."""
    tangent = brdf.frame == "tangent"
    reach = np.pi if tangent else np.pi / 2
    angle = np.concatenate([np.linspace(-reach, reach, 2881), np.radians(VIEWS)])
    angle = np.unique(
        np.concatenate([angle, *(np.radians(v) + np.linspace(-0.05, 0.05, 801) for v in VIEWS)])
    )
    angle = angle[np.abs(angle) <= reach]
    wi = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    curves = []
    for view in np.radians(VIEWS):
        wo = np.broadcast_to([-np.sin(view), 0.0, np.cos(view)], wi.shape)
        values = brdf.transfer(wi, wo)
        curves.append(values if values.ndim == 1 else values @ LUMINANCE)
    peak = max(float(curve.max()) for curve in curves) or 1.0
    for view, curve, color in zip(VIEWS, curves, COLORS, strict=True):
        radius = np.log10(np.maximum(curve / peak, 10**-DECADES)) + DECADES
        axes.plot(angle, radius, color=color, linewidth=1.4, label=f"{view} deg")
        axes.plot([-np.radians(view)] * 2, [0.93 * DECADES, DECADES], color=color, linewidth=2.5)
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set(ylim=(0, DECADES), yticks=range(1, int(DECADES) + 1))
    axes.set_yticklabels(
        [f"{peak * 10 ** (k - DECADES):.2g}" for k in range(1, int(DECADES) + 1)], fontsize=7
    )
    axes.set_rlabel_position(0 if tangent else 88)
    if not tangent:
        axes.set(thetamin=-90, thetamax=90)
    axes.tick_params(labelsize=8)
    axes.grid(color="0.88", linewidth=0.6)
    axes.set_title(
        "BRDF times cosine by the angle of the light, logarithmic; thick marks: the view", fontsize=9
    )
    place = {"loc": "center left", "bbox_to_anchor": (1.08, 0.5)} if tangent else {"loc": "upper center"}
    axes.legend(
        title="view at", fontsize=8, title_fontsize=8, frameon=False, ncols=1 if tangent else 4, **place
    )


def _sphere(axes: Axes, rm: ReflectionMap, env_name: str) -> None:
    camera = Camera((-4.0, 0.0, 0.7), height=2.1)
    picture = render(
        [Object(Sphere((0.0, 0.0, 0.0)), rm)],
        camera,
        (PIXELS, PIXELS),
        viewer="distant",
        samples=3,
        shading="pixel",
    )
    exposure = automatic_exposure(picture.radiance, picture.coverage)
    rgba = np.dstack([display(picture.radiance, exposure), np.round(255 * picture.coverage).astype(np.uint8)])
    axes.imshow(rgba, interpolation="lanczos")
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    core = "" if rm.residual is None else ", peak apart (residual)"
    light = drawn_text(env_name, LONGEST_LIGHT)
    axes.set_title(
        f"under {light.text}: F = {rm.F}, P = {rm.P}{core}, predicted error {rm.error:.1%}",
        fontsize=9,
        parse_math=False,
        family=light.family,
    )


def _spectrum(axes: Axes, energy: FloatArray, captured: FloatArray) -> None:
    l = np.arange(len(energy))
    for p in (0, 1, 2, 3, 5, 8):
        shade = str(0.8 * (1 - p / P))
        axes.semilogy(l, np.maximum(captured[p], 1e-12), color=shade, linewidth=1.0, label=f"P = {p}")
    axes.semilogy(l, np.maximum(energy, 1e-12), "--", color="#d95f02", linewidth=1.6, label="every P")
    top = float(energy.max())
    axes.set(
        xlim=(0, F),
        ylim=(max(energy.min() / 30, 1e-6 * top), 2 * top),
        xlabel="degree l",
        ylabel="share of the energy",
    )
    axes.set_title("spectrum of the coefficients", fontsize=9)
    axes.legend(fontsize=7, frameon=False, ncols=2)
    axes.spines[["top", "right"]].set_visible(False)


def _accuracy(axes: Axes, energy: FloatArray, captured: FloatArray) -> None:
    share = np.cumsum(captured, axis=1)
    image = axes.imshow(
        share,
        origin="lower",
        aspect="auto",
        cmap="viridis",
        vmin=0,
        vmax=1,
        extent=(-0.5, F + 0.5, -0.5, P + 0.5),
    )
    levels = [x for x in (0.5, 0.9, 0.97, 0.99) if share.min() < x < share.max()]
    if levels:
        lines = axes.contour(
            np.arange(F + 1), np.arange(P + 1), share, levels, colors="white", linewidths=0.9
        )
        axes.clabel(lines, fmt=lambda x: f"{x:.0%}", fontsize=8)
    axes.set(xlabel="F", ylabel="P")
    axes.set_title(
        f"accuracy: share of the energy within (F, P); all of F <= {F}: {energy.sum():.1%}", fontsize=9
    )
    axes.figure.colorbar(image, ax=axes, format=lambda x, _: f"{x:.0%}")
