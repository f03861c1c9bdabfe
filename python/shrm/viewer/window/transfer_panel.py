"""The panel's section of an object with transfer: what of it is used."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from slimgui import imgui

from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.viewer.window.choices import BY_PATH, DISTANCES, SHOWN_OF_TRANSFER, WINDOWS
from shrm.viewer.window.opening import absolute, with_file
from shrm.viewer.window.prefiltering import PrefilteredScene
from shrm.viewer.window.relit import Choice
from shrm.viewer.window.state import LEAST_TENTS, State
from shrm.viewer.window.widgets import GREY, Widgets, disabled, explain


def draw_transfer(widgets: Widgets, state: State, result: PrefilteredScene | None, integrated: str) -> State:
    """Draw the section of an object with transfer; return the state as changed.

    `integrated` says how far the integration is; empty if none is asked for.
    """
    assert state.transfer is not None
    imgui.separator_text("Object with transfer")
    meaning = f"{state.transfer}\nAn object whose transfer was precomputed (shrm transfer): {BY_PATH}"
    typed = widgets.entered("object", Path(state.transfer).name, meaning)
    if typed is not None:
        state = with_file(state, absolute(typed))
    if widgets.button("Back to materials", "The spheres or meshes that were there before, with their maps."):
        state = replace(state, transfer=None)
    if result is None or result.transferred is None:
        imgui.text_colored(GREY, "reading ...")
        return state
    transfer = result.transferred.transfer
    choice = Choice.of(state, transfer)
    state = _variant(widgets, state, choice)
    state = _sizes(widgets, state, choice)
    viewer = widgets.choice("viewer", DISTANCES, state.viewer)
    window = widgets.choice("window", WINDOWS, state.window)
    shown = widgets.choice("shown ", SHOWN_OF_TRANSFER, state.shown)
    imgui.text_colored(GREY, integrated or " ")
    state = replace(state, viewer=viewer, window=window, shown=shown)
    for line, meaning in lines(transfer, choice):
        imgui.text_wrapped(line)
        explain(meaning)
    return state


def _variant(widgets: Widgets, state: State, choice: Choice) -> State:
    lacking = "" if choice.other_shadows else "\nThis file has only one of them."
    with disabled(choice.other_shadows is None):
        meaning = f"Parts of the object take light from others. (Key H){lacking}"
        if widgets.check("shadowed", "shadowed (H)", choice.shadows, meaning):
            state = replace(state, variant=choice.other_shadows)
    imgui.same_line()
    lacking = "" if choice.other_bounces else "\nThis file has only one of them."
    with disabled(choice.other_bounces is None):
        meaning = f"Parts of the object light others as well. (Key I){lacking}"
        if widgets.check("interreflected", "interreflected (I)", choice.bounces, meaning):
            state = replace(state, variant=choice.other_bounces)
    return state


def _sizes(widgets: Widgets, state: State, choice: Choice) -> State:
    clamp = imgui.SliderFlags.CLAMP_ON_INPUT
    with disabled(choice.most_K < 2):
        least, most = min(1, choice.most_K), choice.most_K
        changed, K = imgui.slider_int("components K", choice.K, least, most, f"%d of {most}", clamp)
        widgets.place("components")
        explain(
            "How many principal components of the vertices' matrices are used: fewer are faster and less "
            "accurate." + ("" if choice.most_K else " This variant is not compressed.")
        )
    if changed:
        state = replace(state, components=K)
    with disabled(choice.most_M <= LEAST_TENTS or choice.most_K == 0):
        least, most = min(LEAST_TENTS, choice.most_M), choice.most_M
        changed, M = imgui.slider_int("tents M", choice.M, least, most, f"%d of {most}", clamp)
        widgets.place("tents")
        explain("Directions to a side of the grid of outgoing light: how sharp reflections can be.")
    return replace(state, tents=M) if changed else state


def lines(transfer: RadianceTransfer, choice: Choice) -> Iterator[tuple[str, str]]:
    """Yield lines that describe an object, each with its meaning."""
    yield transfer.material.replace(",", ", "), "The object's material, which is in its transfer."
    channels = "colors" if transfer.channels == 3 else "grey"
    yield (
        f"{len(transfer.vertices)} vertices, {len(transfer.faces)} faces",
        "Light is found at the vertices, and interpolated between them.",
    )
    yield (
        f"light of order n = {transfer.n}, {choice.most_M} x {choice.most_M} tents, {channels}",
        f"Light is known by {transfer.n**2} harmonics, of degrees 0 to {transfer.n - 1}.",
    )
    held = transfer.report.get("compression")
    components = _number(held, choice.variant, "SNR of 1 to K", choice.K - 1)
    if components is not None:
        yield (
            f"K = {choice.K}: {components:.1f} dB",
            "Signal to noise of outgoing radiance with these components, against all of the matrices.",
        )
    matrices = _number(transfer.report, "SNR of matrices")
    if matrices is not None:
        yield (
            f"matrices: {matrices:.1f} dB at M = {choice.most_M}",
            "Signal to noise of outgoing radiance by the uncompressed matrices, against rays alone.",
        )


def _number(report: object, *path: str | int) -> float | None:
    """A number of a report, which may hold anything: by names and places on the way to it."""
    for step in path:
        if isinstance(report, dict):
            report = report.get(step)
        elif isinstance(report, list) and isinstance(step, int) and 0 <= step < len(report):
            report = report[step]
        else:
            return None
    return float(report) if isinstance(report, int | float) else None
