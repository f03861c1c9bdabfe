"""Triangle meshes: files through trimesh, rays through Embree."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np

from shrm.arrays import Float32Array, FloatArray, IntArray
from shrm.environment.lookup import texture_lookup
from shrm.files import PathLike
from shrm.render.camera import Vector
from shrm.render.line_field import orthogonalised
from shrm.render.placement import Placement, about_vertical
from shrm.render.shapes import Hits
from shrm.render.tangents import Tangents, principal_tangents, uv_tangents
from shrm.transfer.precomputation import MeshLike
from shrm.validation import indices, one_of, real_array
from shrm.vectors import unit


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh, two-sided, with normals interpolated between its vertices.

    Parameters
    ----------
    vertices : (n, 3) array_like
    faces : (k, 3) array_like of int
        Indices into vertices, k > 0.
    normals : (n, 3) array_like, optional
        Unit normals of the vertices. Without them they are computed: the faces' normals, weighted
        by area, summed over all vertices at one place, so that texture seams do not show.
    uv : (n, 2) array_like, optional
        Texture coordinates of the vertices, v upwards; zero without them.
    tangents : (k, 3, 3) array_like, optional
        Unit tangents at the corners of the faces, see `with_tangents`; without them they run around the
        object's axis. Their signs mean nothing, but agree within a face.
    name : str
        What errors call it: its file.

    Attributes
    ----------
    vertices, faces, normals, uv, tangents : arrays of float64 and int64
        The parameters, where they are given.
    vertex_normals : (n, 3) float64
        The given normals or the computed ones.

    Raises
    ------
    TypeError, ValueError
        If an array has another shape or values that are not finite, or a face has no such vertex.
    """

    vertices: FloatArray
    faces: IntArray
    normals: FloatArray | None = None
    uv: FloatArray | None = None
    tangents: FloatArray | None = None
    name: str = "the mesh"

    def __post_init__(self) -> None:
        vertices = real_array("vertices", self.vertices, ("n", 3))
        n = len(vertices)
        faces = indices("faces", self.faces, n, ("k", 3), empty=False)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces.astype(np.int64))
        shapes = {"normals": (n, 3), "uv": (n, 2), "tangents": (len(faces), 3, 3)}
        for name, shape in shapes.items():
            if getattr(self, name) is not None:
                object.__setattr__(self, name, real_array(name, getattr(self, name), shape))

    def __repr__(self) -> str:
        """Say its name, how large it is, and what it has besides faces."""
        held = [name for name in ("normals", "uv", "tangents") if getattr(self, name) is not None]
        counts = f"{len(self.vertices)} vertices, {len(self.faces)} faces"
        return f"<Mesh {self.name!r}: {', '.join([counts, *held])}>"

    def __getstate__(self) -> dict[str, Any]:
        """Return what a pickle holds: all but Embree's scene, which is built again."""
        return {name: value for name, value in self.__dict__.items() if name != "_scene"}

    @classmethod
    def from_trimesh(cls, mesh: MeshLike) -> Mesh:
        """Take a `trimesh.Trimesh`, or any object with these arrays, as `shrm.transfer.precompute` does.

        Parameters
        ----------
        mesh : trimesh.Trimesh or alike
            Its `vertices` (n, 3), `faces` (k, 3), `vertex_normals` (n, 3) and, if there are any, texture
            coordinates (n, 2), from `uv` or, as trimesh has them, from `visual.uv`. World frame, z up:
            nothing is turned.

        Raises
        ------
        TypeError, ValueError
            If it has no such arrays.
        """
        for name in ("vertices", "faces", "vertex_normals"):
            if not hasattr(mesh, name):
                raise TypeError(
                    f"mesh must have vertices, faces and vertex_normals, got {type(mesh).__name__}"
                )
        uv = getattr(mesh, "uv", None)
        if uv is None:
            uv = getattr(getattr(mesh, "visual", None), "uv", None)
        vertices, faces, normals = (np.asarray(x) for x in (mesh.vertices, mesh.faces, mesh.vertex_normals))
        return cls(vertices, faces, normals, uv)

    @classmethod
    def read(cls, path: PathLike, up: Literal["y", "z"] = "y") -> Mesh:
        """Read a mesh file through trimesh: OBJ, PLY, STL, OFF, glTF.

        Parameters
        ----------
        path : path
        up : "y" or "z"
            The file's upward axis. Most files have y up and are looked at along -z; here the world
            has z up and the default camera looks along +x: (x, y, z) here = (-Z, -X, Y) there.

        Raises
        ------
        OSError
            If there is no such file.
        ValueError
            If the file is not a mesh that trimesh can read.
        """
        one_of("up", up, ("y", "z"))
        with open(path, "rb"):  # missing or unreadable: an OSError that names the file
            pass
        try:
            vertices, faces, normals, uv = _gather(path)
            axes = np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]]) if up == "y" else np.eye(3)
            normals = None if normals is None else normals @ axes.T
            return cls(vertices @ axes.T, faces, normals, uv, name=str(path))
        except Exception as fault:  # trimesh's loaders raise whatever a broken file makes them raise
            raise ValueError(f"{path}: not a mesh that can be read ({_one_line(fault)})") from None

    def placed(self, center: Vector = (0.0, 0.0, 0.0), radius: float = 1.0, turn: float = 0.0) -> Mesh:
        """Return the mesh turned about the vertical, then moved and scaled into a cube.

        Parameters
        ----------
        center : 3 floats
        radius : float
            Half the cube's side, which the longest side of the mesh's bounding box fills.
        turn : float
            Degrees from +x towards +y.
        """
        return self.moved(self.placement(center, radius, turn))

    def placement(
        self, center: Vector = (0.0, 0.0, 0.0), radius: float = 1.0, turn: float = 0.0
    ) -> Placement:
        """Return how `placed` moves the mesh."""
        R = about_vertical(turn)
        turned = self.vertices @ R.T
        low, high = turned.min(axis=0), turned.max(axis=0)
        scale = 2.0 * radius / (float((high - low).max()) or 1.0)
        return Placement(R, scale, np.asarray(center) - scale * 0.5 * (low + high))

    def moved(self, placement: Placement) -> Mesh:
        """Return the mesh as it stands by a placement."""
        R = placement.R
        return replace(
            self,
            vertices=placement.world_from_object(self.vertices),
            normals=None if self.normals is None else self.normals @ R.T,
            tangents=None if self.tangents is None else self.tangents @ R.T,
        )

    def with_tangents(self, field: Tangents) -> Mesh:
        """Return the mesh with a tangent field, for materials about the tangent such as `shrm.brdf.Banks`.

        Parameters
        ----------
        field : {"axis", "uv", "principal"}
            Around the object's axis; along dP/du of the texture coordinates
            (`shrm.render.tangents.uv_tangents`); or along the direction of the larger |curvature|
            (`shrm.render.tangents.principal_tangents`). Where the last two are not defined, tangents run
            around the vertical.

        Raises
        ------
        ValueError
            If the field is another word, or "uv" and the mesh has no texture coordinates.
        """
        one_of("tangents", field, get_args(Tangents))
        if field == "axis":
            return replace(self, tangents=None)
        if field == "principal":
            return replace(self, tangents=principal_tangents(self.vertices, self.faces, self.vertex_normals))
        if self.uv is None:
            raise ValueError(f"{self.name}: no texture coordinates: take axis or principal tangents")
        return replace(self, tangents=uv_tangents(self.vertices, self.faces, self.vertex_normals, self.uv))

    @cached_property
    def vertex_normals(self) -> FloatArray:
        """The given normals or the computed ones, (n, 3) float64; zero where nothing defines one."""
        if self.normals is not None:
            return unit(self.normals)
        _, place = np.unique(self.vertices, axis=0, return_inverse=True)
        place = place.reshape(-1)
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        area_normals = np.cross(b - a, c - a)  # a degenerate face adds nothing
        sums = np.zeros((place.max() + 1, 3))
        for k in range(3):
            np.add.at(sums, place[self.faces[:, k]], area_normals)
        return unit(sums[place])

    @cached_property
    def ball(self) -> tuple[FloatArray, float]:
        """Center (3,) of the bounding box, and radius of the ball about it that holds all vertices."""
        center = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        return center, float(np.linalg.norm(self.vertices - center, axis=1).max())

    def texture_at_vertices(self, texture: Float32Array) -> Float32Array:
        """Return a texture (H, W, C) at the vertices, (n, C): see `shrm.environment.lookup.texture_lookup`.

        Raises
        ------
        ValueError
            If the mesh has no texture coordinates.
        """
        if self.uv is None:
            raise ValueError(f"{self.name}: it has no texture coordinates")
        return texture_lookup(texture, self.uv)

    @cached_property
    def vertex_tangents(self) -> FloatArray | None:
        """Mean tangents (n, 3) at vertices, of any length; None without a field of its own."""
        if self.tangents is None:
            return None
        corners, lines = self.faces.ravel(), self.tangents.reshape(-1, 3)
        # Signs mean nothing: those of a vertex are summed as they agree with its first one
        first = np.zeros((len(self.vertices), 3))
        first[corners[::-1]] = lines[::-1]
        agree = np.where(np.einsum("nx,nx->n", lines, first[corners]) < 0.0, -1.0, 1.0)
        sums = np.zeros_like(first)
        np.add.at(sums, corners, agree[:, None] * lines)
        return sums

    @cached_property
    def _scene(self) -> Any:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        scene = EmbreeScene()
        TriangleMesh(scene, np.ascontiguousarray(self.vertices[self.faces], np.float32))
        return scene

    def intersect(self, origins: FloatArray, directions: FloatArray) -> Hits:
        """First hits of rays with (n, 3) origins and unit directions; Embree works in float32."""
        hits = self._scene.run(
            np.ascontiguousarray(origins, np.float32),
            np.ascontiguousarray(directions, np.float32),
            output=True,
        )
        hit = hits["primID"] >= 0
        distances = np.where(hit, hits["tfar"].astype(np.float64), np.inf)

        face = np.where(hit, hits["primID"], 0)
        corners = self.faces[face]  # (n, 3)
        u, v = hits["u"].astype(np.float64), hits["v"].astype(np.float64)
        weights = np.where(hit[:, None], np.stack([1.0 - u - v, u, v], axis=1), 0.0)
        a, b, c = (self.vertices[corners[:, k]] for k in range(3))
        flat = unit(np.cross(b - a, c - a))
        smooth = unit(np.einsum("nk,nkx->nx", weights, self.vertex_normals[corners]))
        for spare in (flat, -directions):  # vertices, or a whole face, that define no normal
            smooth = np.where(smooth.any(axis=1, keepdims=True), smooth, spare)
        # The side is the face's, not the interpolated normal's, which may tip over at silhouettes.
        flat *= np.where(np.einsum("nk,nk->n", flat, smooth) < 0.0, -1.0, 1.0)[:, None]
        behind = np.einsum("nk,nk->n", flat, directions) > 0.0
        normals = np.where(behind[:, None], -smooth, smooth)

        uv, tangents = np.zeros((len(distances), 2)), None
        if self.uv is not None:
            uv = np.einsum("nk,nkx->nx", weights, self.uv[corners])
        if self.tangents is not None:
            interpolated = np.einsum("nk,nkx->nx", weights, self.tangents[face])
            tangents = orthogonalised(interpolated, normals)
        return Hits(distances, normals, uv, tangents, corners, weights)


def _gather(
    path: PathLike,
) -> tuple[FloatArray, IntArray, FloatArray | None, FloatArray | None]:
    """Vertices, faces, normals (if every part has them) and uv (if any has) of all meshes in a file."""
    import trimesh

    scene: Any = trimesh.load_scene(os.fspath(path), process=False)
    vertices, faces, normals, uv = [], [], [], []
    count = 0
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        part = scene.geometry[name]
        if not isinstance(part, trimesh.Trimesh):
            continue
        vertices.append(np.asarray(part.vertices, np.float64) @ place[:3, :3].T + place[:3, 3])
        faces.append(np.asarray(part.faces, np.int64) + count)
        count += len(part.vertices)
        if "vertex_normals" in part._cache:  # the file's own; the property would compute some
            normals.append(np.asarray(part.vertex_normals, np.float64) @ np.linalg.inv(place[:3, :3]))
        part_uv = getattr(part.visual, "uv", None)
        uv.append(np.zeros((len(part.vertices), 2)) if part_uv is None else np.asarray(part_uv)[:, :2])
    if not vertices:
        raise ValueError("it has no triangles")
    return (
        np.concatenate(vertices),
        np.concatenate(faces),
        unit(np.concatenate(normals)) if len(normals) == len(vertices) else None,
        np.concatenate(uv) if any(part.any() for part in uv) else None,
    )


def _one_line(fault: Exception) -> str:
    text = " ".join(str(fault).split())
    return text[:120] or type(fault).__name__
