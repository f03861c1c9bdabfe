"""The C++ core under AddressSanitizer and UndefinedBehaviorSanitizer, warnings as errors."""

import subprocess
from pathlib import Path

import pytest
from support.machine import tool

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build" / "sanitize"


def run(*command: object) -> str:
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    assert done.returncode == 0, f"{command[0]} failed:\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.mark.slow
def test_the_core_is_clean_under_the_sanitizers() -> None:
    cmake, ninja = tool("cmake"), tool("ninja")
    # --fresh: the folder may have been configured elsewhere; objects that are up to date are kept.
    generator = "-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={ninja}"
    run(cmake, "--fresh", "-S", ROOT, "-B", BUILD, *generator, "-DSHRM_SANITIZE=ON")
    run(cmake, "--build", BUILD, "--parallel")
    assert run(BUILD / "sanitize").endswith("sanitize: done\n")
