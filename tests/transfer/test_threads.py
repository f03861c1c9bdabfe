"""Precomputed transfer is the same for every number of threads and every instruction set."""

import os
import subprocess
import sys

import numpy as np
import pytest
from shrm._core import processor
from support.precomputed_results import computed, results

SCRIPT = """
import sys
import numpy as np
from support.precomputed_results import computed, results

np.savez(sys.argv[1], **results(computed()))
"""


@pytest.fixture(scope="module")
def expected() -> dict[str, np.ndarray]:
    return results(computed())


@pytest.mark.slow
@pytest.mark.parametrize(
    "environment",
    [{"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}, {"OMP_NUM_THREADS": "3"}]
    + [{"SHRM_INSTRUCTION_SET": name} for name in processor.instruction_sets()[1:]],
    ids=lambda environment: " ".join(environment.values()),
)
def test_results_do_not_depend_on_threads_and_instruction_set(environment, expected, tmp_path):
    path = tmp_path / "found.npz"
    subprocess.run(
        [sys.executable, "-c", SCRIPT, str(path)],
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
