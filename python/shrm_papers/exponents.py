"""Power laws fitted to times over a range of sizes: how a cost grows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from shrm.arrays import FloatArray


@dataclass(frozen=True)
class PowerLaw:
    """A least-squares fit of seconds = factor * size^exponent in log-log.

    Attributes
    ----------
    exponent, factor : float
        The fitted parameters.
    deviation : float
        Standard error of the exponent, from the residuals; 0 for two sizes or a given exponent.
    """

    exponent: float
    factor: float
    deviation: float

    def at(self, sizes: npt.ArrayLike) -> FloatArray:
        """Return the seconds that the law gives for sizes."""
        return np.asarray(self.factor * np.asarray(sizes, dtype=np.float64) ** self.exponent)

    def crossing(self, other: PowerLaw) -> float:
        """Return the size at which two laws of different exponents are equal."""
        return float((other.factor / self.factor) ** (1 / (self.exponent - other.exponent)))


def fit(sizes: npt.ArrayLike, seconds: npt.ArrayLike, exponent: float | None = None) -> PowerLaw:
    """Fit a power law.

    Parameters
    ----------
    sizes, seconds : (n,) array_like
        At least two different sizes and their times, all positive.
    exponent : float, optional
        A theory's exponent, if only the factor is to be fitted.

    Raises
    ------
    ValueError
        If sizes and times are not as described.
    """
    x, y = (np.asarray(values, dtype=np.float64) for values in (sizes, seconds))
    if x.ndim != 1 or x.shape != y.shape or len(np.unique(x)) < 2:
        raise ValueError(f"a power law needs a time for each of two sizes or more, got {x.shape}, {y.shape}")
    if not (np.all(x > 0) and np.all(y > 0)):
        raise ValueError("a power law needs sizes and times above zero")

    # Least squares in log-log, of the factor alone or of both
    log_x, log_y = np.log(x), np.log(y)
    centered = log_x - log_x.mean()
    if exponent is not None:
        return PowerLaw(exponent, float(np.exp(np.mean(log_y - exponent * log_x))), 0.0)
    exponent = float(centered @ log_y / (centered @ centered))
    residuals = log_y - log_y.mean() - exponent * centered
    variance = residuals @ residuals / (len(x) - 2) if len(x) > 2 else 0.0
    return PowerLaw(
        exponent,
        float(np.exp(log_y.mean() - exponent * log_x.mean())),
        float(np.sqrt(variance / (centered @ centered))),
    )
