"""The thread beside the window: the newest request wins, and what it answers stays as it is."""

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from shrm import Environment, Prefilter, brdf
from shrm.render import Mesh
from shrm.viewer.window.prefiltering import PrefilteredScene, Prefiltering, Request
from shrm.viewer.window.state import State
from shrm.viewer.window.worker import StaleError, Worker

SECONDS = 60.0


def taken(worker: Worker[int, int]) -> int:
    end = time.monotonic() + SECONDS
    while time.monotonic() < end:
        answer = worker.take()
        if answer is not None:
            return answer
        time.sleep(0.001)
    raise TimeoutError


def never() -> bool:
    return False


def test_stale_work_is_dropped_and_the_newest_request_answered() -> None:
    begun, go_on = threading.Event(), threading.Event()
    worked = []

    def work(request: int, stale: Callable[[], bool]) -> Iterator[int]:
        worked.append(request)
        if request == 0:
            begun.set()
            assert go_on.wait(SECONDS)
            if stale():
                raise StaleError
        yield 10 * request

    worker = Worker(work)
    worker.submit(0)
    assert begun.wait(SECONDS)
    for request in (1, 2, 3):
        worker.submit(request)
    go_on.set()
    assert taken(worker) == 30
    assert worker.take() is None
    worker.close()
    assert worked == [0, 3]
    assert (worker.answered, worker.dropped) == (1, 3)


def test_later_answers_of_stale_work_are_not_made() -> None:
    made = []

    def work(request: int, stale: Callable[[], bool]) -> Iterator[int]:
        for step in range(3):
            made.append((request, step))
            if request == 0 and step == 0:
                worker.submit(1)
            yield 10 * request + step

    worker = Worker(work)
    worker.submit(0)
    answer = -1
    while answer != 12:
        answer = taken(worker)
    worker.close()
    assert made == [(0, 0), (1, 0), (1, 1), (1, 2)]


def test_a_fault_is_raised_where_it_is_taken_and_the_thread_goes_on() -> None:
    def work(request: int, stale: Callable[[], bool]) -> Iterator[int]:
        if request == 0:
            raise ValueError("nought")
        yield request

    woken = threading.Event()
    worker = Worker(work, woken.set)
    worker.submit(0)
    assert woken.wait(SECONDS)
    with pytest.raises(ValueError, match="nought"):
        taken(worker)
    worker.submit(5)
    assert taken(worker) == 5
    worker.close()
    assert not worker.working


def asked(sky: Path, **changes: object) -> Request:
    return Request.of(State(environment=str(sky), **{"materials": ("ggx:0.4",), **changes}))  # type: ignore[arg-type]


def last(answers: Iterator[PrefilteredScene]) -> PrefilteredScene:
    return list(answers)[-1]


@pytest.mark.slow
@pytest.mark.parametrize("orders", [None, (8, 2)])
def test_maps_are_those_of_prefilter_and_no_later_request_writes_to_them(
    sky: Path, orders: tuple[int, int] | None
) -> None:
    R = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    prefiltering = Prefiltering()
    plain = last(prefiltering(asked(sky, orders=orders), never))
    kept = plain.maps[0].parts[0].rings.copy()
    state = State(environment=str(sky), materials=("ggx:0.4",), orders=orders).with_light(R)
    turned = last(prefiltering(Request.of(state), never))
    other = last(prefiltering(asked(sky, orders=orders, materials=("ggx:0.6",)), never))
    assert np.array_equal(plain.maps[0].parts[0].rings, kept)
    assert turned.environment is plain.environment
    assert turned.shapes is plain.shapes

    env = Environment.read(sky)
    mine = Prefilter(env, brdf.GGX(0.4), orders=(plain.maps[0].F, plain.maps[0].P), layout="cube", size=32)
    # A tolerance analyses more degrees of the material, and rounds otherwise.
    np.testing.assert_allclose(kept, mine.map.parts[0].rings, atol=1e-6 * kept.max())
    assert turned.maps[0].parts[0].rings == pytest.approx(mine.update(rotation=R).parts[0].rings, abs=1e-5)
    assert other.maps[0].brdf == "ggx(alpha=0.6)"
    assert other.errors is not None
    assert 0.0 < other.errors[0] < (0.1 if orders is None else 0.3)


def test_other_objects_keep_their_maps_and_errors_come_second(sky: Path) -> None:
    prefiltering = Prefiltering()
    first, second = prefiltering(asked(sky, materials=("lambert:0.5", "phong:8")), never)
    assert first.errors is None
    assert second.errors is not None
    assert first.maps == second.maps
    assert len(second.errors) == len(second.shapes) == 2
    (again,) = prefiltering(asked(sky, materials=("lambert:0.5", "phong:8")), never)
    assert again.errors == second.errors
    assert again.maps == second.maps
    other = last(prefiltering(asked(sky, materials=("lambert:0.5", "phong:9")), never))
    assert [a is b for a, b in zip(other.maps, second.maps, strict=True)] == [True, False]


def test_tangents_are_those_of_the_mesh_where_a_material_depends_on_them(sky: Path, tmp_path: Path) -> None:
    mesh, bare = tmp_path / "ridge.obj", tmp_path / "bare.obj"
    corners = "v 0 0 0\nv 2 0 0\nv 0 0 1\nv 2 1 1\n"
    bare.write_text(corners + "f 1 2 3\nf 2 4 3\n")
    mesh.write_text(corners + "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 3/3\nf 2/2 4/4 3/3\n")
    prefiltering, metal = Prefiltering(), ("ggx:0.4", "0.5*lambert:0.5 + banks:0.5")
    for tangents in ("uv", "principal"):
        answer = last(prefiltering(asked(sky, mesh=str(mesh), tangents=tangents, materials=metal), never))
        expected = Mesh.read(mesh).with_tangents(tangents).tangents
        for shape in answer.shapes:
            assert isinstance(shape, Mesh)
            np.testing.assert_array_equal(shape.tangents, expected)
    plain = last(prefiltering(asked(sky, mesh=str(mesh), tangents="axis", materials=metal), never))
    isotropic = last(prefiltering(asked(sky, mesh=str(bare), tangents="uv"), never))
    assert [getattr(shape, "tangents", 0) for shape in (*plain.shapes, *isotropic.shapes)] == [None] * 3
    with pytest.raises(ValueError, match=r"bare\.obj: no texture coordinates"):
        next(prefiltering(asked(sky, mesh=str(bare), tangents="uv", materials=("banks:0.5",)), never))


def test_prefiltering_stops_when_it_is_stale(sky: Path) -> None:
    with pytest.raises(StaleError):
        next(Prefiltering()(asked(sky), lambda: True))


def test_a_wrong_request_leaves_everything_as_it_was(sky: Path, tmp_path: Path) -> None:
    prefiltering = Prefiltering()
    before = last(prefiltering(asked(sky), never))
    (tmp_path / "garbage.hdr").write_bytes(b"no picture")
    for wrong in (
        asked(tmp_path / "garbage.hdr"),
        asked(tmp_path / "missing.exr"),
        asked(sky, materials=("velvet:1",)),
        asked(sky, mesh=str(tmp_path / "garbage.hdr")),
    ):
        with pytest.raises((ValueError, OSError)):
            next(prefiltering(wrong, never))
    after = last(prefiltering(asked(sky), never))
    assert after.environment is before.environment
    assert np.array_equal(after.maps[0].parts[0].rings, before.maps[0].parts[0].rings)
