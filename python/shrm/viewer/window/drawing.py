"""The picture of a state: what its objects are drawn with, sample by sample."""

from __future__ import annotations

from dataclasses import replace

from shrm.files import one_line
from shrm.render.camera import Camera
from shrm.render.picture import Object
from shrm.render.vertex_radiance import VertexRadiance
from shrm.viewer.gpu.geometry import bounds
from shrm.viewer.gpu.renderer import Drawn, Renderer
from shrm.viewer.gpu.scene import Scene
from shrm.viewer.window.filtered import FilteredMaterials
from shrm.viewer.window.orbit import Orbit
from shrm.viewer.window.prefiltering import PrefilteredScene
from shrm.viewer.window.relit import RelitObject
from shrm.viewer.window.screen import Screen
from shrm.viewer.window.state import State

Faults = (OSError, ValueError, TypeError, RuntimeError, MemoryError)

Materials = tuple[Drawn, ...] | tuple[VertexRadiance]


class Drawing:
    """Draws what there is of a state's objects, further samples of it while nothing changes.

    Parameters
    ----------
    renderer : Renderer
    screen : Screen

    Attributes
    ----------
    relit : RelitObject
    filtered : FilteredMaterials
    seen : tuple
        Equal as long as the picture that is drawn is the same but for its samples.
    sampled : bool
        Whether the last call drew a sample.
    fault : str
        Why its picture is not as the state had it; empty if it is.
    """

    def __init__(self, renderer: Renderer, screen: Screen) -> None:
        self._renderer, self._screen = renderer, screen
        self.relit, self.filtered = RelitObject(), FilteredMaterials(renderer.context)
        self.seen: tuple[object, ...] = ()
        self.sampled, self.fault = False, ""

    def sample(self, result: PrefilteredScene, state: State, shape: tuple[int, int], fit: bool) -> State:
        """Draw a sample if the picture has not all of them.

        Parameters
        ----------
        result : PrefilteredScene
        state : State
        shape : (H, W)
            Rows and columns of the picture.
        fit : bool
            Whether the eye goes where all objects are in the picture, as it does if the state has none.

        Returns
        -------
        State
            With its eye, and with what could be drawn in place of what could not.
        """
        screen = self._screen
        screen.resize(shape)
        self.sampled, self.fault = False, ""
        eye = state.eye
        if fit or eye is None:
            eye = (eye or Orbit()).fitted([bounds(shape) for shape in result.shapes], shape[1] / shape[0])
            state = replace(state, eye=eye)
        background = result.environment if state.background else None
        light = result.request.light if result.transferred is None else state.light
        state, drawn = self._lit(result, state, eye.camera)
        if not drawn:
            return state
        objects = drawn, result.request.filter, result.shapes
        decides = *objects, light, eye, state.viewer, shape, background
        if decides != self.seen:
            self.seen, screen.samples = decides, 0
        if screen.complete:
            return state
        state, materials = self._filtered(result, state, drawn)
        scene = Scene(
            [Object(*pair) for pair in zip(result.shapes, materials, strict=True)],
            eye.camera,
            background,
            state.viewer,
            replace(state, light=light).R,
        )
        try:
            self._renderer.draw(scene, screen.drawn, screen.shift)
        except ValueError as fault:  # more maps than textures have layers
            if state.viewer == "distant":
                raise
            self.fault, state = one_line(fault), replace(state, viewer="distant")
        self._renderer.resources.end_frame()
        screen.add_sample()
        self.sampled = True
        return state

    def _lit(self, result: PrefilteredScene, state: State, camera: Camera) -> tuple[State, Materials]:
        """Return the maps; or the radiance at the vertices of an object with transfer, none if it fails."""
        placed = result.transferred
        if placed is None:
            return state, result.drawn
        try:
            return state, (self.relit.drawn_with(placed, result.environment, state, camera),)
        except Faults as fault:
            self.fault = one_line(fault)
            return replace(state, variant=None, components=None, tents=None), ()

    def _filtered(self, result: PrefilteredScene, state: State, drawn: Materials) -> tuple[State, Materials]:
        """Return the materials, or what the GPU filters instead if the state names a filter."""
        if result.transferred is not None:
            return state, drawn
        try:
            return state, self.filtered.drawn_with(result)
        except Faults as fault:
            self.fault = one_line(fault)
            return replace(state, technique="shrm", filter=None), drawn
