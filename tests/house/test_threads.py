"""Same input, same output, whatever the number of threads and the instruction set."""

import os
import subprocess
import sys

import numpy as np
import pytest
from shrm._core import processor
from support.machine import require

SCRIPT = """
import sys
import numpy as np
from shrm import Environment, _core, brdf, prefilter, prefilter_angular, prefilter_hierarchical, sh
from shrm.transfer.lighting import (
    Compressed, Convolution, Diffuse, FixedLight, FixedView, Projection, Tents,
)

env = Environment.daylight(size=64)
material = brdf.Lambert(0.5) + brdf.GGX(0.2, f0=(1.0, 0.8, 0.3))
rng = np.random.default_rng(1)
N, V = rng.normal(size=(2, 300, 3))
N /= np.linalg.norm(N, axis=1, keepdims=True)
V /= np.linalg.norm(V, axis=1, keepdims=True)
V *= np.sign((N * V).sum(axis=1, keepdims=True))
results = {"analysis": env.coefficients(20), "resampled": env.resized((48, 96)).pixels}
results["rotated"] = sh.rotate(env.coefficients(40), [[0, -1, 0], [0, 0, -1], [1, 0, 0]])
for layout in ("latlong", "cube"):
    rm = prefilter(env, material, orders=(12, 3), size=32, layout=layout)
    results[layout] = rm.parts[1].rings
    results[layout + " radiance"] = rm.radiance(N, V)
results["local"] = rm.parts[1].local_maps(16)
results["angular"] = prefilter_angular(env, material, cutoff=0.01).radiance(N[:20], V[:20])
for symmetry in (True, False):
    lobe = brdf.Phong(32)
    maps = prefilter_angular(env, lobe, cutoff=0.05, size=24, subsamples=1, symmetry=symmetry)
    results[f"angular map {symmetry}"] = maps.at_view([0, 0, 1])
facets = prefilter_angular(env, brdf.Microfacet(0.2), cutoff=0.05, size=16, subsamples=1)
results["half-angle map"] = facets.at_view([0.6, 0, 0.8])
sharp = prefilter(env, brdf.GGX(0.05, f0=(1.0, 0.8, 0.3)), orders=(8, 2), size=16, residual="auto")
results["residual"] = sharp.residual.radiance(N, V)
descent = prefilter_hierarchical(env, brdf.Phong(64) + brdf.Lambert(0.5), threshold=1e-3, size=24)
for center, pixels in descent.maps_at_view([0, 0, 1]).items():
    results[f"hierarchical, {center}"] = pixels

L, E = rng.normal(size=(2, 3000, 3))
L, E = (w / np.linalg.norm(w, axis=1, keepdims=True) * np.where(w[:, 2:] < 0, -1, 1) for w in (L, E))
for axes in ("angles", "half-angle"):
    results[f"table over {axes}"] = brdf.Tabulated(rng.uniform(size=(9, 8, 7, 3)), axes).transfer(L, E)
table = rng.uniform(0.1, 1, (4, 9, 9, 3)).astype(np.float32)
results["adaptive table"] = _core.AdaptiveParameterization(
    theta_i=np.linspace(0, 1.5, 4), vndf=table[..., 0].copy(), values=table, ndf=table[0, :, :, 0].copy(),
    sigma=table[0, 0, :, 0].copy(),
).evaluate(wi=L, wo=E)

T = np.cross(N, V)
T /= np.linalg.norm(T, axis=1, keepdims=True)
surface = V, np.stack([T, np.cross(N, T), N], axis=2)  # vertices and frames
for n, M, dtype in ((3, 4, np.float32), (5, 7, np.float32), (5, 7, np.float16), (6, 3, np.float16)):
    light, matrices = rng.normal(size=(n * n, 3)), rng.normal(size=(300, M * M, 3, n * n)).astype(dtype)
    weights, components = rng.normal(size=(300, 9)).astype(dtype), rng.normal(size=(4, 9, M * M, 1, n * n))
    shadows = rng.normal(size=(300, n * n, n * n)).astype(dtype)
    rows, kernel, clusters = rng.normal(size=(8, 8, 1, n * n)), np.linspace(1, 0.2, n), np.arange(300) % 4
    ways = {
        "tents": Tents(*surface, matrices),
        "one channel": Tents(*surface, matrices[:, :, :1]),
        "compressed": Compressed(*surface, weights, components[0], K=7),
        "clustered": Compressed(*surface, weights, components, clusters),
        "projection": Projection(*surface, rows, shadows),
        "prerotated": Projection(*surface, rows, shadows, prerotated=True),
        "unshadowed": Projection(*surface, rows),
        "convolution": Convolution(*surface, kernel, shadows),
        "unshadowed convolution": Convolution(*surface, kernel),
        "diffuse": Diffuse(shadows[:, :3]),
    }
    ways["fixed light"], ways["fixed view"] = FixedLight(ways["compressed"]), FixedView(ways["tents"])
    for name, lighting in ways.items():
        results[f"{name}, {n}, {dtype.__name__}"] = lighting.radiance(light, eye=[1.5, -0.7, 0.9])
np.savez(sys.argv[1], **results)
"""


def run(path, **environment):
    subprocess.run(
        [sys.executable, "-c", SCRIPT, str(path)], check=True, env={**os.environ, **environment}, timeout=300
    )
    return np.load(path)


FORK = """
import os
from shrm import Environment

env = Environment.daylight(size=16)
env.coefficients(4)  # starts the threads
child = os.fork()
if child == 0:
    Environment.daylight(size=16).coefficients(4)
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
"""


def test_a_forked_child_works():
    require(hasattr(os, "fork"), "a system with fork")
    environment = {**os.environ, "OMP_NUM_THREADS": "4"}
    subprocess.run([sys.executable, "-c", FORK], check=True, env=environment, timeout=60)


@pytest.fixture(scope="module")
def one_thread(tmp_path_factory):
    return run(tmp_path_factory.mktemp("threads") / "one.npz", OMP_NUM_THREADS="1")


def assert_same(other, results):
    for name in results.files:
        scale = np.abs(results[name]).max()
        np.testing.assert_allclose(other[name], results[name], rtol=0, atol=1e-6 * scale, err_msg=name)


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_threads(one_thread, tmp_path):
    assert_same(run(tmp_path / "other.npz", OMP_NUM_THREADS="7"), one_thread)


@pytest.mark.slow
@pytest.mark.parametrize("name", processor.instruction_sets()[1:])  # the best is the one tested elsewhere
def test_results_do_not_depend_on_the_instruction_set(one_thread, name, tmp_path):
    assert_same(run(tmp_path / "other.npz", SHRM_INSTRUCTION_SET=name), one_thread)


def test_an_instruction_set_that_is_not_there_is_refused():
    done = subprocess.run(
        [sys.executable, "-c", "import shrm"],
        env={**os.environ, "SHRM_INSTRUCTION_SET": "sparc"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1
    assert "'sparc'" in done.stderr
    assert "portable" in done.stderr


@pytest.mark.parametrize(
    ("given", "spins"),
    [
        ({}, "20000"),
        ({"GOMP_SPINCOUNT": "7"}, "7"),
        ({"OMP_WAIT_POLICY": "PASSIVE"}, "0"),
    ],
)
def test_waiting_threads_soon_sleep(given: dict[str, str], spins: str) -> None:
    """Unless the user says otherwise; the process keeps nothing of it in its environment."""
    clean = {k: v for k, v in os.environ.items() if k not in ("GOMP_SPINCOUNT", "OMP_WAIT_POLICY")}
    done = subprocess.run(
        [sys.executable, "-c", "import os, shrm; print(os.environ.get('GOMP_SPINCOUNT'))"],
        env={**clean, **given, "OMP_DISPLAY_ENV": "VERBOSE"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert f"GOMP_SPINCOUNT = '{spins}'" in done.stderr
    assert done.stdout.strip() == str(given.get("GOMP_SPINCOUNT"))
