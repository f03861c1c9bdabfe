"""Work beside the window: one thread, the newest request wins."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

Q = TypeVar("Q")
A = TypeVar("A")


class Worker(Generic[Q, A]):
    """A thread that answers requests, always the newest.

    Parameters
    ----------
    work : callable
        ``work(request, stale)`` yields answers, the later the better; between them, and wherever it asks
        ``stale()`` and returns, it is dropped if there is a newer request.
    wake : callable, optional
        Called from the thread when there is something to take.

    Attributes
    ----------
    answered, dropped : int
        Requests whose work was completed; requests that were replaced before they were begun or completed.

    Notes
    -----
    An answer is handed over by one assignment under a lock. The thread gives it away: it must not write to
    it afterwards.
    """

    def __init__(
        self,
        work: Callable[[Q, Callable[[], bool]], Iterator[A]],
        wake: Callable[[], None] = lambda: None,
    ) -> None:
        self._work, self._wake = work, wake
        self._changed = threading.Condition()
        self._request: list[Q] = []  # none or one
        self._answer: list[A | Exception] = []  # none or one
        self._closed = self._at_work = False
        self.answered = self.dropped = 0
        self._thread = threading.Thread(target=self._run, name="shrm worker", daemon=True)
        self._thread.start()

    def submit(self, request: Q) -> None:
        """Ask for something, in place of what was asked for before."""
        with self._changed:
            self.dropped += len(self._request)
            self._request = [request]
            self._changed.notify_all()

    def take(self) -> A | None:
        """Return the newest answer that was not taken yet, or None.

        Raises
        ------
        Exception
            What the work raised, if that is the newest.
        """
        with self._changed:
            if not self._answer:
                return None
            answer = self._answer.pop()
        if isinstance(answer, Exception):
            raise answer
        return answer

    @property
    def working(self) -> bool:
        """Whether there is work."""
        with self._changed:
            return self._at_work or bool(self._request)

    def close(self) -> None:
        """End the thread; work that asks whether it is stale is dropped."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._thread.join()

    def _stale(self) -> bool:
        with self._changed:
            return self._closed or bool(self._request)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._at_work = False
                self._changed.wait_for(lambda: self._closed or bool(self._request))
                if self._closed:
                    return
                request = self._request.pop()
                self._at_work = True
            completed = self._answers(request)
            with self._changed:
                self.answered += completed
                self.dropped += not completed

    def _answers(self, request: Q) -> bool:
        """Do the work of a request; whether it was completed."""
        try:
            for answer in self._work(request, self._stale):
                self._give(answer)
                if self._stale():
                    return False
        except StaleError:
            return False
        except Exception as fault:  # it is raised where the answer is taken
            if self._stale():
                return False
            self._give(fault)
        return True

    def _give(self, answer: A | Exception) -> None:
        with self._changed:
            self._answer = [answer]
        self._wake()


class StaleError(RuntimeError):
    """Raised by work that is not wanted any more."""
