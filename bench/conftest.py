"""What every row of the benchmarks says beside its time: the error, the machine, the threads, the commit."""

import os
import platform
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from counts import Work
from limits import ROOT, limits, share
from shrm.threads import thread_count


def _machine() -> str:
    """Return the processor's name, with what tells its generation: virtual machines hide the rest."""
    said: dict[str, str] = {}
    for line in Path("/proc/cpuinfo").read_text().splitlines() if os.path.exists("/proc/cpuinfo") else []:
        key, _, value = line.partition(":")
        said.setdefault(key.strip(), value.strip())
    if "model name" not in said:
        return platform.processor()
    return "{model name}, family {cpu family}, model {model}".format_map(said)


def _commit() -> str:
    done = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return done.stdout.strip() or "unknown"


_ABOUT = {"machine": _machine(), "threads": thread_count(), "commit": _commit()}


def pytest_benchmark_update_machine_info(machine_info: dict[str, Any]) -> None:
    if shutil.which("g++"):
        machine_info["limits"] = [limits(count) for count in sorted({1, thread_count()})]


@pytest.fixture
def about() -> dict[str, Any]:
    """Return the machine, the threads and the commit."""
    return _ABOUT


@pytest.fixture
def measured(benchmark: Any) -> Callable[..., Any]:
    """Time a call and note its error: `measured(call, error=lambda result: ..., work="...")`.

    With `kernels`, what the call must do at least, its row also says what share of the machine's limit it
    reaches.
    """

    def run(
        call: Callable[[], Any], error: Callable[[Any], float], work: str, kernels: Sequence[Work] = ()
    ) -> Any:
        result = benchmark(call)
        benchmark.extra_info.update(_ABOUT, work=work, error=float(error(result)))
        if kernels and benchmark.stats is not None and shutil.which("g++"):
            reached, bound = share(kernels, benchmark.stats.stats.median, limits(thread_count()))
            benchmark.extra_info.update(
                flops=sum(kernel.flops for kernel in kernels),
                bytes=sum(kernel.bytes for kernel in kernels),
                share=reached,
                bound=bound,
            )
        return result

    return run


@pytest.fixture
def noted(benchmark: Any) -> Callable[[Callable[[], list[dict[str, Any]]]], None]:
    """Keep the rows of a comparison that does its own timing in turns: run once, kept in `extra_info`."""

    def run(compare: Callable[[], list[dict[str, Any]]]) -> None:
        rows = benchmark.pedantic(compare, rounds=1, iterations=1)
        benchmark.extra_info.update(_ABOUT, rows=rows)

    return run
