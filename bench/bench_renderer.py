"""The renderer on whatever OpenGL there is: whole frames, and what of them is ours."""

from collections.abc import Callable
from typing import Any

import moderngl
import numpy as np
import pytest
from inputs import TURN
from shrm import Environment, Prefilter, ReflectionMap, brdf
from shrm.render import Camera, Object, Sphere, render, row_camera
from shrm.viewer import ContextError, Renderer, Scene
from shrm.viewer.gpu.maps import LobeMaps
from shrm_papers.errors import relative_rms

Measured = Callable[..., Any]

F, P, N, SIZE = 24, 3, 64, 512


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    try:
        return Renderer((SIZE, SIZE))
    except ContextError as fault:
        pytest.skip(str(fault))


@pytest.fixture(scope="module")
def relit() -> Prefilter:
    env = Environment.daylight(size=512)
    return Prefilter(env, brdf.GGX(0.3), orders=(F, P), size=N, layout="cube")


def float_target(renderer: Renderer) -> moderngl.Framebuffer:
    """A picture of the renderer's size to draw into."""
    gl, size = renderer.gl, renderer.shape[::-1]
    return gl.framebuffer([gl.texture(size, 4, dtype="f4")], gl.depth_renderbuffer(size))


def name(renderer: Renderer) -> str:
    """The driver, less what is in brackets."""
    return str(renderer.gl.info["GL_RENDERER"]).split(" (")[0]


@pytest.mark.benchmark(group="renderer")
def bench_dynamic_map(measured: Measured, renderer: Renderer, relit: Prefilter) -> None:
    """[RH02 section 7.5]: what a frame takes beside the driver's work, the sum of eq. 12 and its upload."""
    (part,) = relit.map.parts
    lobe, view = LobeMaps(renderer.gl, part, N), np.array([[0.48, 0.6, 0.64]])

    def frame() -> LobeMaps:
        lobe.dynamic(view)
        return lobe

    def error(lobe: LobeMaps) -> float:
        faces = [np.frombuffer(lobe.dynamic(view).read(face), np.float32) for face in range(6)]
        return relative_rms(np.concatenate(faces), relit.map.at_view(view[0]).ravel())  # type: ignore[union-attr]

    measured(frame, error, f"sum for a view and upload, 6 x {N} x {N}, P = {P}, {name(renderer)}")


@pytest.mark.benchmark(group="renderer")
@pytest.mark.parametrize("viewer", ["distant", "near"])
@pytest.mark.parametrize("count", [1, 3])
def bench_frame(measured: Measured, renderer: Renderer, relit: Prefilter, viewer: Any, count: int) -> None:
    """A frame with its background, up to and without reading it back."""
    camera, centers = row_camera(count, 1.0)
    env = Environment.daylight(size=512)
    objects = [Object(Sphere(center), relit.map) for center in centers]
    scene = Scene(objects, camera, env, viewer)
    target = float_target(renderer)

    def frame() -> None:
        renderer.draw(scene, target)
        renderer.gl.finish()

    def error(_: None) -> float:
        expected = render(objects, camera, (SIZE, SIZE), background=env, viewer=viewer, samples=1)
        found = renderer.render(scene)
        seen = (found.coverage == 1) & (expected.coverage == 1)
        return relative_rms(found.radiance[seen], expected.radiance[seen])

    method = "one dynamic map" if viewer == "distant" else f"{(P + 1) ** 2} maps a pixel"
    plural = "s" if count > 1 else ""
    measured(frame, error, f"frame, {count} sphere{plural}, {method}, {SIZE} x {SIZE}, {name(renderer)}")


@pytest.mark.benchmark(group="renderer")
def bench_dragged_light(measured: Measured, renderer: Renderer, relit: Prefilter) -> None:
    """Light that turns: coefficients rotated, maps made anew, and all of a frame of 16 x 16 pixels."""
    small = Renderer((16, 16), context=renderer.context)
    camera, target = Camera((5.0, 0.0, 1.0)), float_target(small)
    again = Prefilter(Environment.daylight(size=512), brdf.GGX(0.3), orders=(F, P), size=N, layout="cube")

    def frame() -> ReflectionMap:
        rm = again.update(rotation=TURN)
        small.draw(Scene([Object(Sphere(), rm)], camera, None, "distant"), target)
        small.gl.finish()
        return rm

    def error(rm: ReflectionMap) -> float:
        view = camera.forward
        return relative_rms(rm.at_view(view), relit.update(rotation=TURN).at_view(view))

    measured(frame, error, f"light turned, F = {F}, P = {P}, 6 x {N} x {N}, and a frame, {name(renderer)}")
