"""What can be chosen in the panel and by keys: labels and meanings."""

from __future__ import annotations

from typing import Literal

from shrm.frequency.request import Window
from shrm.render.camera import Viewer
from shrm.render.tangents import Tangents
from shrm.viewer.window.integration import COARSENESS, ROWS
from shrm.viewer.window.materials import KINDS
from shrm.viewer.window.screen import AMPLIFIED
from shrm.viewer.window.state import Filter, Shown, Technique

KEYS = (
    ("left drag", "orbit around the objects"),
    ("right drag", "rotate the light"),
    ("middle drag, Shift + left drag", "pan"),
    ("wheel", "zoom"),
    ("drop a file", "open an environment, mesh, object with transfer or saved window"),
    ("F", "fit the objects into the view"),
    ("R", "reset the rotation of the light"),
    ("T", "start or stop rotating the light"),
    ("E", "automatic exposure"),
    ("B", "show or hide the background"),
    ("M", "next technique: SHRM, round lobes, 12 views, GPU filters"),
    ("1  2  3", "show the maps or transfer, the integral, the difference"),
    ("H", "shadows on or off (object with transfer)"),
    ("I", "interreflection on or off (object with transfer)"),
    ("W", "window against ringing on or off (object with transfer)"),
    ("Tab", "show or hide the panel"),
    ("S", "save a screenshot: .png as shown, .exr linear"),
    ("Ctrl + S, Ctrl + O", "save the state of the window, open it again"),
    ("?", "show or hide this list"),
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
TECHNIQUES: tuple[tuple[tuple[Technique, Filter | None], str, str], ...] = (
    (
        ("shrm", None),
        "SHRM (Ramamoorthi 2002)",
        "Spherical harmonic reflection maps, after Ramamoorthi & Hanrahan. The most accurate: reflections "
        "may change with the view in any way, up to order P. (P + 1)^2 maps.",
    ),
    (
        ("kautz-mccool-3d", None),
        "round lobes, 3D (Kautz)",
        "Kautz & McCool 2000. Fewer maps, P + 1, because highlights are assumed to be round. Exact for Phong,"
        " wrong for microfacets at grazing views. For hair and brushed metal they are exact: the anisotropic "
        "maps of Kautz et al. 2000.",
    ),
    (
        ("kautz-mccool-2d", None),
        "one round lobe, 2D (Kautz)",
        "Kautz & McCool 2000. A single map: highlights are round and keep their shape; only their brightness "
        "changes with the view.",
    ),
    (
        ("miller-heidrich", None),
        "Phong lobe (Heidrich 1999)",
        "Miller & Hoffman 1984, Heidrich & Seidel 1999. A single map of the nearest Phong lobe, times a "
        "Fresnel factor; diffuse parts have a map of their own.",
    ),
    (
        ("cabral", None),
        "12 views (Cabral 1999)",
        "Cabral et al. 1999. Always 12 maps, of 12 fixed views; others are blended from the nearest three. "
        "Wrong where highlights move.",
    ),
    (
        ("kautz-mccool-2d", "two-pass"),
        "GPU, two passes (Kautz)",
        "Kautz et al. 2000. One round lobe, filtered by the GPU in two passes over a small map whenever the "
        "light changes: the fastest on a graphics card. Errors of 3 to 15 %, more where highlights are not "
        "round. Lobes too broad for it are filtered by taps.",
    ),
    (
        ("kautz-mccool-2d", "exact"),
        "GPU, taps",
        "One round lobe, filtered by the GPU whenever the light changes: for each texel a sum over 128 taps "
        "on the sphere. More accurate than two passes, and slower.",
    ),
)
"""Classes of maps, each with the filter by which the GPU makes them; the key M goes through them."""
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
