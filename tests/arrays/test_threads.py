"""How many threads there are: what the environment says, or what the system allows."""

import os

import pytest
from shrm.threads import thread_count


@pytest.mark.parametrize(("text", "count"), [("3", 3), (" 2 ", 2), ("4,2", 4)])
def test_openmp_says_how_many(monkeypatch: pytest.MonkeyPatch, text: str, count: int) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", text)
    assert thread_count() == count


@pytest.mark.parametrize("text", [None, "", "0", "-1", "many", "\u00b2"])
def test_otherwise_as_many_as_this_process_may_use(monkeypatch: pytest.MonkeyPatch, text: str | None) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    if text is not None:
        monkeypatch.setenv("OMP_NUM_THREADS", text)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {4, 5, 6}, raising=False)
    assert thread_count() == 3


@pytest.mark.parametrize(("processors", "count"), [(6, 6), (None, 1)])
def test_where_the_system_does_not_say_it_is_the_machines(
    monkeypatch: pytest.MonkeyPatch, processors: int | None, count: int
) -> None:
    """As on macOS and Windows."""
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: processors)
    assert thread_count() == count
