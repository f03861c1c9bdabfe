"""Materials of the RGL/EPFL database: .bsdf, isotropic, RGB or spectral [DJ18].

    phi_i (p), theta_i (t)       where the tables over an incident direction i are; p = 1 is isotropic
    vndf (p, t, n, n)            the distribution of visible normals, over (phi_m - phi_i, theta_m)
    rgb (p, t, 3, k, k)          the measurements, over the unit square that vndf makes even
    spectra (p, t, w, k, k), wavelengths (w)   the same by wavelength, nm
    ndf (2, n), sigma (2, n)     the distribution of normals, and the area they show to a direction
    jacobian (1)                 whether ndf / (4 sigma) must be multiplied; it is 1 in the database
    valid                        which of the k k samples are measured, a bit each; optional
    luminance, description       for sampling, and a text; not needed

What the files hold is f_r cos(theta_o), the cosine that of the other, sampled direction o. Here i is V and o
is L: with N.L, rho_hat is what the file holds, and stays finite at grazing angles. Between the theta_i the
densities and the samples are interpolated linearly, in the unit squares bilinearly, as by the authors' own
evaluation; like there, negative colors, outside the gamut, are taken for 0. The measurements are about as
reciprocal as they are.

`valid` is stored from the highest bit of each byte, in the order of the samples. In all files at hand it says
which samples have o above the horizon, in some the other way round: it is taken so that the sample at V = N,
H = N is valid. Directions count as covered where the nearest sample is valid. Where it is not, values are
those of the file, which holds continued ones there ("nearest"), or 0 ("zero").
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm import _core
from shrm.arrays import BoolArray, Float32Array, FloatArray
from shrm.brdf import parameters
from shrm.brdf.measured.measured import Extrapolate, Measured
from shrm.brdf.measured.spectrum import to_linear_srgb
from shrm.brdf.measured.tensor_file import MAGIC, TensorFile, open_tensor_file
from shrm.brdf.value import Method, Value


def recognises(head: bytes, size: int) -> bool:
    """Tell whether a file that starts like this is a tensor file."""
    return head.startswith(MAGIC)


def read(path: Path, extrapolate: Extrapolate = "nearest") -> Measured:
    """Read an isotropic material.

    Parameters
    ----------
    path : Path
        The .bsdf file.
    extrapolate : {"nearest", "zero"}
        Values where no sample is valid: the file's own, or 0.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is damaged, anisotropic, or lacks what it needs, in one line that names it.
    """
    file = open_tensor_file(path)
    theta_i = _theta_i(file)
    notes = _description(file)

    # The distributions of normals: shapes, and no negative densities
    distributions = {"vndf": file.read("vndf", "f4", 4), "ndf": file.read("ndf", "f4", 2)}
    sigma = file.read("sigma", "f4", 2)
    _require_squares(path, len(theta_i), vndf=distributions["vndf"])
    for name, values in (*distributions.items(), ("sigma", sigma)):
        if min(values.shape[-2:]) < 2:
            raise ValueError(f"{path}: {name} must have two rows and columns or more, got {values.shape}")
    if not (sigma > 0.0).all():
        raise ValueError(f"{path}: sigma must be positive, got {sigma.min():g}")
    for name, values in distributions.items():
        if negative := int(np.sum(values < 0.0)):
            notes += (f"{negative} of {values.size} values of {name} were negative and are taken for 0",)
            distributions[name] = np.maximum(values, 0.0)
    vndf, ndf = distributions["vndf"][0], distributions["ndf"]
    if not vndf.any(axis=(1, 2)).all():
        raise ValueError(f"{path}: vndf must not be 0 at a whole theta_i")

    # The measurements
    values = _colors(file, len(theta_i))
    if negative := int(np.sum(values < 0.0)):
        notes += (f"{negative} of {values.size} colors were negative, outside sRGB's gamut: 0 there",)
    size = np.abs(values).mean(dtype=np.float64)
    if (handedness := np.abs(values - values[:, ::-1]).mean(dtype=np.float64)) > 1e-3 * size:
        notes += (f"differs by {handedness / size:.1%} from its mirror image, phi_i - phi_o reversed",)

    # Where they must be multiplied by ndf / (4 sigma), the products stay in range.
    has_jacobian = _jacobian(file)
    if has_jacobian:
        with np.errstate(over="ignore"):
            largest = float(values.max()) * float(ndf.max()) / (4.0 * float(sigma.min()))
        if not largest < parameters.LARGEST:
            raise ValueError(
                f"{path}: values times ndf / (4 sigma) must be below {parameters.LARGEST:g}, "
                f"got up to {largest:g}"
            )

    # The material, by look-up in these tables
    table = AdaptiveTable(
        theta_i=theta_i,
        vndf=np.ascontiguousarray(vndf),
        values=values,
        ndf=ndf if has_jacobian else np.empty((0, 0), np.float32),
        sigma=_middle_row(sigma),
        valid=_valid(file, values.shape[:3]),
    )
    evaluate = AdaptiveTable.covered_values if extrapolate == "zero" else AdaptiveTable.evaluate
    covers = Method(AdaptiveTable.covers, table)
    return Measured(path.stem, "RGL", Method(evaluate, table), covers, extrapolate, notes)


@dataclass(frozen=True, eq=False, repr=False)
class AdaptiveTable(Value):
    """The tables of a file, and which of its samples were measured.

    Attributes
    ----------
    theta_i : (t,) float64
        Increasing, radians.
    vndf : (t, n, n) float32
        The density that makes the unit square even.
    values : (t, k, k, 3) float32
        The measurements, linear sRGB.
    ndf : (m, m) or (0, 0) float32
        Empty where the values are f_r cos(theta_o) already.
    sigma : (s,) float32
        The area that normals show to a direction.
    valid : (t, k, k) bool
        Which samples were measured.
    """

    theta_i: FloatArray
    vndf: Float32Array
    values: Float32Array
    ndf: Float32Array
    sigma: Float32Array
    valid: BoolArray

    def __post_init__(self) -> None:
        for each in fields(self):
            getattr(self, each.name).setflags(write=False)

    @cached_property
    def _table(self) -> _core.AdaptiveParameterization:
        return _core.AdaptiveParameterization(
            theta_i=self.theta_i, vndf=self.vndf, values=self.values, ndf=self.ndf, sigma=self.sigma
        )

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, (n, 3) float64, at unit vectors (n, 3) above the horizon."""
        return self._table.evaluate(wi=wi, wo=wo)

    def covered_values(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, black where no sample was measured."""
        return np.asarray(self.evaluate(wi, wo) * self.covers(wi, wo)[:, None])

    def covers(self, wi: FloatArray, wo: FloatArray) -> BoolArray:
        """Tell, (n,) bool, whether the nearest sample was measured."""
        slices, rows, columns = self.valid.shape
        nearest = np.rint(self._table.samples(wi=wi, wo=wo) * [1, rows - 1, columns - 1]).astype(np.intp)
        return np.asarray(self.valid[tuple(np.clip(nearest, 0, [slices - 1, rows - 1, columns - 1]).T)])


def _theta_i(file: TensorFile) -> FloatArray:
    phi_i = file.read("phi_i", "f4", 1)
    if len(phi_i) > 1:
        raise ValueError(
            f"{file.path}: is anisotropic, it has {len(phi_i)} phi_i: only isotropic materials can be read"
        )
    theta_i = file.read("theta_i", "f4", 1).astype(np.float64)
    if not ((np.diff(theta_i) > 0.0).all() and theta_i[0] >= 0.0 and theta_i[-1] < np.pi / 2 + 1e-3):
        raise ValueError(f"{file.path}: theta_i must rise within [0, pi/2], got {theta_i}".replace("\n", ""))
    return theta_i


def _colors(file: TensorFile, slices: int) -> Float32Array:
    """Return the samples as linear sRGB, (theta_i, k, k, 3)."""
    if "rgb" in file.fields or "spectra" not in file.fields:
        rgb = file.read("rgb", "f4", 5)
        _require_squares(file.path, slices, 3, rgb=rgb)
        return np.ascontiguousarray(np.moveaxis(rgb[0], 1, -1))
    wavelengths = file.read("wavelengths", "f4", 1).astype(np.float64)
    spectra = file.read("spectra", "f4", 5)
    _require_squares(file.path, slices, len(wavelengths), spectra=spectra)
    colors = np.empty((slices, *spectra.shape[3:], 3), np.float32)
    try:
        for color, spectrum in zip(colors, spectra[0], strict=True):  # one by one, in little memory
            color[...] = to_linear_srgb(wavelengths, np.moveaxis(spectrum, 0, -1))
    except ValueError as fault:  # what is wrong with the wavelengths
        raise ValueError(f"{file.path}: {fault}") from None
    return colors


def _require_squares(path: Path, slices: int, *channels: int, **field: npt.NDArray[Any]) -> None:
    """Refuse a field without a table of two rows and columns or more for each theta_i (and channel)."""
    ((name, values),) = field.items()
    if values.shape[:-2] != (1, slices, *channels) or min(values.shape[-2:]) < 2:
        needed = ", ".join(str(n) for n in (1, slices, *channels))
        raise ValueError(f"{path}: {name} must have the shape ({needed}, n, n), n >= 2, got {values.shape}")


def _jacobian(file: TensorFile) -> bool:
    """Tell whether the values must be multiplied by ndf / (4 sigma)."""
    flag = file.read("jacobian", "u1", 1)
    if flag.shape != (1,) or flag[0] > 1:
        raise ValueError(f"{file.path}: jacobian must be 0 or 1, got {flag[:4]}")
    return bool(flag[0])


def _valid(file: TensorFile, shape: tuple[int, ...]) -> BoolArray:
    """Return which samples are measured, (theta_i, k, k) bool: all, unless the file says otherwise."""
    count = int(np.prod(shape))
    if "valid" not in file.fields:
        return np.ones(shape, bool)
    packed = file.read("valid", "u1", 1)
    if len(packed) != (count + 7) // 8:
        raise ValueError(f"{file.path}: valid must have {(count + 7) // 8} bytes, got {len(packed)}")
    bits = np.unpackbits(packed, count=count).astype(bool).reshape(shape)
    return bits if bits[0, 0, 0] else ~bits


def _description(file: TensorFile) -> tuple[str, ...]:
    if "description" not in file.fields:
        return ()
    text = file.read("description", "u1", 1)[:200].tobytes().decode("ascii", "replace")
    return ("".join(letter if letter.isprintable() else " " for letter in text).strip(),)


def _middle_row(table: Float32Array) -> Float32Array:
    """Return the row of a table over (phi, theta) at phi = 0, which is halfway."""
    half = (len(table) - 1) / 2
    return np.asarray(0.5 * (table[int(np.floor(half))] + table[int(np.ceil(half))]), np.float32)
