"""Things that a machine may lack: tests that need one are skipped, but fail under CI, which has them all.

The environment variable `CI` tells, as services of continuous integration set it.
"""

import os
import shutil
import sys
from pathlib import Path

import pytest


def require(present: object, name: str) -> None:
    """Go on if something is present; otherwise skip the test, or fail it under CI.

    Parameters
    ----------
    present : object
        True, or of a true value, if it is present.
    name : str
        Name of the thing, and how to get it.
    """
    if not present:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(f"needs {name}")


def tool(name: str) -> str:
    """Return the path of a program that stands beside this Python or on the PATH; see `require`."""
    places = [str(Path(sys.executable).parent), os.environ.get("PATH", "")]
    path = shutil.which(name, path=os.pathsep.join(places))
    require(path, f"{name}, of the package's test extra or the system")
    return str(path)
