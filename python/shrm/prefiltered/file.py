"""Prefiltered maps as OpenEXR files, with every convention in the metadata.

A multi-part file of 32-bit floats. For lobe k of the material:

`k.maps`
    The layers as pictures, channels `L_j.R`, `.G`, `.B`. Lat-long parts are H x 2H; cubes have six faces, +X
    -X +Y -Y +Z -Z from top to bottom, each N wide and high and with a border of two texels of its own plane.
`k.gamma`
    One row: the angle between C and N over theta_v from 0 to pi/2, radians. Not there about the tangent.
`k.factors`
    For `KautzMcCool2D`: a row for each layer, factors over theta_v from 0 to pi/2; one channel or R, G, B.

The metadata of `0.maps` says the rest in words and numbers under the prefix `shrm:`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast, get_args

import numpy as np
import numpy.typing as npt

from shrm import image_io
from shrm.arrays import FloatArray
from shrm.brdf.lobe import Center
from shrm.frequency.rings import BORDER
from shrm.image_io import ImageError
from shrm.lobes.reflection import Layout
from shrm.prefiltered.layers import Layer
from shrm.prefiltered.maps import (
    Anisotropic,
    Cabral,
    Diffuse,
    KautzMcCool2D,
    KautzMcCool3D,
    Phong,
    PrefilteredMap,
)

VERSION = 1
CLASSES: Mapping[str, type[PrefilteredMap]] = {
    cls.__name__: cls for cls in (Diffuse, Phong, KautzMcCool3D, KautzMcCool2D, Cabral, Anisotropic)
}
LARGEST = 1024
"""Of lobes and of layers, in a file that is believed."""

_CONVENTIONS = {
    "shrm:axes": "right-handed, z up; lat-long: row 0 at +z, column centers at phi = pi - 2 pi (j + 1/2) / W "
    "from +x towards +y",
    "shrm:central direction": "C = cos(gamma) N - sin(gamma) (V - (N.V) N) / |V - (N.V) N|; "
    "reflection: gamma = theta_v, normal: gamma = 0, tangent: C = T",
    "shrm:shares": "Diffuse, Phong: 1; KautzMcCool3D, Anisotropic: linear between layers at equal steps of "
    "the angle between C and V, from 0 to pi (normal: pi/2); KautzMcCool2D: factors; Cabral: barycentric "
    "weights of V in the triangle of the icosahedron around it",
}


def save(lobes: Sequence[PrefilteredMap], path: str | Path) -> None:
    """Write maps; the file appears whole or not at all.

    Raises
    ------
    shrm.ImageError
        If the file cannot be written.
    """
    parts: list[image_io.Part] = []
    for k, one in enumerate(lobes):
        about: dict[str, str | int | float] = {
            "shrm:class": type(one).__name__,
            "shrm:center": one.center,
            "shrm:layout": one.layout,
            "shrm:keeps": one.keeps,
        }
        if k == 0:
            about |= _CONVENTIONS | {
                "shrm:prefiltered": VERSION,
                "shrm:lobes": len(lobes),
                "shrm:brdf": one.brdf,
            }
        rings = np.concatenate([layer.rings for layer in one.layers], axis=1)  # (H, K, 3, W)
        flat = rings.transpose(0, 3, 1, 2).reshape(rings.shape[0], rings.shape[3], -1)
        parts.append(
            _image(f"{k}.maps", flat, [f"L_{j}.{c}" for j in range(rings.shape[1]) for c in "RGB"], about)
        )
        gamma = one.layers[0].gamma
        if len(gamma):
            parts.append(_image(f"{k}.gamma", gamma[None, :, None], ["Y"]))
        if isinstance(one, KautzMcCool2D):
            channels = ["R", "G", "B"] if one.factors.shape[2] == 3 else ["Y"]
            parts.append(_image(f"{k}.factors", one.factors, channels))
    image_io.write_parts(path, parts)


def load(path: str | Path) -> tuple[PrefilteredMap, ...]:
    """Read what `save` wrote.

    Raises
    ------
    shrm.ImageError
        If the file cannot be read, or holds no prefiltered maps.
    """
    images = {part.name: part for part in image_io.read_parts(path)}
    if "0.maps" not in images or "shrm:prefiltered" not in images["0.maps"].metadata:
        raise ImageError(f"{path}: no prefiltered maps (it has no part 0.maps with shrm's metadata)")
    about = images["0.maps"].metadata
    try:
        version = int(cast(int, about["shrm:prefiltered"]))
        if version != VERSION:
            raise ImageError(f"{path}: prefiltered maps of version {version}, this reads version {VERSION}")
        lobes = int(cast(int, about["shrm:lobes"]))
        if not 1 <= lobes <= LARGEST:
            raise ValueError(f"shrm:lobes = {lobes}")
        return tuple(_lobe(images, k, str(about["shrm:brdf"])) for k in range(lobes))
    except (KeyError, ValueError, TypeError, IndexError, OverflowError) as fault:
        raise ImageError(f"{path}: damaged prefiltered maps ({fault})") from fault


def _lobe(images: Mapping[str, image_io.Part], k: int, brdf: str) -> PrefilteredMap:
    picture = images[f"{k}.maps"]
    about = picture.metadata
    layout, center, kind = (str(about[f"shrm:{name}"]) for name in ("layout", "center", "class"))
    if layout not in get_args(Layout) or center not in get_args(Center) or kind not in CLASSES:
        raise ValueError(f"layout {layout!r}, center {center!r}, class {kind!r}")
    if center not in (CLASSES[kind].centers or get_args(Center)):
        raise ValueError(f"a {kind} map about the {center}")
    rows, columns, channels = picture.pixels.shape
    fits = rows == 6 * columns > 12 * BORDER if layout == "cube" else columns == 2 * rows
    if channels % 3 or not fits:
        raise ValueError(f"{layout} maps of {columns} x {rows} texels and {channels} channels")
    gamma = np.zeros(0)
    if center != "tangent":
        gamma = _finite(images, f"{k}.gamma").ravel()
        if len(gamma) < 2 or gamma.min() < 0 or gamma.max() > np.pi:
            raise ValueError("a table of gamma that is none")
    K = channels // 3
    rings = _finite(images, f"{k}.maps").reshape(rows, columns, K, 3).transpose(2, 0, 3, 1)
    layers = tuple(
        Layer(
            cast(Center, center),
            gamma,
            cast(Layout, layout),
            np.ascontiguousarray(layer[:, None], np.float32),
        )
        for layer in rings
    )
    expected = {"Diffuse": 1, "Phong": 1, "Cabral": 12}.get(kind, K)
    if expected != K or (kind in ("KautzMcCool3D", "Anisotropic") and K < 2):
        raise ValueError(f"{K} layers of a {kind} map")
    if kind == "KautzMcCool2D":
        factors = _finite(images, f"{k}.factors")
        if len(factors) != K or factors.shape[1] < 2 or factors.shape[2] not in (1, 3):
            raise ValueError(f"factors of shape {factors.shape} for {K} layers")
        return KautzMcCool2D(layers, brdf, factors)
    return CLASSES[kind](layers, brdf)


def _finite(images: Mapping[str, image_io.Part], name: str) -> FloatArray:
    pixels = images[name].pixels.astype(np.float64)
    if not np.isfinite(pixels).all():
        raise ValueError(f"{name} is not finite")
    return pixels


def _image(
    name: str, pixels: npt.NDArray[Any], channels: Sequence[str], about: Mapping[str, Any] | None = None
) -> image_io.Part:
    return image_io.Part(
        name, np.ascontiguousarray(pixels, dtype=np.float32), list(channels), dict(about or {})
    )
