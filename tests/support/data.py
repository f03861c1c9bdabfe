"""Real data beside the project; tests that need it skip, with the reason, where it is absent."""

from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data"


def require(name: str) -> Path:
    path = FOLDER / name
    if not path.exists():
        pytest.skip(f"needs ../shared/data/{name}")
    return path
