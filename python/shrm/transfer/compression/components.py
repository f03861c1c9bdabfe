"""Principal components of transfer matrices, what they leave, and their half floats [LK03 section 6]."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shrm.arrays import FloatArray, Int32Array, RealArray
from shrm.transfer.described import Described
from shrm.transfer.directional_basis import gram_of_one_dimension
from shrm.validation import whole_number

_HALF_EXPONENT = 14
"""Exponent below which half weights are brought: far from overflow, all digits down to 2^-14."""

_VERTICES = 4096
"""Vertices whose factors are multiplied together: arrays in double precision stay small."""


@dataclass(frozen=True, eq=False, repr=False)
class PrincipalComponents(Described):
    """Components of matrices, A_p ~ sum_k w_pk A_k [LK03 eq. 12]; or of each cluster of vertices [SHHS03].

    Attributes
    ----------
    weights : (V, K) float32 or float16
    components : (K, M^2, C, n^2) or, clustered, (Q, K, M^2, C, n^2) float32 or float16
        The largest first.
    clusters : (V,) int32 or None
        Clusters of the vertices, in [0, Q).
    left : (K + 1,) float64
        The energy of radiance, see `shrm.transfer.compression`, that 0 to K components leave; `left[0]` is
        that of the uncompressed matrices.
    rounding : (K + 1,) float64
        The energy of what rounding to half floats changes with 0 to K components.
    """

    weights: RealArray
    components: RealArray
    clusters: Int32Array | None
    left: FloatArray
    rounding: FloatArray

    @staticmethod
    def of(weights: RealArray, components: RealArray, left: FloatArray) -> PrincipalComponents:
        """Return global components in float32, with signs that do not depend on the machine."""
        # The largest coefficient of each is made positive
        flat = components.reshape(len(components), -1)
        largest = np.take_along_axis(flat, np.abs(flat).argmax(axis=1)[:, None], axis=1)[:, 0]
        signs = np.where(largest < 0, -1, 1)
        return PrincipalComponents(
            np.asarray(weights * signs, np.float32),
            np.asarray(components * signs[:, None, None, None], np.float32),
            None,
            left,
            np.zeros_like(left),
        )

    @property
    def K(self) -> int:
        """Number of components of a vertex."""
        return int(self.weights.shape[1])

    @property
    def snr(self) -> FloatArray:
        """Relative SNR of radiance in dB with 1 to K components, rounding counted; infinite where exact."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self.left[0] / (self.left + self.rounding)[1:]
        return 10 * np.log10(np.where(np.isnan(ratio), np.inf, ratio))  # 0 of 0: nothing to lose

    def truncated(self, K: int) -> PrincipalComponents:
        """Return the K largest components alone."""
        K = whole_number("K", K, 1, self.K)
        return replace(
            self,
            weights=self.weights[:, :K],
            components=self.components[..., :K, :, :, :],
            left=self.left[: K + 1],
            rounding=self.rounding[: K + 1],
        )

    def halved(self, *, components: bool = False) -> PrincipalComponents:
        """Return the weights, and the components if asked for, as half floats, and what rounding costs.

        Powers of two go from components to weights so that weights keep their digits; where both are
        rounded, so that the largest of both are alike.

        Parameters
        ----------
        components : bool
            Whether components are rounded as well.

        Raises
        ------
        ValueError
            If they are half floats already, or half floats cannot hold both.
        """
        if self.weights.dtype == np.float16:
            raise ValueError("weights must be float32 before they are halved, got float16")

        # The powers of two, of each cluster and component
        forms = self.components.reshape(-1, self.K, *self.components.shape[-3:])  # (Q, K, M^2, C, n^2)
        index = np.zeros(len(self.weights), np.int32) if self.clusters is None else self.clusters
        largest = np.zeros(forms.shape[:2])
        np.maximum.at(largest, index, np.abs(self.weights).astype(np.float64))
        shift = -np.frexp(largest)[1] + _HALF_EXPONENT
        if components:
            highest = np.abs(forms).max(axis=(2, 3, 4))
            shift = (np.frexp(highest)[1] - np.frexp(largest)[1]) // 2
        shift = np.where(largest > 0, shift, 0)

        # Rounded, if that is possible
        weights = np.ldexp(self.weights, shift[index])
        scaled = np.ldexp(forms, -shift[:, :, None, None, None])
        with np.errstate(over="ignore"):
            half_weights = weights.astype(np.float16)
            rounded = scaled.astype(np.float16 if components else np.float32)
        if not (np.isfinite(half_weights).all() and np.isfinite(rounded).all()):
            raise ValueError("weights and components must be within the range of half floats, got others")
        return replace(
            self,
            weights=half_weights,
            components=rounded.reshape(self.components.shape),
            rounding=_rounding(weights, half_weights, scaled, rounded, index),
        )

    def report(self) -> dict[str, Any]:
        """Return what a file says of the compression, in numbers that JSON knows; None for infinite."""
        snr = [round(float(x), 3) if np.isfinite(x) else None for x in self.snr]
        halves = [name for name in ("weights", "components") if getattr(self, name).dtype == np.float16]
        result: dict[str, Any] = {"K": self.K, "SNR": snr[-1], "SNR of 1 to K": snr, "half floats": halves}
        if halves:
            with np.errstate(divide="ignore", invalid="ignore"):  # of matrices that are all zero
                alone = 10 * float(np.log10(self.left[0]) - np.log10(self.rounding[-1]))
            result["SNR of rounding"] = round(alone, 3) if np.isfinite(alone) else None
        if self.clusters is not None:
            result["clusters"] = len(self.components)
        return result


def components_for(accuracy: float | None, left: FloatArray, most: int) -> int:
    """Return the smallest K, 1 to `most`, that leaves little enough for an SNR in dB; `most` without one.

    Warns where `most` components do not reach it.
    """
    if accuracy is None:
        return most
    enough = np.flatnonzero(left[1 : most + 1] <= left[0] * 10 ** (-accuracy / 10))
    if not len(enough):
        reached = 10 * np.log10(left[0] / left[most])
        warnings.warn(f"{most} components reach {reached:.1f} dB of the {accuracy:g} asked for", stacklevel=3)
        return most
    return int(enough[0]) + 1


def _rounding(
    weights: RealArray, half_weights: RealArray, forms: RealArray, rounded: RealArray, index: Int32Array
) -> FloatArray:
    """Return energies (K + 1,) of w A - w~ A~ = (w - w~) A + w~ (A - A~), summed over 0 to K components."""
    Q, K, tents = forms.shape[:3]
    G1 = gram_of_one_dimension(round(np.sqrt(tents)))
    M, total = len(G1), np.zeros((K, K))
    for q in range(Q):
        members = np.flatnonzero(index == q)
        of_factors = np.zeros((2 * K, 2 * K))
        # Products of the factors w - w~ and w~, summed over the vertices
        for block in np.split(members, np.arange(_VERTICES, len(members), _VERTICES)):
            w, w2 = (array[block].astype(np.float64) for array in (weights, half_weights))
            factors = np.concatenate([w - w2, w2], axis=1)
            of_factors += factors.T @ factors

        # Times the inner products of A and A - A~ in radiance, 2 pi G1 (x) G1
        A, A2 = (array[q].astype(np.float64) for array in (forms, rounded))
        parts = np.concatenate([A, A - A2]).reshape(2 * K, M, M, -1)
        weighed = 2 * np.pi * np.einsum("ij,kl,ajlx->aikx", G1, G1, parts, optimize=True)
        products = of_factors * (parts.reshape(2 * K, -1) @ weighed.reshape(2 * K, -1).T)
        total += products.reshape(2, K, 2, K).sum(axis=(0, 2))

    # Sums over the first components alone
    leading = np.diagonal(total.cumsum(axis=0).cumsum(axis=1))
    return np.asarray(np.maximum(np.append(0.0, leading), 0))
