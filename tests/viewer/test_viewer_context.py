"""Contexts of EGL, OSMesa and windows, one after another and by turns in one process."""

import ctypes
import threading
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from shrm import Environment, ReflectionMap, brdf, prefilter
from shrm.render import Camera, Object, Sphere
from shrm.viewer import Context, ContextError, Renderer, Scene
from shrm.viewer.gpu.context import ROUTES, Route, leave
from support import opengl
from support.window_driver import SHAPE, Opened, glfw, same

CAMERA = Camera((4.0, 2.0, 1.5), fov=32.0)
Make = Callable[[Route], Context]


@pytest.fixture
def made(screen: None) -> Iterator[Make]:
    """Make contexts, which are released afterwards; see `support.machine.require`."""
    contexts = []

    def make(route: Route) -> Context:
        contexts.append(opengl.context(route))
        return contexts[-1]

    yield make
    for context in contexts:
        context.release()


@pytest.fixture(scope="module")
def scene() -> Scene:
    env = Environment.daylight(size=32)
    rm: ReflectionMap = prefilter(env, brdf.GGX(0.4), orders=(6, 2), size=16, layout="cube")
    return Scene([Object(Sphere(), rm)], CAMERA, env)


def current() -> set[str]:
    """Whose contexts are current in this thread, by their own libraries."""
    asked = {"libEGL.so.1": "eglGetCurrentContext", "libGL.so.1": "glXGetCurrentContext"}
    asked |= {"libOSMesa.so.8": "OSMesaGetCurrentContext", "libOSMesa.so.6": "OSMesaGetCurrentContext"}
    found = set()
    for name, function in asked.items():
        try:
            library = ctypes.CDLL(name)
        except OSError:
            continue
        get = getattr(library, function)
        get.restype = ctypes.c_void_p
        if get():
            found.add(name)
    return found


@pytest.mark.parametrize("route", ROUTES)
def test_a_window_opens_while_another_context_is_current(made: Make, opened: Opened, route: Route) -> None:
    made(route).activate()
    hands = opened()
    assert hands.look().shape == (SHAPE[0], 200, 3)


@pytest.mark.parametrize("route", ROUTES)
def test_contexts_draw_by_turns_what_they_drew_before(
    made: Make, opened: Opened, scene: Scene, route: Route
) -> None:
    renderer = Renderer((48, 48), context=made(route))
    picture = renderer.render(scene)
    hands = opened()
    shown = hands.look()
    in_window = Renderer((48, 48), context=hands.app.context)
    picture_in_window = in_window.render(scene)
    for _ in range(3):
        np.testing.assert_array_equal(renderer.render(scene).radiance, picture.radiance)
        assert renderer.gl.error == "GL_NO_ERROR"
        np.testing.assert_array_equal(in_window.render(scene).radiance, picture_in_window.radiance)
        assert same(hands.look(), shown)
        assert hands.app.context.gl.error == "GL_NO_ERROR"
    in_window.release()
    hands.app.close()
    np.testing.assert_array_equal(renderer.render(scene).radiance, picture.radiance)


def test_a_renderer_is_made_in_the_context_it_is_given(made: Make, scene: Scene) -> None:
    first, second = made("egl"), made("window")
    second.activate()
    Renderer((8, 8), context=first).render(scene)
    assert first.gl.error == "GL_NO_ERROR"


@pytest.mark.parametrize("route", ROUTES)
def test_nothing_is_current_after_leaving_and_after_a_release(made: Make, route: Route) -> None:
    context = made(route)
    assert current()
    leave()
    assert not current()
    context.activate()
    assert current()
    context.release()
    assert not current()
    context.release()
    with pytest.raises(ContextError, match=rf"^the OpenGL context \({route}\) was released: .*$"):
        context.activate()


def test_releasing_one_leaves_another_current(made: Make) -> None:
    first, second = made("egl"), made("window")
    first.release()
    assert bool(glfw.get_current_context())
    second.release()
    assert not current()


def test_a_released_renderer_says_so(made: Make, scene: Scene) -> None:
    own = Renderer((8, 8))
    own.render(scene)
    own.release()
    assert not current()
    assert own.context.released
    given = Renderer((8, 8), context=made("egl"))
    given.release()
    assert not given.context.released
    given.context.activate()
    for renderer in (own, given):
        with pytest.raises(ContextError, match=r"^the renderer was released: it cannot draw any more$"):
            renderer.render(scene)
        renderer.release()


def test_a_renderer_without_its_context_is_released_quietly(made: Make, scene: Scene) -> None:
    renderer = Renderer((8, 8), context=made("egl"))
    renderer.context.release()
    with pytest.raises(ContextError, match="context"):
        renderer.render(scene)
    renderer.release()


def test_a_closed_window_leaves_nothing_current(opened: Opened) -> None:
    opened().app.close()
    assert not current()


def test_a_context_that_another_thread_holds_is_refused(made: Make, scene: Scene) -> None:
    renderer = Renderer((24, 24), context=made("egl"))
    before = renderer.render(scene).radiance
    faults: list[ContextError] = []

    def draw() -> None:
        try:
            renderer.render(scene)
        except ContextError as fault:
            faults.append(fault)

    thread = threading.Thread(target=draw)
    thread.start()
    thread.join()
    assert len(faults) == 1
    assert "cannot be made current" in str(faults[0])
    np.testing.assert_array_equal(renderer.render(scene).radiance, before)


@pytest.mark.parametrize("route", ROUTES)
def test_what_was_released_elsewhere_is_let_go(made: Make, scene: Scene, route: Route) -> None:
    renderer, other = (Renderer((24, 24), context=made(route)) for _ in range(2))
    before = other.render(scene).radiance
    renderer.render(scene)
    renderer.context.gl.release()
    np.testing.assert_array_equal(other.render(scene).radiance, before)


def test_a_renderer_is_released_at_the_end_of_a_block(scene: Scene) -> None:
    with Renderer((8, 8)) as renderer:
        renderer.render(scene)
    with pytest.raises(ContextError, match="released"):
        renderer.render(scene)
