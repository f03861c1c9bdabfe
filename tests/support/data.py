"""Pictures and measurements: those of the tests, and real ones beside the project.

Tests that need `../shared/data` are skipped, with the reason, where it is absent.
"""

import warnings
from functools import cache
from pathlib import Path

import pytest
from shrm import Environment, ImageWarning

OWN = Path(__file__).resolve().parents[1] / "data"
FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data"


def require(name: str) -> Path:
    path = FOLDER / name
    if not path.exists():
        pytest.skip(f"needs ../shared/data/{name}")
    return path


@cache
def environment(name: str, H: int = 64, W: int = 128) -> Environment:
    """Return an environment by its file's name, of the tests or real, brought to H x W texels.

    It is read and resized once in a process: the large ones take seconds.
    """
    path = OWN / name if (OWN / name).exists() else require(f"env/{name}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ImageWarning)
        return Environment.read(path).resized((H, W))
