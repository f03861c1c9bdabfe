"""From what is asked for to reflection maps: the work that the window does not wait for."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np

from shrm import brdf
from shrm.arrays import FloatArray
from shrm.environment import Environment
from shrm.frequency.orders import ToleranceWarning, choose
from shrm.frequency.reflection_map import ReflectionMap
from shrm.frequency.relight import Prefilter
from shrm.prefiltered import Prefiltered
from shrm.prefiltered import Technique as EarlierTechnique
from shrm.prefiltered.explicit import without_azimuth
from shrm.render.mesh import Mesh
from shrm.render.row import SUN_AZIMUTH, row_camera
from shrm.render.shapes import Shape, Sphere
from shrm.render.tangents import Tangents
from shrm.render.transferred import TransferredMesh
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.viewer.window.state import UNTURNED, Filter, Rows, State, Technique, Up
from shrm.viewer.window.worker import StaleError

TechniqueMaps = ReflectionMap | Prefiltered


def _layered(rm: ReflectionMap, material: brdf.BRDF, technique: EarlierTechnique) -> TechniqueMaps:
    """Return the maps of an earlier technique for the light of a reflection map."""
    return Prefiltered.from_reflection_map(rm, material, technique=technique)


TECHNIQUES: Mapping[Technique, Callable[[ReflectionMap, brdf.BRDF], TechniqueMaps]] = {
    "shrm": lambda rm, _: rm,
    "kautz-mccool-3d": lambda rm, _: without_azimuth(rm),
    "kautz-mccool-2d": partial(_layered, technique="kautz-mccool-2d"),
    "miller-heidrich": partial(_layered, technique="miller-heidrich"),
    "cabral": partial(_layered, technique="cabral"),
}
"""How maps of each class are made of a reflection map and its material."""

DAYLIGHT = "daylight"

# The orders that a tolerance may take: more than these cannot be summed in every pixel in real time.
F_MAX, P_MAX = 60, 6

# Edges of the cubes' faces, up to a degree: hardware interpolates linearly, which needs finer maps than
# the cubic look-ups that `shrm.prefilter` chooses its size for.
SIZES = ((12, 32), (30, 64), (70, 128), (1000, 256))


@dataclass(frozen=True)
class Request:
    """The part of a `State` that decides the maps and the objects."""

    environment: str
    layout: str | None
    border: int | None
    repair: bool
    materials: tuple[str, ...]
    mesh: str | None
    up: Up
    tangents: Tangents
    tolerance: float
    orders: tuple[int, int] | None
    technique: Technique
    filter: Filter | None
    light: Rows
    transfer: str | None

    @classmethod
    def of(cls, state: State) -> Request:
        """Return what a state asks for. An object with transfer is lit where it is drawn, under any light."""
        request = cls(**{item.name: getattr(state, item.name) for item in fields(cls)})
        return request if state.transfer is None else replace(request, light=UNTURNED)


@dataclass(frozen=True, eq=False)
class PrefilteredScene:
    """The answer to a request.

    Attributes
    ----------
    request : Request
    environment : Environment
        Not turned.
    shapes : tuple of shapes
        Spheres, or copies of the mesh, in a row.
    maps : tuple of ReflectionMap
        One for each material, of the turned light. Nothing writes to them any more.
    drawn : tuple of ReflectionMap or shrm.prefiltered.Prefiltered
        What the technique makes of them; the same maps where the GPU filters others in their place.
    seconds : float
        What the maps took, files not counted.
    errors : tuple of float, or None
        Predicted for each material; None while they are not known.
    notes : tuple of str
        What was changed of the files as they were read.
    transferred : TransferredMesh, optional
        An object with transfer, the only one, without any maps.
    """

    request: Request
    environment: Environment
    shapes: tuple[Shape, ...]
    maps: tuple[ReflectionMap, ...]
    drawn: tuple[TechniqueMaps, ...]
    seconds: float
    errors: tuple[float, ...] | None
    notes: tuple[str, ...]
    transferred: TransferredMesh | None = None

    @property
    def placing(self) -> tuple[object, ...]:
        """What the positions of the objects depend on."""
        return self.request.mesh, self.request.up, self.request.transfer, len(self.shapes)

    @property
    def source(self) -> tuple[object, ...]:
        """What the exposure depends on."""
        return self.environment, self.request.materials, self.shapes


class Prefiltering:
    """Answers requests in one thread, and keeps what the next one may need again."""

    def __init__(self) -> None:
        self._environment: (
            tuple[tuple[str, str | None, int | None, bool], Environment, tuple[str, ...]] | None
        ) = None
        self._mesh: tuple[tuple[str, Up], Mesh] | None = None
        self._tangent_mesh: tuple[tuple[Mesh, Tangents], Mesh] | None = None
        self._shapes: tuple[tuple[Mesh | None, int], tuple[Shape, ...]] | None = None
        self._objects: list[_ObjectMaps] = []
        self._transferred: tuple[str, TransferredMesh] | None = None

    def __call__(self, request: Request, stale: Callable[[], bool]) -> Iterator[PrefilteredScene]:
        """Yield the maps, then the same with the errors predicted; or an object with transfer.

        Raises
        ------
        OSError, ValueError, MemoryError
            If a file cannot be read, a material's text is none, or the orders take too much memory.
        StaleError
            If there is a newer request.
        """
        if request.transfer is not None:
            environment, notes = self._read_environment(request)
            placed = self._open_transfer(request.transfer)
            yield PrefilteredScene(request, environment, (placed.mesh,), (), (), 0.0, (), notes, placed)
            return
        # A wrong one is a fault before anything is changed.
        lobes = [lobe for text in request.materials for lobe in brdf.parse(text).lobes]
        tangents = request.tangents if any(lobe.center == "tangent" for lobe in lobes) else "axis"
        environment, notes = self._read_environment(request)
        shapes = self._row(request, tangents)
        start = time.perf_counter()
        R = np.asarray(request.light, np.float64)
        del self._objects[len(request.materials) :]
        maps, drawn = [], []
        for index, text in enumerate(request.materials):
            if stale():
                raise StaleError
            if index == len(self._objects):
                self._objects.append(_ObjectMaps())
            of_object = self._objects[index]
            maps.append(of_object.relit(environment, text, request, R))
            drawn.append(of_object.drawn_by(request.technique if request.filter is None else "shrm"))
        seconds = time.perf_counter() - start
        known = [each.error for each in self._objects]
        answer = PrefilteredScene(
            request, environment, shapes, tuple(maps), tuple(drawn), seconds, None, notes
        )
        if None not in known:
            yield replace(answer, errors=tuple(e for e in known if e is not None))
            return
        yield answer
        yield replace(answer, errors=tuple(each.predicted() for each in self._objects))

    def _read_environment(self, request: Request) -> tuple[Environment, tuple[str, ...]]:
        key = request.environment, request.layout, request.border, request.repair
        if self._environment is None or self._environment[0] != key:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                if request.environment == DAYLIGHT:
                    environment = Environment.daylight(sun_azimuth=SUN_AZIMUTH)
                else:
                    environment = Environment.read(
                        request.environment,
                        layout=request.layout,
                        repair=request.repair,
                        border=request.border,
                    )
            notes = tuple(dict.fromkeys(" ".join(str(item.message).split()) for item in caught))
            self._environment = key, environment, notes
        return self._environment[1:]

    def _open_transfer(self, path: str) -> TransferredMesh:
        if self._transferred is None or self._transferred[0] != path:
            self._transferred = path, TransferredMesh.placed(RadianceTransfer.load(path))
        return self._transferred[1]

    def _row(self, request: Request, tangents: Tangents) -> tuple[Shape, ...]:
        """Stand the objects in a row; the same ones as long as mesh, tangents and number are the same."""
        mesh, count = self._read_mesh(request), len(request.materials)
        if mesh is not None and tangents != "axis":
            mesh = self._with_tangents(mesh, tangents)
        if self._shapes is None or self._shapes[0] != (mesh, count):
            _, centers = row_camera(count, 1.0)
            shapes: tuple[Shape, ...]
            if mesh is None:
                shapes = tuple(Sphere(center) for center in centers)
            else:
                meshes = tuple(mesh.placed(center) for center in centers)
                for placed in meshes:
                    _ = placed.vertex_normals  # found here, so that the window does not wait for them
                shapes = meshes
            self._shapes = (mesh, count), shapes
        return self._shapes[1]

    def _read_mesh(self, request: Request) -> Mesh | None:
        if request.mesh is None:
            return None
        key = request.mesh, request.up
        if self._mesh is None or self._mesh[0] != key:
            self._mesh = key, Mesh.read(request.mesh, up=request.up)
        return self._mesh[1]

    def _with_tangents(self, mesh: Mesh, tangents: Tangents) -> Mesh:
        if self._tangent_mesh is None or self._tangent_mesh[0] != (mesh, tangents):
            self._tangent_mesh = (mesh, tangents), mesh.with_tangents(tangents)
        return self._tangent_mesh[1]


class _ObjectMaps:
    """One object's maps, followed through changes of light and material."""

    def __init__(self) -> None:
        self._prefilter: Prefilter | None = None
        self._environment: Environment | None = None
        self._text = ""
        self._accuracy: object = None
        self._R: FloatArray = np.eye(3)
        # The map given away last, and what a technique has made of it
        self._map: ReflectionMap | None = None
        self._drawn: tuple[ReflectionMap, Technique, TechniqueMaps] | None = None
        self.error: float | None = None

    def relit(self, environment: Environment, text: str, request: Request, R: FloatArray) -> ReflectionMap:
        """Return maps of its own memory for a light turned by R."""
        accuracy = request.tolerance if request.orders is None else request.orders
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ToleranceWarning)  # the panel says it
            same_light = self._prefilter is not None and environment is self._environment
            same = same_light and accuracy == self._accuracy and text == self._text
            if self._map is not None and same and np.array_equal(R, self._R):
                return self._map
            if not same:
                self._renew(environment, brdf.parse(text), request, same_light and accuracy == self._accuracy)
                self.error = None
            assert self._prefilter is not None
            if not np.array_equal(R, self._R):
                self._prefilter.update(rotation=R)
        self._environment, self._text, self._accuracy, self._R = environment, text, accuracy, R
        relit = self._prefilter.map
        # The next update overwrites these maps, and the window may still draw them.
        parts = tuple(replace(part, rings=part.rings.copy()) for part in relit.parts)
        self._map = replace(relit, parts=parts)
        return self._map

    def drawn_by(self, technique: Technique) -> TechniqueMaps:
        """Return what a technique makes of the maps given away last."""
        assert self._map is not None
        if self._drawn is None or self._drawn[0] is not self._map or self._drawn[1] != technique:
            self._drawn = self._map, technique, TECHNIQUES[technique](self._map, brdf.parse(self._text))
        return self._drawn[2]

    def _renew(
        self, environment: Environment, material: brdf.BRDF, request: Request, only_material: bool
    ) -> None:
        """Follow a change of light, material or accuracy."""
        if only_material and request.orders is not None and self._prefilter is not None:
            try:
                self._prefilter.update(brdf=material)
                return
            except ValueError:  # lobes of another kind
                pass
        if request.orders is None:
            chosen = choose(environment, material, tolerance=request.tolerance, F_max=F_MAX, P_max=P_MAX)
            degree = chosen.F + chosen.P
        else:
            degree = sum(request.orders)
        self._prefilter = Prefilter(
            environment,
            material,
            tolerance=request.tolerance,
            orders=request.orders,
            size=next(size for largest, size in SIZES if degree <= largest or size == SIZES[-1][1]),
            layout="cube",
            F_max=F_MAX,
            P_max=P_MAX,
        )
        self._R = np.eye(3)

    def predicted(self) -> float:
        """Return the predicted error, which turning the light does not change."""
        if self.error is None:
            assert self._prefilter is not None
            self.error = self._prefilter.map.error
        return self.error
