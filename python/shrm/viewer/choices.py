"""What can be chosen in the panel and by keys: labels and meanings."""

from __future__ import annotations

from shrm.viewer.integration import ROWS
from shrm.viewer.scene import Viewer
from shrm.viewer.screen import AMPLIFIED
from shrm.viewer.state import Method, Shown

KEYS = (
    ("left drag", "orbit around the objects"),
    ("right drag", "turn the light (its coefficients are rotated)"),
    ("middle drag, Shift + left drag", "pan"),
    ("wheel", "zoom"),
    ("drop a file", "environment picture, mesh, or saved window (.json)"),
    ("F", "fit the objects into the picture"),
    ("R", "turn the light back"),
    ("E", "exposure from the picture, always"),
    ("B", "environment behind the objects on or off"),
    ("M", "next method: all of the view, without azimuth, 12 views"),
    ("1  2  3", "reflection maps, direct integration, difference"),
    ("Tab", "panel on or off"),
    ("S", "screenshot: .png as shown, .exr linear"),
    ("Ctrl + S, Ctrl + O", "save the window's state, open it again"),
    ("?", "this list on or off"),
    ("Esc, Q", "quit"),
)

METHODS: tuple[tuple[Method, str, str], ...] = (
    (
        "shrm",
        "all of the view (Ramamoorthi & Hanrahan)",
        "Harmonics of the view to the order P: (P + 1)^2 maps.",
    ),
    (
        "kautz-mccool",
        "without its azimuth (Kautz & McCool)",
        "Lobes are held symmetric about their centre for every view: P + 1 maps.",
    ),
    (
        "cabral",
        "12 views, blended (Cabral et al.)",
        "Maps for the views of an icosahedron; between them, a blend of the nearest three.",
    ),
)
VIEWERS: tuple[tuple[Viewer, str, str], ...] = (
    (
        "distant",
        "distant (eq. 12)",
        "One dynamic map per frame: all maps are summed for one view vector, and each pixel is one look-up.",
    ),
    (
        "near",
        "near (eq. 6, 7)",
        "Summed per pixel: each has a view vector of its own and sums all maps for it.",
    ),
)
SHOWN: tuple[tuple[Shown, str, str], ...] = (
    ("maps", "maps", "Frequency space: what this program is about."),
    (
        "integration",
        "integral",
        f"The same picture by direct integration (eq. 10): a sum over the light, averaged to {2 * ROWS} x "
        f"{ROWS} texels, in every pixel; in the background, coarse first.",
    ),
    ("difference", f"difference x{AMPLIFIED:g}", "Absolute, on objects; black is none."),
)
