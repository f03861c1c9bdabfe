"""Materials: sums of lobes, each about its own center; they can be added, scaled and recentered.

Materials are values: equal where their lobes and names are, hashable, and picklable where the functions of
their lobes are. What is computed for one is kept and found for its equals, so a material must not change.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.lobe import Center, Frame, IsotropicLobe, Lobe, RadialLobe, ZonalLobe, refuse_anisotropic
from shrm.brdf.value import Value
from shrm.validation import number_or_rgb, one_of, require_instance, unit_vectors

_CENTER_TEXT = {"lobe": "lobe center", "reflection": "reflection", "normal": "normal", "tangent": "tangent"}


class BRDF(ABC):
    """A material: a sum of lobes, each with its own center.

    `a + b` is the material that reflects what both reflect; `0.5 * a` and `(1, 0.5, 0.2) * a`
    scale it, per channel where three numbers are given. Factors are in [0, 1e30].

    """

    # So that numpy's scalars and arrays leave `factor * material` to `__rmul__`.
    __array_ufunc__ = None

    @property
    @abstractmethod
    def lobes(self) -> tuple[Lobe, ...]:
        """The lobes whose sum the material is, in a fixed order."""

    @property
    @abstractmethod
    def name(self) -> str:
        """A short text such as "ggx(alpha=0.1)"; `parse` reads those of analytic materials."""

    @property
    def channels(self) -> Literal[1, 3]:
        """3 if any lobe has three channels, else 1."""
        return 3 if any(lobe.channels == 3 for lobe in self.lobes) else 1

    @property
    def frame(self) -> Frame:
        """The frame that all lobes share: "normal" or "tangent".

        Raises
        ------
        ValueError
            If some are about the tangent and some are not.
        """
        frames = {lobe.frame for lobe in self.lobes}
        if len(frames) > 1:
            raise ValueError(
                f"{self.name} has lobes about the tangent and lobes about the normal, "
                "which share no frame: evaluate its lobes one by one"
            )
        return frames.pop()

    def transfer(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> FloatArray:
        """Evaluate rho_hat, the sum over the lobes, the cosine included.

        Parameters
        ----------
        wi, wo : (n, 3) array_like
            Unit vectors to the light and to the eye in the frame x = tangent, z = normal (a
            material about the tangent: z = T).

        Returns
        -------
        (n,) or (n, 3) float64
            Per steradian.

        Raises
        ------
        TypeError, ValueError
            If `wi` or `wo` is not an array of n unit vectors, or the lobes share no frame.
        """
        directions_i, directions_o = unit_vectors("wi", wi), unit_vectors("wo", wo)
        if directions_i.shape != directions_o.shape:
            raise ValueError(
                f"wi and wo must have the same shape, got {directions_i.shape} and {directions_o.shape}"
            )
        self.frame  # noqa: B018  (refuses lobes that share no frame)
        return SumOfTransfers(self.lobes)(directions_i, directions_o)

    def recentered(self, center: Center, *, merge: bool = False) -> BRDF:
        """Return the same material with its lobes about another center.

        Lobes that are exactly symmetric (radial) about their own center keep it, unless they are merged.

        Parameters
        ----------
        center : {"lobe", "reflection", "normal"}
            The new center of the isotropic lobes. ("tangent" leaves a material about the tangent
            as it is.)
        merge : bool
            Put everything, a diffuse lobe included, into one isotropic lobe about `center`; with
            "reflection" that is how [RH02] treats materials with a diffuse part (footnote 6).

        Raises
        ------
        ValueError
            If no such material exists; the text says why.
        """
        one_of("center", center, get_args(Center))
        if _does_not_change(self):
            return _kept_recentered(self, center, bool(merge))
        return _recentered(self, center, bool(merge))

    def __add__(self, other: object) -> BRDF:
        if not isinstance(other, BRDF):
            return NotImplemented
        return Material(self.lobes + other.lobes, f"{self.name} + {other.name}")

    def __mul__(self, factor: object) -> BRDF:
        if isinstance(factor, BRDF):
            return NotImplemented
        weight = number_or_rgb(f"{self.name}: factor", factor, 0.0, parameters.LARGEST)
        terms = (f"{parameters.text(weight)}*{term}" for term in self.name.split(" + "))
        return Material(tuple(lobe.scaled(weight) for lobe in self.lobes), " + ".join(terms))

    def __rmul__(self, factor: object) -> BRDF:
        return self * factor

    def __repr__(self) -> str:
        lobes = ", ".join(
            f"{type(lobe).__name__} about the {_CENTER_TEXT[lobe.center]}" for lobe in self.lobes
        )
        return " ".join(f"<{type(self).__name__} {self.name}: {lobes}>".split())


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Material(BRDF, Value):
    """A material given by its lobes: what sums, products and `recentered` return.

    Parameters
    ----------
    lobes : sequence of Lobe
        At least one.
    name : str
        A short text.
    """

    _lobes: tuple[Lobe, ...]
    _name: str

    def __init__(self, lobes: Iterable[Lobe], name: str):
        parts = tuple(lobes)
        if not parts or not all(isinstance(lobe, Lobe) for lobe in parts):
            raise TypeError(f"Material: lobes must be one or more Lobe objects, got {parts!r}")
        object.__setattr__(self, "_lobes", parts)
        object.__setattr__(self, "_name", name)

    @property
    def lobes(self) -> tuple[Lobe, ...]:
        """The lobes it was made of."""
        return self._lobes

    @property
    def name(self) -> str:
        """The name it was given."""
        return self._name


def require_brdf(value: object, name: str = "brdf") -> None:
    """Refuse what is no material.

    Raises
    ------
    TypeError
        If it is none; the text names the argument.
    """
    require_instance(name, value, BRDF, what="a material of shrm.brdf")


@dataclass(frozen=True, eq=False, repr=False)
class SumOfTransfers(Value):
    """The sum of what lobes in one frame reflect, as a function of wi and wo."""

    lobes: tuple[Lobe, ...]

    def __call__(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate it: (n, 3) float64 each to (n,), or (n, 3) where a lobe has three channels."""
        parts = [lobe.transfer(wi, wo) for lobe in self.lobes]
        if any(part.ndim == 2 for part in parts):
            parts = [part if part.ndim == 2 else part[:, None] for part in parts]
        return np.asarray(sum(parts[1:], start=parts[0]))


# ---- Other centers


def _recentered(material: BRDF, center: Center, merge: bool) -> BRDF:
    """Return a material about another center; see `BRDF.recentered`."""
    frame = "tangent" if center == "tangent" else "normal"
    if any(lobe.frame != frame for lobe in material.lobes):
        raise ValueError(
            f"{material.name} cannot be centered on the {_CENTER_TEXT[center]}: a lobe about the tangent has "
            "no normal, and a lobe about the normal, the reflection or the lobe center depends on it"
        )
    if merge:
        return _merged(material, center)
    lobes = (
        replace(lobe, center=center) if isinstance(lobe, IsotropicLobe) else lobe for lobe in material.lobes
    )
    return Material(lobes, material.name)


# Returns the same material for equal ones, so that what is kept for its functions is found by identity too.
_kept_recentered = lru_cache(maxsize=64)(_recentered)


def _merged(material: BRDF, center: Center) -> BRDF:
    """Return a material whose lobes are one isotropic lobe about a center."""
    if center == "tangent":
        raise ValueError(f"{material.name} cannot be merged about the tangent: its lobes have no normal")
    for lobe in material.lobes:
        refuse_anisotropic(lobe)
    if any(_has_no_horizon(lobe) for lobe in material.lobes):
        raise ValueError(
            f"{material.name} cannot be merged: its lobe about the reflection has no horizon, "
            "and an isotropic lobe is zero below it"
        )
    return Material((IsotropicLobe(center, SumOfTransfers(material.lobes)),), material.name)


def _has_no_horizon(lobe: Lobe) -> bool:
    return isinstance(lobe, ZonalLobe) or (isinstance(lobe, RadialLobe) and lobe.center == "reflection")


def _does_not_change(material: BRDF) -> bool:
    """Tell whether a material is a frozen dataclass that can be hashed, as all of this package are."""
    parameters_of = getattr(type(material), "__dataclass_params__", None)
    if parameters_of is None or not parameters_of.frozen:
        return False
    try:
        hash(material)
    except TypeError:
        return False
    return True
