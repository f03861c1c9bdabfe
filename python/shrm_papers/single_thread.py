"""Processor time in a process of one thread: times that other work on the machine hardly touches.

Threads that wait for each other at a barrier are slowed by whole time slices where something else runs, and
their wall times then say nothing of the work. How many threads there are is fixed when the core is loaded:
hence a process of its own.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from shrm.arrays import FloatArray
from shrm.environment import Environment

from shrm_papers.result import Settings


def measured(module: str, settings: Settings) -> Any:
    """Call `measure(env, quick)` of a module of this package in a process of one thread.

    Parameters
    ----------
    module : str
        Full name of the module.
    settings : Settings
        Its environment, and whether it is quick, are passed on.

    Returns
    -------
    Any
        The result of `measure`, which passes through JSON.

    Raises
    ------
    RuntimeError
        If it failed there; the last line that it printed is in the message.
    """
    # The child loads the core with one thread.
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    # A BLAS held to older instructions would make the machine's peak look lower than it is.
    env = {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"}
    with tempfile.TemporaryDirectory() as folder:
        light = Path(folder) / "environment.npy"
        np.save(light, settings.env.pixels)
        command = [sys.executable, "-m", __name__, module, str(light), "quick" if settings.quick else "full"]
        process = subprocess.run(
            command, env={**env, **one_thread}, capture_output=True, text=True, stdin=subprocess.DEVNULL
        )
    if process.returncode != 0:
        messages = process.stderr.strip().splitlines() or [f"exit status {process.returncode}"]
        raise RuntimeError(f"{module}: {messages[-1]}")
    return json.loads(process.stdout)


def processor_seconds(calls: Sequence[Callable[[], object]], rounds: int) -> FloatArray:
    """Return the seconds of each call in every round, (rounds, calls), after a round that does not count.

    All calls take turns, so that a disturbance falls on all alike.
    """
    for call in calls:
        call()
    seconds = np.empty((rounds, len(calls)))
    for of_round in seconds:
        for index, call in enumerate(calls):
            start = time.process_time()
            call()
            of_round[index] = time.process_time() - start
    return seconds


if __name__ == "__main__":
    name, path, extent = sys.argv[1:]
    light = Environment(np.load(path, allow_pickle=False))
    print(json.dumps(import_module(name).measure(light, extent == "quick")))
