"""Reading and preparing a measured material, alone in a process: the times, and the memory it takes.

    python bench/prepare_measured.py FILE        # as JSON

Prepared means analysed to F = 30, P = 5, so that prefiltering has no more to do than for any other material.
"""

import json
import sys
import time

from precompute_transfer import most_memory
from shrm import brdf
from shrm.frequency import orders

ORDERS = (30, 5)


def main(file: str) -> None:
    """Read, analyse, print."""
    before = most_memory()
    start = time.perf_counter()
    material = brdf.load(file)
    read = time.perf_counter()
    orders.analysed(material, *ORDERS)
    done = time.perf_counter()
    print(
        json.dumps({"reading": read - start, "preparing": done - read, "bytes": most_memory() - before}),
    )


if __name__ == "__main__":
    main(sys.argv[1])
