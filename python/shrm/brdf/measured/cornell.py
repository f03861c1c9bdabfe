"""Measurements of the gonioreflectometer of Cornell's Program of Computer Graphics, `.brdf`.

The file is text; from # to the end of a line is a comment. Then numbers, in lines of any length:

    K                                         wavelengths
    lambda_1 ... lambda_K                     nm
    theta_i phi_i theta_s phi_s f_1 ... f_K   a row for each geometry: source i, detector s, radians; the BRDF

The source is the light L, the detector the eye V, and only |phi_i - phi_s| counts: the surface is taken as
isotropic. Spectra become colors (see `spectrum`); those that are negative somewhere mark missing data.

Between the geometries the BRDF is interpolated (see `scattered`) in X, Y and Z, which are positive, and
then put into a table over half angles, exact to .2% (median) where the data is known to 1%.
Format and measurements are by S. Westin, S.-C. Foo, H. Li and K. Torrance (Reflectance Data, Cornell
University Program of Computer Graphics).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf.measured import text
from shrm.brdf.measured.measured import Extrapolate, Measured
from shrm.brdf.measured.resampled import Cones, resampled, within
from shrm.brdf.measured.scattered import GRAZING, MOST_PLACES, interpolated
from shrm.brdf.measured.spectrum import linear_srgb_from_xyz, to_xyz

FEWEST = 10
"""Fewest geometries with data that a material is interpolated from."""


def recognises(head: bytes, size: int) -> bool:
    """Tell whether a file begins with a lone count of wavelengths, then a number of nanometers."""
    content = text.decoded(head)
    if content is None or "#DIM" in content or "#PARAM" in content:
        return False
    lines = [line for line in (raw.partition("#")[0].split() for raw in content.splitlines()) if line]
    return (
        len(lines) > 1
        and len(lines[0]) == 1
        and lines[0][0].isdecimal()
        and text.is_number(lines[1][0])
        and float(lines[1][0]) > 100.0  # nm
    )


def read(path: Path, extrapolate: Extrapolate = "nearest") -> Measured:
    """Read a file of goniometer measurements.

    Parameters
    ----------
    path : Path
        The file.
    extrapolate : {"nearest", "zero"}
        What there is beyond the largest measured angles from the normal of light and eye.

    Returns
    -------
    Measured
        A material that is evaluated by look-up in a table of 2 MB.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is not as described above; the text names the file and what is wrong.
    """
    # Geometries with data, their colors and directions
    angles, wavelengths, spectra = _parsed(path)
    present = spectra.min(axis=1) >= 0.0
    missing = int(np.sum(~present))
    if np.sum(present) < FEWEST:
        raise ValueError(f"{path}: {np.sum(present)} geometries have data, at least {FEWEST} are needed")
    angles = angles[present]
    xyz = _colors(path, wavelengths, spectra[present])
    outside = int(np.sum(linear_srgb_from_xyz(xyz).min(axis=1) < 0.0))
    wi, wo = (_directions(theta, phi) for theta, phi in (angles[:, :2].T, angles[:, 2:].T))

    # Remarks on what was measured
    notes = [
        f"{len(angles)} geometries, light to {np.degrees(angles[:, 0].max()):.1f} and eye to "
        f"{np.degrees(angles[:, 2].max()):.1f} degrees from the normal",
        f"colors of {len(wavelengths)} wavelengths by the CIE 1931 observer under D65; {outside} are outside "
        "sRGB, their components below 0 are kept",
    ]
    if missing:
        notes.append(f"{missing} geometries have negative values: no data, filled from the others")

    # Interpolation in XYZ, resampled as linear sRGB
    brdf = interpolated(wi, wo, xyz)
    theta_i, theta_s = (min(float(angles[:, column].max()), GRAZING) for column in (0, 2))
    covers = Cones(theta_i, theta_s)
    function = resampled(
        lambda wi, wo: linear_srgb_from_xyz(brdf(within(wi, theta_i), within(wo, theta_s))),
        covers,
        extrapolate,
    )
    return Measured(path.stem, "Cornell", function, covers, extrapolate, tuple(notes))


def _directions(theta: FloatArray, phi: FloatArray) -> FloatArray:
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def _colors(path: Path, wavelengths: FloatArray, spectra: FloatArray) -> FloatArray:
    try:
        return to_xyz(wavelengths, spectra)
    except ValueError as fault:
        raise ValueError(f"{path}: {fault}") from None


def _parsed(path: Path) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the angles (n, 4), radians, the wavelengths (K,), nm, and the spectra (n, K)."""
    # The number of wavelengths
    words = [word for line in text.lines(path) for word in line.partition("#")[0].split()]
    if not words or not words[0].isdecimal() or not words[0].isascii() or len(words[0]) > 18:
        raise ValueError(
            f"{path}: must begin with the number of wavelengths, got {''.join(words[:1])[:40]!r}"
        )
    count = int(words[0])
    if not 2 <= count <= len(words) - 1:
        raise ValueError(f"{path}: {count} wavelengths are declared, and {len(words) - 1} numbers follow")

    # The wavelengths, and a row for each geometry
    values = text.numbers(path, words[1:])
    wavelengths, numbers = values[:count], values[count:]
    if len(numbers) % (4 + count) or not len(numbers):
        raise ValueError(
            f"{path}: rows must have 4 + {count} numbers, but {len(numbers)} are left, no multiple of that"
        )
    rows = numbers.reshape(-1, 4 + count)
    if len(rows) > MOST_PLACES:
        raise ValueError(f"{path}: {len(rows)} geometries are too many, at most {MOST_PLACES} are taken")

    # Ranges
    if np.any(np.diff(wavelengths) <= 0.0):
        raise ValueError(f"{path}: wavelengths must increase")
    text.require_range(path, "wavelengths (nm)", wavelengths, 100.0, 1e5)
    for column, name in ((0, "theta_i"), (2, "theta_s")):
        text.require_range(path, f"{name} (radians)", rows[:, column], 0.0, np.pi / 2)
    for column, name in ((1, "phi_i"), (3, "phi_s")):
        text.require_range(path, f"{name} (radians)", rows[:, column], -7.0, 7.0)
    text.require_range(path, "values", rows[:, 4:], -np.inf, 1e9)
    return rows[:, :4], wavelengths, rows[:, 4:]
