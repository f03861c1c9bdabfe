"""What can be chosen in the panel and by keys: labels and meanings."""

from __future__ import annotations

from typing import Literal

from shrm.frequency.prefilter import Window
from shrm.render.tangents import Tangents
from shrm.viewer.gpu.scene import Viewer
from shrm.viewer.window.integration import COARSENESS, ROWS
from shrm.viewer.window.materials import KINDS
from shrm.viewer.window.screen import AMPLIFIED
from shrm.viewer.window.state import Method, Shown

KEYS = (
    ("left drag", "orbit around the objects"),
    ("right drag", "turn the light (its coefficients are rotated)"),
    ("middle drag, Shift + left drag", "pan"),
    ("wheel", "zoom"),
    ("drop a file", "environment picture, mesh, object with transfer, or saved window (.json)"),
    ("F", "fit the objects into the picture"),
    ("R", "turn the light back"),
    ("T", "the light turns by itself, or stops"),
    ("E", "find the exposure from the picture"),
    ("B", "environment behind the objects on or off"),
    ("M", "next method: SHRM, round lobes, 12 views, GPU"),
    ("1  2  3", "show maps or transfer, integral, difference"),
    ("H", "shadows on or off, of an object with transfer"),
    ("I", "light between its parts (interreflection) on or off"),
    ("W", "its light damped against ringing, or not"),
    ("Tab", "panel on or off"),
    ("S", "screenshot: .png as shown, .exr linear"),
    ("Ctrl + S, Ctrl + O", "save the window's state, open it again"),
    ("?", "this list on or off"),
    ("Esc", "close this list"),
    ("Q", "quit"),
)

BY_PATH = "type its path and Enter, or drop it here."

Action = Literal["fit", "screenshot", "save", "open", "help", "close help", "panel", "expose", "quit"]

BUTTONS: tuple[tuple[Action, str, str], ...] = (
    ("fit", "Fit (F)", "All objects into the picture."),
    ("screenshot", "Screenshot (S)", "shrm-001.png as shown, shrm-001.exr linear; then 002, ..."),
    ("save", "Save", "The window's state, to shrm-view.json or the file of --state. (Ctrl+S)"),
    ("open", "Open", "The state that was saved; others can be dropped on the window. (Ctrl+O)"),
)

# Equations are those of [RH02], Ramamoorthi & Hanrahan 2002.
METHODS: tuple[tuple[Method, str, str], ...] = (
    (
        "shrm",
        "SHRM (Ramamoorthi 2002)",
        "Ramamoorthi & Hanrahan's. The most accurate: reflections may change with the view in any way, "
        "up to the order P. (P + 1)^2 maps.",
    ),
    (
        "kautz-mccool-3d",
        "round lobes, 3D (Kautz)",
        "Kautz & McCool's, 2000. Fewer maps, P + 1: highlights are taken to be round. Good for Phong, "
        "wrong for microfacets at grazing views. About tangents (hair, brushed metal) they are exact: "
        "the anisotropic maps of Kautz et al. 2000.",
    ),
    (
        "kautz-mccool-2d",
        "one round lobe, 2D (Kautz)",
        "Kautz & McCool's, 2000. A single map: highlights are round and keep their shape, and only their "
        "brightness changes with the view.",
    ),
    (
        "miller-heidrich",
        "Phong lobe (Heidrich 1999)",
        "Miller's and Heidrich's. A single map of the Phong lobe that is nearest, times a Fresnel factor; "
        "matt parts have a map of their own.",
    ),
    (
        "cabral",
        "12 views (Cabral 1999)",
        "Always 12 maps, of 12 fixed views; others are blended from the "
        "nearest three. Wrong where highlights move.",
    ),
    (
        "hardware",
        "GPU filter (Kautz 2000)",
        "Kautz et al.'s. One round lobe, filtered in two passes over a small picture whenever the light "
        "changes: the fastest on a graphics card, with 3 to 15 % of error, more where highlights are not "
        "round. Broad lobes are summed over 128 taps.",
    ),
)
VIEWERS: tuple[tuple[Viewer, str, str], ...] = (
    (
        "distant",
        "distant (eq. 12)",
        "For speed: all maps are summed once a frame, for one view vector, and each pixel is one look-up. "
        "Right for an eye that is far away. (Ramamoorthi & Hanrahan, equation 12)",
    ),
    (
        "near",
        "near (eq. 7)",
        "For perspective: each pixel has a view vector of its own and sums all maps for it. "
        "(Ramamoorthi & Hanrahan, equations 6 and 7)",
    ),
)
DISTANCES: tuple[tuple[Viewer, str, str], ...] = (
    ("distant", "distant", "All vertices are seen along one direction: right for an eye that is far away."),
    ("near", "near", "For perspective: each vertex is seen along a direction of its own."),
)
"""Viewers of objects with transfer."""
RINGING = "Beside a sun, light of a low order rings: it is less than nothing there, and colors are wrong. "
WINDOWS: tuple[tuple[Window | None, str, str], ...] = (
    (None, "none", f"{RINGING}As sharp as its order allows."),
    ("lanczos", "Lanczos", f"{RINGING}Damped a little for each degree, to nothing at degree n. (Key W)"),
    ("hann", "Hann", f"{RINGING}Damped more."),
)
"""Windows on the degrees of their light."""
SHOWN: tuple[tuple[Shown, str, str], ...] = (
    ("maps", "maps", "The picture from the maps. (Key 1)"),
    (
        "integration",
        "integral",
        "The same picture by direct integration, to judge the maps: for every pixel a sum over the light, "
        f"averaged to {2 * ROWS} x {ROWS} texels. In the background, in {len(COARSENESS)} passes, coarse "
        "first; the last takes a minute or more. (Key 2)",
    ),
    (
        "difference",
        f"difference x{AMPLIFIED:g}",
        "The absolute difference between maps and integral on the objects, "
        f"{AMPLIFIED:g} times as bright; where "
        "it is black there is none. (Key 3)",
    ),
)
SHOWN_OF_TRANSFER: tuple[tuple[Shown, str, str], ...] = (
    ("maps", "drawn", "The picture from the transfer. (Key 1)"),
    (
        "integration",
        "integral",
        "Plain shading to judge the transfer: the same material in the same light, of the same order, by "
        f"direct integration and without shadows. In the background, in {len(COARSENESS)} passes, coarse "
        "first; the last takes minutes. (Key 2)",
    ),
    (
        "difference",
        f"difference x{AMPLIFIED:g}",
        "The absolute difference between transfer and integral on the object, "
        f"{AMPLIFIED:g} times as bright: what shadows and bounces do; without them, how accurate the "
        "transfer is. (Key 3)",
    ),
)
TANGENTS: tuple[tuple[Tangents, str, str], ...] = (
    (
        "axis",
        "around the vertical",
        "How the grooves of brushed metal or the threads of hair run on a mesh.\n"
        "around the vertical: as on a lathe.",
    ),
    ("uv", "along u", "along u: as the mesh's texture coordinates say; it must have some."),
    (
        "principal",
        "along the larger curvature",
        "along the larger curvature: around limbs and handles, whatever way they point.",
    ),
)
OF_LIGHT = "Largest degree of the light's harmonics: how sharp reflections can be."
OF_VIEW = "Largest order of the view's harmonics: how well reflections change with the view."
NAMED = ", ".join(
    f"{name}:{','.join(parameter.name for parameter in kind.parameters)}" for name, kind in KINDS.items()
)
