"""Measurements of the gonioreflectometer of Cornell's Program of Computer Graphics, `.brdf`.

The file is text; from # to the end of a line is a comment. Then numbers, in lines of any length:

    K                                         wavelengths
    lambda_1 ... lambda_K                     nm
    theta_i phi_i theta_s phi_s f_1 ... f_K   a row for each geometry: source i, detector s, radians; the BRDF

The source is the light L, the detector the eye V, and only |phi_i - phi_s| counts: the surface is taken as
isotropic. Spectra become colors (see `spectrum`); those that are negative somewhere mark missing data.

Between the geometries the values are interpolated by a thin-plate spline (`scattered`) of

    log(f N.L N.V + softening)   over   (0.2 log(cos^2 theta_h + 100 sin^2 theta_h), 1.5 theta_d, (N.V - N.L) / 2)

in X, Y and Z, which are positive, and then put into a table over half angles. The first coordinate is the
logarithm of the GGX distribution of roughness 0.1 [WMLT07 eq. 33], whose lobe is a straight line in it; the
third is sin(theta_h) sin(theta_d) cos(phi_d), smooth where phi_d is undefined. An exchange of L and V changes
its sign: reciprocity is not assumed. The softening is a tenth of the median.

Each measurement of krylon_blue and garnet_red, left out, is found again to .7% and 1.3% (medians; root mean
square of the logarithm .13), each interior plane of incidence to 2% and 2% (.07 to .10). In the coordinates
(sin sin, delta phi, cos cos, with N.V - N.L) of earlier renderers [PH04] it is 0.8% and 1.7% (.19) and 2.4%
and 3.0% (.13). Against these the table is exact (median .2%).

References
----------
.. [WMLT07] B. Walter, S. Marschner, H. Li, K. Torrance. Microfacet Models for Refraction through
   Rough Surfaces. EGSR 2007.
.. [PH04] M. Pharr, G. Humphreys. Physically Based Rendering. Morgan Kaufmann, 2nd edition 2010, sec. 8.6.
S. Westin, S.-C. Foo, H. Li, K. Torrance. Measurements and format: Cornell University, Program of Computer
Graphics, Reflectance Data.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shrm.brdf.lobe import FloatArray
from shrm.brdf.measured import text
from shrm.brdf.measured.material import Extrapolate, Measured
from shrm.brdf.measured.resampled import Function, resampled
from shrm.brdf.measured.scattered import MOST_PLACES, ThinPlateSpline
from shrm.brdf.measured.spectrum import linear_srgb_from_xyz, to_xyz

GRAZING = np.radians(89.5)
"""Angles beyond are taken for it: the spline is of values times both cosines."""

FEWEST = 10
"""Geometries of a file."""


def recognises(head: bytes, size: int) -> bool:
    """Whether a file begins so: a lone count of wavelengths, then that many increasing numbers."""
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
        Its function looks a table up, 2 MB.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is not as described above; the text names the file and what is wrong.
    """
    angles, wavelengths, spectra = _parsed(path)
    present = spectra.min(axis=1) >= 0.0
    missing = int(np.sum(~present))
    if np.sum(present) < FEWEST:
        raise ValueError(f"{path}: {np.sum(present)} geometries have data, at least {FEWEST} are needed")
    angles = angles[present]
    xyz = to_xyz(wavelengths, spectra[present])
    outside = int(np.sum(linear_srgb_from_xyz(xyz).min(axis=1) < 0.0))
    wi, wo = (_directions(theta, phi) for theta, phi in (angles[:, :2].T, angles[:, 2:].T))
    notes = [
        f"{len(angles)} geometries, light to {np.degrees(angles[:, 0].max()):.1f} and eye to "
        f"{np.degrees(angles[:, 2].max()):.1f} degrees from the normal",
        f"colors of {len(wavelengths)} wavelengths by the CIE 1931 observer under D65; {outside} are outside "
        "sRGB, their components below 0 are kept",
    ]
    if missing:
        notes.append(f"{missing} geometries have negative values: no data, filled from the others")
    brdf = interpolated(wi, wo, xyz)
    function, covers = resampled(
        lambda wi, wo: linear_srgb_from_xyz(brdf(wi, wo)),
        min(float(angles[:, 0].max()), GRAZING),
        min(float(angles[:, 2].max()), GRAZING),
        extrapolate,
    )
    return Measured(path.stem, "Cornell", function, covers, extrapolate, tuple(notes))


def interpolated(wi: FloatArray, wo: FloatArray, values: FloatArray) -> Function:
    """Return a BRDF through values at scattered geometries, as described above.

    Parameters
    ----------
    wi, wo : (n, 3) float64
        Unit vectors to the light and to the eye.
    values : (n, c) float64
        The BRDF there, without the cosine, at least 0.

    Returns
    -------
    callable
        wi, wo, (m, 3) float64, to (m, c) float64, at least 0.

    Raises
    ------
    ValueError
        If there are too many geometries for a spline.
    """
    weighted = values * _cosines(wi, wo)
    softening = np.median(weighted, axis=0) / 10.0
    softening = np.where(softening > 0.0, softening, np.maximum(weighted.mean(axis=0) / 10.0, 1e-12))
    logarithm = np.log(weighted + softening)
    spline = ThinPlateSpline(coordinates(wi, wo), logarithm)
    largest = logarithm.max(axis=0) + np.log(2.0)  # no peak between geometries is believed beyond that

    def brdf(wi: FloatArray, wo: FloatArray) -> FloatArray:
        value = np.exp(np.minimum(spline(coordinates(wi, wo)), largest)) - softening
        return np.maximum(value, 0.0) / _cosines(wi, wo)

    return brdf


def coordinates(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return the three coordinates, (n, 3), in which the logarithm of a BRDF is smooth."""
    h = wi + wo
    across2, length2 = h[:, 0] ** 2 + h[:, 1] ** 2, np.einsum("nc,nc->n", h, h)
    sin2 = across2 / np.maximum(length2, 1e-300)
    theta_d = np.arctan2(np.linalg.norm(wi - wo, axis=1), np.sqrt(length2))
    return np.stack([0.2 * np.log1p(99.0 * sin2), 1.5 * theta_d, 0.5 * (wo[:, 2] - wi[:, 2])], axis=1)


def _cosines(wi: FloatArray, wo: FloatArray) -> FloatArray:
    least = np.cos(GRAZING)
    return np.asarray(np.maximum(wi[:, 2:], least) * np.maximum(wo[:, 2:], least))


def _directions(theta: FloatArray, phi: FloatArray) -> FloatArray:
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def _parsed(path: Path) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The angles (n, 4), the wavelengths (K,) and the spectra (n, K)."""
    words = [word for line in text.lines(path) for word in line.partition("#")[0].split()]
    if not words or not words[0].isdecimal() or not words[0].isascii() or len(words[0]) > 9:
        raise ValueError(
            f"{path}: must begin with the number of wavelengths, got {''.join(words[:1])[:40]!r}"
        )
    count = int(words[0])
    if not 2 <= count <= len(words) - 1:
        raise ValueError(f"{path}: {count} wavelengths are declared, and {len(words) - 1} numbers follow")
    values = text.numbers(path, words[1:])
    wavelengths, rest = values[:count], values[count:]
    if len(rest) % (4 + count) or not len(rest):
        raise ValueError(
            f"{path}: rows must have 4 + {count} numbers, but {len(rest)} are left, no multiple of that"
        )
    rows = rest.reshape(-1, 4 + count)
    if len(rows) > MOST_PLACES:
        raise ValueError(f"{path}: {len(rows)} geometries are too many, at most {MOST_PLACES} are taken")
    if np.any(np.diff(wavelengths) <= 0.0):
        raise ValueError(f"{path}: wavelengths must increase")
    text.require_range(path, "wavelengths (nm)", wavelengths, 100.0, 1e5)
    for column, name in ((0, "theta_i"), (2, "theta_s")):
        text.require_range(path, f"{name} (radians)", rows[:, column], 0.0, np.pi / 2)
    for column, name in ((1, "phi_i"), (3, "phi_s")):
        text.require_range(path, f"{name} (radians)", rows[:, column], -7.0, 7.0)
    text.require_range(path, "values", rows[:, 4:], -np.inf, 1e9)
    return rows[:, :4], wavelengths, rows[:, 4:]
