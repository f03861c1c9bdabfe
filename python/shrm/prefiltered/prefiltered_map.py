"""Prefiltered maps of one lobe: layers over a central direction, looked up in shares [KVHS00 section 4]."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar, get_args

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray
from shrm.brdf import BRDF, Material
from shrm.brdf.lobe import Center
from shrm.environment import Environment
from shrm.files import PathLike
from shrm.frequency.rings import Interpolation
from shrm.image_io import ImageError
from shrm.lobes.directions import across, central_directions
from shrm.lobes.reflection import Layout, Reflection
from shrm.prefiltered import file
from shrm.prefiltered.layers import Integration, Layer, Method, material_of_one_lobe
from shrm.validation import one_of, unit_vectors

Map = TypeVar("Map", bound="PrefilteredMap")


@dataclass(frozen=True, eq=False, repr=False)
class PrefilteredMap(Reflection):
    """A prefiltered map of one lobe.

    Attributes
    ----------
    layers : tuple of Layer
        Maps of radiance over the central direction C.
    brdf : str
        The material's name.
    error : float
        The relative RMS error that the layers were integrated to: of the radiance under the lobe that the
        class holds. What the class does not hold of the material's lobe is not in it, and not known without
        integrating the lobe itself. nan for layers that were not integrated here.
    keeps : str
        The variables among v, n and t that the class keeps.
    assumes : str
        The assumption under which these variables suffice.
    kinds, centers_held : tuple of str
        Kinds and centers of the lobes that the class holds; isotropic ones may have any center.
    layer_counts : (int, int)
        Fewest and most layers.
    """

    layers: tuple[Layer, ...]
    brdf: str
    error: float = float("nan")

    keeps: ClassVar[str]
    assumes: ClassVar[str]
    kinds: ClassVar[tuple[str, ...]]
    centers_held: ClassVar[tuple[Center, ...]]
    layer_counts: ClassVar[tuple[int, int]]

    @property
    def center(self) -> Center:
        """The direction C at which layers are looked up."""
        return self.layers[0].center

    @property
    def centers(self) -> tuple[Center, ...]:
        """The center of the one lobe."""
        return (self.center,)

    @property
    def layout(self) -> Layout:
        """The grid of the layers: "latlong" or "cube"."""
        return self.layers[0].layout

    @property
    def size(self) -> int:
        """Rows of a lat-long map, or of a cube's face."""
        return self.layers[0].size

    @property
    def maps(self) -> Float32Array:
        """Radiance of the layers: (K, H, W, 3), or (K, 6, N, N, 3)."""
        return np.stack([layer.pixels for layer in self.layers])

    @property
    def nbytes(self) -> int:
        """Bytes of the layers."""
        return sum(layer.rings.nbytes for layer in self.layers)

    # ---- Prefiltering

    @classmethod
    def prefilter(
        cls: type[Map],
        env: Environment,
        brdf: BRDF,
        *,
        method: Method = "hierarchical",
        tolerance: float = 0.01,
        size: int | None = None,
        layout: Layout = "latlong",
    ) -> Map:
        """Prefilter an environment for a material of one lobe, of a kind and center that the class holds.

        Parameters
        ----------
        env : Environment
            The light.
        brdf : BRDF
            The material.
        method : {"frequency", "angular", "hierarchical"}
            The integrator of the layers.
        tolerance : float
            Relative RMS of the radiance under the lobe that the class holds, in (0, 1).
        size : int, optional
            Rows of lat-long layers (default 128), or the edge of a cube's face (default 64), 2 to 8192.
        layout : {"latlong", "cube"}
            The grid of the layers.

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described.
        """
        integration = Integration.requested(env, method, tolerance, size, layout)
        return cls.integrated(cls.held(brdf), integration)

    @classmethod
    def held(cls, brdf: BRDF) -> Material:
        """Return the material if it is of one lobe that the class holds; else TypeError or ValueError."""
        return material_of_one_lobe(brdf, cls.__name__, cls.kinds, cls.centers_held)

    @classmethod
    @abstractmethod
    def integrated(cls: type[Map], material: Material, integration: Integration, **options: Any) -> Map:
        """Integrate the layers of a material that the class holds; classes have options of their own."""

    # ---- Reading

    @abstractmethod
    def shares(self, theta_o: FloatArray, views: FloatArray) -> FloatArray:
        """Return the layers' shares for angles between C and V, (n,), and views, (n, 3): (n, K or K, 3)."""

    def radiance(
        self,
        normals: npt.ArrayLike,
        views: npt.ArrayLike,
        tangents: npt.ArrayLike | None = None,
        *,
        interpolation: Interpolation = "cubic",
    ) -> Float32Array:
        """Return the radiance reflected towards the eye.

        Parameters
        ----------
        normals : (n, 3) array_like
            Unit vectors, world frame.
        views : (n, 3) or (3,) array_like
            Unit vectors from the surface to the eye.
        tangents : (n, 3) array_like, optional
            Unit vectors, needed about the tangent.
        interpolation : {"cubic", "bilinear"}
            Between the layers' texels.

        Returns
        -------
        (n, 3) float32

        Raises
        ------
        TypeError, ValueError
            If an argument is not as described, or tangents are missing.
        """
        one_of("interpolation", interpolation, get_args(Interpolation))
        N = unit_vectors("normals", normals)
        V = np.broadcast_to(unit_vectors("views", views, 1 if np.ndim(views) == 1 else len(N)), N.shape)
        T = N
        if self.center == "tangent":
            if tangents is None:
                raise ValueError(f"{self.brdf} has a lobe about the tangent: radiance needs tangents")
            T = unit_vectors("tangents", tangents, len(N))

        # Each layer is looked up where it has a share.
        C = np.ascontiguousarray(self.central_directions(N, V, T))
        shares = self.shares(across(C, V)[1], V)
        result = np.zeros(N.shape, np.float32)
        for k, layer in enumerate(self.layers):
            share = shares[:, k] if shares.ndim == 3 else shares[:, k, None]
            near = np.flatnonzero(share.any(axis=1))
            if len(near):
                result[near] += share[near] * layer.radiance(C[near], interpolation)
        return result

    def central_directions(self, N: FloatArray, V: FloatArray, T: FloatArray) -> FloatArray:
        """Return C for normals, views and tangents, (n, 3) each."""
        return central_directions(self.center, N, V, T)

    def lobe_maps(self, view: FloatArray) -> Iterator[Float32Array]:
        """Yield the map of the lobe; see `shrm.lobes.reflection.Reflection`."""
        C = np.ascontiguousarray(self.layers[0].directions().reshape(-1, 3))
        V = np.broadcast_to(view, C.shape)
        shares = self.shares(across(C, V)[1], V)
        shares = shares if shares.ndim == 3 else shares[..., None]
        pixels = np.zeros(C.shape, np.float32)
        for k, layer in enumerate(self.layers):
            pixels += (shares[:, k] * layer.pixels.reshape(-1, 3)).astype(np.float32)
        yield pixels.reshape(self.layers[0].shape)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.brdf}: {len(self.layers)} layers {self.layout} {self.size}>"

    # ---- Files

    def save(self, path: PathLike) -> None:
        """Write a file, in the format of `shrm.prefiltered.file`.

        Raises
        ------
        shrm.ImageError
            If it cannot be written.
        """
        file.write(path, [self.saved()])

    @classmethod
    def load(cls: type[Map], path: PathLike) -> Map:
        """Read a file of one map of this class.

        Raises
        ------
        shrm.ImageError
            If it cannot be read, is damaged, or holds something else.
        """
        (loaded,) = restored(path, [cls], most=1)
        assert isinstance(loaded, cls)
        return loaded

    def saved(self) -> file.SavedLobe:
        """Return what a file holds of the map."""
        return file.SavedLobe(type(self).__name__, self.keeps, self.layers, self.brdf, self.error)

    @classmethod
    def from_saved(cls: type[Map], saved: file.SavedLobe) -> Map:
        """Return a map of the class from what a file holds; ValueError if it is none."""
        center, count = saved.layers[0].center, len(saved.layers)
        if center not in (cls.centers_held or get_args(Center)):
            raise ValueError(f"a {cls.__name__} map about the {center}")
        if not cls.layer_counts[0] <= count <= cls.layer_counts[1]:
            raise ValueError(f"{count} layers of a {cls.__name__} map")
        return cls(saved.layers, saved.brdf, saved.error)


def restored(
    path: PathLike, classes: Sequence[type[PrefilteredMap]], most: int | None = None
) -> tuple[PrefilteredMap, ...]:
    """Read the maps of a file, each of one of some classes, at most `most`.

    Raises
    ------
    shrm.ImageError
        If the file cannot be read, is damaged, or holds other maps, or more.
    """
    lobes = file.read(path)
    by_name = {cls.__name__: cls for cls in classes}
    if most is not None and len(lobes) > most:
        raise ImageError(
            f"{path}: holds the maps of {len(lobes)} lobes: shrm.prefiltered.Prefiltered reads it"
        )
    try:
        for lobe in lobes:
            if lobe.kind not in by_name:
                raise ValueError(f"a {lobe.kind} map where it must be {' or '.join(by_name)}")
        return tuple(by_name[lobe.kind].from_saved(lobe) for lobe in lobes)
    except ValueError as fault:
        raise ImageError(f"{path}: damaged prefiltered maps ({fault})") from fault
