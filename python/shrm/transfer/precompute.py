"""The door of matrix radiance transfer: from a mesh and a material to an object with transfer [LK03]."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from shrm.brdf import BRDF
from shrm.files import PathLike
from shrm.transfer.matrices.product import Route
from shrm.transfer.precomputation import MeshLike, Precomputation, Progress
from shrm.transfer.radiance_transfer import RadianceTransfer


def precompute(
    mesh: MeshLike,
    brdf: BRDF | Sequence[BRDF],
    *,
    shares: npt.ArrayLike | None = None,
    tangents: npt.ArrayLike | None = None,
    order: int = 5,
    directions: int = 4096,
    variants: Sequence[str] = ("unshadowed", "shadowed"),
    bounces: int | None = None,
    albedo: npt.ArrayLike | None = None,
    accuracy: float = 24.0,
    tents: int | None = None,
    route: Route | None = None,
    components: int | None = None,
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
        How much of each of several materials is at each vertex, 0 to 10^6: a material for each vertex, or
        blends, at no cost at run time. Those of a texture are `shrm.render.Mesh.texture_at_vertices`.
    tangents : (V, 3) array_like, optional
        Tangents at the vertices, for anisotropic materials; by default around the vertical.
    order : int
        Order n of the light, degrees 0 to n - 1, in [1, 10].
    directions : int
        Directions over a sphere, in [16, 65536]; a ray is cast from each vertex along half of them, those
        over its hemisphere.
    variants : sequence of {"unshadowed", "shadowed", "interreflected"}
        What is computed: light that nothing hides, that the object hides, and that its parts also send each
        other.
    bounces : int, optional
        Diffuse reflections of the object by itself, in [1, 1000], for "interreflected" alone; 1 if not given.
    albedo : float, (3,), (V,) or (V, 3) array_like, optional
        Albedo of those reflections, in [0, 1], for "interreflected" alone; by default the material's under
        uniform light.
    accuracy : float
        Relative SNR of outgoing radiance in dB, in [0, 60], that tents and the route are chosen for, against
        rays; and then components, up to 512, against uncompressed matrices: both together have some 3 dB
        less. Both SNRs are measured (`RadianceTransfer.report`). Where components or clusters are given, the
        SNR of the components is what they have.
    tents : int, optional
        Tents M along a side of the directional basis, in [2, 33], instead of choosing.
    route : shrm.transfer.Route, optional
        Expansions on the way from rays to tents, instead of choosing.
    components : int, optional
        Principal components K, instead of choosing; fewer where fewer are exact.
    clusters : int, optional
        Clusters of vertices with components of their own; `components` is then the number of each, 3 unless
        given.
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
        If an argument is not as described, or bounces or albedo are given without "interreflected".
    OSError
        If the folder cannot be written.
    """
    return Precomputation(
        mesh=mesh,
        brdf=brdf,
        shares=shares,
        tangents=tangents,
        order=order,
        directions=directions,
        variants=variants,
        bounces=bounces,
        albedo=albedo,
        accuracy=accuracy,
        tents=tents,
        route=route,
        components=components,
        clusters=clusters,
        half=half,
        matrices=matrices,
        work=work,
        progress=progress,
    ).run()
