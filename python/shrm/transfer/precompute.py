"""From a mesh and a material to an object with transfer: rays, products, compression [LK03].

What takes long is kept in a folder as it is finished, so that a computation that was stopped goes on where it
was, and the matrices of all vertices need not fit in memory.
"""

from __future__ import annotations

import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from shrm.arrays import Float32Array, FloatArray, Int32Array
from shrm.brdf import BRDF
from shrm.transfer.compression.clusters import clustered
from shrm.transfer.compression.components import PrincipalComponents
from shrm.transfer.compression.compression import factored, streamed
from shrm.transfer.lighting.surface import MOST_ORDER, MOST_TENTS
from shrm.transfer.matrices.accuracy import Sample, chosen
from shrm.transfer.matrices.materials import Materials
from shrm.transfer.matrices.matrices import Factors, Matrices
from shrm.transfer.matrices.product import Path as Way
from shrm.transfer.matrices.product import Product, product
from shrm.transfer.object import VARIANTS, RadianceTransfer, Variant
from shrm.transfer.rays.bounces import MOST_BOUNCES, albedos, leaving
from shrm.transfer.rays.directions import FEWEST_DIRECTIONS, MOST_DIRECTIONS, local_directions
from shrm.transfer.rays.rays import Occluders, mesh_faces, rows
from shrm.transfer.rays.stored import read
from shrm.transfer.rays.visibility import Visibility
from shrm.transfer.tangent_frames import vertex_frames
from shrm.validation import number, one_of, whole_number

Progress = Callable[[str, int, int], None]

SAMPLE = 48
"""Vertices at which accuracy is measured."""

_FINER = 4
"""How many times as many rays they cast."""

_COORDINATES = 256
"""Components whose coordinates clusters are found among."""

_OF_CLUSTER = 3
"""Components of a cluster."""

_FACTORED = 2048
"""Columns up to which exact components are found as fast as random ones."""

_RAYS = ("rays", "rays with hits")
"""Folders in the one for work: without hits, and with them."""

_UNCOMPRESSED = " matrices"
"""What the names of uncompressed matrices end in there."""


class Surface(Protocol):
    """A triangle mesh, such as `shrm.render.Mesh`."""

    @property
    def vertices(self) -> FloatArray:
        """(V, 3)."""

    @property
    def faces(self) -> npt.NDArray[np.integer[Any]]:
        """(T, 3), indices into vertices."""

    @property
    def vertex_normals(self) -> FloatArray:
        """(V, 3), zero where there is none."""

    @property
    def uv(self) -> FloatArray | None:
        """(V, 2), if it has any."""


def precompute(
    mesh: Surface,
    brdf: BRDF | Sequence[BRDF],
    *,
    shares: npt.ArrayLike | None = None,
    tangents: npt.ArrayLike | None = None,
    n: int = 5,
    directions: int = 4096,
    variants: Sequence[str] = ("unshadowed", "shadowed"),
    bounces: int = 1,
    albedo: npt.ArrayLike | None = None,
    accuracy: float = 24.0,
    M: int | None = None,
    path: Way | None = None,
    K: int | None = None,
    clusters: int | None = None,
    half: bool = True,
    matrices: bool = False,
    work: str | Path | None = None,
    progress: Progress | None = None,
) -> RadianceTransfer:
    """Precompute how an object reflects the light around it, shadows and interreflections included.

    Parameters
    ----------
    mesh : Surface
        Vertices, faces, normals; in the coordinates of the light, z up.
    brdf : BRDF or sequence of BRDF
        The material, anisotropic ones too; or several.
    shares : (V, materials) array_like, optional
        Of several materials at each vertex, 0 to 10^6: a material for each vertex, or blends, at no cost at
        run time. Those of a texture are `shrm.render.Mesh.texture_at_vertices`.
    tangents : (V, 3) array_like, optional
        At the vertices, for anisotropic materials; by default around the vertical.
    n : int
        Order of the light, degrees 0 to n - 1, 1 to 10.
    directions : int
        Rays over a sphere, 16 to 65536; half of them are cast from each vertex.
    variants : sequence of {"unshadowed", "shadowed", "interreflected"}
        What is computed. The last has `bounces` diffuse reflections of the object by itself.
    bounces : int
        1 to 1000.
    albedo : float, (3,), (V,) or (V, 3) array_like, optional
        Of those reflections, in [0, 1]; by default the material's under uniform light.
    accuracy : float
        Relative SNR of outgoing radiance in dB, in [0, 60], that tents and the path are chosen for, against
        rays; and then, against their matrices, up to 512 components: both together have some 3 dB less. Both
        are measured (`report`). Components whose number is given by K or clusters have what they have.
    M : int, optional
        Tents along a side, instead of choosing.
    path : shrm.transfer.Path, optional
        Expansions on the way from rays to tents, instead of choosing.
    K : int, optional
        Principal components, instead of choosing; fewer where fewer are exact.
    clusters : int, optional
        Clusters of vertices with components of their own; K is then those of each, 3 unless given.
    half : bool
        Whether weights are half floats.
    matrices : bool
        Whether uncompressed matrices are kept as well.
    work : path, optional
        A folder for what is finished; the same call continues there. Without it a temporary one is used.
    progress : callable, optional
        Called with what is being done, in words, and how much of how much is finished. What it raises ends
        the computation.

    Returns
    -------
    RadianceTransfer

    Warns
    -----
    UserWarning
        If the accuracy is not reached by what was chosen.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    vertices = rows("vertices", mesh.vertices, 3)
    faces = mesh_faces(mesh.faces, len(vertices))
    n = whole_number("n", n, 1, MOST_ORDER)
    bounces = whole_number("bounces", bounces, 1, MOST_BOUNCES)
    accuracy = number("accuracy", accuracy, 0.0, 60.0)
    M = None if M is None else whole_number("M", M, 2, MOST_TENTS)
    if path is not None and not isinstance(path, Way):
        raise TypeError(f"path must be a shrm.transfer.Path, got {path!r}")
    K = None if K is None else whole_number("K", K, 1)
    clusters = None if clusters is None else whole_number("clusters", clusters, 1, len(vertices))
    for name, flag in (("half", half), ("matrices", matrices)):
        if not isinstance(flag, bool):
            raise TypeError(f"{name} must be True or False, got {flag!r}")
    if work is not None:
        Path(work).mkdir(parents=True, exist_ok=True)
    wanted = _wanted(variants)
    uv = None if mesh.uv is None else _uv(mesh.uv, len(vertices))
    if np.abs(vertices).max() > np.finfo(np.float32).max:
        raise ValueError(f"vertices must be within the range of float32, got {np.abs(vertices).max():.3g}")
    materials = Materials.of(brdf, shares, len(vertices))
    frames = _frames(mesh, vertices, tangents)
    rays = local_directions(whole_number("directions", directions, FEWEST_DIRECTIONS, MOST_DIRECTIONS))
    if albedo is not None:
        albedos(albedo, len(vertices))

    def stage(what: str) -> Callable[[int, int], None]:
        return lambda done, total: progress(what, done, total) if progress else None

    hidden, given = wanted != ["unshadowed"], M is not None and path is not None
    sample = _sample(vertices, faces, frames, rays, hidden)
    M, path, snr = chosen(
        materials.brdfs, n, sample, accuracy, M=M, path=path, progress=stage("choosing tents")
    )
    if K is not None:
        K = whole_number("K", K, 1, M * M * materials.channels * n * n)
    if snr < accuracy and not given:
        warnings.warn(f"{M} x {M} tents reach {snr:.1f} dB of the {accuracy:g} asked for", stacklevel=2)
    products: list[Product] = []
    for one in materials.brdfs:
        stage("materials")(len(products), len(materials.brdfs))
        products.append(product(one, M, n, rays, path))
    channels, reflected = materials.channels, None
    found: dict[str, Variant] = {}
    compression: dict[str, Any] = {}
    with _folder(work) as folder:
        if hidden:
            hits = "interreflected" in wanted
            visibility = Visibility(folder / _RAYS[hits], vertices, faces, frames, rays, hits=hits)
            visibility.compute(stage("rays"))
            if hits:
                albedo = materials.albedo(products) if albedo is None else albedo
                reflected = leaving(visibility, n, albedo, bounces, stage("bounces"))
                channels = max(channels, reflected.shape[1])
        made = Matrices(frames, materials, products, channels, n, folder)
        for name in wanted:
            if name == "unshadowed":
                factors = made.unshadowed(stage(name))
            else:
                light = reflected if name == "interreflected" else None
                factors = made.shadowed(visibility, light, stage(name))
            stage(f"compressing {name}")(0, 1)
            components = _compressed(factors, n, accuracy, K, clusters)
            components = components.halved() if half else components
            stage(f"compressing {name}")(1, 1)
            compression[name] = components.report()
            whole = factors.matrices(folder / f"{name}{_UNCOMPRESSED}") if matrices else None
            found[name] = Variant(components.weights, components.components, components.clusters, whole)
    report = {
        "SNR of matrices": round(snr, 2) if np.isfinite(snr) else None,
        "accuracy": accuracy,
        "path": str(path),
        "directions": directions,
        "bounces": bounces if reflected is not None else 0,
        "compression": compression,
    }
    return RadianceTransfer(
        vertices=vertices.astype(np.float32),
        faces=faces,
        frames=frames.astype(np.float32),
        n=n,
        M=M,
        channels=channels,
        variants=found,
        uv=uv,
        material=materials.name,
        report=report,
    )


def remove_work(work: str | Path) -> None:
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


def _wanted(variants: Sequence[str]) -> list[str]:
    """The variants in their order."""
    if not isinstance(variants, Iterable):
        raise TypeError(f"variants must be names, got {variants!r}")
    names = [variants] if isinstance(variants, str) else list(variants)
    for name in names:
        one_of("variants", name, VARIANTS)
    if not names:
        raise ValueError("variants must name at least one, got none")
    return [name for name in VARIANTS if name in names]


def _uv(uv: npt.ArrayLike, count: int) -> Float32Array:
    array = rows("uv", uv, 2)
    if len(array) != count:
        raise ValueError(f"uv must have the shape ({count}, 2), got {array.shape}")
    return array.astype(np.float32)


def _frames(mesh: Surface, vertices: FloatArray, tangents: npt.ArrayLike | None) -> FloatArray:
    """Frames at the vertices; without tangents x runs around the vertical."""
    normals = rows("vertex_normals", mesh.vertex_normals, 3)
    if len(normals) != len(vertices):
        raise ValueError(f"vertex_normals must have the shape {vertices.shape}, got {normals.shape}")
    around = np.cross([0.0, 0.0, 1.0], normals)
    return vertex_frames(normals, around if tangents is None else tangents)


def _sample(
    vertices: FloatArray,
    faces: Int32Array,
    frames: FloatArray,
    rays: FloatArray,
    hidden: bool,
) -> Sample:
    """Some vertices of faces, seeded, and what they see."""
    fine = local_directions(min(_FINER * 2 * len(rays), MOST_DIRECTIONS))
    if not hidden:
        all_see = (np.ones((1, len(d)), np.bool_) for d in (rays, fine))
        return Sample(rays, next(all_see), fine, next(all_see))
    of_faces = np.unique(faces)
    count = min(SAMPLE, len(of_faces))
    where = np.sort(np.random.default_rng(0).choice(of_faces, count, replace=False))
    occluders = Occluders(vertices, faces, frames[:, :, 2])
    seen = [
        np.concatenate([occluders.cast(slice(p, p + 1), frames[p : p + 1], d, hits=False)[0] for p in where])
        for d in (rays, fine)
    ]
    return Sample(rays, seen[0], fine, seen[1])


def _compressed(
    factors: Factors, n: int, accuracy: float, K: int | None, clusters: int | None
) -> PrincipalComponents:
    """Components of a variant, as many as the accuracy takes or as are asked for."""
    outer = factors.outer
    small = outer is not None and outer.shape[1] * n * n <= _FACTORED
    height = factors.tents * factors.channels
    columns = (min(height, factors.rows.shape[1]) if small else height) * n * n
    asked: dict[str, Any] = {"accuracy": accuracy} if K is None else {"K": min(K, columns)}
    if clusters is not None:
        asked = {"K": min(max(_COORDINATES, K or 0), columns)}
    if outer is not None and small:
        P = outer.reshape(factors.tents, factors.channels, -1)
        components = factored(P, factors.rows, **asked)
    else:
        components = streamed(_blocks(factors), **asked)
    if clusters is None:
        return components
    return clustered(components, clusters, min(K or _OF_CLUSTER, components.K))


def _blocks(factors: Factors) -> Callable[[], Iterator[Float32Array]]:
    """What gives the matrices anew, in blocks."""

    def blocks() -> Iterator[Float32Array]:
        for start in range(0, len(factors.rows), 1024):
            part = read(factors.rows, slice(start, start + 1024))
            whole = part if factors.outer is None else np.matmul(factors.outer, part)
            yield whole.reshape(len(part), factors.tents, factors.channels, -1)

    return blocks


@contextmanager
def _folder(work: str | Path | None) -> Iterator[Path]:
    """The folder that is given, made if need be; or a temporary one."""
    if work is None:
        with tempfile.TemporaryDirectory(prefix="shrm-transfer-") as temporary:
            yield Path(temporary)
    else:
        yield Path(work)
