"""The peak of one core in float32, by which the speed of other work is measured."""

from __future__ import annotations

import numpy as np

from shrm_papers.single_thread import processor_seconds


def flops_per_second(n: int = 768, rounds: int = 7) -> float:
    """Return the flops in a second of processor time of an n x n float32 matrix product of BLAS.

    Such products reach nine tenths and more of what multiply-adds alone would reach. The fastest round
    counts. Call it in a process of one thread.
    """
    a, b = np.random.default_rng(0).random((2, n, n), dtype=np.float32)
    out = np.empty((n, n), dtype=np.float32)
    seconds = processor_seconds([lambda: np.matmul(a, b, out=out)], rounds)
    return 2 * n**3 / float(seconds.min())
