"""The stages from a mesh and a material to an object with transfer, in the order of the data [LK03].

What takes long is kept in a folder as it is finished, so that a computation that was stopped goes on where it
was, and the matrices of all vertices need not fit in memory.
"""

from __future__ import annotations

import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray, Int32Array
from shrm.brdf import BRDF
from shrm.files import PathLike
from shrm.transfer.compression.choice import principal_components
from shrm.transfer.compression.components import PrincipalComponents
from shrm.transfer.described import Described
from shrm.transfer.lighting.surface import MOST_ORDER, MOST_TENTS
from shrm.transfer.matrices.accuracy import Sample, chosen
from shrm.transfer.matrices.materials import Materials
from shrm.transfer.matrices.product import Product, Route, product
from shrm.transfer.matrices.vertex_matrices import Factors, Matrices
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.rays.bounces import MOST_BOUNCES, albedos, leaving
from shrm.transfer.rays.directions import FEWEST_DIRECTIONS, MOST_DIRECTIONS, local_directions
from shrm.transfer.rays.occluders import Occluders
from shrm.transfer.rays.visibility import Visibility
from shrm.transfer.tangent_frames import vertex_frames
from shrm.transfer.variant import VARIANTS, Variant
from shrm.validation import (
    flag,
    float32_array,
    indices,
    number,
    one_of,
    real_array,
    require_instance,
    whole_number,
)

Progress = Callable[[str, int, int], None]
"""Called with what is being done, in words, and how much of how much of it is finished."""

MOST_ACCURACY = 60.0
"""The largest accuracy that can be asked for, in dB: rounding to float32 is not far beyond."""

SAMPLE = 48
"""Vertices at which the accuracy of tents is measured."""

_FINER = 4
"""Rays that such a vertex casts for the reference, for each of those of the computation."""

_RAYS = ("rays", "rays with hits")
"""Names of the folders of visibility in the one for work: without hits, and with them."""

_UNCOMPRESSED = " matrices"
"""What is appended to a variant's name for its uncompressed matrices there."""


class MeshLike(Protocol):
    """A triangle mesh: `shrm.render.Mesh`, `trimesh.Trimesh`, or any object with these arrays.

    Texture coordinates, (V, 2), are taken from `uv` or, as trimesh has them, from `visual.uv`; none need be.
    """

    @property
    def vertices(self) -> npt.NDArray[np.floating[Any]]:
        """Positions (V, 3)."""

    @property
    def faces(self) -> npt.NDArray[np.integer[Any]]:
        """Indices of vertices (T, 3)."""

    @property
    def vertex_normals(self) -> npt.NDArray[np.floating[Any]]:
        """Normals (V, 3), zero where there is none."""


@dataclass(eq=False, repr=False, kw_only=True)
class Precomputation(Described):
    """A request of `shrm.transfer.precompute`, whose parameters these are, and the stages that answer it.

    Attributes
    ----------
    vertices, faces, frames : (V, 3) float64, (T, 3) int32, (V, 3, 3) float64
        The mesh, checked.
    uv : (V, 2) float32 or None
    materials : Materials
    local_directions : (D, 3) float64
        Directions in which every vertex casts its rays, in its own frame.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as `precompute` describes it.
    OSError
        If the folder for work cannot be made.
    """

    shown = ("vertices", "faces", "materials", "order", "directions", "variants", "accuracy")

    mesh: MeshLike
    brdf: BRDF | Sequence[BRDF]
    shares: npt.ArrayLike | None
    tangents: npt.ArrayLike | None
    order: int
    directions: int
    variants: Sequence[str]
    bounces: int | None
    albedo: npt.ArrayLike | None
    accuracy: float
    tents: int | None
    route: Route | None
    components: int | None
    clusters: int | None
    half: bool
    matrices: bool
    work: PathLike | None
    progress: Progress | None

    vertices: FloatArray = field(init=False)
    faces: Int32Array = field(init=False)
    frames: FloatArray = field(init=False)
    uv: Float32Array | None = field(init=False)
    materials: Materials = field(init=False)
    local_directions: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self._check_mesh()
        self._check_light()
        self._check_sizes()
        if self.work is not None:
            Path(self.work).mkdir(parents=True, exist_ok=True)

    def _check_light(self) -> None:
        """Check what light and material are, and the variants with what goes with them."""
        V = len(self.vertices)
        self.materials = Materials.of(self.brdf, self.shares, V)
        self.order = whole_number("order", self.order, 1, MOST_ORDER)
        self.directions = whole_number("directions", self.directions, FEWEST_DIRECTIONS, MOST_DIRECTIONS)
        self.local_directions = local_directions(self.directions)
        self.variants = _variants_in_order(self.variants)
        if self.bounces is not None:
            self.bounces = whole_number("bounces", self.bounces, 1, MOST_BOUNCES)
        if self.albedo is not None:
            albedos(self.albedo, V)

        # Elsewhere they would be ignored
        for name in ("bounces", "albedo"):
            if getattr(self, name) is not None and not self.interreflected:
                raise ValueError(
                    f"variants must have interreflected where {name} is given, got {', '.join(self.variants)}"
                )

    def _check_sizes(self) -> None:
        """Check how accurate and how large the result is asked to be."""
        self.accuracy = number("accuracy", self.accuracy, 0.0, MOST_ACCURACY)
        if self.tents is not None:
            self.tents = whole_number("tents", self.tents, 2, MOST_TENTS)
        if self.route is not None:
            require_instance("route", self.route, Route, what="a shrm.transfer.Route")
        if self.components is not None:
            self.components = whole_number("components", self.components, 1)
        if self.clusters is not None:
            self.clusters = whole_number("clusters", self.clusters, 1, len(self.vertices))
        self.half, self.matrices = flag("half", self.half), flag("matrices", self.matrices)

    def _check_mesh(self) -> None:
        """Take the arrays of the mesh, and make the frames of its vertices."""
        for name in ("vertices", "faces", "vertex_normals"):
            if not hasattr(self.mesh, name):
                raise TypeError(
                    f"mesh must have vertices, faces and vertex_normals, got {type(self.mesh).__name__}"
                )
        self.vertices = real_array("vertices", self.mesh.vertices, ("V", 3), empty=False)
        float32_array("vertices", self.vertices)  # as the result has them
        V = len(self.vertices)
        self.faces = indices("faces", self.mesh.faces, V, ("T", 3), empty=False)

        # Frames, around the vertical where no tangents are given
        normals = real_array("vertex_normals", self.mesh.vertex_normals, (V, 3))
        around = np.cross([0.0, 0.0, 1.0], normals)
        self.frames = vertex_frames(normals, around if self.tangents is None else self.tangents)

        # Texture coordinates of our meshes, or of trimesh's
        uv = getattr(self.mesh, "uv", None)
        if uv is None:
            uv = getattr(getattr(self.mesh, "visual", None), "uv", None)
        self.uv = None if uv is None else float32_array("uv", uv, (V, 2))

    @property
    def hidden(self) -> bool:
        """Whether a variant is asked for in which the object hides light from itself."""
        return list(self.variants) != ["unshadowed"]

    @property
    def interreflected(self) -> bool:
        """Whether the variant in which the object lights itself is asked for."""
        return "interreflected" in self.variants

    def run(self) -> RadianceTransfer:
        """Compute all stages, each from what those before it gave.

        Warns
        -----
        UserWarning
            If the accuracy is not reached by what was chosen.
        """
        # The sizes, which decide how much of everything else there is
        M, route, snr = self.choose_tents()
        if snr < self.accuracy and (self.tents is None or self.route is None):
            warnings.warn(
                f"{M} x {M} tents reach {snr:.1f} dB of the {self.accuracy:g} asked for", stacklevel=3
            )

        # What the materials make of light, what the vertices see, and what they send each other
        products = self.make_products(M, route)
        with _folder(self.work) as folder:
            visibility = self.cast_rays(folder) if self.hidden else None
            reflected = self.bounce(visibility, products)
            channels = max(self.materials.channels, 1 if reflected is None else reflected.shape[1])
            matrices = Matrices(self.frames, self.materials, products, channels, self.order, folder)

            # The matrices of each variant, compressed
            variants, compression = {}, {}
            for name in self.variants:
                factors = self.make_factors(name, matrices, visibility, reflected)
                pca = self.compress(name, factors)
                compression[name] = pca.report()
                uncompressed = factors.matrices(folder / f"{name}{_UNCOMPRESSED}") if self.matrices else None
                variants[name] = Variant(pca.weights, pca.components, pca.clusters, uncompressed)

        report = {
            "SNR of matrices": round(snr, 2) if np.isfinite(snr) else None,
            "accuracy": self.accuracy,
            "route": str(route),
            "directions": self.directions,
            "bounces": 0 if reflected is None else self._bounces,
            "compression": compression,
        }
        return self.assemble(M, channels, variants, report)

    @property
    def _bounces(self) -> int:
        """How often the object lights itself, where it does."""
        return 1 if self.bounces is None else self.bounces

    # ---- Stages

    def choose_tents(self) -> tuple[int, Route, float]:
        """Choose the tents M and the route that the accuracy takes; return them and their SNR in dB.

        Raises
        ------
        ValueError
            If more components are asked for than matrices of these tents have.
        """
        M, route, snr = chosen(
            self.materials.brdfs,
            self.order,
            self._sample(),
            self.accuracy,
            M=self.tents,
            route=self.route,
            progress=self._stage("choosing tents"),
        )
        if self.components is not None:
            most = M**2 * self.materials.channels * self.order**2
            whole_number("components", self.components, 1, most)
        return M, route, snr

    def make_products(self, M: int, route: Route) -> list[Product]:
        """Make the product of each material: tents from light along the rays."""
        brdfs, stage = self.materials.brdfs, self._stage("materials")
        products: list[Product] = []
        for brdf in brdfs:
            stage(len(products), len(brdfs))
            products.append(product(brdf, M, self.order, self.local_directions, route))
        return products

    def cast_rays(self, folder: Path) -> Visibility:
        """Cast the rays of all vertices, with their hits where light is to be reflected."""
        hits = self.interreflected
        visibility = Visibility(
            folder / _RAYS[hits], self.vertices, self.faces, self.frames, self.local_directions, hits=hits
        )
        visibility.compute(self._stage("rays"))
        return visibility

    def bounce(self, visibility: Visibility | None, products: Sequence[Product]) -> Float32Array | None:
        """Bounce light between the vertices: transfer to the radiance (V, C, n^2) that leaves them."""
        if visibility is None or not self.interreflected:
            return None
        albedo = self.materials.albedo(products) if self.albedo is None else self.albedo
        return leaving(visibility, self.order, albedo, self._bounces, self._stage("bounces"))

    def make_factors(
        self,
        name: str,
        matrices: Matrices,
        visibility: Visibility | None,
        reflected: Float32Array | None,
    ) -> Factors:
        """Make the matrices of a variant, which stay in the folder."""
        if visibility is None or name == "unshadowed":
            return matrices.unshadowed(self._stage(name))
        light = reflected if name == "interreflected" else None
        return matrices.shadowed(visibility, light, self._stage(name))

    def compress(self, name: str, factors: Factors) -> PrincipalComponents:
        """Find the components of a variant, as many as the accuracy takes or as are asked for."""
        stage = self._stage(f"compressing {name}")
        stage(0, 1)
        pca = principal_components(factors, self.order, self.accuracy, self.components, self.clusters)
        pca = pca.halved() if self.half else pca
        stage(1, 1)
        return pca

    def assemble(
        self, M: int, channels: int, variants: dict[str, Variant], report: dict[str, Any]
    ) -> RadianceTransfer:
        """Put the mesh and its variants together."""
        return RadianceTransfer(
            vertices=self.vertices.astype(np.float32),
            faces=self.faces,
            frames=self.frames.astype(np.float32),
            n=self.order,
            M=M,
            channels=channels,
            variants=variants,
            uv=self.uv,
            material=self.materials.name,
            report=report,
        )

    def _sample(self) -> Sample:
        """Choose some vertices of faces, seeded, and cast their rays and more: what hides the light there."""
        # Where nothing hides the light all vertices are alike
        fine = local_directions(min(_FINER * 2 * len(self.local_directions), MOST_DIRECTIONS))
        if not self.hidden:
            coarse_visible, fine_visible = (
                np.ones((1, len(d)), np.bool_) for d in (self.local_directions, fine)
            )
            return Sample(self.local_directions, coarse_visible, fine, fine_visible)

        # Vertices of no face are seen nowhere
        of_faces = np.unique(self.faces)
        count = min(SAMPLE, len(of_faces))
        where = np.sort(np.random.default_rng(0).choice(of_faces, count, replace=False))
        occluders = Occluders(self.vertices, self.faces, self.frames[:, :, 2])
        coarse_visible, fine_visible = (
            np.concatenate(
                [occluders.cast(slice(p, p + 1), self.frames[p : p + 1], d, hits=False)[0] for p in where]
            )
            for d in (self.local_directions, fine)
        )
        return Sample(self.local_directions, coarse_visible, fine, fine_visible)

    def _stage(self, what: str) -> Callable[[int, int], None]:
        """Return what tells the progress of a stage."""
        progress = self.progress
        return lambda done, total: progress(what, done, total) if progress else None


def remove_work(work: PathLike) -> None:
    """Remove a folder that `precompute` worked in: what it put there, and the folder if nothing else is left.

    Raises
    ------
    OSError
        If something of it cannot be removed.
    """
    work = Path(work)
    for name in _RAYS:
        if (work / name).is_dir():
            shutil.rmtree(work / name)
    for name in VARIANTS:
        for array in (name, f"{name}{_UNCOMPRESSED}"):
            for pattern in (f"{array}.npy", f"{array}.json", f".{array}.*.part"):
                for file in work.glob(pattern):
                    file.unlink()
    with suppress(OSError):  # what else is there stays; and so does a link, to a folder made by hand
        work.rmdir()


def _variants_in_order(variants: Sequence[str]) -> list[str]:
    """Return the names of the variants in the order of `VARIANTS`; a single one may be given by itself."""
    if not isinstance(variants, Iterable):
        raise TypeError(f"variants must be names, got {variants!r}")
    names = [variants] if isinstance(variants, str) else list(variants)
    for name in names:
        one_of("variants", name, VARIANTS)
    if not names:
        raise ValueError("variants must name at least one, got none")
    return [name for name in VARIANTS if name in names]


@contextmanager
def _folder(work: PathLike | None) -> Iterator[Path]:
    """Yield the folder for work, or a temporary one."""
    if work is None:
        with tempfile.TemporaryDirectory(prefix="shrm-transfer-") as temporary:
            yield Path(temporary)
    else:
        yield Path(work)
