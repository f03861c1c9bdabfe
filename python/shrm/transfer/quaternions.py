"""Frames as unit quaternions (w, x, y, z), less than half the numbers, as files hold them."""

from __future__ import annotations

import numpy as np

from shrm.arrays import FloatArray, RealArray


def from_rotations(rotations: RealArray) -> FloatArray:
    """Return unit quaternions (k, 4) of rotations (k, 3, 3), w at least 0."""
    R = np.asarray(rotations, np.float64)
    # 4 q q^T from R: its largest row is a multiple of q that loses no digits
    trace = np.trace(R, axis1=1, axis2=2)
    products = np.empty((len(R), 4, 4))
    products[:, 0, 0] = 1 + trace
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        products[:, a + 1, a + 1] = 1 + 2 * R[:, a, a] - trace
        products[:, 0, a + 1] = products[:, a + 1, 0] = R[:, c, b] - R[:, b, c]
        products[:, a + 1, b + 1] = products[:, b + 1, a + 1] = R[:, b, a] + R[:, a, b]
    largest = np.einsum("kii->ki", products).argmax(axis=1)
    q = products[np.arange(len(R)), largest]
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    return np.asarray(np.where(q[:, :1] < 0, -q, q))


def to_rotations(quaternions: RealArray) -> FloatArray:
    """Return rotations (k, 3, 3) of quaternions (k, 4) of any length but zero."""
    q = np.asarray(quaternions, np.float64)
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
