"""The error of a reflection map, predicted from the spectra of light, material and maps.

Three errors, relative to the RMS of all that is reflected, add up by root mean square: that of the orders, of
look-ups between texels, and of the integrated cores.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from shrm.environment import Environment
from shrm.frequency.expansion import Expansion
from shrm.frequency.interpolation import interpolation_error, map_spectrum, measured_interpolation_error
from shrm.frequency.orders import error_of, light_power
from shrm.frequency.part import Part
from shrm.frequency.split_orders import split_energy

_LEAST_SMOOTH_SHARE = 1e-3
"""Floor of the share of what is reflected that the smooth parts have: they are divided by it, and with less
of it texels may be as coarse as they like."""


class _Numbers(NamedTuple):
    """The numbers of a `Truncation`, computed together."""

    error: float
    smooth_share: float
    energy: float


class Truncation:
    """The error that the orders of an expansion leave under a light.

    It is measured when it is first asked for; light and material are held until then, and no longer.
    """

    def __init__(self, env: Environment, expansion: Expansion) -> None:
        self.criterion = expansion.criterion
        self._measured_from: tuple[Environment, Expansion] | None = env, expansion

    @property
    def error(self) -> float:
        """The error that the orders leave, in the measure of the criterion."""
        return self._numbers.error

    @property
    def smooth_share(self) -> float:
        """The RMS of what is expanded relative to the whole: 1 but where cores were split off."""
        return self._numbers.smooth_share

    @property
    def energy(self) -> float:
        """Mean square of the radiance that the whole material reflects; nan if no residual was asked for."""
        return self._numbers.energy

    @cached_property
    def _numbers(self) -> _Numbers:
        assert self._measured_from is not None
        env, expansion = self._measured_from
        self._measured_from = None
        if expansion.cores is None:
            L = max(expansion.F_max, expansion.F)
            windows = expansion.windows()
            orders = error_of(
                expansion.material, expansion.orders, light_power(env, L), self.criterion, windows, L=L
            )
            return _Numbers(orders.error, 1.0, np.nan)
        energy = split_energy(
            env, expansion.smooth, expansion.material, expansion.orders, expansion.analysed_to
        )
        return _Numbers(energy.truncation, max(energy.smooth_share, _LEAST_SMOOTH_SHARE), energy.total)


class Prediction:
    """The error of maps and what it is made of, each computed when it is first asked for.

    Parameters
    ----------
    truncation : Truncation
        The error that the orders leave.
    parts : sequence of Part
        The maps.
    cores : float
        The relative RMS error of the cores that are integrated.
    look_up : bool
        True if the maps are also looked up at a sample of frames, which tells more where the fit over the
        views is ill-conditioned, and takes longer than their spectra.
    """

    def __init__(
        self, truncation: Truncation, parts: Sequence[Part], cores: float = 0.0, look_up: bool = True
    ) -> None:
        self._truncation = truncation
        self._parts = tuple(parts)
        self._look_up = look_up
        self.cores = cores

    @property
    def truncation(self) -> float:
        """The error that the orders leave, in the measure of the criterion."""
        return self._truncation.error

    @cached_property
    def interpolation(self) -> float:
        """The error of look-ups between texels; criteria other than `light` do not count it."""
        if self._truncation.criterion != "light":
            return 0.0
        first = self._parts[0]
        error = interpolation_error([map_spectrum(part) for part in self._parts], first.size, first.layout)
        if self._look_up:
            error = max(error, measured_interpolation_error(self._parts))
        return self._truncation.smooth_share * error

    @property
    def error(self) -> float:
        """The predicted error: the root sum of squares of the three."""
        return float(np.sqrt(self.truncation**2 + self.interpolation**2 + self.cores**2))

    def __repr__(self) -> str:
        return f"<Prediction of the error of {len(self._parts)} parts>"
