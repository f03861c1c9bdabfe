"""Measurements in processes of their own: OpenMP fixes its threads when it starts."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

# Each thread stays on a processor of its own: else two may share one while another program has the other.
BOUND = {"OMP_PROC_BIND": "true"}


def found_by(script: str, *arguments: str, threads: int, **environment: str) -> Any:
    """Run a script of this folder with so many threads, and return what it printed, as JSON."""
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name(script)), *arguments],
        env={**os.environ, **environment, "OMP_NUM_THREADS": str(threads)},
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)
