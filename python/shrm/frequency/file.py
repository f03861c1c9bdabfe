"""Reflection maps as OpenEXR files: maps that other programs can read, coefficients, and every convention.

A multi-part file of 32-bit floats. For lobe k of the material:

`k.maps`
    The maps as pictures. Channels `B_p_q.R`, `.G`, `.B` in the order p(p+1)+q (only q = 0 if zonal). Lat-long
    parts are H x 2H; cubes are N wide and 6 N high, the faces +X -X +Y -Y +Z -Z from top to bottom.
`k.light`
    L_lm at row l, column m + F; channels R, G, B.
`k.rho`
    rho_lpq at row l, column p(P+1) + q; channels R, G, B.
`k.gamma`
    One row: the angle between C and N over theta_v from 0 to pi/2, radians. Not there about the tangent.
`k.light.rest`, `k.rho.rest`, `k.gamma.rest`
    What float32 leaves of them (`shrm.image_io.tables`).

The metadata of `0.maps` says the rest in words and numbers under the prefix `shrm:`. A residual has parts of
its own (`shrm.frequency.residual_file`), and makes the file one of version 3: what reads version 1 would
lose it. Files of version 2 have other names for some of these parts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, cast, get_args

import numpy as np
import numpy.typing as npt

from shrm import image_io
from shrm.arrays import FloatArray, IntArray
from shrm.brdf.lobe import Center
from shrm.files import PathLike, one_line
from shrm.frequency.part import CoefficientMaps, Part, order_of, synthesised
from shrm.frequency.residual_file import read_residual, residual_parts
from shrm.frequency.rings import BORDER
from shrm.image_io import ImageError
from shrm.integrate.residual import Residual
from shrm.lobes.reflection import Layout, map_names

VERSION, WITH_RESIDUAL = 1, 3
"""Versions of the format that are written, without a residual and with one."""

READABLE = (1, 2, 3)
"""Versions that are read: 2 is 3 with other names for the tables of a residual."""

_CONVENTIONS = {
    "shrm:axes": "right-handed, z up; lat-long: row 0 at +z, column centers at phi = pi - 2 pi (j + 1/2) / W "
    "from +x towards +y",
    "shrm:basis": "real orthonormal spherical harmonics, index l(l+1)+m, sqrt2 Re Y_lm for m > 0, "
    "sqrt2 Im Y_l|m| for m < 0, Condon-Shortley phase",
    "shrm:radiance": "sum over p, q of B_p_q(C) Y_pq(V), V the world direction towards the eye; "
    "zonal: sum over p of B_p_0(C) Y_p0(angle between C and V)",
    "shrm:central direction": "C = cos(gamma) N - sin(gamma) (V - (N.V) N) / |V - (N.V) N|; "
    "reflection: gamma = theta_v, normal: gamma = 0, tangent: C = T",
}


@dataclass(frozen=True, eq=False)
class SavedMap:
    """The content of a file: plain data, from which `shrm.ReflectionMap` is built.

    Attributes
    ----------
    parts : tuple of CoefficientMaps
        The maps of each lobe; those that have coefficients are a `Part`.
    brdf, criterion, window, clamp, residual
        As in `shrm.ReflectionMap`.
    error : float
        The error predicted for it.
    """

    parts: tuple[CoefficientMaps, ...]
    brdf: str
    criterion: str
    window: str | None
    clamp: bool
    error: float
    residual: Residual | None


def write(path: PathLike, saved: SavedMap) -> None:
    """Write a reflection map; the file appears whole or not at all.

    Raises
    ------
    shrm.ImageError
        If the file cannot be written.
    ValueError
        If a cube map has no coefficients: its borders, which a file does not hold, are made from them. If a
        value, or the predicted error, is not finite.
    """
    if any(part.layout == "cube" and part.F < 0 for part in saved.parts):
        raise ValueError(f"{saved.brdf}: cube maps without coefficients cannot be saved, take lat-long maps")
    facts = _conventions_and_facts(saved)
    pictures = [
        picture
        for k, part in enumerate(saved.parts)
        for picture in _pictures(k, part, facts if k == 0 else {})
    ]
    if saved.residual is not None:
        pictures += residual_parts(saved.residual)
    if not (np.isfinite(saved.error) and all(np.isfinite(picture.pixels).all() for picture in pictures)):
        raise ValueError(f"{saved.brdf}: its maps hold values beyond float32 or none, and cannot be saved")
    image_io.write_parts(path, pictures)


def read(path: PathLike) -> SavedMap:
    """Read what `write` wrote.

    Raises
    ------
    shrm.ImageError
        If the file cannot be read, or is no reflection map.
    """
    images = {part.name: part for part in image_io.read_parts(path)}
    if "0.maps" not in images or "shrm:version" not in images["0.maps"].metadata:
        raise ImageError(f"{path}: no reflection map (it has no part 0.maps with shrm's metadata)")
    about = images["0.maps"].metadata
    if str(about["shrm:version"]) not in map(str, READABLE):
        raise ImageError(
            f"{path}: a reflection map of version {about['shrm:version']}, this reads versions"
            f" {', '.join(map(str, READABLE))}"
        )
    try:
        return _saved_map(images, about)
    except (KeyError, ValueError, TypeError, IndexError, OverflowError) as fault:
        raise ImageError(f"{path}: a damaged reflection map ({one_line(fault)})") from fault


def _conventions_and_facts(saved: SavedMap) -> dict[str, str | int | float]:
    """Return the metadata of the whole map."""
    return {
        **_CONVENTIONS,
        "shrm:version": VERSION if saved.residual is None else WITH_RESIDUAL,
        "shrm:lobes": len(saved.parts),
        "shrm:brdf": saved.brdf,
        "shrm:error": repr(float(saved.error)),
        "shrm:criterion": saved.criterion,
        "shrm:window": saved.window or "none",
        "shrm:clamp": int(saved.clamp),
    }


def _pictures(k: int, part: CoefficientMaps, facts: Mapping[str, Any]) -> list[image_io.Part]:
    """Return the parts of a file for lobe k; the first has `facts` in its metadata."""
    about = {
        **facts,
        "shrm:center": part.center,
        "shrm:layout": part.layout,
        "shrm:zonal": int(part.zonal),
        "shrm:half": int(part.rings.dtype == np.float16),
        "shrm:F": part.F,
        "shrm:P": part.P,
    }

    # A cube's faces one below the other, then the maps beside each other as channels
    maps = part.maps
    pictures = maps.reshape(len(maps), -1, maps.shape[-2], 3)
    flat = pictures.transpose(1, 2, 0, 3).reshape(*pictures.shape[1:3], -1)
    images = [_image(f"{k}.maps", flat, _map_channels(part), about)]
    if isinstance(part, Part):
        images += image_io.table_parts(f"{k}.light", _triangle(part.light), "RGB")
        images += image_io.table_parts(f"{k}.rho", part.rho.reshape(part.F + 1, -1, 3), "RGB")
    if len(part.gamma):
        images += image_io.table_parts(f"{k}.gamma", part.gamma[None, :, None])
    return images


def _saved_map(images: Mapping[str, image_io.Part], about: Mapping[str, Any]) -> SavedMap:
    """The record of a file's parts; `about` is the metadata of the first."""
    lobes = _number(about, "shrm:lobes")
    if lobes < 1:
        raise ValueError(f"shrm:lobes = {lobes}")
    stored = [_part(images, k) for k in range(lobes)]
    halves = [images[f"{k}.maps"].metadata.get("shrm:half", 0) == 1 for k in range(lobes)]
    parts = tuple(part.as_half() if half else part for part, half in zip(stored, halves, strict=True))
    residual = None
    if str(about["shrm:version"]) != str(VERSION):
        names = map_names([part.center for part in parts])
        maps = [(name, part.center, part.gamma) for name, part in zip(names, parts, strict=True)]
        residual = read_residual(images, maps, parts[0].layout, parts[0].size)
    window = str(about["shrm:window"])
    return SavedMap(
        parts=parts,
        brdf=str(about["shrm:brdf"]),
        criterion=str(about["shrm:criterion"]),
        window=None if window == "none" else window,
        clamp=bool(about["shrm:clamp"]),
        error=float(about["shrm:error"]),
        residual=residual,
    )


def _part(images: Mapping[str, image_io.Part], k: int) -> CoefficientMaps:
    """Return the maps of lobe k, with their coefficients if the file has them."""
    # What the metadata says, and that it fits the picture
    picture = images[f"{k}.maps"]
    about = picture.metadata
    zonal, layout, center = bool(about["shrm:zonal"]), str(about["shrm:layout"]), str(about["shrm:center"])
    if layout not in get_args(Layout) or center not in get_args(Center):
        raise ValueError(f"layout {layout!r}, center {center!r}")
    F, P = _number(about, "shrm:F"), _number(about, "shrm:P")
    rows, columns, channels = picture.pixels.shape
    if channels % 3 or order_of(channels // 3, zonal) != P:
        raise ValueError(f"{channels} channels for P = {P}")
    if not np.isfinite(picture.pixels).all():
        raise ValueError("maps that are not finite")

    # The table of the maps' centers
    gamma = np.zeros(0)
    if center != "tangent":
        gamma = _pixels(images, f"{k}.gamma", (1, None, 1)).ravel()
        if len(gamma) < 2:
            raise ValueError("a table of gamma with one entry")

    # The maps, row by row as they lie in memory
    pixels = picture.pixels.reshape(rows, columns, channels // 3, 3)
    maps = CoefficientMaps(
        center=cast(Center, center),
        gamma=gamma,
        layout=cast(Layout, layout),
        rings=np.ascontiguousarray(pixels.transpose(0, 2, 3, 1), dtype=np.float32),
        zonal=zonal,
    )
    if layout == "latlong" and (rows % 2 or columns != 2 * rows):
        raise ValueError(f"lat-long maps of {columns} x {rows} texels")

    # The coefficients; maps that were fitted to pictures have none, and F = -1.
    if F < 0:
        if layout == "cube":
            raise ValueError("cube maps without coefficients")
        return maps
    light = _from_triangle(_pixels(images, f"{k}.light", (F + 1, 2 * F + 1, 3)))
    rho = _pixels(images, f"{k}.rho", (F + 1, (P + 1) ** 2, 3)).reshape(F + 1, P + 1, P + 1, 3)
    part = Part(**vars(maps), light=light, rho=rho)
    return part if layout == "latlong" else _bordered(part)


def _bordered(part: Part) -> Part:
    """Add to a cube's faces, as stored, the borders that the coefficients give."""
    N = part.rings.shape[3]
    if N < 2 or part.rings.shape[0] != 6 * N:
        raise ValueError(f"cube maps of {N} x {part.rings.shape[0]} texels")
    rings = synthesised(part.coefficients, N, "cube")
    side = N + 2 * BORDER
    faces = rings.reshape(6, side, *rings.shape[1:])
    faces[:, BORDER:-BORDER, ..., BORDER:-BORDER] = part.rings.reshape(6, N, *part.rings.shape[1:])
    return replace(part, rings=rings)


def _image(
    name: str, pixels: npt.NDArray[Any], channels: str | list[str], about: Mapping[str, Any] | None = None
) -> image_io.Part:
    """Return a part of a file, its pixels as float32."""
    return image_io.Part(
        name, np.ascontiguousarray(pixels, dtype=np.float32), list(channels), dict(about or {})
    )


def _pixels(images: Mapping[str, image_io.Part], name: str, shape: tuple[int | None, ...]) -> FloatArray:
    """Return finite pixels of a shape, in which None stands for any length; else ValueError, or KeyError."""
    pixels = image_io.table_values(images, name)
    if any(length not in (None, actual) for length, actual in zip(shape, pixels.shape, strict=True)):
        raise ValueError(f"{name} of shape {pixels.shape}")
    if not np.isfinite(pixels).all():
        raise ValueError(f"{name} is not finite")
    return pixels


def _number(about: Mapping[str, Any], name: str) -> int:
    """Return a degree, an order or a number of lobes: -1 to 1000, else ValueError."""
    value = int(about[name])
    if not -1 <= value <= 1000:
        raise ValueError(f"{name} = {value}")
    return value


def _map_channels(part: CoefficientMaps) -> list[str]:
    """Return the names of the channels of `k.maps`."""
    pairs = [(p, q) for p in range(part.P + 1) for q in ([0] if part.zonal else range(-p, p + 1))]
    return [f"B_{p}_{q}.{c}" for p, q in pairs for c in "RGB"]


def _triangle(light: FloatArray) -> FloatArray:
    """Return coefficients ((F+1)^2, 3) as a picture (F+1, 2F+1, 3): L_lm at [l, m + F], zero elsewhere."""
    l, m = _degrees(len(light))
    F = int(l[-1])
    picture = np.zeros((F + 1, 2 * F + 1, 3))
    picture[l, m + F] = light
    return picture


def _from_triangle(picture: FloatArray) -> FloatArray:
    """Return the coefficients in a picture that `_triangle` returned."""
    l, m = _degrees(len(picture) ** 2)
    return np.ascontiguousarray(picture[l, m + len(picture) - 1])


def _degrees(count: int) -> tuple[IntArray, IntArray]:
    """Return the degree l and order m of each of the first coefficients."""
    index = np.arange(count)
    l = np.sqrt(index).astype(np.int64)
    return l, index - l * (l + 1)
