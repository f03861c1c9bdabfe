"""An object with its precomputed transfer: the mesh, its frames, and matrices, compressed or not [LK03].

All arrays are as `shrm.transfer.file` writes them; those of a loaded object are mapped from its file.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, Int32Array, RealArray
from shrm.files import PathLike
from shrm.transfer.described import Described
from shrm.transfer.directional_basis import DirectionalBasis
from shrm.transfer.file import Saved, damaged, read, write
from shrm.transfer.lighting import Compressed, Lighting, Tents
from shrm.transfer.lighting.surface import FRAME_TOLERANCE, MOST_ORDER, MOST_TENTS
from shrm.transfer.variant import VARIANTS, Variant
from shrm.validation import (
    float32_array,
    indices,
    one_of,
    require_instance,
    require_rotations,
    require_stored,
    string,
    whole_number,
)


@dataclass(eq=False, repr=False)
class RadianceTransfer(Described):
    """An object with its precomputed transfer.

    Attributes
    ----------
    vertices : (V, 3) float32
    faces : (T, 3) int32
        Indices of vertices, in [0, V).
    frames : (V, 3, 3) float32
        Rotations global_from_local, orthogonal to 1e-5: columns tangent, bitangent, normal.
    n : int
        Order of the light, degrees 0 to n - 1, in [1, 10].
    M : int
        Tents along a side, see `shrm.transfer.directional_basis`, in [2, 33].
    channels : int
        C: 1, the same for R, G and B, or 3.
    variants : dict of Variant
        Variants by their names, those of `VARIANTS`; at least one.
    uv : (V, 2) float32 or None
        Texture coordinates.
    material : str
        The material in words, or as `shrm.brdf.parse` reads it.
    report : dict
        How it was made and how accurate it is: text, numbers, lists and dicts, as JSON has them.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described, or they do not fit each other.
    """

    shown = ("vertices", "faces", "n", "M", "channels", "variants", "material")

    vertices: Float32Array
    faces: Int32Array
    frames: Float32Array
    n: int
    M: int
    channels: int
    variants: dict[str, Variant]
    uv: Float32Array | None = None
    material: str = ""
    report: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.n, self.M = whole_number("n", self.n, 1, MOST_ORDER), whole_number("M", self.M, 2, MOST_TENTS)
        self.channels = whole_number("channels", self.channels, 1, 3)
        if self.channels == 2:
            raise ValueError("channels must be 1 or 3, got 2")

        # The mesh and its frames
        self.vertices = float32_array("vertices", self.vertices, ("V", 3), empty=False)
        V = len(self.vertices)
        self.faces = indices("faces", self.faces, V, ("T", 3), empty=False)
        self.frames = float32_array("frames", self.frames, (V, 3, 3))
        require_rotations("frames", self.frames, FRAME_TOLERANCE)
        self.uv = None if self.uv is None else float32_array("uv", self.uv, (V, 2))

        # What it is made of
        string("material", self.material)
        require_instance("report", self.report, dict)
        if not self.variants:
            raise ValueError("variants must hold at least one, got none")
        for name in self.variants:
            one_of("variants", name, VARIANTS)
        self.variants = {name: self._fitting(name, variant) for name, variant in self.variants.items()}

        self._coarser: dict[tuple[str, int], RealArray] = {}
        self._lit: tuple[tuple[str, int], Lighting] | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Return what a pickle holds: all but what was made to light the object."""
        return {**vars(self), "_coarser": {}, "_lit": None}

    def _fitting(self, name: str, variant: Variant) -> Variant:
        """Return the variant with clusters in int32; refuse it if its arrays do not fit."""
        V, shape = len(self.vertices), (self.M**2, self.channels, self.n**2)
        weights, components, matrices = variant.weights, variant.components, variant.matrices

        # What there must be
        if (weights is None) != (components is None) or (weights is None and matrices is None):
            there = [key for key, array in vars(variant).items() if array is not None]
            raise ValueError(
                f"{name} must have weights and components, or matrices, got {', '.join(there) or 'none'}"
            )
        if weights is None and variant.clusters is not None:
            raise ValueError(f"{name} must have weights where it has clusters, got none")

        # What shape it has; matrices may be large, mapped from disk, and are not read
        if matrices is not None:
            require_stored(f"{name}: matrices", matrices, (V, *shape), finite=False)
        if weights is None or components is None:
            return variant
        require_stored(f"{name}: weights", weights, (V, "K"))
        clustered = () if variant.clusters is None else ("Q",)
        require_stored(f"{name}: components", components, (*clustered, variant.K, *shape))
        if variant.clusters is None:
            return variant
        clusters = indices(f"{name}: clusters", variant.clusters, len(components), (V,))
        return replace(variant, clusters=clusters)

    # ---- Radiance

    def lighting(
        self, variant: str | None = None, *, components: int | None = None, tents: int | None = None
    ) -> Lighting:
        """Return what lights the vertices: from components where there are some, else from the matrices.

        Parameters
        ----------
        variant : str, optional
            Name of the variant; by default the most complete one.
        components : int, optional
            How many components are used, K from 1 to those that there are; by default all.
        tents : int, optional
            Tents along a side, from 2 to the object's M: components are projected on fewer, which is kept
            for the next time. Matrices are not.

        Raises
        ------
        TypeError, ValueError
            If there is no such variant, or as many components or tents.
        """
        name, K, M = self._chosen(variant, components, tents)
        held = self.variants[name]
        if held.weights is None:
            assert held.matrices is not None
            return Tents(self.vertices, self.frames, held.matrices)
        return Compressed(
            self.vertices, self.frames, held.weights, self._components(name, M), held.clusters, K
        )

    def radiance(
        self,
        light: npt.ArrayLike,
        *,
        eye: npt.ArrayLike | None = None,
        view: npt.ArrayLike | None = None,
        variant: str | None = None,
        components: int | None = None,
        tents: int | None = None,
    ) -> Float32Array:
        """Return the radiance of the vertices; what lights them is kept for the next call.

        Parameters
        ----------
        light : (n^2, 3) array_like
            Coefficients of the light, see `Lighting.radiance`.
        eye, view : (3,) array_like
            The position of a near viewer, or the unit vector to a distant one.
        variant, components, tents
            What of the transfer is used, see `lighting`.

        Returns
        -------
        (V, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described, or not one of `eye` and `view` is given.
        """
        name, K, M = self._chosen(variant, components, tents)
        if self._lit is None or self._lit[0] != (name, M):
            self._lit = (name, M), self.lighting(name, tents=M)
        lighting = self._lit[1]
        if isinstance(lighting, Compressed):
            lighting.K = K
        return np.asarray(lighting.radiance(light, eye=eye, view=view))

    def _chosen(self, variant: str | None, components: int | None, tents: int | None) -> tuple[str, int, int]:
        """Return the name of a variant, K and M, those that are not given as large as there are."""
        name = max(self.variants, key=VARIANTS.index) if variant is None else variant
        one_of("variant", name, self.variants)
        held = self.variants[name]
        M = self.M if tents is None else whole_number("tents", tents, 2, self.M)
        if held.weights is None and (components is not None or self.M != M):
            raise ValueError(f"variant must be compressed where components or tents are given, got {name}")
        return name, held.K if components is None else whole_number("components", components, 1, held.K), M

    def _components(self, name: str, M: int) -> RealArray:
        """Return a variant's components (..., M^2, C, n^2) in float32, on coarser tents if M is smaller."""
        components = np.asarray(self.variants[name].components, np.float32)
        if self.M == M:
            return components
        if (name, M) not in self._coarser:
            rows = components.reshape(-1, self.M**2, self.channels * self.n**2)
            projected = DirectionalBasis(self.M).coarser(M).astype(np.float32) @ rows
            shape = (*components.shape[:-3], M * M, *components.shape[-2:])
            self._coarser[name, M] = projected.reshape(shape)
        return self._coarser[name, M]

    # ---- Its file

    def save(self, path: PathLike) -> None:
        """Write the object to a file, whole or not at all; see `shrm.transfer.file.write`.

        Raises
        ------
        shrm.transfer.file.TransferFileError
            If the file cannot be written.
        ValueError
            If the report holds what JSON does not.
        """
        saved = Saved(
            vertices=self.vertices,
            faces=self.faces,
            frames=self.frames,
            n=self.n,
            M=self.M,
            channels=self.channels,
            variants=self.variants,
            uv=self.uv,
            material=self.material,
            report=self.report,
        )
        write(path, saved)

    @classmethod
    def load(cls, path: PathLike, *, verify: bool = False) -> RadianceTransfer:
        """Read an object from a file: arrays are read-only and mapped; see `shrm.transfer.file.read`.

        Raises
        ------
        shrm.transfer.file.TransferFileError
            If the file cannot be read, is damaged, or its arrays do not fit each other.
        """
        saved = read(path, verify=verify)
        try:
            return cls(**vars(saved))
        except (TypeError, ValueError, OverflowError) as fault:
            raise damaged(path, fault) from fault
