"""The RGL/EPFL format written, read and evaluated from its description; imports nothing of shrm.

What is linear or bilinear between nodes is a sum of hat functions here, and integrals of it sums of their
antiderivatives, in float64: no cells, no running sums.
"""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np

TYPES = {"|u1": 1, "<f4": 10, "<f8": 11}


def header(fields: dict[str, np.ndarray], offsets: dict[str, int]) -> bytes:
    parts = [b"tensor_file\0\1\0", struct.pack("<I", len(fields))]
    for name, values in fields.items():
        text = name.encode()
        parts += [struct.pack("<H", len(text)), text, struct.pack("<H", values.ndim)]
        parts += [struct.pack("<BQ", TYPES[values.dtype.str], offsets[name])]
        parts += [struct.pack(f"<{values.ndim}Q", *values.shape)]
    return b"".join(parts)


def content(fields: dict[str, np.ndarray]) -> bytes:
    """Return a file with these fields, each at a multiple of eight bytes."""
    data = bytearray(header(fields, dict.fromkeys(fields, 0)))
    offsets = {}
    for name, values in fields.items():
        data += b"\0" * (-len(data) % 8)
        offsets[name] = len(data)
        data += values.tobytes()
    start = header(fields, offsets)
    data[: len(start)] = start
    return bytes(data)


def read(path: Path) -> dict[str, np.ndarray]:
    data = path.read_bytes()
    types = {number: name for name, number in TYPES.items()} | {5: "<u4"}
    at, fields = 18, {}
    for _ in range(struct.unpack_from("<I", data, 14)[0]):
        (length,) = struct.unpack_from("<H", data, at)
        name = data[at + 2 : at + 2 + length].decode()
        at += 2 + length
        ndim, kind, offset = struct.unpack_from("<HBQ", data, at)
        shape = struct.unpack_from(f"<{ndim}Q", data, at + 11)
        at += 11 + 8 * ndim
        fields[name] = np.frombuffer(data, types[kind], int(np.prod(shape)), offset).reshape(shape)
    return fields


def hats(u: np.ndarray, n: int) -> np.ndarray:
    """Weights (len(u), n) of n nodes evenly over [0, 1]."""
    return np.maximum(1 - np.abs(u[:, None] * (n - 1) - np.arange(n)), 0)


def integrals(u: np.ndarray, n: int) -> np.ndarray:
    """Integrals of the hats from 0 to u, (len(u), n)."""
    t = np.clip(u[:, None] * (n - 1) - np.arange(n), -1, 1)
    areas = np.where(t < 0, (1 + t) ** 2 / 2, 1 - (1 - t) ** 2 / 2)
    areas[:, 0] -= 0.5  # of the first, half lies before 0
    return areas / (n - 1)


def linear_weights(x: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Weights (len(x), len(nodes)) of nodes anywhere, the outer ones' held beyond them."""
    return np.stack([np.interp(x, nodes, unit) for unit in np.eye(len(nodes))], axis=1)


def densities(vndf: np.ndarray) -> np.ndarray:
    """Slices (t, n, n) with integral 1 over the unit square."""
    one = np.ones(1)
    rows, columns = (integrals(one, n)[0] for n in vndf.shape[1:])
    D = vndf.astype(np.float64)
    return D / np.einsum("tyx,y,x->t", D, rows, columns)[:, None, None]


def warped(D: np.ndarray, slices: np.ndarray, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(x, y) of half vectors at (u, v), for weights (n, t) of the slices."""
    rows, columns = D.shape[1:]
    at_v = np.einsum("nt,ny->nty", slices, hats(v, rows)).reshape(len(u), -1) @ D.reshape(-1, columns)
    total = at_v @ integrals(np.ones(1), columns)[0]
    x = np.einsum("nx,nx->n", at_v, integrals(u, columns)) / np.where(total > 0, total, 1)
    marginal = slices @ (D @ integrals(np.ones(1), columns)[0])
    return np.where(total > 0, x, u), np.einsum("ny,ny->n", marginal, integrals(v, rows))


def angles(i: np.ndarray, o: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """theta_i, and (u, v) of the half vector."""
    h = i + o
    theta_i, theta_m = (np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]) for w in (i, h))
    phi = np.arctan2(h[:, 1], h[:, 0]) - np.arctan2(i[:, 1], i[:, 0])
    return theta_i, np.sqrt(2 * theta_m / np.pi), np.mod((phi + np.pi) / (2 * np.pi), 1)


def samples(fields: dict[str, np.ndarray], i: np.ndarray, o: np.ndarray) -> np.ndarray:
    """Place of theta_i among the slices, y and x, (n, 3)."""
    theta_i, u, v = angles(i, o)
    slices = linear_weights(theta_i, fields["theta_i"].astype(np.float64))
    x, y = warped(densities(fields["vndf"][0]), slices, u, v)
    return np.stack([slices @ np.arange(slices.shape[1]), y, x], axis=1)


def factor(fields: dict[str, np.ndarray], i: np.ndarray, o: np.ndarray) -> np.ndarray:
    """The factor ndf / (4 sigma), (n,), or 1 where the file says so."""
    if not fields["jacobian"][0]:
        return np.ones(len(i))
    theta_i, u, v = angles(i, o)
    ndf, sigma = (fields[name].astype(np.float64) for name in ("ndf", "sigma"))
    of_ndf = np.einsum("ny,yx,nx->n", hats(v, ndf.shape[0]), ndf, hats(u, ndf.shape[1]))
    at_i = np.sqrt(2 * theta_i / np.pi)
    half = np.full(len(i), 0.5)  # phi_i = 0
    return of_ndf / (
        4 * np.einsum("ny,yx,nx->n", hats(half, sigma.shape[0]), sigma, hats(at_i, sigma.shape[1]))
    )


def evaluate(fields: dict[str, np.ndarray], i: np.ndarray, o: np.ndarray) -> np.ndarray:
    """f_r cos(theta_o) of an RGB file, (n, 3)."""
    rgb = fields["rgb"][0].astype(np.float64)
    result = np.empty((len(i), 3))
    for first in range(0, len(i), 500):
        part = slice(first, first + 500)
        t, y, x = samples(fields, i[part], o[part]).T
        weights = [hats(t / max(len(rgb) - 1, 1), len(rgb)), hats(y, rgb.shape[2]), hats(x, rgb.shape[3])]
        color = np.einsum("nt,ny,nx,tcyx->nc", *weights, rgb, optimize=True)
        result[part] = np.maximum(color, 0) * factor(fields, i[part], o[part])[:, None]
    return result


def half_vectors(D: np.ndarray, y: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(u, v) whose samples are x and y in one slice D (n, n), by bisection to 1e-12."""
    rows, columns = D.shape
    one = np.ones(1)
    v = bisected(lambda at: integrals(at, rows) @ (D @ integrals(one, columns)[0]), y)
    of_row = hats(v, rows) @ D
    target = x * (of_row @ integrals(one, columns)[0])
    return bisected(lambda at: np.einsum("nx,nx->n", of_row, integrals(at, columns)), target), v


def bisected(rising: Callable[[np.ndarray], np.ndarray], value: np.ndarray) -> np.ndarray:
    low, high = np.zeros(len(value)), np.ones(len(value))
    for _ in range(40):
        middle = 0.5 * (low + high)
        less = rising(middle) < value
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    return 0.5 * (low + high)


def ggx(alpha: float, slices: int, k: int, n: int = 128) -> dict[str, np.ndarray]:
    """A file of GGX with separable masking and F = 1, `slices` theta_i, k x k samples."""
    theta_i = np.linspace(0, np.pi / 2, slices)
    u = np.linspace(0, 1, n)
    theta, phi = u**2 * np.pi / 2, np.linspace(-np.pi, np.pi, n)
    D = alpha**2 / (np.pi * (np.cos(theta) ** 2 * (alpha**2 - 1) + 1) ** 2)

    def area(t: np.ndarray) -> np.ndarray:  # cos(theta) / G1
        return 0.5 * (np.cos(t) + np.sqrt(np.cos(t) ** 2 + alpha**2 * np.sin(t) ** 2))

    vndf = np.empty((1, slices, n, n), np.float32)
    rgb = np.empty((1, slices, 3, k, k), np.float32)
    y, x = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, k), np.linspace(0, 1, k), indexing="ij"))
    for slice_, t in enumerate(theta_i):
        along = np.cos(t) * np.cos(theta) + np.sin(t) * np.sin(theta) * np.cos(phi)[:, None]
        vndf[0, slice_] = D * np.maximum(along, 0) * np.sin(theta) * u
        at_u, at_v = half_vectors(densities(vndf[:, slice_])[0], y, x)
        theta_m, phi_m = at_u**2 * np.pi / 2, (2 * at_v - 1) * np.pi
        i_m = np.cos(t) * np.cos(theta_m) + np.sin(t) * np.sin(theta_m) * np.cos(phi_m)
        cos_o = np.clip(2 * i_m * np.cos(theta_m) - np.cos(t), 0, 1)
        g1 = cos_o / area(np.arccos(cos_o))
        rgb[0, slice_] = g1.reshape(k, k)
    return {
        "phi_i": np.zeros(1, np.float32),
        "theta_i": theta_i.astype(np.float32),
        "ndf": np.tile(D, (2, 1)).astype(np.float32),
        "sigma": np.tile(area(theta), (2, 1)).astype(np.float32),
        "vndf": vndf,
        "rgb": rgb,
        "jacobian": np.ones(1, np.uint8),
    }


def random(seed: int, slices: int = 3, n: int = 6, k: int = 4) -> dict[str, np.ndarray]:
    """A small file of positive numbers that mean nothing."""
    rng = np.random.default_rng(seed)

    def values(*shape: int) -> np.ndarray:
        return rng.uniform(0.2, 1.0, shape).astype(np.float32)

    return {
        "description": np.frombuffer(b"noise", np.uint8),
        "phi_i": np.zeros(1, np.float32),
        "theta_i": np.linspace(0, 1.5, slices).astype(np.float32),
        "ndf": values(2, 5),
        "sigma": values(2, 7),
        "vndf": values(1, slices, n, n),
        "luminance": values(1, slices, k, k),
        "rgb": values(1, slices, 3, k, k),
        "jacobian": np.ones(1, np.uint8),
        "valid": np.full((slices * k * k + 7) // 8, 255, np.uint8),
    }
