"""The integrated picture in place of the drawn one, as far as it is ready."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from shrm.render.camera import Camera
from shrm.render.picture import Picture
from shrm.viewer.window.integration import COARSENESS, Integrated, Integration, Question
from shrm.viewer.window.prefiltering import PrefilteredScene
from shrm.viewer.window.screen import Screen
from shrm.viewer.window.state import State
from shrm.viewer.window.worker import Worker


def question_of(result: PrefilteredScene, state: State, camera: Camera, shape: tuple[int, int]) -> Question:
    """Return the question for the picture, of a shape (H, W), of what is drawn.

    Of an object with transfer that is its material without shadows, in the light that its transfer knows.
    """
    environment, shapes, request = result.environment, result.shapes, result.request
    if result.transferred is None:
        return Question(environment, request.light, request.materials, shapes, camera, state.viewer, shape)
    transfer = result.transferred.transfer
    materials = (transfer.material,)
    return Question(
        environment,
        state.light,
        materials,
        shapes,
        camera,
        state.viewer,
        shape,
        transfer.n,
        state.window,
    )


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
        self._measured: tuple[Integrated, object, float] | None = None

    def show(self, question: Question, difference: bool, screen: Screen, drawn: object) -> None:
        """Show the answer to a question, or its difference from what is drawn; what is drawn until then.

        `drawn` is equal as long as the picture that is drawn is the same but for its samples.

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
        if not self._fits or self._ready is None:
            screen.show_drawn()
            return
        screen.show_integrated(difference)
        if screen.complete and (self._measured is None or self._measured[:2] != (self._ready, drawn)):
            error = relative_rms(screen.drawn_picture(), self._ready.picture)
            self._measured = self._ready, drawn, error

    @property
    def says(self) -> str:
        """Progress of the integration, for the panel."""
        question = self._question
        drawn = "the maps are" if question is None or question.n is None else "with transfer it is"
        if not self._fits or self._ready is None:
            return "integrating ... (until then, as drawn)"
        done, passes = COARSENESS.index(self._ready.coarseness) + 1, len(COARSENESS)
        how_far = "integrated" if done == passes else f"pass {done} of {passes}"
        if self._measured is None or self._measured[0] is not self._ready:
            return how_far
        return f"{how_far}: {drawn} {100.0 * self._measured[2]:.2g} % off"

    @property
    def _fits(self) -> bool:
        return self._ready is not None and self._ready.question == self._question


def relative_rms(drawn: Picture, integrated: Picture) -> float:
    """Return the relative RMS difference of two pictures where both see nothing but objects, colors pooled.

    The second may have fewer pixels: those of the first that lie at their middles are taken.
    """
    rows, columns = (
        ((np.arange(few) + 0.5) * (many / few)).astype(int)
        for few, many in zip(integrated.coverage.shape, drawn.coverage.shape, strict=True)
    )
    at = np.ix_(rows, columns)
    inside = (drawn.coverage[at] == 1.0) & (integrated.coverage == 1.0)
    expected = integrated.radiance[inside].astype(np.float64)
    energy = (expected**2).sum()
    return (
        float(np.sqrt(((drawn.radiance[at][inside] - expected) ** 2).sum() / energy)) if energy > 0.0 else 0.0
    )
