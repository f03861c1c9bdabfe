"""The generalised cosine lobes of Lafortune et al. [LFTG97].

    rho_hat = N.L ( diffuse / pi + sum_k max(0, Cx Lx Vx + Cy Ly Vy + Cz Lz Vz)^n )    where N.L > 0

with coefficients C and exponents n per lobe k and channel. The cosine is in it. L and V both point
away from the surface, so a lobe round the mirror direction has Cx = Cy < 0 < Cz (-1, -1, 1 is a cosine
lobe about R); Cz < 0 makes lobes that act at grazing angles only.

The diffuse part is a Lambert lobe about the normal; the rest is one lobe about the lobe center, or
about the reflection. `recentered("reflection", merge=True)` puts both into one lobe about R, as
[RH02 footnote 6] does.

Lobes with Cx != Cy depend on the azimuth of L and V itself, not only on its difference: they are
anisotropic, and no map about R, N or the lobe center can hold them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.cosine_power import SHARP
from shrm.brdf.half_vector import above_horizon
from shrm.brdf.lobe import IsotropicLobe, Lobe
from shrm.brdf.material import BRDF
from shrm.brdf.models import json_file
from shrm.brdf.models.lambert import Lambert
from shrm.brdf.value import Method, Value
from shrm.files import PathLike
from shrm.validation import RGB, number_or_rgb, real_array


@dataclass(frozen=True, eq=False, repr=False)
class Lafortune(BRDF, Value):
    """A sum of generalised cosine lobes and a diffuse term.

    Parameters
    ----------
    x, y, z : (K,) or (K, 3) array_like
        Cx, Cy, Cz of K lobes; with three columns, one per channel. x must equal y.
    exponent : (K,) or (K, 3) array_like
        n, in [0, 1e12]; max(|x|, |z|)^n at most 1e30.
    diffuse : float or three floats
        Albedo of the diffuse part, in [0, 1].
    label : str
        What the name shows, such as "skin".

    Raises
    ------
    ValueError
        If x and y differ (anisotropic), or an argument is out of its range or shape.
    """

    x: npt.ArrayLike
    y: npt.ArrayLike
    z: npt.ArrayLike
    exponent: npt.ArrayLike
    diffuse: float | RGB = 0.0
    label: str = ""

    def __post_init__(self) -> None:
        # One shape for all coefficients
        arrays = {
            key: real_array(f"Lafortune: {key}", getattr(self, key)).copy()
            for key in ("x", "y", "z", "exponent")
        }
        shapes = {value.shape for value in arrays.values()}
        shape = shapes.pop()
        if shapes or len(shape) not in (1, 2) or shape[0] == 0 or shape[1:] not in ((), (3,)):
            got = ", ".join(f"{key} {value.shape}" for key, value in arrays.items())
            raise ValueError(
                f"Lafortune: x, y, z, exponent must share the shape (K,) or (K, 3), K > 0, got {got}"
            )

        # An isotropic lobe whose powers stay in range
        if not np.array_equal(arrays["x"], arrays["y"]):
            raise ValueError(
                "Lafortune: x and y differ, so the BRDF depends on the absolute azimuth about the normal "
                "(it is anisotropic) and cannot be centered on R, N or the lobe: x must equal y"
            )
        low, high = arrays["exponent"].min(), arrays["exponent"].max()
        if low < 0.0 or high > parameters.SHARPEST:
            raise ValueError(
                f"Lafortune: exponent must be in [0, {parameters.SHARPEST:g}], got {low:g} to {high:g}"
            )
        largest = np.maximum(np.abs(arrays["x"]), np.abs(arrays["z"]))  # bounds the dot product
        if np.any(arrays["exponent"] * np.log(np.maximum(largest, 1.0)) > np.log(parameters.LARGEST)):
            raise ValueError(
                f"Lafortune: exponent must keep max(|x|, |z|)^exponent below {parameters.LARGEST:g}, "
                "got a larger value"
            )

        # Kept read-only: materials are hashed by their contents
        for key, value in arrays.items():
            value.setflags(write=False)
            object.__setattr__(self, key, value)
        diffuse = number_or_rgb("Lafortune: diffuse", self.diffuse, 0.0, 1.0)
        object.__setattr__(self, "diffuse", diffuse)

    @classmethod
    def read(cls, path: PathLike, name: str) -> Lafortune:
        """Read one material of a JSON file of coefficients.

        The file is an object of materials; each has `diffuse` and, for k = 0, 1, ..., `xyk` (or `xk`
        and `yk`), `zk`, `ek`, each three numbers R, G, B.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError
            If it is no such file, or has no material of that name; the text names those it has.
        """
        return json_file.material(
            path,
            name,
            "Lafortune coefficients",
            lambda values: cls.from_coefficients(values, f"{path}#{name}"),
        )

    @classmethod
    def from_coefficients(cls, coefficients: Mapping[str, Any], label: str) -> Lafortune:
        """Make a material of `diffuse` and, for k = 0, 1, ..., `xyk` (or `xk` and `yk`), `zk` and `ek`.

        Raises
        ------
        ValueError
            If one is missing, or is not what the material takes.
        """
        return cls(**_arguments(coefficients), label=label)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The glossy lobe about the lobe center, and the diffuse one about the normal where there is any."""
        glossy = IsotropicLobe("lobe", Method(Lafortune._transfer, self))
        return (glossy, *Lambert(self.diffuse).lobes) if np.any(self.diffuse) else (glossy,)

    @property
    def name(self) -> str:
        """A description such as "lafortune(skin)", which `parse` does not read: it needs the file."""
        return f"lafortune({self.label or f'{len(np.asarray(self.x))} lobes'})"

    def _transfer(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        xy, z, exponent = (np.asarray(value) for value in (self.x, self.z, self.exponent))
        column = (slice(None),) + (None,) * (xy.ndim - 1)  # (n,) against the (3,) channels of a lobe
        along = (wi[:, 0] * wo[:, 0] + wi[:, 1] * wo[:, 1])[column]
        up = (wi[:, 2] * wo[:, 2])[column]
        apart2 = (wi[:, 0] + wo[:, 0]) ** 2 + (wi[:, 1] + wo[:, 1]) ** 2 + (wi[:, 2] - wo[:, 2]) ** 2
        cosine = np.where(above_horizon(wi, wo), wi[:, 2], 0.0)[column]
        total = np.zeros(along.shape[:1] + xy.shape[1:])
        for k in range(len(xy)):
            dot = xy[k] * along + z[k] * up
            if np.all(exponent[k] < SHARP):
                power = np.maximum(dot, 0.0) ** exponent[k]
            else:
                # dot - 1 with R.L = up - along = 1 - |L - R|^2 / 2: as exact as the lobe is narrow about R
                excess = (z[k] - 1.0) - 0.5 * z[k] * apart2[column] + (xy[k] + z[k]) * along
                power = np.exp(exponent[k] * np.log1p(np.maximum(excess, -1.0 + 1e-16)))
            total += np.where(dot > 0.0, power, 0.0)
        return total * cosine


def _arguments(coefficients: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `Lafortune` for the coefficients of a file."""
    columns: dict[str, list[object]] = {"x": [], "y": [], "z": [], "exponent": []}
    while (k := len(columns["z"])) == 0 or f"z{k}" in coefficients:
        for argument, keys in (("x", ("xy", "x")), ("y", ("xy", "y")), ("z", ("z",)), ("exponent", ("e",))):
            present = [f"{key}{k}" for key in keys if f"{key}{k}" in coefficients]
            if not present:
                raise ValueError(f"{' or '.join(f'{key}{k}' for key in keys)} is missing")
            columns[argument].append(coefficients[present[0]])
    return {**columns, "diffuse": coefficients.get("diffuse", 0.0)}
