"""What orders leave out of a lobe under a light, in the measure of a criterion (`shrm.orders`).

A lobe is analysed to a degree L and an azimuth Q. Energy that it has beyond them is known in sum only, by
Parseval's theorem; how it lies over degrees and azimuths is taken from how those that are analysed fall off.
From some degree on the energy of a coefficient falls as a power of l or faster in lobes without bands,

    E_l / (2l + 1) = e (l / (L+1))^-p,    l > L,

with e and p from the last two quarters of the degrees analysed, and reflects sum_m |L_lm|^2 e (l / (L+1))^-p
of the light's own energy in each degree. The same of azimuths q > Q, in the degrees where the last quarter of
the azimuths lies. Energy that neither law explains lies in bands that the analysis does not reach: it is
taken to meet the light where that is strongest [RH02 appendix B].
"""

from __future__ import annotations

import numpy as np

from shrm.arrays import FloatArray
from shrm.frequency.analysis import LobeAnalysis
from shrm.frequency.light_power import LightPower

_EXPLAINED = 3.0
"""Energy beyond what is analysed, relative to what the laws explain, above which a lobe has bands: they are
extrapolations."""

_ROUNDING = 1e-6
"""Fraction of a lobe's energy that its nodes do not tell."""

_LEAST = 8
"""Degrees or azimuths that must be analysed for their fall to be told; with fewer the law is constant."""


class Measure:
    """Squared errors of one lobe under one light, in one criterion's measure."""

    def __init__(self, lobe: LobeAnalysis, power: LightPower, criterion: str) -> None:
        # The lobe's energy by degree; that of degrees and azimuths that are not analysed, by Parseval
        self.lobe = lobe
        self.criterion = criterion
        L = min(lobe.L, len(power.degrees) - 1)
        self.degree_energy = lobe.degree_energy()[: L + 1]
        self.unresolved = np.maximum(lobe.energy - self.degree_energy.sum(axis=0), 0.0)

        # The light's weights: Lambda_l^2 |L_l|^2 / 4 pi; the brdf criterion weighs all degrees alike.
        self.power = power
        if criterion == "brdf":
            self.light = np.ones((L + 1, 1))
            self.beyond = float(self.unresolved.sum())
        else:
            self.light = power.per_coefficient[: L + 1]
            self.beyond = self._reflected_beyond()
        self.total = float((self.light * self.degree_energy).sum()) + self.beyond

    def squared_error(self, F: int, P: int, window: FloatArray | None = None) -> float:
        """Return what orders (F, P) leave of `total`: a squared radiance, or an energy."""
        if self.criterion == "minimum":
            return min(self._light_left_out(F) * self.total, self._brdf_left_out(F, P) * self.total)
        if self.criterion == "bound":
            return self._bound(F, P)
        captured = self.lobe.captured(P)[: F + 1]
        if window is not None:  # a degree with weight w errs by (1 - w)^2
            captured = captured * (1 - (1 - window[: F + 1, None]) ** 2)
        left_out = max(self.total - float((self.light[: F + 1] * captured).sum()), 0.0)
        return left_out + self.lobe.quadrature_error * self.total

    def _light_left_out(self, F: int) -> float:
        """Return eps_L, the fraction of the light's energy above degree F [RH02 section 5.1]."""
        above = self.power.degrees[F + 1 :].sum() + self.power.above.sum()
        return float(above / max(self.power.degrees.sum() + self.power.above.sum(), 1e-300))

    def _brdf_left_out(self, F: int, P: int) -> float:
        """Return eps_rho, the fraction of the BRDF's energy outside (F, P) [RH02 section 5.1]."""
        captured = self.lobe.captured(P)[: F + 1].sum()
        return max(1 - float(captured / max(self.lobe.energy.sum(), 1e-300)), 0.0)

    def _bound(self, F: int, P: int) -> float:
        """Return the bound of [RH02] appendix B, corrected; Lambda_l^2 = 4 pi / (2l+1), 4 pi left out."""
        captured = self.lobe.captured(P)
        light_above = self.power.degrees[F + 1 :].sum(axis=0) + self.power.above
        brdf_above = self.degree_energy[F + 1 :].sum(axis=0) + self.unresolved
        in_degrees = np.maximum(self.degree_energy[: F + 1] - captured[: F + 1], 0.0)
        residual = float(
            (light_above * brdf_above).sum() / (2 * F + 3) + (self.light[: F + 1] * in_degrees).sum()
        )
        reflected = float((self.light[: F + 1] * captured[: F + 1]).sum())
        return self.total * residual / max(reflected + residual, 1e-300)

    def _reflected_beyond(self) -> float:
        """Return the squared radiance that the lobe reflects beyond the degrees and azimuths analysed."""
        lobe, power, unresolved = self.lobe, self.power, self.unresolved
        L, K = len(self.degree_energy) - 1, len(power.degrees) - 1
        of_coefficient = self.degree_energy / (2 * np.arange(L + 1)[:, None] + 1)

        # Degrees: the light is told apart to K; above, all of it meets the law at its highest.
        height, fall = power_law(of_coefficient)
        l = np.arange(L + 1, K + 1)[:, None]
        in_degrees = (power.degrees[L + 1 :] * height * (l / (L + 1)) ** -fall).sum(axis=0)
        in_degrees = in_degrees + power.above * height * ((K + 1) / (L + 1)) ** -fall
        explained = 2.0 * (L + 1) ** 2 * height / np.maximum(fall - 2.0, 1e-6)  # the integral of (2l + 1) E_l

        explained_q, met = self._azimuths_beyond()
        in_azimuths = met * np.minimum(explained_q, unresolved)

        # The rest: a band's degree is at least its azimuth.
        beyond = np.maximum(unresolved - _ROUNDING * lobe.energy, 0.0)
        scale = np.clip(beyond / np.maximum(explained + explained_q, 1e-300), 1.0, _EXPLAINED)
        in_bands = np.maximum(beyond - scale * (explained + explained_q), 0.0)
        strongest = power.per_coefficient[min(L, lobe.Q) + 1 :].max(axis=0, initial=0.0)
        strongest = np.maximum(strongest, power.above / (2 * K + 3))
        by_law = scale * (in_degrees + in_azimuths)
        return float(np.minimum(by_law + in_bands * strongest, unresolved * strongest).sum())

    def _azimuths_beyond(self) -> tuple[FloatArray, FloatArray]:
        """Return the energy that the azimuths' law has beyond Q, and the light's energy that it meets."""
        lobe, L = self.lobe, len(self.degree_energy) - 1
        if lobe.kind != "isotropic":
            return np.zeros(lobe.channels), np.zeros(lobe.channels)
        energy = 2 * np.einsum("cqlv,v->qlc", lobe.g[:, :, : L + 1] ** 2, lobe.weight)
        height, fall = power_law(energy.sum(axis=1))
        beyond = (lobe.Q + 1) * height / np.maximum(fall - 1.0, 1e-6)  # the integral of the law

        # Energy of the last quarter of the azimuths, each degree of it met by the light's
        last = energy[3 * (lobe.Q + 1) // 4 :].sum(axis=0)
        return beyond, (self.light * last).sum(axis=0) / np.maximum(last.sum(axis=0), 1e-300)


def power_law(energy: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Extrapolate a sequence by the power by which it falls over its last two quarters.

    Parameters
    ----------
    energy : (n, channels) float64
        Not negative.

    Returns
    -------
    height, fall : (channels,) float64
        The value at index n, and the power, at least 0; constant if there are few values or none.
    """
    n = len(energy)
    if n < _LEAST:
        return energy[-1], np.zeros(energy.shape[1])

    # Means over the quarters, as lobes with edges have ripples
    middle, end = n // 2, 3 * n // 4
    before, last = energy[middle:end].mean(axis=0), energy[end:].mean(axis=0)
    at_before, at_last = 0.5 * (middle + end - 1), 0.5 * (end + n - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        fall = np.log(before / last) / np.log(at_last / at_before)
    fall = np.clip(np.where(last > 0, fall, 0.0), 0.0, 100.0)
    return last * (n / at_last) ** -fall, fall
