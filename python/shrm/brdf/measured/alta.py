"""Text files of ALTA, the library for the analysis of BRDFs [BBP14].

    #DIM 1 3                numbers before and after: coordinates, values
    #PARAM_IN  COS_TH       what the coordinates are
    #PARAM_OUT RGB_COLOR    what the values are
    0.99998 0.1 0.08 0.06   a row for each measurement
    ...

Lines that begin with # and say something else are comments, but #VS 1 or #VS 2 (rows have further columns,
with intervals of confidence, which are left out) and #FORMAT binary (refused). Coordinates as ALTA defines
them in its class `params`, angles in radians; (theta_d, phi_d) is the direction of the view from H there:

    COS_TH                  cos(theta_h); the BRDF depends on the half angle alone
    RUSIN_TH_TD             theta_h, theta_d; it depends on these alone
    RUSIN_TH_TD_PD          theta_h, theta_d, phi_d
    ISOTROPIC_TV_TL_DPHI    theta_v, theta_l, phi_l - phi_v

and values: the BRDF, without the cosine, RGB_COLOR (three channels, taken for linear sRGB) or INV_STERADIAN
(one).

One coordinate is interpolated linearly in theta_h, several as scattered data (`scattered`). Rows with a
negative value have no data. Beyond the largest coordinates the values there hold ("nearest") or it is black
("zero").

The slice pink-felt-1d.alta that comes with ALTA has 90 rows even in sin(theta_h), (j + 1/2) / 90 to 2e-5.
Each is the value of the bin of MERL in which theta_h, taken as it is written, lies: neighbors are equal at
14 places, all among the 19 where bins that are even in the square root of theta_h say they could be.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shrm.arrays import BoolArray, FloatArray
from shrm.brdf.measured import text
from shrm.brdf.measured.measured import Extrapolate, Measured
from shrm.brdf.measured.resampled import Cones, Covers, Function, from_half_angles, resampled, within
from shrm.brdf.measured.scattered import GRAZING, MOST_PLACES, interpolated
from shrm.brdf.value import Method, Value

COORDINATES: Mapping[str, tuple[tuple[str, float, float], ...]] = {
    "COS_TH": (("cos(theta_h)", 0.0, 1.0),),
    "RUSIN_TH_TD": (("theta_h", 0.0, np.pi / 2), ("theta_d", 0.0, np.pi / 2)),
    "RUSIN_TH_TD_PD": (
        ("theta_h", 0.0, np.pi / 2),
        ("theta_d", 0.0, np.pi / 2),
        ("phi_d", -2 * np.pi, 2 * np.pi),
    ),
    "ISOTROPIC_TV_TL_DPHI": (
        ("theta_v", 0.0, np.pi / 2),
        ("theta_l", 0.0, np.pi / 2),
        ("dphi", -2 * np.pi, 2 * np.pi),
    ),
}
"""Coordinates of each PARAM_IN: their names and ranges, radians."""

CHANNELS: Mapping[str, int] = {"RGB_COLOR": 3, "INV_STERADIAN": 1}
"""Values in a row of each PARAM_OUT."""

_ROUNDING = 1e-9
"""Radians by which the angles of a measured pair of directions may exceed those of its row, by rounding."""


def recognises(head: bytes, size: int) -> bool:
    """Tell whether the first bytes of a file hold a line #DIM or #PARAM_IN."""
    content = text.decoded(head)
    return content is not None and any(
        line.split()[:1] in (["#DIM"], ["#PARAM_IN"]) for line in content.splitlines()
    )


def read(path: Path, extrapolate: Extrapolate = "nearest") -> Measured:
    """Read a text file of ALTA.

    Parameters
    ----------
    path : Path
        The file.
    extrapolate : {"nearest", "zero"}
        What there is beyond the coordinates of the file.

    Returns
    -------
    Measured

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is not as described above; the text names the file and what is wrong.
    """
    # Rows with data, in three channels
    name, coordinates, values = _parsed(path)
    present = values.min(axis=1) >= 0.0
    notes = [f"{int(np.sum(present))} rows over {name}"]
    if missing := int(np.sum(~present)):
        notes.append(f"{missing} rows have negative values: no data, left out")
    if np.sum(present) < 2:
        raise ValueError(f"{path}: {np.sum(present)} rows have data, at least 2 are needed")
    coordinates, values = coordinates[present], np.repeat(values[present], 3 // values.shape[1], axis=1)

    # By half angles alone, or over the directions of light and eye
    if name == "COS_TH":
        function, covers = _of_half_angle(np.arccos(coordinates[:, 0]), values, extrapolate)
    elif name == "RUSIN_TH_TD":
        function, covers = _of_half_and_difference(coordinates, values, extrapolate)
    else:
        wi, wo = _directions(name, coordinates)
        above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
        if np.sum(above) < 2:
            raise ValueError(f"{path}: {np.sum(above)} rows have light and eye above the surface")
        if below := int(np.sum(~above)):
            notes.append(f"{below} rows have light or eye below the surface, and are left out")
        wi, wo = wi[above], wo[above]
        theta_i, theta_o = (min(float(np.arccos(w[:, 2].min())), float(GRAZING)) for w in (wi, wo))
        brdf = interpolated(wi, wo, values[above])
        covers = Cones(theta_i, theta_o)
        function = resampled(
            lambda wi, wo: brdf(within(wi, theta_i), within(wo, theta_o)), covers, extrapolate
        )
    return Measured(path.stem, "ALTA", function, covers, extrapolate, tuple(notes))


@dataclass(frozen=True, eq=False, repr=False)
class HalfAngleProfile(Value):
    """A BRDF of theta_h alone, linear between rows, times N.L.

    Attributes
    ----------
    theta_h : (n,) float64
        Increasing, radians.
    values : (3, n) float64
        The BRDF there.
    extrapolate : {"nearest", "zero"}
        What there is beyond the last row.
    """

    theta_h: FloatArray
    values: FloatArray
    extrapolate: Extrapolate

    def __call__(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, (n, 3) float64, at unit vectors (n, 3)."""
        theta_h = _half_angle(wi, wo)
        result = np.stack([np.interp(theta_h, self.theta_h, column) for column in self.values], axis=1)
        inside = theta_h <= self.theta_h[-1] + _ROUNDING
        result *= wi[:, 2:] if self.extrapolate == "nearest" else (wi[:, 2] * inside)[:, None]
        return result

    def covers(self, wi: FloatArray, wo: FloatArray) -> BoolArray:
        """Tell, (n,) bool, where there is data."""
        return np.asarray(_half_angle(wi, wo) <= self.theta_h[-1] + _ROUNDING)


@dataclass(frozen=True, eq=False, repr=False)
class HalfAngleLimits(Value):
    """True where theta_h and theta_d are within the last rows, radians."""

    theta_h: float
    theta_d: float

    def __call__(self, wi: FloatArray, wo: FloatArray) -> BoolArray:
        """Tell, (n,) bool, for unit vectors (n, 3)."""
        theta_h, theta_d = _half_and_difference_angles(wi, wo)
        return np.asarray((theta_h <= self.theta_h + _ROUNDING) & (theta_d <= self.theta_d + _ROUNDING))


def _half_angle(wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return theta_h (n,), radians."""
    h = wi + wo
    return np.asarray(np.arctan2(np.hypot(h[:, 0], h[:, 1]), h[:, 2]))


def _half_and_difference_angles(wi: FloatArray, wo: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return theta_h and theta_d, (n,) each, radians."""
    theta_d = np.arctan2(np.linalg.norm(wi - wo, axis=1), np.linalg.norm(wi + wo, axis=1))
    return _half_angle(wi, wo), theta_d


def _of_half_angle(
    theta_h: FloatArray, values: FloatArray, extrapolate: Extrapolate
) -> tuple[Function, Covers]:
    """Return the function of a material that depends on theta_h alone, and where it has data."""
    order = np.argsort(theta_h)
    nodes, columns = theta_h[order], np.ascontiguousarray(values[order].T)
    for array in (nodes, columns):
        array.setflags(write=False)
    profile = HalfAngleProfile(nodes, columns, extrapolate)
    return profile, Method(HalfAngleProfile.covers, profile)


def _of_half_and_difference(
    coordinates: FloatArray, values: FloatArray, extrapolate: Extrapolate
) -> tuple[Function, Covers]:
    """Return the function of a material that depends on theta_h and theta_d alone, and where it has data."""
    last_h, last_d = (float(last) for last in coordinates.max(axis=0))

    # phi_d = 90 degrees, where light and eye are equally far from the normal, stands for all.
    def level(theta_h: FloatArray, theta_d: FloatArray) -> tuple[FloatArray, FloatArray]:
        return from_half_angles(theta_h, theta_d, np.full(len(theta_h), np.pi / 2))

    between = interpolated(*level(coordinates[:, 0], coordinates[:, 1]), values)

    def brdf(wi: FloatArray, wo: FloatArray) -> FloatArray:
        theta_h, theta_d = _half_and_difference_angles(wi, wo)
        return between(*level(np.minimum(theta_h, last_h), np.minimum(theta_d, last_d)))

    covers = HalfAngleLimits(last_h, last_d)
    return resampled(brdf, covers, extrapolate), covers


def _directions(name: str, coordinates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors to the light and to the eye, (n, 3), at coordinates of three dimensions."""
    first, second, third = coordinates.T
    if name == "RUSIN_TH_TD_PD":
        wo, wi = from_half_angles(first, second, third)
        return wi, wo
    wo = np.stack([np.sin(first), np.zeros_like(first), np.cos(first)], axis=1)
    wi = np.stack([np.sin(second) * np.cos(third), np.sin(second) * np.sin(third), np.cos(second)], axis=1)
    return wi, wo


def _parsed(path: Path) -> tuple[str, FloatArray, FloatArray]:
    """Return the name of the coordinates, the coordinates, (n, 1 to 3), and the values, (n, 1 or 3)."""
    # The header
    lines = text.lines(path)
    header = {}
    for line in lines:
        words = line.split()
        if words[0] in ("#DIM", "#PARAM_IN", "#PARAM_OUT", "#VS", "#FORMAT"):
            header[words[0]] = words[1:]
    name = _one_of(path, header, "#PARAM_IN", COORDINATES)
    kind = _one_of(path, header, "#PARAM_OUT", CHANNELS)
    if header.get("#FORMAT", ["text"])[:1] == ["binary"]:
        raise ValueError(f"{path}: is ALTA's binary form, which is not read: convert it to text")
    inputs, outputs = len(COORDINATES[name]), CHANNELS[kind]
    if header.get("#DIM") != [str(inputs), str(outputs)]:
        raise ValueError(
            f"{path}: {name} and {kind} need the line #DIM {inputs} {outputs}, got "
            f"{' '.join(['#DIM', *header['#DIM']])[:60] if '#DIM' in header else 'none'}"
        )

    # The rows of numbers, without columns for intervals of confidence
    content = [line for line in lines if not line.startswith("#")]
    if len(content) > MOST_PLACES:
        raise ValueError(f"{path}: {len(content)} rows are too many, at most {MOST_PLACES} are taken")
    rows = text.rows(path, content)
    further = rows.shape[1] - inputs - outputs
    if further < 0 or (further > 0 and header.get("#VS", ["0"])[:1] == ["0"]):
        raise ValueError(f"{path}: rows must have {inputs} + {outputs} numbers, got {rows.shape[1]}")
    coordinates, values = rows[:, :inputs], rows[:, inputs : inputs + outputs]

    # Ranges; coordinates beyond theirs by rounding are taken for its end
    for column, (coordinate, least, most) in enumerate(COORDINATES[name]):
        inside = np.clip(coordinates[:, column], least, most)
        rounded = np.abs(inside - coordinates[:, column]) < 1e-9
        coordinates[rounded, column] = inside[rounded]
        text.require_range(path, coordinate, coordinates[:, column], least, most)
    text.require_range(path, "values", values, -np.inf, 1e9)
    return name, coordinates, values


def _one_of(path: Path, header: Mapping[str, Sequence[str]], key: str, options: Mapping[str, object]) -> str:
    """Return the one word of a header line, which must be among the options."""
    words = header.get(key, [])
    if len(words) != 1 or words[0] not in options:
        got = " ".join(words)[:60] if words else "none"
        raise ValueError(f"{path}: {key} must be one of {', '.join(options)}, got {got}")
    return words[0]
