"""Prefiltered maps as OpenEXR files, with every convention in the metadata.

A multi-part file of 32-bit floats. For lobe k of the material:

`k.maps`
    The layers as pictures, channels `L_j.R`, `.G`, `.B`. Lat-long parts are H x 2H; cubes have six faces, +X
    -X +Y -Y +Z -Z from top to bottom, each N wide and high and with a border of two texels of its own plane.
`k.gamma`
    One row: the angle between C and N over theta_v from 0 to pi/2, radians; missing about the tangent.
`k.factors`
    For `KautzMcCool2D`: a row for each layer, factors over theta_v from 0 to pi/2; one channel or R, G, B.
`k.gamma.rest`, `k.factors.rest`
    What float32 leaves of them (`shrm.image_io.tables`).

The metadata of `0.maps` says the rest in words and numbers under the prefix `shrm:`; `shrm:error` is missing
where it is not known.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast, get_args

import numpy as np
import numpy.typing as npt

from shrm import image_io
from shrm.arrays import FloatArray
from shrm.brdf.lobe import Center
from shrm.files import PathLike, one_line
from shrm.frequency.rings import BORDER
from shrm.image_io import ImageError
from shrm.lobes.reflection import Layout
from shrm.prefiltered.layers import Layer

VERSION = 1

LARGEST = 1024
"""Most lobes, and most layers of a lobe, that a file is believed to hold."""

_CONVENTIONS = {
    "shrm:axes": "right-handed, z up; lat-long: row 0 at +z, column centers at phi = pi - 2 pi (j + 1/2) / W "
    "from +x towards +y",
    "shrm:central direction": "C = cos(gamma) N - sin(gamma) (V - (N.V) N) / |V - (N.V) N|; "
    "reflection: gamma = theta_v, normal: gamma = 0, tangent: C = T",
    "shrm:shares": "Diffuse, Phong: 1; KautzMcCool3D, Anisotropic: linear between layers at equal steps of "
    "the angle between C and V, from 0 to pi (normal: pi/2); KautzMcCool2D: factors; Cabral: barycentric "
    "weights of V in the triangle of the icosahedron around it",
}


@dataclass(frozen=True, eq=False)
class SavedLobe:
    """The map of one lobe as plain data, from which a class of `shrm.prefiltered` builds it.

    Attributes
    ----------
    kind : str
        The name of the class.
    keeps : str
        The variables that it keeps, in words.
    layers : tuple of Layer
        At least one.
    brdf : str
        The material's name.
    error : float
        The relative RMS error of the layers; nan if it is not known.
    factors : (K, T, 1 or 3) float64, optional
        The factors of `KautzMcCool2D`.
    """

    kind: str
    keeps: str
    layers: tuple[Layer, ...]
    brdf: str
    error: float
    factors: FloatArray | None = None


def write(path: PathLike, lobes: Sequence[SavedLobe]) -> None:
    """Write maps; the file appears whole or not at all.

    Raises
    ------
    shrm.ImageError
        If the file cannot be written.
    """
    about_file: dict[str, str | int] = {**_CONVENTIONS, "shrm:prefiltered": VERSION, "shrm:lobes": len(lobes)}
    pictures = [
        picture
        for k, lobe in enumerate(lobes)
        for picture in _pictures(k, lobe, {**about_file, "shrm:brdf": lobe.brdf} if k == 0 else {})
    ]
    image_io.write_parts(path, pictures)


def read(path: PathLike) -> tuple[SavedLobe, ...]:
    """Read what `write` wrote.

    Raises
    ------
    shrm.ImageError
        If the file cannot be read, or holds no prefiltered maps.
    """
    images = {part.name: part for part in image_io.read_parts(path)}
    if "0.maps" not in images or "shrm:prefiltered" not in images["0.maps"].metadata:
        raise ImageError(f"{path}: no prefiltered maps (it has no part 0.maps with shrm's metadata)")
    metadata = images["0.maps"].metadata
    try:
        version = int(cast(int, metadata["shrm:prefiltered"]))
        if version != VERSION:
            raise ImageError(f"{path}: prefiltered maps of version {version}, this reads version {VERSION}")
        lobes = int(cast(int, metadata["shrm:lobes"]))
        if not 1 <= lobes <= LARGEST:
            raise ValueError(f"shrm:lobes = {lobes}")
        return tuple(_lobe(images, k, str(metadata["shrm:brdf"])) for k in range(lobes))
    except (KeyError, ValueError, TypeError, IndexError, OverflowError) as fault:
        raise ImageError(f"{path}: damaged prefiltered maps ({one_line(fault)})") from fault


# ---- A lobe to pictures


def _pictures(k: int, lobe: SavedLobe, about_file: Mapping[str, str | int]) -> list[image_io.Part]:
    """Return the parts of lobe k."""
    # What a reader must know of the lobe
    first = lobe.layers[0]
    metadata: dict[str, str | int | float] = {
        "shrm:class": lobe.kind,
        "shrm:center": first.center,
        "shrm:layout": first.layout,
        "shrm:keeps": lobe.keeps,
        **({"shrm:error": repr(float(lobe.error))} if math.isfinite(lobe.error) else {}),
        **about_file,
    }

    # The layers as channels of one part, then its tables
    rings = np.concatenate([layer.rings for layer in lobe.layers], axis=1)  # (H, K, 3, W)
    flat = rings.transpose(0, 3, 1, 2).reshape(rings.shape[0], rings.shape[3], -1)
    channels = [f"L_{j}.{c}" for j in range(rings.shape[1]) for c in "RGB"]
    pictures = [_image(f"{k}.maps", flat, channels, metadata)]
    if len(first.gamma):
        pictures += image_io.table_parts(f"{k}.gamma", first.gamma[None, :, None])
    if lobe.factors is not None:
        channels = ["R", "G", "B"] if lobe.factors.shape[2] == 3 else ["Y"]
        pictures += image_io.table_parts(f"{k}.factors", lobe.factors, channels)
    return pictures


def _image(
    name: str, pixels: npt.NDArray[Any], channels: Sequence[str], metadata: Mapping[str, Any] | None = None
) -> image_io.Part:
    return image_io.Part(
        name, np.ascontiguousarray(pixels, dtype=np.float32), list(channels), dict(metadata or {})
    )


# ---- Pictures to a lobe; what does not fit raises ValueError or KeyError


def _lobe(images: Mapping[str, image_io.Part], k: int, brdf: str) -> SavedLobe:
    """Return lobe k of a file's images."""
    metadata = images[f"{k}.maps"].metadata
    layers = _layers(images, k)
    factors = _factors(images, k, len(layers)) if f"{k}.factors" in images else None
    error = float(cast(float, metadata.get("shrm:error", math.nan)))
    return SavedLobe(str(metadata["shrm:class"]), str(metadata["shrm:keeps"]), layers, brdf, error, factors)


def _layers(images: Mapping[str, image_io.Part], k: int) -> tuple[Layer, ...]:
    """Return the layers of lobe k."""
    # Grid and center
    metadata = images[f"{k}.maps"].metadata
    layout, center = str(metadata["shrm:layout"]), str(metadata["shrm:center"])
    if layout not in get_args(Layout) or center not in get_args(Center):
        raise ValueError(f"layout {layout!r}, center {center!r}")

    # Three channels for each layer
    pixels = _finite(images, f"{k}.maps")
    rows, columns, channels = pixels.shape
    fits = rows == 6 * columns > 12 * BORDER if layout == "cube" else columns == 2 * rows
    if not channels or channels % 3 or not fits:
        raise ValueError(f"{layout} maps of {columns} x {rows} texels and {channels} channels")
    gamma = np.zeros(0) if center == "tangent" else _gamma(images, k)
    rings = pixels.reshape(rows, columns, channels // 3, 3).transpose(2, 0, 3, 1)
    return tuple(
        Layer(
            cast(Center, center), gamma, cast(Layout, layout), np.ascontiguousarray(ring[:, None], np.float32)
        )
        for ring in rings
    )


def _gamma(images: Mapping[str, image_io.Part], k: int) -> FloatArray:
    """Return the angle between C and N of lobe k, radians, over theta_v."""
    gamma = _finite(images, f"{k}.gamma").ravel()
    if len(gamma) < 2 or gamma.min() < 0 or gamma.max() > np.pi:
        raise ValueError("gamma must be two or more angles in [0, pi]")
    return gamma


def _factors(images: Mapping[str, image_io.Part], k: int, layers: int) -> FloatArray:
    """Return the factors of the layers of lobe k, (layers, T, channels)."""
    factors = _finite(images, f"{k}.factors")
    if len(factors) != layers or factors.shape[1] < 2 or factors.shape[2] not in (1, 3):
        raise ValueError(f"factors of shape {factors.shape} for {layers} layers")
    return factors


def _finite(images: Mapping[str, image_io.Part], name: str) -> FloatArray:
    pixels = image_io.table_values(images, name)
    if not np.isfinite(pixels).all():
        raise ValueError(f"{name} is not finite")
    return pixels
