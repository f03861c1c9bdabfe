"""What a machine may lack. A test that needs it is skipped; under CI it fails, for there nothing is left out.

`CI` in the environment says which, as on the services of continuous integration.
"""

import os
import shutil
import sys
from pathlib import Path

import pytest


def require(present: object, what: str) -> None:
    """Go on if something is present; otherwise skip the test, or fail it under CI.

    Parameters
    ----------
    present : object
        Whether it is there, by its truth.
    what : str
        What the test needs, and how to get it.
    """
    if not present:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(f"needs {what}")


def tool(name: str) -> str:
    """Return the path of a program that stands beside this Python or on the PATH; see `require`."""
    places = [str(Path(sys.executable).parent), os.environ.get("PATH", "")]
    path = shutil.which(name, path=os.pathsep.join(places))
    require(path, f"{name}, of the package's test extra or the system")
    return str(path)
