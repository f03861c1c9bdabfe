"""Fixtures: a small environment in a file, the command in this process, a display, windows."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import settings
from shrm.cli import main
from shrm.image_io import write_image

Array = npt.NDArray[np.floating]

# The same examples in every run, however slow the machine is.
settings.register_profile("shrm", derandomize=True, deadline=None)
settings.load_profile("shrm")

# Processes that tests start find `support` too.
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(Path(__file__).parent), os.environ.get("PYTHONPATH")])
)


@pytest.fixture(scope="session")
def sky(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small environment: bright above, reddish towards +x."""
    H, W = 16, 32
    theta = ((np.arange(H) + 0.5) * np.pi / H)[:, None]
    phi = np.pi - 2.0 * np.pi * (np.arange(W) + 0.5) / W
    up, ahead = np.cos(theta) + 0.0 * phi, np.sin(theta) * np.cos(phi)
    pixels = np.stack([1.2 + up + 0.2 * ahead, 1.2 + up, 1.3 + up - 0.1 * ahead], axis=2)
    path = tmp_path_factory.mktemp("sky") / "sky.exr"
    write_image(path, pixels.astype(np.float32))
    return path


@pytest.fixture
def shrm(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run the command in this process: status, standard output, standard error."""

    def run(*arguments: object) -> tuple[int, str, str]:
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as end:  # argparse ends the process itself
            status = int(end.code or 0)
        out, err = capsys.readouterr()
        return status, out, err

    return run


@pytest.fixture(scope="module")
def screen() -> Iterator[None]:
    """A display."""
    from support.window_driver import display

    with display():
        yield


@pytest.fixture
def opened(
    screen: None, sky: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> Iterator[Callable[..., object]]:
    """Open windows; see `support.window_driver.windows`."""
    from support.window_driver import windows

    with windows(sky, tmp_path, request.node.name) as opened:
        yield opened
