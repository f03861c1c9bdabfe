"""OpenGL for results that need it: a context without a display, or a note of why there is none."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from shrm.viewer import Context, ContextError, offscreen


def context_or_note() -> tuple[Context | None, str]:
    """Return a context and the driver's name, or None and what to write in place of a measurement."""
    try:
        context = offscreen()
    except ContextError as fault:
        return None, f"What needs OpenGL was left out: {fault}"
    return context, str(context.gl.info["GL_RENDERER"])


def frame_seconds(context: Context, calls: Sequence[Callable[[], object]], rounds: int) -> list[float]:
    """Return the median wall time of each call with the driver's work; all take turns in every round.

    The first call of each does not count: drivers compile shaders when they first draw.
    """
    seconds = np.empty((rounds + 1, len(calls)))
    for of_round in seconds:
        for index, call in enumerate(calls):
            context.gl.finish()
            start = time.perf_counter()
            call()
            context.gl.finish()
            of_round[index] = time.perf_counter() - start
    return [float(s) for s in np.median(seconds[1:], axis=0)]
