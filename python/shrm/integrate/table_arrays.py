"""Conversion of tables of lobes to named arrays, as files hold them, and back.

All axes of a table before the last are joined into one; numbers are arrays without axes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from shrm.arrays import Float32Array
from shrm.integrate.radial_table import RadialTable
from shrm.integrate.saved_arrays import SMALLEST, NamedArrays, angle_pairs, number, table
from shrm.integrate.tables import (
    AZIMUTH_INTERVALS,
    ENVELOPE_INTERVALS,
    LIGHT_INTERVALS,
    VIEW_INTERVALS,
    ZONAL_INTERVALS,
    ZONAL_ROWS,
    HalfAngleTable,
    IsotropicTable,
    ZonalTable,
)

LEAST_SEGMENTS, LARGEST_SHIFT, MOST_OCTAVES = 32, 22, 100
"""Fewest segments, most bits of the shift and most octaves of a profile's table that the core takes."""


class Profile(NamedTuple):
    """The attributes of a `RadialTable` that the core takes."""

    values: Float32Array
    shift: int
    scale: float
    support: float


def profile_from(arrays: NamedArrays) -> Profile:
    """Return the cubics of a radial table.

    Raises
    ------
    KeyError, ValueError
        If an array is missing, or none that the core could use.
    """
    # Rows of the coefficients of one channel, or of three
    rows = table(arrays, "profile", (None, None)).astype(np.float32)
    segments = rows.shape[1]
    if len(rows) not in (4, 12) or segments < LEAST_SEGMENTS or segments & (segments - 1):
        raise ValueError(f"profile of shape {rows.shape}")

    # The places of its segments
    shift, scale, support = (number(arrays, name) for name in ("shift", "scale", "support"))
    if not shift <= LARGEST_SHIFT or segments >> (23 - int(shift)) > MOST_OCTAVES:
        raise ValueError(f"shift = {shift:g} for {segments} segments")
    if not (min(scale, support) > SMALLEST and max(scale, support) < 1 / SMALLEST):
        raise ValueError(f"profile over {scale:g}, {support:g}")
    return Profile(np.ascontiguousarray(rows.reshape(-1, 4, segments)), int(shift), scale, support)


def as_rows(values: Float32Array) -> Float32Array:
    """Return a table with all axes before the last as one."""
    return values.reshape(-1, values.shape[-1])


def numbers_of(source: object, *names: str) -> NamedArrays:
    """Return attributes that are numbers, or arrays as they are."""
    return {name: np.asarray(getattr(source, name)) for name in names}


# ---- Radial


def radial_arrays(radial: RadialTable) -> NamedArrays:
    """Return what `radial_from` takes."""
    numbers = numbers_of(radial, "shift", "scale", "support", "outer", "width", "integral", "error")
    return {"profile": as_rows(radial.values), **numbers}


def radial_from(arrays: NamedArrays) -> RadialTable:
    """Restore a table from what `radial_arrays` returned; KeyError or ValueError if that is damaged."""
    return RadialTable(
        *profile_from(arrays), *(number(arrays, name) for name in ("outer", "width", "integral", "error"))
    )


# ---- Half angles


def half_angle_arrays(half_angle: HalfAngleTable) -> NamedArrays:
    """Return what `half_angle_from` takes."""
    lobe = {"caps": half_angle.caps, "lobe width": np.asarray(half_angle.width)}
    return {**radial_arrays(half_angle.radial), **lobe}


def half_angle_from(arrays: NamedArrays) -> HalfAngleTable:
    """Restore a table from what `half_angle_arrays` returned; KeyError or ValueError if that is damaged."""
    radial = radial_from(arrays)
    if len(radial.values) != 1:
        raise ValueError(f"a profile of half angles of {len(radial.values)} channels")
    width = number(arrays, "lobe width")
    return HalfAngleTable(radial, angle_pairs(arrays, "caps", VIEW_INTERVALS + 1), width, radial.error)


# ---- Zonal


def zonal_arrays(zonal: ZonalTable) -> NamedArrays:
    """Return what `zonal_from` takes."""
    numbers = numbers_of(zonal, "bands", "width", "integral", "error")
    return {"profiles": as_rows(zonal.values), **numbers}


def zonal_from(arrays: NamedArrays) -> ZonalTable:
    """Restore a table from what `zonal_arrays` returned; KeyError or ValueError if that is damaged."""
    width, integral, error = (number(arrays, name) for name in ("width", "integral", "error"))
    return ZonalTable(profiles_from(arrays), angle_pairs(arrays, "bands", ZONAL_ROWS), width, integral, error)


def profiles_from(arrays: NamedArrays) -> Float32Array:
    """Return the profiles of a zonal table; KeyError or ValueError if they are missing or none."""
    rows = table(arrays, "profiles", (None, ZONAL_INTERVALS + 2)).astype(np.float32)
    if len(rows) not in (ZONAL_ROWS, 3 * ZONAL_ROWS):
        raise ValueError(f"profiles of shape {rows.shape}")
    return np.ascontiguousarray(rows.reshape(ZONAL_ROWS, -1, rows.shape[1]))


# ---- Isotropic


def isotropic_arrays(isotropic: IsotropicTable) -> NamedArrays:
    """Return what `isotropic_from` takes."""
    numbers = numbers_of(isotropic, "caps", "width", "integral", "error")
    return {"envelope": isotropic.envelope[None], "ratio": as_rows(isotropic.ratio), **numbers}


def isotropic_from(arrays: NamedArrays) -> IsotropicTable:
    """Restore a table from what `isotropic_arrays` returned; KeyError or ValueError if that is damaged."""
    envelope = table(arrays, "envelope", (1, ENVELOPE_INTERVALS + 2)).astype(np.float32)[0]
    caps = angle_pairs(arrays, "caps", VIEW_INTERVALS + 1)
    width, integral, error = (number(arrays, name) for name in ("width", "integral", "error"))
    return IsotropicTable(envelope, ratio_from(arrays), caps, width, integral, error)


def ratio_from(arrays: NamedArrays) -> Float32Array:
    """Return the ratio of an isotropic table; KeyError or ValueError if it is missing or none."""
    rows = table(arrays, "ratio", (None, AZIMUTH_INTERVALS + 2)).astype(np.float32)
    of_channel = (VIEW_INTERVALS + 1) * (LIGHT_INTERVALS + 2)
    if len(rows) not in (of_channel, 3 * of_channel):
        raise ValueError(f"ratio of shape {rows.shape}")
    return np.ascontiguousarray(rows.reshape(VIEW_INTERVALS + 1, -1, LIGHT_INTERVALS + 2, rows.shape[1]))
