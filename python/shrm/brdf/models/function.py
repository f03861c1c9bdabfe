"""Materials from any Python function, tested for the symmetries that its center needs.

    rho_hat = f(wi, wo) max(N.L, 0)    about the normal, the reflection or the lobe center
    rho_hat = f(wi, wo)                about the tangent (vectors with z = T, no cosine)

A map about R, N or the lobe center holds functions of theta_i, theta_o and |phi_i - phi_o| about N
[RH02 sec. 3.1]; one about T, functions of the two angles from T. `from_function` tests f for that
at seeded pairs of directions, spread over the hemisphere and gathered round the mirror direction.
Asymmetries below 0.1% of the value pass unseen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import get_args

import numpy as np

from shrm.arrays import FloatArray
from shrm.brdf import parameters
from shrm.brdf.half_vector import above_horizon
from shrm.brdf.lobe import Center, IsotropicLobe, ZonalLobe
from shrm.brdf.material import BRDF, Material
from shrm.brdf.value import Value
from shrm.validation import one_of
from shrm.vectors import unit

Function = Callable[[FloatArray, FloatArray], FloatArray]


def from_function(f: Function, center: Center = "lobe", name: str | None = None) -> BRDF:
    """Make a material of a function.

    Parameters
    ----------
    f : callable
        f(wi, wo) with wi, wo (n, 3) float64 unit vectors to the light and to the eye, in the frame
        x = tangent, z = normal. Returns the BRDF per steradian WITHOUT the cosine, (n,) or (n, 3).
        It is asked only for N.L > 0, N.V >= 0. With `center="tangent"` the vectors have z = T and
        cover the sphere, and there is no cosine.
    center : {"lobe", "reflection", "normal", "tangent"}
        The central direction.
    name : str, optional
        A short text; the function's own name if not given.

    Raises
    ------
    TypeError
        If f is not callable or does not return real numbers.
    ValueError
        If it returns another shape or values that are not finite (also later, when it is
        evaluated), or if it lacks the symmetry that the center needs.
    """
    if not callable(f):
        raise TypeError(f"f must be a function of wi and wo, got {f!r}")
    one_of("center", center, get_args(Center))
    title = name if name is not None else getattr(f, "__name__", "function")
    channels = _channels(f, title)
    rng = np.random.default_rng(20020721)
    if center == "tangent":
        samples = _require_angles_from_tangent(f, title, rng)
        return Material((ZonalLobe("tangent", FunctionOfAngles(f, title, samples)),), title)
    samples = _require_isotropy(f, title, rng)
    return Material((IsotropicLobe(center, FunctionTimesCosine(f, title, samples, channels)),), title)


@dataclass(frozen=True, eq=False, repr=False)
class FunctionOfAngles(Value):
    """A function of directions as a profile of their angles from the tangent.

    Attributes
    ----------
    f : callable
        As `from_function` takes it.
    title : str
        What errors call it.
    samples : (512,) or (512, 3) float64
        Its values when it was tested. A function that has changed since, through a variable that it reads,
        makes another material, for which nothing is kept yet.
    """

    f: Function
    title: str
    samples: FloatArray

    def __call__(self, theta_i: FloatArray, theta_o: FloatArray) -> FloatArray:
        """Evaluate rho_hat, (n,) or (n, 3), at angles (n,) from the tangent, radians."""
        return _checked(self.f, self.title, *_meridian(theta_i, theta_o))


@dataclass(frozen=True, eq=False, repr=False)
class FunctionTimesCosine(Value):
    """A function of directions times N.L above the horizon, 0 below.

    Attributes
    ----------
    f, title, samples
        As `FunctionOfAngles` has them.
    channels : {1, 3}
        What f returns: (n,) or (n, 3).
    """

    f: Function
    title: str
    samples: FloatArray
    channels: int

    def __call__(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Evaluate rho_hat, (n,) or (n, 3), at unit vectors (n, 3)."""
        above = above_horizon(wi, wo)
        if above.all():  # as at the nodes of an analysis: no copies
            values = _checked(self.f, self.title, wi, wo)
            return np.asarray(values * self._cosine(wi))
        result = np.zeros(len(wi) if self.channels == 1 else (len(wi), self.channels))
        if above.any():
            values = _checked(self.f, self.title, wi[above], wo[above])
            result[above] = values * self._cosine(wi[above])
        return result

    def _cosine(self, wi: FloatArray) -> FloatArray:
        return wi[:, 2] if self.channels == 1 else wi[:, 2:]


def _checked(f: Function, title: str, wi: FloatArray, wo: FloatArray) -> FloatArray:
    """Return f(wi, wo) as float64; refuse another shape and values that are not finite."""
    # Type and shape
    values = np.asarray(f(wi, wo))
    if values.dtype.kind not in "fiu":
        raise TypeError(f"{title}: must return real numbers, got dtype {values.dtype}")
    if values.shape not in ((len(wi),), (len(wi), 3)):
        raise ValueError(
            f"{title}: must return the shape ({len(wi)},) or ({len(wi)}, 3) for {len(wi)} directions, "
            f"got {values.shape}"
        )

    # Range
    finite = np.isfinite(values.reshape(len(wi), -1)).all(axis=1)
    if not finite.all():
        first = int(np.argmin(finite))
        raise ValueError(
            f"{title}: must be finite, got {np.sum(~finite)} of {len(wi)} values that are not, "
            f"the first at wi = {_triple(wi[first])}, wo = {_triple(wo[first])}"
        )
    values = values.astype(np.float64, copy=False)
    if np.abs(values).max(initial=0.0) > parameters.LARGEST:
        raise ValueError(
            f"{title}: must be at most {parameters.LARGEST:g} per steradian, got {np.abs(values).max():g}"
        )
    return values


def _channels(f: Function, title: str) -> int:
    """Return 1 or 3, the channels that f returns."""
    # Two directions, so that (n,) with n = 3 and (n, 3) cannot be taken for one another.
    above = np.array([[0.0, 0.6, 0.8], [0.6, 0.0, 0.8]])
    return 1 if _checked(f, title, above, above[::-1].copy()).ndim == 1 else 3


def _require_isotropy(f: Function, title: str, rng: np.random.Generator) -> FloatArray:
    """Return values of f at seeded pairs of directions; refuse one that is anisotropic or not symmetric."""
    wi, wo = _pairs_about_mirror(rng)
    values = _checked(f, title, wi, wo)

    # Isotropic: unchanged when both turn about the normal
    turns = rng.uniform(0.0, 2.0 * np.pi, len(wi))
    turned = _checked(f, title, _turned(wi, turns), _turned(wo, turns))
    if (first := _first_difference(values, turned)) is not None:
        raise ValueError(
            f"{title}: depends on the absolute azimuth about the normal (it is anisotropic) and cannot be "
            f"centered on R, N or the lobe: turning both wi = {_triple(wi[first])} and "
            f"wo = {_triple(wo[first])} by {turns[first]:.3f} about the normal changes it"
        )

    # Without handedness: unchanged when both are mirrored
    mirror = np.array([1.0, -1.0, 1.0])
    mirrored = _checked(f, title, wi * mirror, wo * mirror)
    if (first := _first_difference(values, mirrored)) is not None:
        raise ValueError(
            f"{title}: depends on the sign of phi_i - phi_o and cannot be centered on R, N or the lobe: "
            f"mirroring both wi = {_triple(wi[first])} and wo = {_triple(wo[first])} changes it"
        )
    return values.copy()


def _require_angles_from_tangent(f: Function, title: str, rng: np.random.Generator) -> FloatArray:
    """Return values of f at seeded pairs of angles; refuse one that depends on azimuths about the tangent."""
    # Half of the pairs round the mirror cone, a quarter round that of theta_i = theta_o, a quarter anywhere
    theta_i, theta_o = rng.uniform(0.0, np.pi, (2, 512))
    theta_i[:256] = np.abs(np.pi - theta_o[:256] + rng.normal(0.0, 0.1, 256))
    theta_i[256:384] = np.abs(theta_o[256:384] + rng.normal(0.0, 0.1, 128))
    wi, wo = _meridian(theta_i, theta_o)

    # Unchanged when each turns about the tangent by an angle of its own
    values = _checked(f, title, wi, wo)
    turned = _checked(f, title, *(_turned(w, rng.uniform(0.0, 2.0 * np.pi, len(w))) for w in (wi, wo)))
    if (first := _first_difference(values, turned)) is not None:
        raise ValueError(
            f"{title}: depends on azimuth about the tangent and cannot be centered on it: it must be a "
            "function of the angles theta_i, theta_o from T alone, and changes with the azimuths at "
            f"theta_i = {theta_i[first]:.3f}, theta_o = {theta_o[first]:.3f}"
        )
    return values.copy()


def _pairs_about_mirror(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return 512 pairs above the horizon: wi round the reflection of wo, from very near to anywhere."""
    spread = np.repeat([0.01, 0.05, 0.2, 2.0], 128)[:, None]
    wo = unit(rng.normal(size=(512, 3)))
    wo[:, 2] = np.abs(wo[:, 2])
    wi = unit(wo * [-1.0, -1.0, 1.0] + spread * rng.normal(size=(512, 3)))
    wi[:, 2] = np.abs(wi[:, 2])
    return wi, wo


def _first_difference(a: FloatArray, b: FloatArray) -> int | None:
    """Return where evaluations that should be equal differ first, by more than float32 functions do."""
    a, b = (values.reshape(len(values), -1) for values in (a, b))
    scale = np.maximum(np.abs(a), np.abs(b))
    different = (np.abs(a - b) > 1e-3 * scale + 1e-7 * scale.max(initial=0.0)).any(axis=1)
    return int(np.argmax(different)) if different.any() else None


def _meridian(theta_i: FloatArray, theta_o: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors at these angles from z, in the half plane y = 0, x > 0."""
    wi, wo = (np.stack([np.sin(t), np.zeros_like(t), np.cos(t)], axis=1) for t in (theta_i, theta_o))
    return wi, wo


def _turned(w: FloatArray, angle: FloatArray) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], axis=1)


def _triple(w: FloatArray) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in w) + ")"
