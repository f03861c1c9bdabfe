"""An object with its precomputed transfer: the mesh, its frames, and matrices, compressed or not [LK03].

All arrays are as `shrm.transfer.file` writes them; those of a loaded object are mapped from its file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, Int32Array, RealArray
from shrm.files import PathLike
from shrm.transfer.directional_basis import DirectionalBasis
from shrm.transfer.file import Saved, damaged, read, write
from shrm.transfer.lighting import Compressed, Lighting, Tents
from shrm.transfer.lighting.surface import MOST_ORDER, MOST_TENTS
from shrm.transfer.variant import VARIANTS, Variant
from shrm.validation import one_of, real_array, whole_number


@dataclass(eq=False)
class RadianceTransfer:
    """An object with its precomputed transfer.

    Attributes
    ----------
    vertices : (V, 3) float32
    faces : (T, 3) int32
        In [0, V).
    frames : (V, 3, 3) float32
        Rotations global_from_local, orthogonal to 1e-5: columns tangent, bitangent, normal.
    n : int
        Order of the light, degrees 0 to n - 1, in [1, 10].
    M : int
        Tents along a side, see `shrm.transfer.directional_basis`, in [2, 33].
    channels : int
        C: 1, the same for R, G and B, or 3.
    variants : dict of Variant
        By names of `VARIANTS`, at least one.
    uv : (V, 2) float32 or None
        Texture coordinates.
    material : str
        In words, or as `shrm.brdf.parse` reads it.
    report : dict
        How it was made and how accurate it is: text, numbers, lists and dicts, as JSON has them.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described, or they do not fit each other.
    """

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
        self.vertices = _rows("vertices", self.vertices, (None, 3))
        V = len(self.vertices)
        self.faces = _indices("faces", self.faces, (None, 3), V)
        self.frames = _rows("frames", self.frames, (V, 3, 3))
        off = np.abs(np.swapaxes(self.frames, 1, 2) @ self.frames - np.eye(3)).max()
        if off > 1e-5 or np.linalg.det(self.frames).min() < 0:
            raise ValueError(f"frames must be rotations, orthogonal to 1e-5, got some off by {off:.2g}")
        self.uv = None if self.uv is None else _rows("uv", self.uv, (V, 2))
        for what, kind in (("material", str), ("report", dict)):
            if not isinstance(getattr(self, what), kind):
                raise TypeError(f"{what} must be a {kind.__name__}, got {getattr(self, what)!r}")
        if not self.variants:
            raise ValueError("variants must hold at least one")
        for name in self.variants:
            one_of("variants", name, VARIANTS)
        self.variants = {name: self._fitting(name, variant) for name, variant in self.variants.items()}
        self._coarser: dict[tuple[str, int], RealArray] = {}
        self._lit: tuple[tuple[str, int], Lighting] | None = None

    def _fitting(self, name: str, variant: Variant) -> Variant:
        """The variant with clusters in int32; refused if its arrays do not fit."""
        V, shape = len(self.vertices), (self.M**2, self.channels, self.n**2)
        weights, components, matrices = variant.weights, variant.components, variant.matrices
        if (weights is None) != (components is None) or (weights is None and matrices is None):
            raise ValueError(f"{name} must have weights and components, or matrices")
        if weights is None and variant.clusters is not None:
            raise ValueError(f"{name} has clusters without weights")
        if matrices is not None:
            _floats(f"{name}: matrices", matrices, (V, *shape))
        if weights is not None and components is not None:
            _floats(f"{name}: weights", weights, (V, None))
            clustered = () if variant.clusters is None else (None,)
            _floats(f"{name}: components", components, (*clustered, variant.K, *shape))
            if variant.clusters is not None:
                clusters = _indices(f"{name}: clusters", variant.clusters, (V,), len(components))
                variant = replace(variant, clusters=clusters)
            for what, array in (("weights", weights), ("components", components)):
                if not np.isfinite(array).all():
                    raise ValueError(f"{name}: {what} must be finite")
        return variant

    # ---- Radiance

    def lighting(
        self, variant: str | None = None, *, components: int | None = None, tents: int | None = None
    ) -> Lighting:
        """Return what lights the vertices: from components where there are some, else from the matrices.

        Parameters
        ----------
        variant : str, optional
            By default the most complete one.
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

    # ---- Its mesh and file

    def require_mesh(self, vertices: npt.ArrayLike, faces: npt.ArrayLike) -> None:
        """Refuse a mesh that is not the one that transfer was computed for.

        Parameters
        ----------
        vertices : (V, 3) array_like
            Equal to 1e-5 of the largest coordinate.
        faces : (T, 3) array_like

        Raises
        ------
        ValueError
            If it is another one.
        """
        positions, triangles = real_array("vertices", vertices), np.asarray(faces)
        for what, given, own in (("vertices", positions, self.vertices), ("faces", triangles, self.faces)):
            if given.shape != own.shape:
                raise ValueError(
                    f"the mesh does not match its transfer: it has {what} of shape {given.shape}, "
                    f"the transfer {own.shape}"
                )
        moved = int(
            (np.abs(positions - self.vertices).max(axis=1) > 1e-5 * np.abs(self.vertices).max()).sum()
        )
        turned = int((triangles != self.faces).any(axis=1).sum())
        if moved or turned:
            raise ValueError(
                f"the mesh does not match its transfer: {moved} vertices and {turned} faces are others"
            )

    def save(
        self, path: PathLike, *, blocks: Mapping[str, Callable[[], Iterable[RealArray]]] | None = None
    ) -> None:
        """Write the object to a file, whole or not at all; see `shrm.transfer.file.write`."""
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
        write(path, saved, blocks=blocks)

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


def _rows(name: str, value: RealArray, shape: tuple[int | None, ...]) -> Float32Array:
    """A finite array of this shape as float32 in C order; None is any length above 0."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} must be an array of real numbers, got dtype {array.dtype}")
    _require_shape(name, array.shape, shape)
    if not np.isfinite(array).all():
        raise ValueError(f"{name} must be finite")
    return np.ascontiguousarray(array, np.float32)


def _indices(
    name: str, value: npt.NDArray[np.integer], shape: tuple[int | None, ...], below: int
) -> Int32Array:
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name} must be an array of whole numbers, got dtype {array.dtype}")
    _require_shape(name, array.shape, shape)
    if array.min() < 0 or array.max() >= below:
        raise ValueError(f"{name} must be in [0, {below}), got {array.min()} to {array.max()}")
    return np.ascontiguousarray(array, np.int32)


def _floats(name: str, value: RealArray, shape: tuple[int | None, ...]) -> None:
    if not isinstance(value, np.ndarray) or value.dtype not in (np.float32, np.float16):
        raise TypeError(
            f"{name} must be an array of float32 or float16, got {getattr(value, 'dtype', value)}"
        )
    _require_shape(name, value.shape, shape)


def _require_shape(name: str, shape: tuple[int, ...], wanted: tuple[int | None, ...]) -> None:
    if len(shape) != len(wanted) or any(
        w not in (None, s) or not s for s, w in zip(shape, wanted, strict=True)
    ):
        text = ", ".join("any" if w is None else str(w) for w in wanted)
        raise ValueError(f"{name} must have the shape ({text}), got {shape}")
