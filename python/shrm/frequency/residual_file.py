"""The residual of a reflection map in its file: the light, and the tables of each core.

`residual.light`
    The light as a lat-long picture; channels R, G, B.
`residual.rotation`
    The rotation of the light, 3 x 3.
`residual.k.center`
    For core k: one row, the angle between the center and N over theta_v, radians.
`residual.k.envelope`, `.ratio`, `.caps`
    Of an isotropic lobe, see `shrm.integrate.descent_lobes.IsotropicDescent`; the ratio as rows of azimuths.
`residual.k.profile`, `.within`
    Of a radial lobe, see `shrm.integrate.descent_lobes.RadialDescent`; the profile as rows of segments.
`residual.k.albedo`, `.mirror`
    What is looked up: a row for each view, and one row of angles as `.center` has. Not there if nothing is.

The metadata of `residual.light` says the rest, numbers as text of full precision.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast, get_args

import numpy as np
import numpy.typing as npt

from shrm import image_io
from shrm.arrays import FloatArray
from shrm.brdf.lobe import Center
from shrm.integrate.descent_lobes import IsotropicDescent, RadialDescent
from shrm.integrate.residual import LARGEST_CUT, Core, LookUp, Residual
from shrm.integrate.tables import LIGHT_INTERVALS, view_nodes

Images = Mapping[str, image_io.Part]

LIGHT = "residual.light"


def residual_parts(residual: Residual) -> list[image_io.Part]:
    """Return the parts of a file that hold a residual."""
    about: dict[str, str | int | float] = {"shrm:cut": residual.cut, "shrm:cores": len(residual.cores)}
    parts = [_values("residual.rotation", residual.rotation)]
    for k, (name, core) in enumerate(residual.cores):
        descent = core.descent
        numbers = {"threshold": core.threshold, "integral": descent.integral, "width": descent.width}
        tables: dict[str, npt.NDArray[Any]]
        if isinstance(descent, IsotropicDescent):
            numbers |= {"above": descent.above, "below": descent.below}
            ratio = descent.ratio.reshape(-1, descent.ratio.shape[-1])
            tables = {"center": descent.gamma[None], "envelope": descent.envelope}
            tables |= {"ratio": ratio, "caps": descent.caps}
        else:
            numbers |= {"shift": descent.shift, "scale": descent.scale, "support": descent.support}
            tables = {"profile": descent.values.reshape(-1, descent.values.shape[-1])}
            tables |= {"within": descent.within}
        about[f"shrm:{k}.looked up"] = int(core.look_up is not None)
        if core.look_up is not None:
            tables |= {"albedo": core.look_up.albedo, "mirror": core.look_up.gamma[None]}
        about |= {f"shrm:{k}.map": name, f"shrm:{k}.center": descent.center}
        about |= {f"shrm:{k}.{key}": repr(float(value)) for key, value in numbers.items()}
        parts += [_values(f"residual.{k}.{key}", table) for key, table in tables.items()]
    light = image_io.Part(LIGHT, residual.pixels, ["R", "G", "B"], about)
    return [light, *parts]


def read_residual(
    images: Images, maps: Sequence[tuple[str, Center, FloatArray]], layout: str, size: int
) -> Residual:
    """Read what `residual_parts` wrote.

    Parameters
    ----------
    images : {name: part}
        Of the file.
    maps : sequence of (name, center, gamma)
        Of the reflection map's parts.
    layout, size
        Of its maps.

    Raises
    ------
    KeyError, TypeError, ValueError
        If they are damaged.
    """
    light = images[LIGHT]
    about, pixels = light.metadata, np.ascontiguousarray(light.pixels, np.float32)
    H, W, channels = pixels.shape
    cut = int(cast(int, about["shrm:cut"]))
    if channels != 3 or not np.isfinite(pixels).all() or H < 2 or W < 4:
        raise ValueError(f"{LIGHT} of shape {pixels.shape}, or not finite")
    if not 1 <= cut <= max(LARGEST_CUT // max(H, W), 1):
        raise ValueError(f"shrm:cut = {cut}")
    rotation = _table(images, "residual.rotation", (3, 3))
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-5:
        raise ValueError("residual.rotation is none")
    by_name = {name: (center, gamma) for name, center, gamma in maps}
    count = int(cast(int, about["shrm:cores"]))
    if not 1 <= count <= len(maps):
        raise ValueError(f"shrm:cores = {count}")
    cores = tuple(_core(images, about, k, by_name) for k in range(count))
    return Residual(pixels, cut, cores, layout, size, rotation)


LEAST_SEGMENTS, LARGEST_SHIFT = 32, 22
"""Of the tables of profiles, as the core has them."""
TINY = 1e-30
"""What heights and scales are above: squares of smaller ones are nothing to a float."""


def _core(
    images: Images, about: Mapping[str, Any], k: int, maps: Mapping[str, tuple[Center, FloatArray]]
) -> tuple[str, Core]:
    name = str(about[f"shrm:{k}.map"])
    center, gamma = maps[name]
    own_center = str(about[f"shrm:{k}.center"])
    if own_center not in get_args(Center):
        raise ValueError(f"center {own_center!r}")

    def number(key: str) -> float:
        value = float(about[f"shrm:{k}.{key}"])
        if not value >= 0:
            raise ValueError(f"shrm:{k}.{key} = {value}")
        return value

    descent: IsotropicDescent | RadialDescent
    integral, width = number("integral"), number("width")
    if f"residual.{k}.ratio" in images:
        envelope = _table(images, f"residual.{k}.envelope", (None, None)).astype(np.float32)
        flat = _table(images, f"residual.{k}.ratio", (None, None)).astype(np.float32)
        caps = _table(images, f"residual.{k}.caps", (None, 2))
        views, (rows, azimuths) = len(caps), flat.shape
        lights = LIGHT_INTERVALS + 2
        channels = rows // max(views * lights, 1)
        if channels not in (1, 3) or rows != channels * views * lights or views < 2 or azimuths < 3:
            raise ValueError(f"residual.{k}.ratio of shape {flat.shape}")
        if len(envelope) not in (1, channels) or envelope.shape[1] < 3:
            raise ValueError(f"residual.{k}.envelope of shape {envelope.shape}")
        ratio = np.ascontiguousarray(flat.reshape(views, -1, lights, azimuths))
        own_gamma = _angles(images, f"residual.{k}.center")
        heights = number("above"), number("below")
        if not min(heights[1], 1.0) > TINY:
            raise ValueError(f"shrm:{k}.below = {heights[1]}")
        descent = IsotropicDescent(own_center, own_gamma, width, envelope, ratio, caps, integral, *heights)
    else:
        flat = _table(images, f"residual.{k}.profile", (None, None)).astype(np.float32)
        segments = flat.shape[1]
        if len(flat) not in (4, 12) or segments < LEAST_SEGMENTS or segments & (segments - 1):
            raise ValueError(f"residual.{k}.profile of shape {flat.shape}")
        values = np.ascontiguousarray(flat.reshape(-1, 4, flat.shape[1]))
        within = _table(images, f"residual.{k}.within", (None, 2))
        if len(within) < 2:
            raise ValueError(f"residual.{k}.within of shape {within.shape}")
        shift, scale, support = number("shift"), number("scale"), number("support")
        if not (shift <= LARGEST_SHIFT and min(scale, support) > TINY and max(scale, support) < 1 / TINY):
            raise ValueError(f"residual.{k}.profile over {shift:g}, {scale:g}, {support:g}")
        descent = RadialDescent(own_center, values, int(shift), scale, support, integral, width, within)
    look_up = None
    if number("looked up"):
        albedo = _table(images, f"residual.{k}.albedo", (len(view_nodes()), None))
        mirror = _angles(images, f"residual.{k}.mirror")
        if albedo.shape[1] not in (1, 3):
            raise ValueError(f"residual.{k}.albedo of shape {albedo.shape}")
        look_up = LookUp(cast(Center, own_center), mirror, albedo)
    return name, Core(center, gamma, descent, number("threshold"), look_up)


def _angles(images: Images, name: str) -> FloatArray:
    """A row of angles over theta_v."""
    angles: FloatArray = _table(images, name, (1, None))[0]
    if len(angles) < 2:
        raise ValueError(f"{name} of {len(angles)} angles")
    return angles


def _values(name: str, table: npt.NDArray[Any]) -> image_io.Part:
    return image_io.Part(name, np.ascontiguousarray(table[:, :, None], dtype=np.float32), ["Y"], {})


def _table(images: Images, name: str, shape: tuple[int | None, int | None]) -> FloatArray:
    """A table of finite numbers, of the shape wanted."""
    values = images[name].pixels[:, :, 0].astype(np.float64)
    if any(want is not None and want != have for want, have in zip(shape, values.shape, strict=True)):
        raise ValueError(f"{name} of shape {values.shape}")
    if not np.all(np.abs(values) < 1 / TINY):
        raise ValueError(f"{name} is not finite, or beyond {1 / TINY:g}")
    return values
