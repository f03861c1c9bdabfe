"""The Columbia-Utrecht database: 61 surfaces, each measured at 205 pairs of directions, as fits of order 8.

The sparse measurements are fitted by the basis of Koenderink and van Doorn (`koenderink_van_doorn`), as by
the authors of the database [DGNK99]. Four layouts of text, numbers in rows; the first three are the
database's own, described at www.cs.columbia.edu/CAVE/software/curet, pages brdfm and brdfp:

    kp8.dat, kp2.dat     sample a_1 ... a_55 (or 5)         coefficients, a row a sample
    abrdf.dat            sample f_1 ... f_205               the BRDF, a row a sample, with
    table.txt            number theta_v phi_v theta_i phi_i the directions, a row a measurement, radians
    any other name       theta_i phi_i theta_v phi_v f      or f_R f_G f_B: one sample, the BRDF, radians

kp8.dat and abrdf.dat are means over the channels. Where kp8r.dat, kp8g.dat and kp8b.dat (or rbrdf.dat,
gbrdf.dat and bbrdf.dat) lie together, reading one of them reads all three. Colors are those of the camera,
taken for linear sRGB.

The pages do not say in which order and scale the coefficients stand: they are taken as the a_nml of the
published sum, n slowest and l fastest. A measurement below 0 is taken for missing. The fit may go below 0,
where it is cut.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf.measured import koenderink_van_doorn, text
from shrm.brdf.measured.measured import Extrapolate, Measured
from shrm.brdf.measured.resampled import Cones, Function, resampled, within

MEASUREMENTS = 205
"""Pairs of directions at which each sample of the database was measured."""

ORDERS = {5: 2, 55: 8}
"""Order of a fit by its number of coefficients."""

FITTED_ORDER = 8
"""Order that measurements are fitted by: the higher of the two that the database publishes."""

_CHANNEL_FILE = re.compile(r"(?P<before>kp[28]?)?(?P<channel>[rgb])(?P<after>(?:brdf)?\.dat)")


def recognises(head: bytes, size: int) -> bool:
    """Tell whether a file begins with a row of numbers of one of the lengths above."""
    content = text.decoded(head)
    if content is None or "#DIM" in content or "#PARAM" in content:
        return False
    lines = [line for line in (raw.partition("#")[0].split() for raw in content.splitlines()) if line]
    if not lines or not all(text.is_number(word) for word in lines[0][:-1]):
        return False
    first = lines[0]
    if len(first) in (5, 7):
        return all(0.0 <= float(word) <= np.pi / 2 for word in (first[0], first[2]))
    complete = len(lines) > 1 or size <= len(head)  # else the row goes on beyond the head
    counts = (*(1 + count for count in ORDERS), 1 + MEASUREMENTS)
    return first[0].isdecimal() and (len(first) in counts if complete else len(first) <= max(counts))


def read(path: Path, extrapolate: Extrapolate = "nearest", *, sample: int | None = None) -> Measured:
    """Read a sample of the database.

    Parameters
    ----------
    path : Path
        The file, in one of the layouts above.
    extrapolate : {"nearest", "zero"}
        What there is beyond the largest measured angle from the normal. Coefficients say nothing of that:
        they are taken to hold everywhere.
    sample : int, optional
        Which row, by its number. Needed where there are several.

    Returns
    -------
    Measured
        A material that is evaluated by look-up in a table of 2 MB.

    Raises
    ------
    OSError
        If the file, or the table of directions beside it, cannot be read.
    ValueError
        If it is not as described above; the text names the file and what is wrong.
    """
    # Coefficients
    rows = _rows(path)
    count = rows.shape[1] - 1
    if count in ORDERS:
        number, coefficients = _channels(path, rows, sample)
        notes = [f"order {ORDERS[count]} of Koenderink and van Doorn, {count} coefficients, taken as a_nml"]
        return _material(path, number, coefficients.T, ORDERS[count], np.pi / 2, extrapolate, notes)

    # Measurements, with their directions in a table beside them
    if count == MEASUREMENTS:
        number, values = _channels(path, rows, sample)
        directions = _rows(path.with_name("table.txt"))
        if directions.shape != (MEASUREMENTS, 5):
            raise ValueError(
                f"{path.with_name('table.txt')}: must have {MEASUREMENTS} rows of 5 numbers, got "
                f"{directions.shape[0]} of {directions.shape[1]}"
            )
        return _fitted(path, number, directions[:, [3, 4, 1, 2]], values.T, extrapolate)

    # Measurements of one sample, each row with its directions
    if rows.shape[1] in (5, 7):
        if sample is not None:
            raise ValueError(f"{path}: holds one sample, which has no number, got sample {sample}")
        return _fitted(path, None, rows[:, :4], rows[:, 4:], extrapolate)
    raise ValueError(
        f"{path}: rows must have 6 or 56 numbers (coefficients), 206 (measurements) or 5 or 7 (directions "
        f"and values), got {rows.shape[1]}"
    )


def _rows(path: Path) -> FloatArray:
    content = [line.partition("#")[0] for line in text.lines(path)]
    return text.rows(path, [line for line in content if line.strip()])


def _channels(path: Path, rows: FloatArray, sample: int | None) -> tuple[int, FloatArray]:
    """Return the number of a sample and its row in each channel's file, (3, count); thrice one if gray."""
    number = _sample(path, rows, sample)

    # The files of red, green and blue, where all three lie together
    match = _CHANNEL_FILE.fullmatch(path.name)
    names = [f"{match['before'] or ''}{channel}{match['after']}" for channel in "rgb"] if match else []
    files = [path.with_name(name) for name in names]
    if not files or not all(file.exists() for file in files):
        return number, np.repeat(_row(path, rows, number), 3, axis=0)
    channels = []
    for file in files:
        channel = _rows(file)
        if channel.shape[1] != rows.shape[1]:
            raise ValueError(
                f"{file}: has rows of {channel.shape[1]} numbers, {path.name} of {rows.shape[1]}"
            )
        channels.append(_row(file, channel, number))
    return number, np.concatenate(channels)


def _sample(path: Path, rows: FloatArray, sample: int | None) -> int:
    """Return the number of a sample: the one that is asked for, or the only one of the file."""
    if sample is not None:
        return sample
    if len(rows) > 1:
        raise ValueError(
            f"{path}: holds {len(rows)} samples, numbers {rows[0, 0]:g} to {rows[-1, 0]:g}: say which"
            " (sample=N, or FILE:sample=N)"
        )
    return int(rows[0, 0])


def _row(path: Path, rows: FloatArray, number: int) -> FloatArray:
    """Return the row of a sample, (1, count), without its number."""
    matches = np.flatnonzero(rows[:, 0] == number)
    if len(matches) != 1:
        raise ValueError(f"{path}: has {len(matches)} rows for sample {number}, must have 1")
    return rows[matches, 1:]


def _fitted(
    path: Path, number: int | None, angles: FloatArray, values: FloatArray, extrapolate: Extrapolate
) -> Measured:
    """Fit a material to measurements at angles (n, 4), theta_i phi_i theta_v phi_v, values (n, 1 or 3)."""
    # Ranges
    for column, name in ((0, "theta_i"), (2, "theta_v")):
        text.require_range(path, f"{name} (radians)", angles[:, column], 0.0, np.pi / 2)
    for column, name in ((1, "phi_i"), (3, "phi_v")):
        text.require_range(path, f"{name} (radians)", angles[:, column], -7.0, 7.0)
    text.require_range(path, "values", values, -np.inf, 1e9)

    # Measurements with data, enough of them for the fit, in three channels
    present = values.min(axis=1) >= 0.0
    least = len(koenderink_van_doorn.indices(FITTED_ORDER))
    if np.sum(present) < least:
        raise ValueError(f"{path}: {np.sum(present)} measurements are too few for {least} coefficients")
    angles, values = angles[present], np.repeat(values[present], 3 // values.shape[1], axis=1)
    wi, wo = (
        np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
        for theta, phi in (angles[:, :2].T, angles[:, 2:].T)
    )

    # The fit, and how well it holds the measurements
    coefficients = koenderink_van_doorn.fit(FITTED_ORDER, wi, wo, values)
    residual = koenderink_van_doorn.evaluate(FITTED_ORDER, wi, wo) @ coefficients - values
    relative = np.linalg.norm(residual) / max(float(np.linalg.norm(values)), 1e-300)
    notes = [
        f"{len(values)} measurements, fitted by order {FITTED_ORDER} of Koenderink and van Doorn with a "
        f"relative RMS error of {relative:.3g}"
    ]
    if missing := int(np.sum(~present)):
        notes.append(f"{missing} measurements are negative: no data, left out")

    # The basis is reciprocal: what was measured of one direction is known of the other.
    limit = float(angles[:, [0, 2]].max())
    return _material(path, number, coefficients, FITTED_ORDER, limit, extrapolate, notes)


def _material(
    path: Path,
    number: int | None,
    coefficients: FloatArray,
    order: int,
    limit: float,
    extrapolate: Extrapolate,
    notes: list[str],
) -> Measured:
    """Make a material of coefficients (coefficients, 3) that hold up to `limit` radians from the normal."""
    text.require_range(path, "coefficients", coefficients, -1e9, 1e9)

    def brdf(wi: FloatArray, wo: FloatArray) -> FloatArray:
        return np.asarray(koenderink_van_doorn.evaluate(order, wi, wo) @ coefficients)

    below = _share_below_zero(brdf)
    if below > 0.0:
        notes.append(f"the fit is below 0, and cut there, at {100.0 * below:.2g}% of directions")
    covers = Cones(limit, limit)
    function = resampled(
        lambda wi, wo: np.maximum(brdf(within(wi, limit), within(wo, limit)), 0.0), covers, extrapolate
    )
    label = path.stem if number is None else f"{path.stem} sample {number}"
    return Measured(label, "CUReT", function, covers, extrapolate, tuple(notes))


def _share_below_zero(brdf: Function) -> float:
    """Return the part of pairs of directions, even in projected solid angle, where a channel is below 0."""
    middle = (np.arange(16) + 0.5) / 16
    cos2_i, cos2_v, phi = (x.ravel() for x in np.meshgrid(middle, middle, np.pi * middle, indexing="ij"))
    wi = np.stack([np.sqrt(1.0 - cos2_i), np.zeros_like(phi), np.sqrt(cos2_i)], axis=1)
    sin_v = np.sqrt(1.0 - cos2_v)
    wo = np.stack([sin_v * np.cos(phi), sin_v * np.sin(phi), np.sqrt(cos2_v)], axis=1)
    return float(np.mean(brdf(wi, wo).min(axis=1) < 0.0))
