"""The integrated picture in place of the drawn one, as far as it is ready."""

from __future__ import annotations

from collections.abc import Callable

from shrm.viewer.integration import Integrated, Integration, Question
from shrm.viewer.screen import Screen
from shrm.viewer.worker import Worker


class Comparison:
    """Asks for pictures by integration, and puts those that fit what is drawn on the screen.

    Attributes
    ----------
    worker : Worker
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        self.worker: Worker[Question, Integrated] = Worker(Integration(), wake)
        self._question: Question | None = None
        self._ready: Integrated | None = None

    def show(self, question: Question, difference: bool, screen: Screen) -> None:
        """Show the answer to a question, or its difference from what is drawn; what is drawn until then.

        Raises
        ------
        ValueError, RuntimeError, MemoryError
            If the integration failed.
        """
        if question != self._question:
            self._question = question
            self.worker.submit(question)
        ready = self.worker.take()
        if ready is not None and ready.question == question:
            self._ready = ready
            screen.keep_integrated(ready.picture)
        if self._fits:
            screen.show_integrated(difference)
        else:
            screen.show_drawn()

    @property
    def says(self) -> str:
        """How far it is, for the panel."""
        if not self._fits or self._ready is None:
            return "integrating ... (until then: from the maps)"
        coarseness = self._ready.coarseness
        return "integrated" if coarseness == 1 else f"integrating ... 1/{coarseness} of the resolution so far"

    @property
    def _fits(self) -> bool:
        return self._ready is not None and self._ready.question == self._question
