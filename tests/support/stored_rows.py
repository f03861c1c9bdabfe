"""An array on disk of known rows, computed part by part by something that counts and stops."""

from pathlib import Path
from typing import Any

import numpy as np
from shrm.transfer.rays.stored import stored

SHAPE = (10, 3, 4)
RIGHT = np.random.default_rng(0).normal(size=SHAPE).astype(np.float32)
PARTS = [slice(0, 4), slice(4, 8), slice(8, 10)]


class Maker:
    """Makes the rows, counts them, and stops after some."""

    def __init__(self, stop: int = 10) -> None:
        self.made: list[slice] = []
        self.steps: list[int] = []
        self.stop = stop

    def __call__(self, part: slice) -> np.ndarray:
        self.made.append(part)
        return RIGHT[part]

    def progress(self, done: int, total: int) -> None:
        assert total == len(RIGHT)
        self.steps.append(done)
        if self.stop <= done < total:
            raise KeyboardInterrupt


def run(folder: Path, maker: Maker, about: Any = "this", parts: list[slice] = PARTS) -> np.ndarray:
    return stored(folder / "rows", {"of": about}, SHAPE, parts, maker, maker.progress)
