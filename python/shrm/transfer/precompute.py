"""The door of matrix radiance transfer: from a mesh and a material to an object with transfer [LK03]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from shrm.brdf import BRDF
from shrm.files import PathLike
from shrm.transfer.matrices.product import Route
from shrm.transfer.object import RadianceTransfer
from shrm.transfer.precomputation import MeshLike, Precomputation, Progress


def precompute(
    mesh: MeshLike,
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
    route: Route | None = None,
    K: int | None = None,
    clusters: int | None = None,
    half: bool = True,
    matrices: bool = False,
    work: PathLike | None = None,
    progress: Progress | None = None,
) -> RadianceTransfer:
    """Precompute how an object reflects the light around it, shadows and interreflections included.

    Parameters
    ----------
    mesh : shrm.render.Mesh, trimesh.Trimesh or alike
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
        Relative SNR of outgoing radiance in dB, in [0, 60], that tents and the route are chosen for, against
        rays; and then, against their matrices, up to 512 components: both together have some 3 dB less. Both
        are measured (`report`). Components whose number is given by K or clusters have what they have.
    M : int, optional
        Tents along a side, instead of choosing.
    route : shrm.transfer.Route, optional
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
    return Precomputation(
        mesh=mesh,
        brdf=brdf,
        shares=shares,
        tangents=tangents,
        n=n,
        directions=directions,
        variants=variants,
        bounces=bounces,
        albedo=albedo,
        accuracy=accuracy,
        M=M,
        route=route,
        K=K,
        clusters=clusters,
        half=half,
        matrices=matrices,
        work=work,
        progress=progress,
    ).run()
