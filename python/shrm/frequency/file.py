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

The metadata of `0.maps` says the rest in words and numbers under the prefix `shrm:`. A residual has parts of
its own (`shrm.frequency.residual_file`), and makes the file one of version 3: what reads version 1 would
lose it. Files of version 2 have other names for some of these parts.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast, get_args

import numpy as np
import numpy.typing as npt

from shrm import image_io
from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.brdf.lobe import Center
from shrm.frequency.reflection_map import Part, ReflectionMap, require_maps
from shrm.frequency.residual_file import read_residual, residual_parts
from shrm.frequency.rings import BORDER, synthesised
from shrm.image_io import ImageError
from shrm.lobes.reflection import Layout, map_names

VERSION, WITH_RESIDUAL = 1, 3
READABLE = (1, 2, 3)

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


def save(rm: ReflectionMap, path: str | Path) -> None:
    """Write a reflection map; the file appears whole or not at all.

    Raises
    ------
    shrm.ImageError
        If the file cannot be written.
    ValueError
        If a cube map has no coefficients: its borders, which a file does not hold, are made from them. If a
        value, or the predicted error, is not finite.
    """
    if any(part.layout == "cube" and part.F < 0 for part in rm.parts):
        raise ValueError(f"{rm.brdf}: cube maps without coefficients cannot be saved, take lat-long maps")
    parts: list[image_io.Part] = []
    for k, part in enumerate(rm.parts):
        about: dict[str, str | int | float] = {
            "shrm:center": part.center,
            "shrm:layout": part.layout,
            "shrm:zonal": int(part.zonal),
            "shrm:F": part.F,
            "shrm:P": part.P,
        }
        if k == 0:
            about |= _CONVENTIONS | {
                "shrm:version": VERSION if rm.residual is None else WITH_RESIDUAL,
                "shrm:lobes": len(rm.parts),
                "shrm:brdf": rm.brdf,
                "shrm:error": rm.error,
                "shrm:criterion": rm.criterion,
                "shrm:window": rm.window or "none",
                "shrm:clamp": int(rm.clamp),
            }
        maps = part.maps
        pictures = maps.reshape(len(maps), -1, maps.shape[-2], 3)
        flat = pictures.transpose(1, 2, 0, 3).reshape(*pictures.shape[1:3], -1)
        parts.append(_image(f"{k}.maps", flat, _map_channels(part), about))
        if len(part.light):
            parts.append(_image(f"{k}.light", _triangle(part.light), "RGB"))
            parts.append(_image(f"{k}.rho", part.rho.reshape(part.F + 1, -1, 3), "RGB"))
        if len(part.gamma):
            parts.append(_image(f"{k}.gamma", part.gamma[None, :, None], "Y"))
    if rm.residual is not None:
        parts += residual_parts(rm.residual)
    if not (np.isfinite(rm.error) and all(np.isfinite(part.pixels).all() for part in parts)):
        raise ValueError(f"{rm.brdf}: its maps hold values beyond float32 or none, and cannot be saved")
    image_io.write_parts(path, parts)


def load(path: str | Path) -> ReflectionMap:
    """Read what `save` wrote.

    Returns
    -------
    ReflectionMap
        With the maps and the predicted error as saved.

    Raises
    ------
    shrm.ImageError
        If the file cannot be read, or is no reflection map.
    """
    images = {part.name: part for part in image_io.read_parts(path)}
    if "0.maps" not in images or "shrm:version" not in images["0.maps"].metadata:
        raise ImageError(f"{path}: no reflection map (it has no part 0.maps with shrm's metadata)")
    about = images["0.maps"].metadata
    if about["shrm:version"] not in READABLE:
        raise ImageError(
            f"{path}: a reflection map of version {about['shrm:version']}, this reads versions"
            f" {', '.join(map(str, READABLE))}"
        )
    try:
        lobes = _number(about, "shrm:lobes")
        if lobes < 1:
            raise ValueError(f"shrm:lobes = {lobes}")
        parts = tuple(_part(images, k) for k in range(lobes))
        error = float(cast(float, about["shrm:error"]))
        window = str(about["shrm:window"])
        residual = None
        if about["shrm:version"] != VERSION:
            names = map_names([part.center for part in parts])
            maps = [(name, part.center, part.gamma) for name, part in zip(names, parts, strict=True)]
            residual = read_residual(images, maps, parts[0].layout, parts[0].size)
        return ReflectionMap(
            parts,
            str(about["shrm:brdf"]),
            str(about["shrm:criterion"]),
            None if window == "none" else window,
            bool(about["shrm:clamp"]),
            lambda: error,
            residual,
        )
    except (KeyError, ValueError, TypeError, IndexError, OverflowError) as fault:
        raise ImageError(f"{path}: a damaged reflection map ({fault})") from fault


def _part(images: Mapping[str, image_io.Part], k: int) -> Part:
    picture = images[f"{k}.maps"]
    about = picture.metadata
    zonal, layout, center = bool(about["shrm:zonal"]), str(about["shrm:layout"]), str(about["shrm:center"])
    if layout not in get_args(Layout) or center not in get_args(Center):
        raise ValueError(f"layout {layout!r}, center {center!r}")
    F, P = _number(about, "shrm:F"), _number(about, "shrm:P")
    rows, columns, channels = picture.pixels.shape
    if channels % 3 or require_maps(channels // 3, zonal) != P:
        raise ValueError(f"{channels} channels for P = {P}")
    light = np.zeros((0, 3))
    rho = np.zeros((0, P + 1, P + 1, 3))
    if F >= 0:
        light = _from_triangle(_pixels(images, f"{k}.light", (F + 1, 2 * F + 1, 3)))
        rho = _pixels(images, f"{k}.rho", (F + 1, (P + 1) ** 2, 3)).reshape(F + 1, P + 1, P + 1, 3)
    gamma = np.zeros(0)
    if center != "tangent":
        gamma = _pixels(images, f"{k}.gamma", (1, None, 1)).ravel()
        if len(gamma) < 2:
            raise ValueError("a table of gamma with one entry")
    maps = picture.pixels.reshape(rows, columns, channels // 3, 3)
    part = Part(
        cast(Center, center), gamma, zonal, cast(Layout, layout), light, rho, maps.transpose(0, 2, 3, 1)
    )
    if not np.isfinite(picture.pixels).all():
        raise ValueError("maps that are not finite")
    if layout == "cube":
        return _bordered(part, maps)
    if rows % 2 or columns != 2 * rows:
        raise ValueError(f"lat-long maps of {columns} x {rows} texels")
    rings = np.ascontiguousarray(part.rings, dtype=np.float32)
    return Part(part.center, gamma, zonal, "latlong", light, rho, rings)


def _bordered(part: Part, maps: Float32Array) -> Part:
    """A cube's faces as stored, in the borders that the coefficients give."""
    N = maps.shape[1]
    if N < 2 or maps.shape[0] != 6 * N or not len(part.light):
        raise ValueError(f"cube maps of {N} x {maps.shape[0]} texels")
    rings = synthesised(part.coefficients, N, "cube")
    side = N + 2 * BORDER
    faces = rings.reshape(6, side, *rings.shape[1:])
    faces[:, BORDER:-BORDER, ..., BORDER:-BORDER] = maps.reshape(6, N, *maps.shape[1:]).transpose(
        0, 1, 3, 4, 2
    )
    return Part(part.center, part.gamma, part.zonal, "cube", part.light, part.rho, rings)


def _image(
    name: str, pixels: npt.NDArray[Any], channels: str | list[str], about: Mapping[str, Any] | None = None
) -> image_io.Part:
    return image_io.Part(
        name, np.ascontiguousarray(pixels, dtype=np.float32), list(channels), dict(about or {})
    )


def _pixels(images: Mapping[str, image_io.Part], name: str, shape: tuple[int | None, ...]) -> FloatArray:
    pixels = images[name].pixels.astype(np.float64)
    if any(want is not None and want != have for want, have in zip(shape, pixels.shape, strict=True)):
        raise ValueError(f"{name} of shape {pixels.shape}")
    if not np.isfinite(pixels).all():
        raise ValueError(f"{name} is not finite")
    return pixels


def _number(about: Mapping[str, Any], name: str) -> int:
    value = int(about[name])
    if not -1 <= value <= 1000:
        raise ValueError(f"{name} = {value}")
    return value


def _map_channels(part: Part) -> list[str]:
    pairs = [(p, q) for p in range(part.P + 1) for q in ([0] if part.zonal else range(-p, p + 1))]
    return [f"B_{p}_{q}.{c}" for p, q in pairs for c in "RGB"]


def _triangle(light: FloatArray) -> FloatArray:
    """((F+1)^2, 3) to (F+1, 2F+1, 3): L_lm at [l, m + F], zero elsewhere."""
    l, m = _degrees(len(light))
    F = int(l[-1])
    picture = np.zeros((F + 1, 2 * F + 1, 3))
    picture[l, m + F] = light
    return picture


def _from_triangle(picture: FloatArray) -> FloatArray:
    l, m = _degrees(len(picture) ** 2)
    return np.ascontiguousarray(picture[l, m + len(picture) - 1])


def _degrees(count: int) -> tuple[IntArray, IntArray]:
    index = np.arange(count)
    l = np.sqrt(index).astype(np.int64)
    return l, index - l * (l + 1)
