"""An object with transfer that holds everything that its file can hold: random, and small."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.variant import Variant

V, K, Q, M, N = 7, 3, 2, 2, 2
SHAPE = (M * M, 3, N * N)


def random(seed: int, *shape: int, dtype: Any = np.float32) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=shape).astype(dtype)


def transfer(**change: Any) -> RadianceTransfer:
    """Return an object with everything that a file can hold, some of it changed."""
    fields: dict[str, Any] = {
        "vertices": random(0, V, 3),
        "faces": np.random.default_rng(1).integers(0, V, (5, 3), np.int32),
        "frames": Rotation.random(V, rng=np.random.default_rng(2)).as_matrix().astype(np.float32),
        "n": N,
        "M": M,
        "channels": 3,
        "variants": {
            "unshadowed": Variant(matrices=random(3, V, *SHAPE, dtype=np.float16)),
            "shadowed": Variant(random(4, V, K, dtype=np.float16), random(5, K, *SHAPE)),
            "interreflected": Variant(
                random(6, V, K),
                random(7, Q, K, *SHAPE, dtype=np.float16),
                np.array([0, 1, 1, 0, 1, 0, 0], np.int32),
                random(8, V, *SHAPE),
            ),
        },
        "uv": random(9, V, 2),
        "material": "lambert(albedo=0.5) – Ω",
        "report": {"SNR": 24.5, "path": "direct", "list": [1, None, True, {"ü": -1e-300}]},
    }
    return RadianceTransfer(**{**fields, **change})
