"""Materials that vary over a surface: several, and the share of each at every vertex."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF
from shrm.transfer.described import Described
from shrm.transfer.matrices.product import Product
from shrm.validation import real_array

MOST_SHARE = 1e6
"""The largest share; those of a blend sum to 1, others are as much brighter."""


@dataclass(frozen=True, eq=False, repr=False)
class Materials(Described):
    """Materials and their shares; made by `of`.

    Attributes
    ----------
    brdfs : tuple of BRDF
    shares : (V, materials) float32 or None
        None: one material everywhere.
    """

    brdfs: tuple[BRDF, ...]
    shares: Float32Array | None

    @classmethod
    def of(cls, brdf: BRDF | Sequence[BRDF], shares: npt.ArrayLike | None, vertices: int) -> Materials:
        """Take one material, or several with their shares.

        Raises
        ------
        TypeError, ValueError
            If they are no materials, or the shares are not (vertices, materials) numbers in [0, 1e6].
        """
        brdfs = tuple(brdf) if isinstance(brdf, Sequence) else (brdf,)
        if not brdfs or not all(isinstance(material, BRDF) for material in brdfs):
            raise TypeError(f"brdf must be a material of shrm.brdf, or several, got {brdf!r}")
        if shares is None:
            if len(brdfs) > 1:
                raise ValueError(f"shares must be given for {len(brdfs)} materials, got None")
            return cls(brdfs, None)
        array = real_array("shares", shares, (vertices, len(brdfs)))
        if array.min() < 0 or array.max() > MOST_SHARE:
            raise ValueError(f"shares must be in [0, {MOST_SHARE:g}], got {array.min():g} to {array.max():g}")
        return cls(brdfs, array.astype(np.float32))

    @property
    def channels(self) -> int:
        """Number of channels: 3 if those of a material differ, else 1."""
        return max(brdf.channels for brdf in self.brdfs)

    @property
    def name(self) -> str:
        """Names of the materials, in one text."""
        return " / ".join(brdf.name for brdf in self.brdfs)

    def albedo(self, products: Sequence[Product]) -> FloatArray:
        """Return the share of white light that leaves in all directions together: (), (3,), (V,) or (V, 3).

        Parameters
        ----------
        products : sequence of Product
            One for each material.
        """
        # Of each material: the flux that leaves, over that of light of radiance 1, pi
        of_each = []
        for product in products:
            views, weights = product.basis.quadrature(4)
            # White light has the coefficient sqrt(4 pi) and no other
            tents = np.sqrt(4 * np.pi) * product.unshadowed[:, 0].reshape(-1, product.channels)
            mean = (weights * views[:, 2]) @ product.basis.evaluate(tents, views) / np.pi
            of_each.append(np.broadcast_to(mean, (self.channels,)))

        # Of the vertices
        of_materials = np.stack(of_each)
        mixed = of_materials if self.shares is None else self.shares.astype(np.float64) @ of_materials
        albedos = np.clip(mixed, 0, 1)
        if self.channels == 1:
            albedos = albedos[:, 0]
        return np.asarray(albedos[0] if self.shares is None else albedos)
