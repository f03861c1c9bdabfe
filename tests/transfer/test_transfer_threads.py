"""Precomputed transfer is the same for every number of threads and every instruction set."""

import os
import subprocess
import sys

import numpy as np
import pytest
from shrm import brdf
from shrm._core import processor
from shrm.transfer.object import RadianceTransfer
from shrm.transfer.precompute import precompute
from support.transfer_meshes import Surface, bumpy
from test_transfer_precompute import ALL, matrices, rebuilt

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[2])
import numpy as np
from test_transfer_threads import computed, results

np.savez(sys.argv[1], **results(computed()))
"""


def computed() -> RadianceTransfer:
    material = brdf.Lambert((0.2, 0.4, 0.6)) + brdf.GGX(0.6)
    options = {"n": 3, "directions": 256, "accuracy": 14.0, "bounces": 2}
    return precompute(Surface(*bumpy(9, subdivisions=1)), material, variants=ALL, matrices=True, **options)


def results(held: RadianceTransfer) -> dict[str, np.ndarray]:
    """What is chosen, the matrices, and what components make of them."""
    found = {"M": np.array(held.M), "K": np.array([held.variants[name].K for name in ALL])}
    for name in ALL:
        found[f"{name} matrices"] = matrices(held, name)
        found[f"{name} rebuilt"] = rebuilt(held, name, held.variants[name].K)
    return found


@pytest.fixture(scope="module")
def expected() -> dict[str, np.ndarray]:
    return results(computed())


@pytest.mark.parametrize(
    "environment",
    [{"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}, {"OMP_NUM_THREADS": "3"}]
    + [{"SHRM_INSTRUCTION_SET": name} for name in processor.instruction_sets()[1:]],
    ids=lambda environment: " ".join(environment.values()),
)
def test_results_do_not_depend_on_threads_and_instruction_set(environment, expected, tmp_path):
    path = tmp_path / "found.npz"
    subprocess.run(
        [sys.executable, "-c", SCRIPT, str(path), os.path.dirname(__file__)],
        check=True,
        env={**os.environ, **environment},
        timeout=120,
    )
    found = np.load(path)
    for name, array in expected.items():
        # Half weights may round to either side: 2^-12 of the largest
        bound = {"matrices": 1e-6, "rebuilt": 2.0**-11}.get(name.split(" ")[-1], 0.0)
        error = np.abs(found[name] - array).max() / np.abs(array).max()
        assert error <= bound, name
