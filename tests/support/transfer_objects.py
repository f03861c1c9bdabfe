"""Small objects with transfer, unshadowed or with made-up shadows."""

from functools import cache

import numpy as np
from shrm import brdf
from shrm.transfer.brdf_matrix import project_on_tents
from shrm.transfer.directional_basis import DirectionalBasis
from shrm.transfer.radiance_transfer import RadianceTransfer
from shrm.transfer.tangent_frames import band_rotations, vertex_frames
from shrm.transfer.variant import Variant

N, M = 4, 5
COMPONENTS = 60
GLOSSY = brdf.GGX(0.5, f0=(1.0, 0.7, 0.3))


def globe(rings: int = 12, around: int = 24) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, faces and uv of an oblate spheroid, off the origin and of an odd size, with a seam."""
    v, u = np.meshgrid(np.arange(rings + 1) / rings, np.arange(around + 1) / around, indexing="ij")
    theta, phi = np.pi * v.ravel(), 2.0 * np.pi * u.ravel()
    unit = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(rings), np.arange(around), indexing="ij"))
    a, b = i * (around + 1) + j, (i + 1) * (around + 1) + j
    faces = np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])
    vertices = np.array([3.0, -2.0, 1.0]) + unit * np.array([0.7, 0.7, 0.5])
    return vertices.astype(np.float32), faces.astype(np.int32), np.stack([u, 1.0 - v], axis=2).reshape(-1, 2)


@cache
def transferred(
    rings: int = 12,
    around: int = 24,
    variants: tuple[str, ...] = ("unshadowed", "shadowed", "interreflected"),
    material: brdf.BRDF = GLOSSY,
    named: str | None = None,
) -> RadianceTransfer:
    """A globe: T is the identity, and the made-up shadow lies on its lower half."""
    vertices, faces, uv = globe(rings, around)
    normals = (vertices - vertices.mean(axis=0)) / np.array([0.7, 0.7, 0.5]) ** 2
    frames = vertex_frames(normals, np.cross([0.0, 0.0, 1.0], normals))
    Q = project_on_tents(material, DirectionalBasis(M), N)
    R = np.zeros((len(vertices), N * N, N * N))
    for l, band in enumerate(band_rotations(frames, N)):
        R[:, l * l : (l + 1) ** 2, l * l : (l + 1) ** 2] = band
    A = np.einsum("ctj,pjk->ptck", Q, R)
    shade = {"unshadowed": 1.0, "shadowed": np.where(normals[:, 2] < 0, 0.3, 1.0)}
    shade["interreflected"] = 0.8 * shade["shadowed"] + 0.2
    contents = {}
    for name in variants:
        shaded = (A * np.reshape(shade[name], (-1, 1, 1, 1))).reshape(len(A), -1)
        left, s, right = np.linalg.svd(shaded, full_matrices=False)
        contents[name] = Variant(
            weights=(left * s)[:, :COMPONENTS].astype(np.float32),
            components=right[:COMPONENTS].reshape(COMPONENTS, *A.shape[1:]).astype(np.float32),
        )
    return RadianceTransfer(
        vertices=vertices,
        faces=faces,
        frames=frames.astype(np.float32),
        n=N,
        M=M,
        channels=A.shape[2],
        variants=contents,
        uv=uv.astype(np.float32),
        material=named or material.name,
        report={
            "SNR of matrices": 21.5,
            "compression": {variants[-1]: {"SNR of 1 to K": [*range(COMPONENTS)]}},
        },
    )


def broken(content: bytes) -> dict[str, bytes]:
    """Contents of a file that cannot be read, made of one that can."""
    return {
        "cut short": content[:-1000],
        "cut in its header": content[:100],
        "of another version": content[:8] + b"\x02" + content[9:],
        "damaged": content[:-100] + bytes([content[-100] ^ 255]) + content[-99:],
        "no object": b"ply\n",
        "empty": b"",
    }
