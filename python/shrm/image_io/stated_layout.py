"""The layout of an environment as the metadata of its picture state it.

OpenEXR's own attribute `envmap` (OpenImageIO's `textureformat`) knows two layouts. shrm writes beside it, in
OpenEXR files, the attributes `shrm:layout` and `shrm:border`; in TIFF files, which have no attributes of
one's own, the image description "shrm:layout=NAME shrm:border=N".
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

LAYOUT_KEY, BORDER_KEY = "shrm:layout", "shrm:border"

_DESCRIPTION = re.compile(rf"{LAYOUT_KEY}=(\S+) {BORDER_KEY}=(\d{{1,4}})")

_ENVMAP = {"openexr-latlong": "LatLong Environment", "openexr-cube": "CubeFace Environment"}


def layout_metadata(suffix: str, layout: str, border: int) -> dict[str, str | int]:
    """Return the metadata by which a file of some suffix states its layout; none if it can have none."""
    if suffix.lower() in (".tif", ".tiff"):
        return {"ImageDescription": f"{LAYOUT_KEY}={layout} {BORDER_KEY}={border}"}
    if suffix.lower() != ".exr":
        return {}
    envmap = {"textureformat": _ENVMAP[layout]} if layout in _ENVMAP else {}
    return {**envmap, LAYOUT_KEY: layout, BORDER_KEY: border}


def stated_layout(metadata: Mapping[str, Any], is_openexr: bool) -> tuple[str | None, int]:
    """Return the layout and the border that metadata state; None and 0 if they state none."""
    described = _DESCRIPTION.search(str(metadata.get("ImageDescription", "")))
    if described is not None:
        return described[1], int(described[2])
    if LAYOUT_KEY in metadata:
        border = metadata.get(BORDER_KEY, 0)
        return str(metadata[LAYOUT_KEY]), border if isinstance(border, int) and border > 0 else 0
    of_envmap = {text.lower(): layout for layout, text in _ENVMAP.items()}
    return (of_envmap.get(str(metadata.get("textureformat", "")).lower()) if is_openexr else None), 0
